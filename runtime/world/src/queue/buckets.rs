//! A queue of numbers by whole keys that only grow: buckets in a ring (Dial 1969); its memory is allocated once.

use throng_core::patch::NONE;

/// The least key first; of equal keys, what came last.
#[derive(Clone, Debug)]
pub(crate) struct Buckets {
    /// First number of each bucket (a power of two above the longest step).
    heads: Vec<u32>,
    /// The numbers before and after each in its bucket.
    links: Vec<[u32; 2]>,
    /// Key of each number in the queue.
    keys: Vec<u32>,
    is_there: Vec<bool>,
    len: usize,
    /// No key is less.
    least: u32,
}

impl Buckets {
    /// Memory for the numbers below `limit`, and for keys that are at most `step` more than the least one.
    pub fn new(limit: usize, step: u32) -> Self {
        let heads = vec![NONE; (step as usize + 1).next_power_of_two()];
        let (links, keys, is_there) = (vec![[NONE; 2]; limit], vec![0; limit], vec![false; limit]);
        Self { heads, links, keys, is_there, len: 0, least: 0 }
    }

    /// Grows to the numbers below `limit`; empty before.
    pub fn grow(&mut self, limit: usize) {
        let limit = limit.max(self.keys.len());
        self.links.resize(limit, [NONE; 2]);
        self.keys.resize(limit, 0);
        self.is_there.resize(limit, false);
    }

    /// Removes everything; keys begin at 0 again.
    pub fn clear(&mut self) {
        while self.pop().is_some() {}
        self.least = 0;
    }

    /// Adds a number, or lowers its key (number < limit, least key <= key <= least key + step).
    pub fn push(&mut self, number: u32, key: u32) {
        if self.is_there[number as usize] {
            self.take(number);
        }
        let mask = self.heads.len() - 1;
        let head = &mut self.heads[key as usize & mask];
        self.links[number as usize] = [NONE, *head];
        if let Some(next) = self.links.get_mut(*head as usize) {
            next[0] = number;
        }
        *head = number;
        self.keys[number as usize] = key;
        self.is_there[number as usize] = true;
        self.len += 1;
    }

    /// Removes the number with the least key and returns it.
    pub fn pop(&mut self) -> Option<(u32, u32)> {
        if self.len == 0 {
            return None;
        }
        loop {
            let number = self.heads[self.least as usize & (self.heads.len() - 1)];
            if number != NONE {
                self.take(number);
                return Some((self.least, number));
            }
            self.least += 1;
        }
    }

    fn take(&mut self, number: u32) {
        let [before, after] = self.links[number as usize];
        match self.links.get_mut(before as usize) {
            Some(before) => before[1] = after,
            None => {
                let at = self.keys[number as usize] as usize & (self.heads.len() - 1);
                self.heads[at] = after;
            }
        }
        if let Some(after) = self.links.get_mut(after as usize) {
            after[0] = before;
        }
        self.is_there[number as usize] = false;
        self.len -= 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    proptest! {
        #[test]
        fn numbers_come_out_by_their_lowest_key(pushes in prop::collection::vec((0u32..30, 0u32..40, any::<bool>()), 0..200)) {
            let (mut buckets, mut keys) = (Buckets::new(30, 40), BTreeMap::<u32, u32>::new());
            for round in 0..2 {
                let mut least = 0;
                for &(number, more, pop) in &pushes {
                    if keys.get(&number).is_none_or(|k| *k > least + more) {
                        keys.insert(number, least + more);
                        buckets.push(number, least + more);
                    }
                    if pop || round == 1 {
                        let (key, number) = buckets.pop().unwrap();
                        prop_assert_eq!(Some(&key), keys.values().min());
                        prop_assert_eq!(keys.remove(&number), Some(key));
                        least = key;
                    }
                }
                buckets.clear();
                keys.clear();
                prop_assert_eq!(buckets.pop(), None);
            }
        }
    }
}
