//! Numbering of shared values: values of a changed world in common with the previous one stay shared, and are found by
//! number, without comparing their inputs.

use super::identity_arc::IdentityArc;
use std::collections::HashMap;
use std::sync::Arc;
use throng_core::patch::NONE;

/// Numbers of shared values, in the order of first use.
pub(in crate::stitch) struct SharedNumbers<'b, T> {
    before: &'b [Arc<T>],
    /// New number of each previous value; [`NONE`] until used (before.len()).
    now: Vec<u32>,
    known: HashMap<IdentityArc<T>, u32>,
    /// All used values, by number.
    pub all: Vec<Arc<T>>,
}

impl<'b, T> SharedNumbers<'b, T> {
    /// - `before`: values of the previous world.
    pub fn new(before: &'b [Arc<T>]) -> Self {
        Self { before, now: vec![NONE; before.len()], known: HashMap::new(), all: Vec::new() }
    }

    /// New number of a value with a previous number; [`NONE`] for [`NONE`].
    pub fn renumber(&mut self, was: u32) -> u32 {
        let Some(&now) = self.now.get(was as usize) else { return NONE };
        if now != NONE {
            return now;
        }
        let now = self.number_of(&self.before[was as usize]);
        self.now[was as usize] = now;
        now
    }

    /// The number of a shared thing.
    pub fn number_of(&mut self, shared: &Arc<T>) -> u32 {
        let all = &mut self.all;
        *self.known.entry(IdentityArc::new(shared)).or_insert_with(|| {
            all.push(Arc::clone(shared));
            all.len() as u32 - 1
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_there_before_and_what_is_new_have_one_number_each() {
        let before: Vec<Arc<char>> = "abc".chars().map(Arc::new).collect();
        let new = Arc::new('d');
        let mut numbers = SharedNumbers::new(&before);
        assert_eq!(
            [numbers.renumber(2), numbers.number_of(&new), numbers.number_of(&before[2]), numbers.renumber(NONE)],
            [0, 1, 0, NONE]
        );
        assert_eq!([numbers.number_of(&before[0]), numbers.renumber(0), numbers.renumber(2)], [2, 2, 0]);
        assert_eq!(numbers.all.iter().map(|c| **c).collect::<String>(), "cda");
    }
}
