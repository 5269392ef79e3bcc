//! Ids that come and go, over rows without gaps.

use serde::{Deserialize, Serialize};
use throng_base::{Error, Id, Result};

/// Marks an index that is free.
const FREE: u32 = u32::MAX;

/// Map from ids to rows. Rows have no gaps: the last one moves to a row that becomes free.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct Roster {
    /// Id in each row.
    ids: Vec<Id>,
    /// Generation and row of each index, or [`FREE`] (capacity).
    slots: Vec<(u32, u32)>,
    /// Free indices; the last one is taken next.
    free: Vec<u32>,
}

impl Clone for Roster {
    /// The copy has room for as many ids.
    fn clone(&self) -> Self {
        let mut out = Self::with_capacity(self.capacity());
        out.ids.extend(&self.ids);
        out.slots.clone_from(&self.slots);
        out.free.clone_from(&self.free);
        out
    }
}

impl Roster {
    /// Allocates for `capacity` ids.
    pub fn with_capacity(capacity: usize) -> Self {
        let slots = vec![(0, FREE); capacity];
        Self { ids: Vec::with_capacity(capacity), slots, free: (0..capacity as u32).rev().collect() }
    }

    /// Ids, row by row.
    pub fn ids(&self) -> &[Id] {
        &self.ids
    }

    /// Most ids.
    pub fn capacity(&self) -> usize {
        self.slots.len()
    }

    /// The row of an id.
    ///
    /// # Errors
    /// [`Error::Gone`].
    pub fn row(&self, id: Id) -> Result<usize> {
        match self.slots.get(id.index()) {
            Some(&(generation, row)) if generation == id.generation && row != FREE => Ok(row as usize),
            _ => Err(Error::Gone(id)),
        }
    }

    /// The id that would enter next.
    ///
    /// # Errors
    /// [`Error::Full`].
    pub fn next_id(&self) -> Result<Id> {
        let index = *self.free.last().ok_or(Error::Full { capacity: self.slots.len() })?;
        Ok(Id { index, generation: self.slots[index as usize].0 })
    }

    /// Adds a row at the end. Allocates nothing.
    ///
    /// # Errors
    /// [`Error::Full`].
    pub fn add_id(&mut self) -> Result<Id> {
        let id = self.next_id()?;
        self.free.pop();
        self.slots[id.index()].1 = self.ids.len() as u32;
        self.ids.push(id);
        Ok(id)
    }

    /// Removes an id; the last row moves to its row.
    ///
    /// - returns the row, and the number of rows that are left, which was that of the last row.
    ///
    /// # Errors
    /// [`Error::Gone`].
    pub fn remove_id(&mut self, id: Id) -> Result<(usize, usize)> {
        let row = self.row(id)?;
        self.ids.swap_remove(row);
        if let Some(moved) = self.ids.get(row) {
            self.slots[moved.index()].1 = row as u32;
        }
        self.slots[id.index()] = (id.generation.wrapping_add(1), FREE);
        self.free.push(id.index);
        Ok((row, self.ids.len()))
    }

    /// Restores the content of a snapshot, or changes nothing and returns false where it is not sound or of another
    /// capacity.
    pub fn restore(&mut self, kept: &Self) -> bool {
        let capacity = self.slots.len();
        if kept.slots.len() != capacity {
            return false;
        }
        let mut seen = vec![false; capacity];
        let rows = kept.ids.iter().enumerate().all(|(row, id)| {
            kept.slots.get(id.index()) == Some(&(id.generation, row as u32))
                && !std::mem::replace(&mut seen[id.index()], true)
        });
        let free = kept.free.iter().all(|&index| {
            let is_free = kept.slots.get(index as usize).is_some_and(|slot| slot.1 == FREE);
            is_free && !std::mem::replace(&mut seen[index as usize], true)
        });
        let sound = rows && free && seen.iter().all(|s| *s);
        if sound {
            self.ids.clone_from(&kept.ids);
            self.slots.clone_from(&kept.slots);
            self.free.clone_from(&kept.free);
        }
        sound
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_have_no_gaps_and_ids_are_never_used_twice() {
        let mut roster = Roster::with_capacity(3);
        let [a, b, c] = [(); 3].map(|()| roster.add_id().unwrap());
        assert!(matches!(roster.add_id(), Err(Error::Full { capacity: 3 })));
        assert_eq!(roster.remove_id(a).unwrap(), (0, 2));
        assert_eq!((roster.ids(), roster.row(c).unwrap(), roster.row(b).unwrap()), (&[c, b][..], 0, 1));
        let d = roster.add_id().unwrap();
        assert_eq!((d.index, d.generation), (a.index, 1));
        assert!(matches!(roster.row(a), Err(Error::Gone(id)) if id == a));
        assert!(roster.remove_id(a).is_err() && roster.row(Id::first(7)).is_err());
    }

    #[test]
    fn restoring_brings_back_rows_and_the_next_id() {
        let mut roster = Roster::with_capacity(3);
        let [a, _] = [(); 2].map(|()| roster.add_id().unwrap());
        roster.remove_id(a).unwrap();
        let kept = roster.clone();
        let next = roster.add_id().unwrap();
        roster.add_id().unwrap();
        assert!(roster.restore(&kept) && roster == kept);
        assert_eq!(roster.add_id().unwrap(), next);
    }

    #[test]
    fn refuses_what_is_not_sound() {
        let mut roster = Roster::with_capacity(2);
        let a = roster.add_id().unwrap();
        let (good, mut other) = (roster.clone(), Roster::with_capacity(2));
        let spoils: [fn(&mut Roster); 5] = [
            |r| r.ids[0].index = 9,
            |r| r.slots[0].1 = 1,
            |r| r.free[0] = 0,
            |r| r.ids.push(r.ids[0]),
            |r| r.slots.push((0, FREE)),
        ];
        for spoil in spoils {
            let mut bad = good.clone();
            spoil(&mut bad);
            assert!(!other.restore(&bad));
            assert_eq!(other, Roster::with_capacity(2));
        }
        assert!(other.restore(&good) && other.row(a).is_ok());
    }
}
