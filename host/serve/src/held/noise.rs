//! The noise of a signal, from means over short blocks: noise whose neighbours are alike counts as what it does to a mean.

use std::collections::VecDeque;

/// Length of a block, s.
pub(super) const BLOCK_S: f64 = 0.05;
/// Differences kept, and fewest that tell the noise.
const KEPT: usize = 120;
const MIN_MEANS: usize = 12;
/// Least noise of a mean, µε: the smallest step of a strain on the line.
const MIN_NOISE_USTRAIN: f64 = 1.0 / 256.0;
/// Median of the size of a normal variable of unit variance.
const MEDIAN: f64 = 0.674_490;

/// Means over blocks.
#[derive(Clone, Debug, Default)]
pub(super) struct Blocks {
    since: Option<f64>,
    sum: f64,
    count: u32,
}

impl Blocks {
    /// Adds a value at a time, s; the mean of the block that it completes.
    pub(super) fn add(&mut self, time: f64, value: f64) -> Option<f64> {
        let since = *self.since.get_or_insert(time);
        self.sum += value;
        self.count += 1;
        (time - since >= BLOCK_S).then(|| {
            let mean = self.sum / f64::from(self.count);
            *self = Self::default();
            mean
        })
    }
}

/// The noise of a mean over a block.
#[derive(Clone, Debug, Default)]
pub(super) struct Noise {
    /// The last means without a break between them.
    before: VecDeque<f64>,
    /// Sizes of second differences, µε, the oldest first: a straight course has none, a slowly curved one hardly any.
    differences: VecDeque<f64>,
}

impl Noise {
    pub(super) fn add(&mut self, mean: f64) {
        self.before.push_back(mean);
        if let (3, Some(&[a, b, c])) =
            (self.before.len(), self.before.make_contiguous().first_chunk())
        {
            self.differences.push_back((a - 2.0 * b + c).abs());
            self.before.pop_front();
        }
        if self.differences.len() > KEPT {
            self.differences.pop_front();
        }
    }

    /// What comes next does not go on from what was.
    pub(super) fn interrupt(&mut self) {
        self.before.clear();
    }

    /// Standard deviation of a mean over a block, µε; none while it is not known.
    pub(super) fn of_a_block(&self) -> Option<f64> {
        if self.differences.len() < MIN_MEANS {
            return None;
        }
        let mut sizes: Vec<f64> = self.differences.iter().copied().collect();
        sizes.sort_by(f64::total_cmp);
        // A second difference has the variance 1 + 4 + 1.
        let deviation = sizes[sizes.len() / 2] / (MEDIAN * 6f64.sqrt());
        Some(deviation.max(MIN_NOISE_USTRAIN))
    }
}
