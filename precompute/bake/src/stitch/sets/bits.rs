//! Bits in words of 64, and lists of such words with equal ones stored once.

use std::collections::HashMap;

/// Number of words for `count` bits.
pub(in crate::stitch) fn num_words(count: usize) -> usize {
    count.div_ceil(64)
}

/// `count` bits, all set.
pub(in crate::stitch) fn all_set(count: usize) -> Vec<u64> {
    let mut words = vec![u64::MAX; num_words(count)];
    if !count.is_multiple_of(64)
        && let Some(last) = words.last_mut()
    {
        *last = (1 << (count % 64)) - 1;
    }
    words
}

/// Clears a bit.
pub(in crate::stitch) fn clear_bit(words: &mut [u64], bit: u32) {
    words[bit as usize / 64] &= !(1 << (bit % 64));
}

/// Sets a bit.
pub(in crate::stitch) fn set_bit(words: &mut [u64], bit: u32) {
    words[bit as usize / 64] |= 1 << (bit % 64);
}

/// Concatenated lists of words, with equal ones stored once.
#[derive(Clone, Debug)]
pub(in crate::stitch) struct WordPool {
    /// All words.
    pub words: Vec<u64>,
    known: HashMap<u64, Vec<(u32, u32)>>,
}

impl WordPool {
    /// An empty pool that reuses the memory of some words.
    pub fn new(mut memory: Vec<u64>) -> Self {
        memory.clear();
        Self { words: memory, known: HashMap::new() }
    }

    /// Begin of a list of words, which is added if missing.
    pub fn intern(&mut self, list: &[u64]) -> u32 {
        let hash = xxhash_rust::xxh3::xxh3_64(bytemuck::cast_slice(list));
        let same = |&(first, len): &(u32, u32)| self.words[first as usize..(first + len) as usize] == *list;
        let candidates = self.known.entry(hash).or_default();
        if let Some(&(first, _)) = candidates.iter().find(|c| same(c)) {
            return first;
        }
        let first = self.words.len() as u32;
        candidates.push((first, list.len() as u32));
        self.words.extend_from_slice(list);
        first
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_world::is_set;

    #[test]
    fn bits_are_set_cleared_and_counted() {
        let mut words = all_set(70);
        assert_eq!(words.iter().map(|w| w.count_ones()).sum::<u32>(), 70);
        clear_bit(&mut words, 69);
        assert!(!is_set(&words, 0, 69) && is_set(&words, 0, 68));
        set_bit(&mut words, 69);
        assert_eq!(words, all_set(70));
        assert!(all_set(0).is_empty() && all_set(128) == [u64::MAX; 2]);
    }

    #[test]
    fn equal_lists_are_stored_once() {
        let mut pool = WordPool::new(vec![7; 9]);
        let a = pool.intern(&[1, 2]);
        assert_eq!(pool.intern(&[3]), 2);
        assert_eq!(pool.intern(&[1, 2]), a);
        assert_eq!(pool.intern(&[1]), 3);
        assert_eq!(pool.words, [1, 2, 3, 1]);
    }
}
