//! What of FA is faster than a corner frequency.

use super::Config;
use crate::fixed::product;

/// Levels are held in 2^-3 LSB, so that averages are finer than a sample.
const RAISED: u32 = 3;
/// Largest signal or FA admitted, LSB: 25 bits, so that the differences of three stages still fit in 32.
const LARGEST: i32 = (1 << 24) - 1;
const LEAST: i32 = -1 << 24;
/// A jolt weaker than the strongest of late by more than this, as a power of two, does not count.
const MASKED: u32 = 2;
/// FA counts beside vibration as if it were weaker by this, as a power of two.
const DROWNED: u32 = 8;

/// A value in LSB as the filters take it.
#[inline(always)]
pub(super) fn raised(value: i32) -> i32 {
    value.clamp(LEAST, LARGEST) << RAISED
}

/// A low pass of first order; its level has 32 fractional bits more than a raised value, so that the upper word is one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct LowPass(i64);

impl LowPass {
    pub(super) const fn at(level: i32) -> Self {
        Self((level as i64) << 32)
    }

    pub(super) const fn level(self) -> i32 {
        (self.0 >> 32) as i32
    }

    /// Follows a value with a share (31 fractional bits) of the way; gives its new level.
    #[inline(always)]
    pub(super) const fn follow(&mut self, share: i32, value: i32) -> i32 {
        // Levels and values of one stage are within 2^29, so twice their difference fits; and a share is less than the whole, so
        // that the new level lies between the two.
        let way = value.wrapping_sub(self.level());
        self.0 = self.0.wrapping_add(product(way << 1, share));
        self.level()
    }

    /// Falls towards zero with a share of the way, but not below a value; gives its new level.
    #[inline(always)]
    fn at_least(&mut self, share: i32, value: i32) -> i32 {
        if self.follow(share, 0) < value {
            *self = Self::at(value);
        }
        self.level()
    }
}

/// Three high passes one behind the other, and what is strong enough to be heard behind what was felt of late.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Vibration {
    stages: [LowPass; 3],
    /// The strongest vibration of late, or the largest smoothed FA of late as it counts beside it; forgets with the time of a
    /// mask.
    strongest: LowPass,
    /// When the last jolt came, if any did.
    last: Option<u32>,
}

impl Vibration {
    pub(super) const NONE: Self =
        Self { stages: [LowPass::at(0); 3], strongest: LowPass::at(0), last: None };

    /// Takes a raised FA, and smoothed; whether it is as strong as a jolt.
    #[inline(always)]
    pub(super) fn shakes(&mut self, config: &Config, fa: i32, smooth: i32) -> bool {
        let mut rest = fa;
        for stage in &mut self.stages {
            rest = rest.wrapping_sub(stage.follow(config.corner, rest));
        }
        let strength = rest.wrapping_abs();
        let felt = strength.max(smooth.wrapping_abs() >> DROWNED);
        let strongest = self.strongest.at_least(config.masking, felt);
        strength >= config.jolt && strength >= strongest >> MASKED
    }

    /// Something as strong as a jolt comes: whether it is one, far enough behind the last.
    #[inline(always)]
    pub(super) fn jolts(&mut self, config: &Config, now: u32) -> bool {
        if self.last.is_some_and(|last| now.wrapping_sub(last) < config.apart) {
            return false;
        }
        self.last = Some(now);
        config.jolts > 0
    }

    /// Forgets a jolt that is too long ago to matter.
    pub(super) fn forget(&mut self, config: &Config, now: u32) {
        self.last = self.last.filter(|last| now.wrapping_sub(*last) < config.apart);
    }
}
