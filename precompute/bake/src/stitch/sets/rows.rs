//! Bits in words of 64: sets of cells, one for each cell of a patch, as non-empty words, so that a search handles many cells
//! at a time; and lists of words with equal ones stored once.

use std::collections::HashMap;

/// Up to 64 numbers of a set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::stitch) struct BitWord {
    /// Index of the word, which holds the numbers `64 * index + bit`.
    pub index: u32,
    /// One bit for each number.
    pub bits: u64,
}

/// A set of small numbers for each row.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::stitch) struct BitRows {
    /// First word of each row (rows + 1).
    starts: Vec<u32>,
    words: Vec<BitWord>,
}

impl BitRows {
    /// Collects the numbers of rows.
    ///
    /// - `pairs`: row and number; those of each row are ascending and may repeat.
    pub fn new(num_rows: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let mut ends = vec![0u32; num_rows + 1];
        pairs.clone().for_each(|(row, _)| ends[row as usize + 1] += 1);
        for row in 0..num_rows {
            ends[row + 1] += ends[row];
        }
        let mut numbers = vec![0u32; ends[num_rows] as usize];
        for (row, number) in pairs {
            // Insert position in the row.
            let at = &mut ends[row as usize];
            numbers[*at as usize] = number;
            *at += 1;
        }
        let mut out = Self { starts: vec![0], words: Vec::new() };
        let mut first = 0;
        for &end in &ends[..num_rows] {
            out.push(&numbers[first..end as usize]);
            first = end as usize;
        }
        out
    }

    fn push(&mut self, numbers: &[u32]) {
        for same in numbers.chunk_by(|a, b| a / 64 == b / 64) {
            let bits = same.iter().fold(0, |bits, m| bits | 1 << (m % 64));
            self.words.push(BitWord { index: same[0] / 64, bits });
        }
        self.starts.push(self.words.len() as u32);
    }

    /// The transposed relation: rows with each number (num_rows).
    pub fn transposed(&self, num_rows: usize) -> Self {
        let rows = 0..self.starts.len() as u32 - 1;
        Self::new(num_rows, rows.flat_map(|row| self.members(row).map(move |number| (number, row))))
    }

    /// Words of a row.
    pub fn words_of(&self, row: u32) -> &[BitWord] {
        &self.words[self.starts[row as usize] as usize..self.starts[row as usize + 1] as usize]
    }

    /// Members of a row, ascending.
    pub fn members(&self, row: u32) -> impl Iterator<Item = u32> + Clone {
        self.words_of(row).iter().flat_map(|word| set_bits(word.bits).map(|bit| 64 * word.index + bit))
    }

    /// Next number of a row; `at` starts at 0 and is advanced.
    pub fn next(&self, row: u32, at: &mut u32) -> Option<u32> {
        let words = self.words_of(row);
        while let Some(word) = words.get(*at as usize / 64) {
            let left = word.bits & (u64::MAX << (*at % 64));
            if left != 0 {
                let bit = left.trailing_zeros();
                // After the last bit comes the first of the next word.
                *at = *at / 64 * 64 + bit + 1;
                return Some(64 * word.index + bit);
            }
            *at = (*at / 64 + 1) * 64;
        }
        None
    }
}

/// Numbers of the bits that are set, ascending.
pub(in crate::stitch) fn set_bits(mut bits: u64) -> impl Iterator<Item = u32> + Clone {
    std::iter::from_fn(move || {
        let bit = (bits != 0).then(|| bits.trailing_zeros())?;
        bits &= bits - 1;
        Some(bit)
    })
}

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
#[derive(Clone, Debug, Default)]
pub(in crate::stitch) struct WordPool {
    /// All words.
    pub words: Vec<u64>,
    known: HashMap<u64, Vec<(u32, u32)>>,
}

impl WordPool {
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
    use proptest::prelude::*;
    use std::collections::BTreeSet;
    use throng_world::is_set;

    proptest! {
        #[test]
        fn rows_hold_what_was_put_in(pairs in prop::collection::vec((0u32..9, 0u32..300), 0..60)) {
            let mut sorted = pairs.clone();
            sorted.sort_unstable();
            let (rows, set) = (BitRows::new(9, sorted.iter().copied()), BTreeSet::from_iter(pairs));
            let found = |r: &BitRows, n: u32| (0..n).flat_map(|k| r.members(k).map(move |m| (k, m))).collect::<Vec<_>>();
            prop_assert_eq!(found(&rows, 9), set.iter().copied().collect::<Vec<_>>());
            let turned: BTreeSet<_> = set.iter().map(|&(r, m)| (m, r)).collect();
            prop_assert_eq!(found(&rows.transposed(300), 300), turned.into_iter().collect::<Vec<_>>());
            for k in 0..9 {
                let mut at = 0;
                let one_by_one: Vec<u32> = std::iter::from_fn(|| rows.next(k, &mut at)).collect();
                prop_assert_eq!(one_by_one, rows.members(k).collect::<Vec<_>>());
            }
        }
    }

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
        let mut pool = WordPool::default();
        let a = pool.intern(&[1, 2]);
        assert_eq!(pool.intern(&[3]), 2);
        assert_eq!(pool.intern(&[1, 2]), a);
        assert_eq!(pool.intern(&[1]), 3);
        assert_eq!(pool.words, [1, 2, 3, 1]);
    }
}
