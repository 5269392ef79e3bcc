//! Who holds which unit. Every unit has at most one holder, so each holder's units are a list through the units.

use throng_core::patch::NONE;

/// Reservations of all units.
#[derive(Clone, Debug)]
pub(super) struct Reservations {
    /// Holder of each unit, or [`NONE`].
    holder: Vec<u32>,
    /// The unit after each one in its holder's list.
    next: Vec<u32>,
    /// First unit of each character.
    first: Vec<u32>,
    /// Units that are to be kept carry the stamp of the last release.
    kept: Vec<u32>,
    stamp: u32,
}

impl Reservations {
    pub fn new(num_units: usize, num_characters: usize) -> Self {
        Self {
            holder: vec![NONE; num_units],
            next: vec![NONE; num_units],
            first: vec![NONE; num_characters],
            kept: vec![0; num_units],
            stamp: 0,
        }
    }

    /// Who holds a unit.
    pub fn of(&self, unit: u32) -> Option<u32> {
        Some(self.holder[unit as usize]).filter(|&c| c != NONE)
    }

    /// Who else holds one of these units.
    pub fn other(&self, units: &[u32], character: u32) -> Option<u32> {
        units.iter().filter_map(|&u| self.of(u)).find(|&c| c != character)
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

    /// Begins a release: what is kept is then named by [`Reservations::keep`], the rest is let go by [`Reservations::release`].
    pub fn begin_release(&mut self) {
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.kept.fill(0);
            self.stamp = 1;
        }
    }

    pub fn keep(&mut self, units: &[u32]) {
        for &u in units {
            self.kept[u as usize] = self.stamp;
        }
    }

    /// Lets go of what a character holds and was not named since [`Reservations::begin_release`].
    pub fn release(&mut self, character: u32) {
        let mut unit = std::mem::replace(&mut self.first[character as usize], NONE);
        while unit != NONE {
            let after = self.next[unit as usize];
            if self.kept[unit as usize] == self.stamp {
                self.next[unit as usize] = self.first[character as usize];
                self.first[character as usize] = unit;
            } else {
                self.holder[unit as usize] = NONE;
            }
            unit = after;
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
        h.begin_release();
        h.keep(&[2, 3, 5]);
        h.release(0);
        let mut held: Vec<_> = h.units(0).collect();
        held.sort_unstable();
        assert_eq!(held, [2, 3]);
        assert_eq!((0..6).map(|u| h.of(u)).collect::<Vec<_>>(), [None, Some(1), Some(0), Some(0), None, Some(1)]);
    }
}
