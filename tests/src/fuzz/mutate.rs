//! Inputs like those that are known, and unlike them.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Longest input, bytes.
const MAX_BYTES: usize = 64 * 1024;
/// Numbers at which programs stumble.
const NUMBERS: [&str; 16] = [
    "0",
    "-0",
    "-1",
    "1e308",
    "-1e308",
    "1e-320",
    "9e999",
    "NaN",
    "inf",
    "-inf",
    "2147483648",
    "-2147483649",
    "18446744073709551616",
    "9007199254740993",
    "0.1",
    "1e-9",
];

/// Makes inputs out of known ones; the same from the same seed.
pub struct Mutator<'a> {
    random: ChaCha8Rng,
    corpus: &'a [Vec<u8>],
    words: &'a [&'a str],
}

impl<'a> Mutator<'a> {
    /// Of these inputs and pieces.
    #[must_use]
    pub fn new(seed: u64, corpus: &'a [Vec<u8>], words: &'a [&'a str]) -> Self {
        Self { random: ChaCha8Rng::seed_from_u64(seed), corpus, words }
    }

    /// The next input.
    pub fn next_input(&mut self) -> Vec<u8> {
        let mut bytes = self.any().to_vec();
        for _ in 0..=self.random.random_range(0..6) {
            self.change(&mut bytes);
        }
        bytes.truncate(MAX_BYTES);
        bytes
    }

    fn any(&mut self) -> &'a [u8] {
        let corpus = self.corpus;
        corpus.get(self.below(corpus.len())).map_or(&[], Vec::as_slice)
    }

    /// A number from 0 to below `end`, or 0.
    fn below(&mut self, end: usize) -> usize {
        if end == 0 { 0 } else { self.random.random_range(0..end) }
    }

    /// A stretch of so many bytes at most.
    fn stretch(&mut self, length: usize, longest: usize) -> std::ops::Range<usize> {
        let from = self.below(length);
        let count = self.below(longest.min(length - from) + 1);
        from..from + count
    }

    fn change(&mut self, bytes: &mut Vec<u8>) {
        let at = self.below(bytes.len());
        match self.random.random_range(0..11) {
            0 if !bytes.is_empty() => bytes[at] ^= 1 << self.below(8),
            1 if !bytes.is_empty() => bytes[at] = self.random.random(),
            2 => {
                let mut some = [0; 8];
                self.random.fill_bytes(&mut some);
                let count = 1 + self.below(8);
                bytes.splice(at..at, some[..count].iter().copied());
            }
            3 => drop(bytes.drain(self.stretch(bytes.len(), 64))),
            4 => {
                let again = bytes[self.stretch(bytes.len(), 256)].to_vec();
                bytes.splice(at..at, again);
            }
            5 => {
                let other = self.any();
                let piece = &other[self.stretch(other.len(), 512)];
                bytes.splice(at..at, piece.iter().copied());
            }
            6 if !self.words.is_empty() => {
                let word = self.words[self.below(self.words.len())];
                bytes.splice(at..at, word.bytes());
            }
            7 => self.change_number(bytes),
            8 => bytes.truncate(at),
            9 => self.swap_lines(bytes),
            _ => {
                let repeated = bytes[self.stretch(bytes.len(), 32)].to_vec();
                let times = self.below(64);
                bytes.splice(at..at, repeated.repeat(times));
            }
        }
    }

    /// Puts another number in the place of one.
    fn change_number(&mut self, bytes: &mut Vec<u8>) {
        let part = |byte: &u8| byte.is_ascii_digit() || b".-+e".contains(byte);
        let from = self.below(bytes.len());
        let Some(start) = bytes[from..].iter().position(u8::is_ascii_digit) else { return };
        let start = from + start;
        let end = start + bytes[start..].iter().take_while(|byte| part(byte)).count();
        let number = NUMBERS[self.below(NUMBERS.len())];
        bytes.splice(start..end, number.bytes());
    }

    fn swap_lines(&mut self, bytes: &mut Vec<u8>) {
        let mut lines: Vec<&[u8]> = bytes.split(|byte| *byte == b'\n').collect();
        let (a, b) = (self.below(lines.len()), self.below(lines.len()));
        lines.swap(a, b);
        *bytes = lines.join(&b'\n');
    }
}
