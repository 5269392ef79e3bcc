//! Hashes of states and of content.

use std::hash::Hasher;

/// Two hashes of 64 bits side by side, each multiplied and shifted as the finaliser of SplitMix64 does.
///
/// Tells content apart (one chance in 2^128 of a mistake); it keeps no secret.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hash128([u64; 2]);

impl Default for Hash128 {
    fn default() -> Self {
        Self([0x243f_6a88_85a3_08d3, 0x1319_8a2e_0370_7344])
    }
}

impl Hash128 {
    /// Adds a word.
    pub fn add_word(&mut self, word: u64) {
        self.0[0] = mix(self.0[0] ^ word);
        self.0[1] = mix(self.0[1].rotate_left(29) ^ word.wrapping_mul(0xd6e8_feb8_6659_fd93));
    }

    /// Adds bytes and their number.
    pub fn add_bytes(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks();
        words.iter().for_each(|word| self.add_word(u64::from_le_bytes(*word)));
        let mut last = [0; 8];
        last[..rest.len()].copy_from_slice(rest);
        self.add_word(u64::from_le_bytes(last));
        self.add_word(bytes.len() as u64);
    }

    /// The hash of all that was added.
    pub fn finish(self) -> u128 {
        u128::from(mix(self.0[0])) << 64 | u128::from(mix(self.0[1]))
    }

    /// The hash of some bytes.
    pub fn hash_bytes(bytes: &[u8]) -> u128 {
        let mut hash = Self::default();
        hash.add_bytes(bytes);
        hash.finish()
    }
}

/// A hash of 64 bits of the state of a simulation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StateHash(u64);

impl StateHash {
    /// Begins with a word.
    pub fn new(word: u64) -> Self {
        Self(word)
    }

    /// Adds a word.
    pub fn add_word(&mut self, word: u64) {
        self.0 = mix(self.0 ^ word);
    }

    /// The hash of all that was added.
    pub fn get(self) -> u64 {
        self.0
    }
}

impl Hasher for StateHash {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&b| self.add_word(u64::from(b)));
    }

    fn write_u32(&mut self, i: u32) {
        self.add_word(u64::from(i));
    }

    fn write_u64(&mut self, i: u64) {
        self.add_word(i);
    }
}

fn mix(word: u64) -> u64 {
    let x = word.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^ (x >> 27)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_that_differs_in_a_bit_or_a_length_has_another_hash() {
        let bytes: Vec<u8> = (0..40).collect();
        let whole = Hash128::hash_bytes(&bytes);
        for i in 0..bytes.len() {
            let mut other = bytes.clone();
            other[i] ^= 1;
            assert_ne!(Hash128::hash_bytes(&other), whole);
            assert_ne!(Hash128::hash_bytes(&bytes[..i]), whole);
        }
        assert_ne!(Hash128::hash_bytes(&[0; 8]), Hash128::hash_bytes(&[0; 9]));
    }
}
