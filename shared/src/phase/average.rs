//! Means of the motion and of the signal, one for each smoothing time.

use crate::fixed::product;

/// Sums up samples until there are enough for a mean, each with its weight: a multiplication and addition in one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Average {
    /// `WEIGHT_BITS` fractional bits.
    motion: i64,
    signal: i64,
    /// What a sample is multiplied by, one divided by their number.
    weight: i32,
    /// Samples still to come.
    left: u32,
    pub(super) samples: u32,
}

const WEIGHT_BITS: u32 = 30;

/// What has been averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Mean {
    pub(super) motion: i32,
    pub(super) signal: i32,
    /// Over how many samples.
    pub(super) samples: u32,
}

impl Mean {
    /// The other way round, if `is`.
    pub(super) const fn turned(self, is: bool) -> Self {
        if !is {
            return self;
        }
        let Self { motion, signal, samples } = self;
        Self { motion: motion.saturating_neg(), signal: signal.saturating_neg(), samples }
    }
}

impl Average {
    /// None yet of 2^`exponent` samples, at most 2^12.
    pub(super) const fn of(exponent: u32) -> Self {
        let samples = 1_u32.wrapping_shl(exponent);
        let weight = 1_i32.wrapping_shl(WEIGHT_BITS.wrapping_sub(exponent));
        Self { motion: 0, signal: 0, weight, left: samples, samples }
    }

    /// Takes one sample; whether it completes the mean.
    #[inline(always)]
    pub(super) const fn add(&mut self, motion: i32, signal: i32) -> bool {
        self.motion = self.motion.wrapping_add(product(motion, self.weight));
        self.signal = self.signal.wrapping_add(product(signal, self.weight));
        self.left = self.left.wrapping_sub(1);
        self.left == 0
    }

    pub(super) const fn mean(&self) -> Mean {
        Mean {
            motion: (self.motion >> WEIGHT_BITS) as i32,
            signal: (self.signal >> WEIGHT_BITS) as i32,
            samples: self.samples,
        }
    }
}
