//! Mutants of good files, from a seed.

use super::Form;
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Numbers that are hard to take.
const NUMBERS: [&str; 24] = [
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "255",
    "256",
    "65536",
    "2147483648",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "-9223372036854775808",
    "0.0",
    "1e-40",
    "-1e-7",
    "1e6",
    "1e9",
    "1e38",
    "-1e39",
    "1e308",
    "nan",
    "inf",
    "-inf",
];

/// Makes mutants.
#[derive(Clone, Debug)]
pub struct Mutator(Pcg64Mcg);

impl Mutator {
    /// The same seed gives the same mutants.
    pub fn new(seed: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(seed))
    }

    /// One of some good files with one to four changes.
    pub fn mutant(&mut self, good: &[Vec<u8>], form: Form) -> Vec<u8> {
        let mut bytes = good[self.below(good.len())].clone();
        for _ in 0..=self.below(4) {
            match form {
                Form::Text if self.0.random_bool(0.9) => bytes = self.text(bytes),
                Form::Binary if self.0.random_bool(0.9) => self.word(&mut bytes),
                _ => self.shape(&mut bytes),
            }
        }
        bytes
    }

    fn below(&mut self, n: usize) -> usize {
        self.0.random_range(0..n.max(1))
    }

    /// Puts an extreme or random word in place of another; nothing moves.
    fn word(&mut self, bytes: &mut [u8]) {
        let floats = [f32::NAN, f32::INFINITY, f32::MAX, -1.0, 1e6, 0.0, 1e-40];
        let doubles = [f64::NAN, f64::INFINITY, 1e300, -1.0, 3.5, 0.0];
        let integers = [u64::MAX, u64::MAX / 2, 1 << 40, u64::from(u32::MAX), 1 << 31, 77, 5, 1, 0];
        let word: Vec<u8> = match self.below(6) {
            0 => floats[self.below(floats.len())].to_le_bytes().into(),
            1 => doubles[self.below(doubles.len())].to_le_bytes().into(),
            2 => integers[self.below(integers.len())].to_le_bytes().into(),
            3 => (integers[self.below(integers.len())] as u32).to_le_bytes().into(),
            4 => vec![self.0.next_u32() as u8],
            _ => {
                // A bit, or a little more or less.
                let at = self.below(bytes.len());
                let change = [1 << self.below(8), 1, 0xff][self.below(3)];
                if let Some(b) = bytes.get_mut(at) {
                    *b = if self.0.random_bool(0.5) { *b ^ change } else { b.wrapping_add(change) };
                }
                return;
            }
        };
        let at = self.below(bytes.len());
        // Most numbers lie at a multiple of four.
        let at = if word.len() > 1 && self.0.random_bool(0.8) { at & !3 } else { at };
        for (b, w) in bytes[at..].iter_mut().zip(word) {
            *b = w;
        }
    }

    /// Takes bytes out, doubles some, or cuts the end.
    fn shape(&mut self, bytes: &mut Vec<u8>) {
        let from = self.below(bytes.len());
        let to = (from + 1 + self.below(64)).min(bytes.len());
        match self.below(4) {
            0 => drop(bytes.drain(from..to)),
            1 => {
                let some = bytes[from..to].to_vec();
                bytes.splice(from..from, some);
            }
            2 => bytes.truncate(from),
            _ => self.word(bytes),
        }
    }

    /// Changes a number, a word or a line of a text.
    fn text(&mut self, bytes: Vec<u8>) -> Vec<u8> {
        let Ok(text) = String::from_utf8(bytes.clone()) else {
            let mut bytes = bytes;
            self.word(&mut bytes);
            return bytes;
        };
        match self.below(8) {
            0..4 => self.number(&text),
            4 => self.replaced(&text),
            _ => self.line(&text),
        }
        .into_bytes()
    }

    fn number(&mut self, text: &str) -> String {
        let all = tokens(text, |c| c.is_ascii_digit() || matches!(c, '.' | '-' | '+'));
        let numbers: Vec<_> =
            all.into_iter().filter(|&(a, b)| text[a..b].contains(|c: char| c.is_ascii_digit())).collect();
        let Some(&(from, to)) = numbers.get(self.below(numbers.len())) else { return text.into() };
        let number = NUMBERS[self.below(NUMBERS.len())];
        [&text[..from], number, &text[to..]].concat()
    }

    /// A word in place of another one.
    fn replaced(&mut self, text: &str) -> String {
        let words = tokens(text, |c| c.is_alphanumeric() || matches!(c, '_' | '-'));
        let of = |i: usize| words.get(i).copied();
        let (Some((from, to)), Some(other)) = (of(self.below(words.len())), of(self.below(words.len()))) else {
            return text.into();
        };
        [&text[..from], &text[other.0..other.1], &text[to..]].concat()
    }

    /// Takes a line out, doubles it, or puts it elsewhere.
    fn line(&mut self, text: &str) -> String {
        let mut lines: Vec<&str> = text.split_inclusive('\n').collect();
        let (at, to) = (self.below(lines.len()), self.below(lines.len()));
        if lines.is_empty() {
            return text.into();
        }
        match self.below(3) {
            0 => drop(lines.remove(at)),
            1 => lines.insert(at, lines[at]),
            _ => lines.swap(at, to),
        }
        lines.concat()
    }
}

/// Ranges of a text all of whose characters are of a kind.
fn tokens(text: &str, is_part: impl Fn(char) -> bool) -> Vec<(usize, usize)> {
    let mut out: Vec<(usize, usize)> = Vec::new();
    for (at, c) in text.char_indices().filter(|(_, c)| is_part(*c)) {
        match out.last_mut() {
            Some(last) if last.1 == at => last.1 = at + c.len_utf8(),
            _ => out.push((at, at + c.len_utf8())),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_gives_the_same_mutants_and_most_of_them_differ_from_what_is_good() {
        let good = vec![b"a = 1.5\nb = [2, 3]\n".to_vec(), b"name = \"x\"\n".to_vec()];
        for form in [Form::Text, Form::Binary] {
            let make = |seed| {
                let mut m = Mutator::new(seed);
                (0..200).map(|_| m.mutant(&good, form)).collect::<Vec<_>>()
            };
            let first = make(1);
            assert_eq!(first, make(1));
            assert_ne!(first, make(2));
            let changed = first.iter().filter(|m| !good.contains(m)).count();
            assert!(changed > 150, "{form:?}: {changed}");
        }
        assert!(Mutator::new(1).mutant(&[Vec::new()], Form::Binary).len() < 9, "nothing can be made of nothing");
    }
}
