//! The filter that makes noise white, on block means.
//!
//! The filter is linear in what goes in and in what it remembers. For a signal that is constant within a block, what it
//! remembers after the block and the mean of what it gives over the block are therefore a small matrix times what it
//! remembered before and that constant. With the root of the number of samples as weight, the means are as white as the
//! samples, and their sum of squares is that of the samples less what scatters within the blocks. A block of one sample
//! is whitened exactly as that sample.

use std::collections::HashMap;
use std::sync::Arc;

use super::whitening::Whitening;

/// The filter over the blocks of one stretch.
#[derive(Clone, Debug)]
pub(super) struct WhitenedBlocks {
    states: usize,
    /// What the filter makes of each block, and the root of its number of samples.
    blocks: Vec<(Arc<Passage>, f64)>,
}

/// What the filter makes of one block: each row gives a number remembered after it, the last the sum of what comes out; the
/// last column is for what goes in.
#[derive(Debug)]
struct Passage {
    size: usize,
    numbers: Vec<f64>,
}

/// Passages by their number of samples, where the filter does the same at every sample.
#[derive(Debug, Default)]
pub(super) struct Settled(HashMap<usize, Arc<Passage>>);

impl WhitenedBlocks {
    /// The filter over blocks that begin at these samples, the last of which is the end of the stretch.
    pub fn new(whitening: &Whitening, begins: &[usize], settled: &mut Settled) -> Self {
        let block = |pair: &[usize]| {
            let (begin, end) = (pair[0], pair[1]);
            let root = ((end - begin) as f64).sqrt();
            if begin >= whitening.settles_after() {
                return (settled.of(whitening, end - begin), root);
            }
            let samples = (begin..end).map(|k| Passage::of_sample(whitening, k));
            let passage = samples.reduce(|before, next| before.then(&next));
            (Arc::new(passage.unwrap_or_else(|| Passage::of_sample(whitening, begin))), root)
        };
        Self { states: whitening.states(), blocks: begins.windows(2).map(block).collect() }
    }

    /// Whitens a signal that has one value in each block.
    pub fn apply(&self, values: &mut [f64]) {
        let size = self.states + 1;
        let (mut state, mut next) = (vec![0.0; size], vec![0.0; size]);
        for (value, (passage, root)) in values.iter_mut().zip(&self.blocks) {
            state[self.states] = *value;
            for (next, row) in next.iter_mut().zip(passage.numbers.chunks_exact(size)) {
                *next = row.iter().zip(&state).map(|(a, x)| a * x).sum();
            }
            *value = next[self.states] / root;
            std::mem::swap(&mut state, &mut next);
        }
    }
}

impl Settled {
    /// The passage over so many samples, by halves.
    fn of(&mut self, whitening: &Whitening, samples: usize) -> Arc<Passage> {
        if let Some(known) = self.0.get(&samples) {
            return known.clone();
        }
        let passage = if samples <= 1 {
            Passage::of_sample(whitening, whitening.settles_after())
        } else {
            let half = self.of(whitening, samples / 2);
            half.then(&self.of(whitening, samples - samples / 2))
        };
        let passage = Arc::new(passage);
        self.0.insert(samples, passage.clone());
        passage
    }
}

impl Passage {
    /// Over sample `k` of a stretch.
    fn of_sample(whitening: &Whitening, k: usize) -> Self {
        let states = whitening.states();
        let size = states + 1;
        let mut numbers = vec![0.0; size * size];
        for column in 0..size {
            let mut state = vec![0.0; states];
            if let Some(own) = state.get_mut(column) {
                *own = 1.0;
            }
            let value = if column == states { 1.0 } else { 0.0 };
            let out = whitening.step(k, &mut state, value);
            for (row, after) in state.iter().chain([&out]).enumerate() {
                numbers[row * size + column] = *after;
            }
        }
        Self { size, numbers }
    }

    /// This passage and then another.
    fn then(&self, next: &Self) -> Self {
        let (size, states) = (self.size, self.size - 1);
        let mut numbers = vec![0.0; size * size];
        for row in 0..size {
            for column in 0..size {
                let through = (0..states)
                    .map(|k| next.numbers[row * size + k] * self.numbers[k * size + column])
                    .sum::<f64>();
                let from_input =
                    if column == states { next.numbers[row * size + states] } else { 0.0 };
                // What has come out before adds up.
                let before = if row == states { self.numbers[row * size + column] } else { 0.0 };
                numbers[row * size + column] = through + from_input + before;
            }
        }
        Self { size, numbers }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Noise of every kind.
    fn kinds() -> Vec<Whitening> {
        vec![
            Whitening::none(),
            Whitening::new(0.3, &[], 0.0, 0),
            Whitening::new(0.3, &[0.7], 0.0, 0),
            Whitening::new(0.3, &[0.7, -0.2, 0.1], 0.0, 0),
            Whitening::new(0.3, &[0.5], 0.1, 4000),
        ]
    }

    #[test]
    fn blocks_of_one_sample_are_whitened_as_samples() {
        let signal: Vec<f64> = (0..300).map(|k| (0.37 * f64::from(k)).sin()).collect();
        let begins: Vec<usize> = (0..=300).collect();
        for whitening in kinds() {
            let (mut samples, mut blocks) = (signal.clone(), signal.clone());
            whitening.apply(&mut samples);
            WhitenedBlocks::new(&whitening, &begins, &mut Settled::default()).apply(&mut blocks);
            for (a, b) in samples.iter().zip(&blocks) {
                assert!((a - b).abs() < 1e-12 * (1.0 + a.abs()), "{a} {b}");
            }
        }
    }

    #[test]
    fn a_slow_signal_keeps_its_sum_of_squares() {
        let begins: Vec<usize> = (0..50).chain((50..3000).step_by(10)).chain([3000]).collect();
        let signal = |k: f64| (0.004 * k).sin() + 0.3;
        for whitening in kinds() {
            let mut samples: Vec<f64> = (0..3000).map(|k| signal(f64::from(k))).collect();
            let mean = |pair: &[usize]| {
                samples[pair[0]..pair[1]].iter().sum::<f64>() / (pair[1] - pair[0]) as f64
            };
            let mut blocks: Vec<f64> = begins.windows(2).map(mean).collect();
            whitening.apply(&mut samples);
            WhitenedBlocks::new(&whitening, &begins, &mut Settled::default()).apply(&mut blocks);
            let square = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>();
            let (all, few) = (square(&samples), square(&blocks));
            assert!((few / all - 1.0).abs() < 0.01, "{few} for {all}");
        }
    }
}
