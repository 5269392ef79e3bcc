//! Who holds which unit. Every unit has at most one holder, so each holder's units are a list through the units.

use throng_core::patch::NONE;

/// Stands for somebody whom something else moves, on whose ground a unit is.
pub(super) const OUTSIDER: u32 = NONE - 1;

/// Reservations of all units.
#[derive(Clone, Debug)]
pub(super) struct Reservations {
    /// Holder of each unit, or [`NONE`].
    holder: Vec<u32>,
    /// Units on ground that outsiders hold.
    barred: Vec<bool>,
    /// The unit after each one in its holder's list.
    next: Vec<u32>,
    /// First unit of each character.
    first: Vec<u32>,
    /// Units that are marked carry the stamp.
    marks: Vec<u32>,
    stamp: u32,
}

impl Reservations {
    pub fn new(num_units: usize, num_characters: usize) -> Self {
        Self {
            holder: vec![NONE; num_units],
            barred: vec![false; num_units],
            next: vec![NONE; num_units],
            first: vec![NONE; num_characters],
            marks: vec![0; num_units],
            stamp: 0,
        }
    }

    /// Who holds a unit.
    pub fn of(&self, unit: u32) -> Option<u32> {
        Some(self.holder[unit as usize]).filter(|&c| c != NONE)
    }

    /// Who else holds one of these units; [`OUTSIDER`] where it is no inhabitant. What a character holds already is its
    /// own, whoever comes.
    pub fn other(&self, units: &[u32], character: u32) -> Option<u32> {
        let holder = |&u: &u32| self.of(u).or_else(|| self.barred[u as usize].then_some(OUTSIDER));
        units.iter().filter_map(holder).find(|&c| c != character)
    }

    /// No unit is on the ground of outsiders.
    pub fn open_all(&mut self) {
        self.barred.fill(false);
    }

    /// These units are on the ground of outsiders.
    pub fn bar(&mut self, units: &[u32]) {
        units.iter().for_each(|&u| self.barred[u as usize] = true);
    }

    /// True where all units are free or held by the character.
    pub fn are_free(&self, units: &[u32], character: u32) -> bool {
        self.other(units, character).is_none()
    }

    /// Gives units to a character, which are free or its own.
    pub fn take(&mut self, units: &[u32], character: u32) {
        for &u in units {
            if self.holder[u as usize] == NONE {
                self.holder[u as usize] = character;
                self.next[u as usize] = self.first[character as usize];
                self.first[character as usize] = u;
            }
        }
    }

    /// Takes all marks away.
    pub fn clear_marks(&mut self) {
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.marks.fill(0);
            self.stamp = 1;
        }
    }

    /// Marks units.
    pub fn mark(&mut self, units: &[u32]) {
        for &u in units {
            self.marks[u as usize] = self.stamp;
        }
    }

    /// True where one of these units is marked.
    pub fn is_any_marked(&self, units: &[u32]) -> bool {
        units.iter().any(|&u| self.marks[u as usize] == self.stamp)
    }

    /// Lets go of what a character holds and is not marked.
    pub fn release(&mut self, character: u32) {
        let mut unit = std::mem::replace(&mut self.first[character as usize], NONE);
        while unit != NONE {
            let after = self.next[unit as usize];
            if self.marks[unit as usize] == self.stamp {
                self.next[unit as usize] = self.first[character as usize];
                self.first[character as usize] = unit;
            } else {
                self.holder[unit as usize] = NONE;
            }
            unit = after;
        }
    }

    /// Gives all reservations of a character to another one, which has none.
    pub fn hand_over(&mut self, from: u32, to: u32) {
        let mut unit = std::mem::replace(&mut self.first[from as usize], NONE);
        self.first[to as usize] = unit;
        while unit != NONE {
            self.holder[unit as usize] = to;
            unit = self.next[unit as usize];
        }
    }

    /// What a character holds.
    pub fn units(&self, character: u32) -> impl Iterator<Item = u32> + '_ {
        let some = |u: u32| Some(u).filter(|&u| u != NONE);
        std::iter::successors(some(self.first[character as usize]), move |&u| some(self.next[u as usize]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_have_one_holder_and_are_let_go_unless_kept() {
        let mut h = Reservations::new(6, 2);
        h.take(&[0, 2, 4], 0);
        h.take(&[1, 5], 1);
        assert!(h.are_free(&[0, 3], 0) && !h.are_free(&[0, 3], 1));
        h.take(&[0, 3], 0);
        h.clear_marks();
        h.mark(&[2, 3, 5]);
        h.release(0);
        let mut held: Vec<_> = h.units(0).collect();
        held.sort_unstable();
        assert_eq!(held, [2, 3]);
        assert_eq!((0..6).map(|u| h.of(u)).collect::<Vec<_>>(), [None, Some(1), Some(0), Some(0), None, Some(1)]);
        h.clear_marks();
        h.release(0);
        h.hand_over(1, 0);
        assert_eq!((0..6).map(|u| h.of(u)).collect::<Vec<_>>(), [None, Some(0), None, None, None, Some(0)]);
        assert!(h.units(1).next().is_none() && h.units(0).count() == 2);
    }
}
