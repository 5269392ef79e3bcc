//! Shared things by number: what a changed world has in common with the one before keeps being shared, and is found
//! without a look at what it was made from.

use super::same::Same;
use std::collections::HashMap;
use std::sync::Arc;
use throng_core::patch::NONE;

/// Numbers of shared things, in the order in which they are named.
pub(in crate::stitch) struct Numbers<'b, T> {
    before: &'b [Arc<T>],
    /// The number of each of those before; [`NONE`] until it is named (before.len()).
    now: Vec<u32>,
    known: HashMap<Same<T>, u32>,
    all: Vec<Arc<T>>,
}

impl<'b, T> Numbers<'b, T> {
    /// - `before`: those of the world before.
    pub fn new(before: &'b [Arc<T>]) -> Self {
        Self { before, now: vec![NONE; before.len()], known: HashMap::new(), all: Vec::new() }
    }

    /// The number of what had a number before, or [`NONE`] for [`NONE`].
    pub fn same(&mut self, was: u32) -> u32 {
        let Some(&now) = self.now.get(was as usize) else { return NONE };
        if now != NONE {
            return now;
        }
        let now = self.of(&self.before[was as usize]);
        self.now[was as usize] = now;
        now
    }

    /// The number of a shared thing.
    pub fn of(&mut self, shared: &Arc<T>) -> u32 {
        let all = &mut self.all;
        *self.known.entry(Same::new(shared)).or_insert_with(|| {
            all.push(Arc::clone(shared));
            all.len() as u32 - 1
        })
    }

    /// All that were named, by number.
    pub fn into_all(self) -> Vec<Arc<T>> {
        self.all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_there_before_and_what_is_new_have_one_number_each() {
        let before: Vec<Arc<char>> = "abc".chars().map(Arc::new).collect();
        let new = Arc::new('d');
        let mut numbers = Numbers::new(&before);
        assert_eq!([numbers.same(2), numbers.of(&new), numbers.of(&before[2]), numbers.same(NONE)], [0, 1, 0, NONE]);
        assert_eq!([numbers.of(&before[0]), numbers.same(0), numbers.same(2)], [2, 2, 0]);
        assert_eq!(numbers.into_all().iter().map(|c| **c).collect::<String>(), "cda");
    }
}
