//! Long holds in block means, on which every exponential is as good as on the samples.
//!
//! A block of samples lasts at most a hundredth of the time since the first. Over it an exponential is
//! straight up to (v Δt)²/24 of what it still is, at most 3e-6 of its amplitude whatever its rate; so a hold
//! of hours is told by some hundred means, and what scatters within the blocks counts as it did.

use std::ops::Range;

use crate::log_blocks::log_blocks;

/// Samples from which on a hold is taken in means.
const LONG: usize = 4096;

/// How samples are taken together.
#[derive(Clone, Debug)]
pub(super) struct Means {
    blocks: Vec<Range<usize>>,
    /// Time of every sample since the first, s.
    times: Vec<f64>,
    /// Root of the weight of every sample; empty where all weigh the same.
    roots: Vec<f64>,
}

impl Means {
    /// Blocks of these times since the first sample, s; none where they are few.
    pub fn new(times: &[f64], roots: &[f64]) -> Option<Self> {
        if times.len() < LONG {
            return None;
        }
        Some(Self { blocks: log_blocks(times), times: times.to_vec(), roots: roots.to_vec() })
    }

    /// Mean time of every block, s.
    pub fn times(&self) -> Vec<f64> {
        self.of(&self.times).0
    }

    /// Root of the weight of every block.
    pub fn block_roots(&self) -> Vec<f64> {
        let weight = |block: &Range<usize>| block.clone().map(|k| self.weight(k)).sum::<f64>();
        self.blocks.iter().map(|block| weight(block).sqrt()).collect()
    }

    /// The means of values, and the weighted sum of squares about a straight line through every block: what
    /// no exponential explains.
    pub fn of(&self, values: &[f64]) -> (Vec<f64>, f64) {
        let mut scatter = 0.0;
        let mean = |block: &Range<usize>| {
            let (mean, about) = self.line(block, values);
            scatter += about;
            mean
        };
        let means = self.blocks.iter().map(mean).collect();
        (means, scatter)
    }

    /// Weighted sum of squares of what a function of time leaves of values, sample by sample.
    pub fn left(&self, values: &[f64], function: impl Fn(f64) -> f64) -> f64 {
        let square = |(k, (time, value)): (usize, (&f64, &f64))| {
            self.weight(k) * (value - function(*time)).powi(2)
        };
        self.times.iter().zip(values).enumerate().map(square).sum()
    }

    fn weight(&self, sample: usize) -> f64 {
        self.roots.get(sample).map_or(1.0, |root| root * root)
    }

    /// Mean over a block, and what scatters about a line through it; of samples that do not count, their
    /// plain mean.
    fn line(&self, block: &Range<usize>, values: &[f64]) -> (f64, f64) {
        let all: f64 = block.clone().map(|k| self.weight(k)).sum();
        let weight = |k: usize| if all > 0.0 { self.weight(k) } else { 1.0 };
        let total: f64 = block.clone().map(weight).sum();
        // From the first of the block, so that an offset costs no digits.
        let (t0, y0) = (self.times[block.start], values[block.start]);
        let sum = |of: &dyn Fn(usize) -> f64| block.clone().map(|k| weight(k) * of(k)).sum::<f64>();
        let (t, y) = (sum(&|k| self.times[k] - t0) / total, sum(&|k| values[k] - y0) / total);
        let time = |k: usize| self.times[k] - t0 - t;
        let value = |k: usize| values[k] - y0 - y;
        let (tt, ty) = (sum(&|k| time(k) * time(k)), sum(&|k| time(k) * value(k)));
        let slope = if tt > 0.0 { ty / tt } else { 0.0 };
        let about = sum(&|k| (value(k) - slope * time(k)).powi(2));
        (y0 + y, if all > 0.0 { about } else { 0.0 })
    }
}
