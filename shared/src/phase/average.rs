//! Means of the motion and of the signal, one for each smoothing time.

/// Sums up samples until there are enough for a mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Average {
    motion: i64,
    signal: i64,
    /// Samples still to come.
    left: u32,
    pub(super) samples: u32,
    /// 2^32 / samples: a multiplication divides sooner than a shift of 64 bits.
    scale: i64,
}

/// What has been averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Mean {
    pub(super) motion: i32,
    pub(super) signal: i32,
    /// Over how many samples.
    pub(super) samples: u32,
}

impl Average {
    /// None yet of 2^`exponent` samples, at most 2^12.
    pub(super) const fn of(exponent: u32) -> Self {
        let samples = 1_u32.wrapping_shl(exponent);
        let scale = 1_i64.wrapping_shl(32_u32.wrapping_sub(exponent));
        Self { motion: 0, signal: 0, left: samples, samples, scale }
    }

    /// Takes one sample; whether it completes the mean.
    #[inline]
    pub(super) const fn add(&mut self, motion: i32, signal: i32) -> bool {
        self.motion = self.motion.wrapping_add(motion as i64);
        self.signal = self.signal.wrapping_add(signal as i64);
        self.left = self.left.wrapping_sub(1);
        self.left == 0
    }

    pub(super) const fn mean(&self) -> Mean {
        Mean {
            motion: self.divided(self.motion),
            signal: self.divided(self.signal),
            samples: self.samples,
        }
    }

    const fn divided(&self, sum: i64) -> i32 {
        (sum.wrapping_mul(self.scale) >> 32) as i32
    }
}
