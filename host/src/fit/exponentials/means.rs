//! Long holds in block means, on which every exponential is as good as on the samples.
//!
//! A block of samples lasts at most a hundredth of the time since the first. Over it an exponential is
//! straight up to (v Δt)²/24 of what it still is, at most 3e-6 of its amplitude whatever its rate; so a hold
//! of hours is told by some hundred means, and what scatters within the blocks counts as it did.

use std::ops::Range;

/// Samples from which on a hold is taken in means.
const LONG: usize = 4096;
/// Duration of a block, over the time since the first sample.
const STEP: f64 = 0.01;

/// How samples are taken together.
#[derive(Clone, Debug)]
pub(super) struct Means {
    blocks: Vec<Range<usize>>,
    /// Root of the weight of every sample; empty where all weigh the same.
    roots: Vec<f64>,
}

impl Means {
    /// Blocks of these times since the first sample, s; none where they are few.
    pub fn new(times: &[f64], roots: &[f64]) -> Option<Self> {
        if times.len() < LONG {
            return None;
        }
        let mut blocks = Vec::new();
        let mut begin = 0;
        while begin < times.len() {
            let reach = times[begin] * (1.0 + STEP);
            let end = begin + times[begin..].partition_point(|time| *time <= reach);
            let end = end.max(begin + 1);
            blocks.push(begin..end);
            begin = end;
        }
        Some(Self { blocks, roots: roots.to_vec() })
    }

    fn weight(&self, sample: usize) -> f64 {
        self.roots.get(sample).map_or(1.0, |root| root * root)
    }

    /// Mean over a block, and what scatters about it; of samples that do not count, their plain mean.
    fn mean(&self, block: &Range<usize>, values: &[f64]) -> (f64, f64) {
        let first = values[block.start];
        let (mut sum, mut weight) = (0.0, 0.0);
        for k in block.clone() {
            sum += self.weight(k) * (values[k] - first);
            weight += self.weight(k);
        }
        if weight == 0.0 {
            let plain: f64 = values[block.clone()].iter().map(|value| value - first).sum();
            return (first + plain / block.len() as f64, 0.0);
        }
        let mean = first + sum / weight;
        let about = |k: usize| self.weight(k) * (values[k] - mean).powi(2);
        (mean, block.clone().map(about).sum())
    }

    /// The means of values, and the weighted sum of squares about them.
    pub fn of(&self, values: &[f64]) -> (Vec<f64>, f64) {
        let mut within = 0.0;
        let mean = |block: &Range<usize>| {
            let (mean, about) = self.mean(block, values);
            within += about;
            mean
        };
        let means = self.blocks.iter().map(mean).collect();
        (means, within)
    }

    /// Root of the weight of every block.
    pub fn block_roots(&self) -> Vec<f64> {
        let weight = |block: &Range<usize>| block.clone().map(|k| self.weight(k)).sum::<f64>();
        self.blocks.iter().map(|block| weight(block).sqrt()).collect()
    }
}
