//! The gap of the latency model in fixed point, with the logarithm and the exponential to base 2 that it needs.
//!
//! Series in 62 fractional bits, cut where the next term is below 2^-50; no tables. Products of 64 × 64 bits: this serves
//! models that run beside the stream, not the filter of every sample.

use core::ops::{Add, Sub};

use super::Gap;

/// Fractional bits of a logarithm.
const LOG_BITS: u32 = 44;
const LOG_ONE: i64 = 1 << LOG_BITS;
/// Fractional bits inside the series; 1.0 leaves one bit for the sign and one for numbers up to 2.
const SERIES_BITS: u32 = 62;
const ONE: i64 = 1 << SERIES_BITS;
/// ln 2 and its inverse, 62 fractional bits.
const LN_2: i64 = 3_196_577_161_300_663_915;
const INVERSE_LN_2_HALF: i64 = 3_326_628_274_461_080_623;
/// log2 (1/ln 2), as a logarithm.
const LOG2_INVERSE_LN_2: i64 = 9_302_156_406_878;

/// A gap in 2^-40 µε, which is 2^-32 LSB of strain; ±2^23 µε.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FixedGap(i64);

/// A logarithm to base 2 with 44 fractional bits; sums saturate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FixedLog(i64);

impl FixedGap {
    /// One unit, 2^-40 µε.
    pub const RESOLUTION_MICROSTRAIN: f64 = 1.0 / (1_u64 << Self::FRACTION_BITS) as f64;
    const FRACTION_BITS: u32 = 40;
    const ABOVE_STRAIN: u32 = Self::FRACTION_BITS - crate::fixed::STRAIN_FRACTION_BITS;

    /// From its integer representation, in 2^-40 µε.
    #[must_use]
    pub const fn from_bits(bits: i64) -> Self {
        Self(bits)
    }

    /// Its integer representation, in 2^-40 µε.
    #[must_use]
    pub const fn bits(self) -> i64 {
        self.0
    }

    /// The gap between two strains (LSB), exact.
    #[must_use]
    pub const fn between(strain: i32, equilibrium: i32) -> Self {
        let gap = (strain as i64).wrapping_sub(equilibrium as i64);
        // 33 bits and 32 zeros would not fit; strains of 24 bits do.
        Self(gap.saturating_mul(1 << Self::ABOVE_STRAIN))
    }

    /// Rounded and saturated; NaN becomes 0.
    #[must_use]
    pub fn from_microstrain(microstrain: f64) -> Self {
        Self(libm::round(microstrain / Self::RESOLUTION_MICROSTRAIN) as i64)
    }

    /// As a floating-point number.
    #[must_use]
    pub fn microstrain(self) -> f64 {
        self.0 as f64 * Self::RESOLUTION_MICROSTRAIN
    }
}

impl Add for FixedLog {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl Sub for FixedLog {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

impl Gap for FixedGap {
    type Log = FixedLog;

    fn log(value: f64) -> FixedLog {
        FixedLog(libm::round(value * LOG_ONE as f64) as i64)
    }

    fn log2(self) -> Option<FixedLog> {
        let magnitude = self.0.unsigned_abs();
        (magnitude != 0).then(|| FixedLog(log2(magnitude, Self::FRACTION_BITS)))
    }

    fn times(factor: FixedLog, log: FixedLog) -> FixedLog {
        FixedLog(multiply(factor.0, log.0, LOG_BITS))
    }

    fn log2_ln_1p(log: FixedLog) -> FixedLog {
        FixedLog(log2_ln_1p(log.0))
    }

    fn decayed(self, log: FixedLog) -> Self {
        let magnitude = decayed(self.0.unsigned_abs(), log.0);
        // Not larger than |self|; the sign of the smallest i64 survives too.
        Self(if self.0 < 0 { 0_i64.wrapping_sub_unsigned(magnitude) } else { magnitude as i64 })
    }
}

/// a b 2^-shift, rounded, saturated.
const fn multiply(a: i64, b: i64, shift: u32) -> i64 {
    let product = (a as i128).wrapping_mul(b as i128);
    let half = 1_i128.wrapping_shl(shift).wrapping_shr(1);
    let value = product.wrapping_add(half).wrapping_shr(shift);
    if value > i64::MAX as i128 {
        i64::MAX
    } else if value < i64::MIN as i128 {
        i64::MIN
    } else {
        value as i64
    }
}

/// c0 + x (c1 + x (c2 + …)), 62 fractional bits; |x| and every partial sum below 2.
fn polynomial(x: i64, coefficients: &[i64]) -> i64 {
    coefficients.iter().rev().fold(0, |sum, c| c.saturating_add(multiply(sum, x, SERIES_BITS)))
}

/// 1, 1/3, 1/5, …: artanh(s)/s in s².
const ARTANH: [i64; 12] = [
    ONE,
    ONE / 3,
    ONE / 5,
    ONE / 7,
    ONE / 9,
    ONE / 11,
    ONE / 13,
    ONE / 15,
    ONE / 17,
    ONE / 19,
    ONE / 21,
    ONE / 23,
];

/// 1, −1/2!, 1/3!, …: (1 − e^−x)/x.
const ONE_MINUS_EXP: [i64; 14] = [
    ONE,
    -ONE / 2,
    ONE / 6,
    -ONE / 24,
    ONE / 120,
    -ONE / 720,
    ONE / 5_040,
    -ONE / 40_320,
    ONE / 362_880,
    -ONE / 3_628_800,
    ONE / 39_916_800,
    -ONE / 479_001_600,
    ONE / 6_227_020_800,
    -ONE / 87_178_291_200,
];

/// (m − 1)/(m + 1) for a mantissa m of 62 fractional bits, 0 < m < 2.
fn half_ratio(m: i64) -> i64 {
    let above = i128::from(m).wrapping_sub(i128::from(ONE)).wrapping_shl(SERIES_BITS);
    let below = i128::from(m).wrapping_add(i128::from(ONE)).max(1);
    above.checked_div(below).unwrap_or(0) as i64
}

/// log2 of a positive integer with `fraction_bits` fractional bits, as a logarithm.
fn log2(value: u64, fraction_bits: u32) -> i64 {
    // Mantissa in 1 … 2, then in 0.707 … 1.414 so that the series converges fast.
    let lead = value.leading_zeros();
    let mut exponent = 63_i64.wrapping_sub(i64::from(lead)).wrapping_sub(i64::from(fraction_bits));
    let mut mantissa = (value.wrapping_shl(lead) >> 1) as i64;
    const SQRT_2: i64 = 6_521_908_912_666_391_106;
    if mantissa > SQRT_2 {
        mantissa >>= 1;
        exponent = exponent.wrapping_add(1);
    }
    let s = half_ratio(mantissa);
    let ln_half = multiply(s, polynomial(multiply(s, s, SERIES_BITS), &ARTANH), SERIES_BITS);
    // log2 m = 2 artanh(s) / ln 2; half of 1/ln 2 fits the format, so two factors of two remain.
    let fraction = multiply(ln_half, INVERSE_LN_2_HALF, SERIES_BITS.wrapping_add(16));
    exponent.saturating_mul(LOG_ONE).saturating_add(fraction)
}

/// 2^log split into a mantissa of 62 fractional bits, 1 … 2, and an exponent.
fn exp2(log: i64) -> (i64, i64) {
    let exponent = log >> LOG_BITS;
    let fraction = log & LOG_ONE.wrapping_sub(1);
    // 2^f = 2 e^−x with x = (1 − f) ln 2 in 0 … ln 2.
    let rest = LOG_ONE.wrapping_sub(fraction);
    let x = multiply(rest, LN_2, LOG_BITS);
    let falls = multiply(x, polynomial(x, &ONE_MINUS_EXP), SERIES_BITS);
    // Below 1.0 before doubling, so the doubled mantissa fits.
    (ONE.wrapping_sub(falls).wrapping_mul(2).clamp(ONE, i64::MAX), exponent)
}

/// 2^log with `fraction_bits`, rounded down; 0 when too small, saturated when too large.
fn exp2_fixed(log: i64, fraction_bits: u32) -> i64 {
    let (mantissa, exponent) = exp2(log);
    let shift =
        i64::from(SERIES_BITS).wrapping_sub(i64::from(fraction_bits)).wrapping_sub(exponent);
    match shift {
        ..0 => i64::MAX,
        0..=62 => mantissa >> shift,
        _ => 0,
    }
}

/// log2 ln(1 + 2^log).
fn log2_ln_1p(log: i64) -> i64 {
    const LN_2_LOG: i64 = -LOG2_INVERSE_LN_2;
    if log > 48 << LOG_BITS {
        // ln(1 + z) = ln z.
        return log2(log as u64, LOG_BITS).saturating_add(LN_2_LOG);
    }
    if log >= -LOG_ONE {
        // log2(1 + z) = log2(1 + 1/z) + log2 z keeps the mantissa below 2.
        let (shared, above) = if log > 0 { (log.wrapping_neg(), log) } else { (log, 0) };
        let sum = exp2_fixed(shared, SERIES_BITS).wrapping_add(ONE) as u64;
        let log2_1p = log2(sum, SERIES_BITS).saturating_add(above);
        return log2(log2_1p.unsigned_abs(), LOG_BITS).saturating_add(LN_2_LOG);
    }
    // ln(1 + z)/z = 2/(2 + z) artanh(s)/s with s = z/(2 + z), close to 1: its logarithm is added to that of z.
    let z = exp2_fixed(log, SERIES_BITS);
    let s = half_ratio(ONE.wrapping_add(z));
    let series = polynomial(multiply(s, s, SERIES_BITS), &ARTANH);
    let ratio = multiply(ONE.wrapping_sub(s), series, SERIES_BITS);
    log.saturating_add(log2(ratio.unsigned_abs(), SERIES_BITS))
}

/// `magnitude` exp(−2^log), rounded to nearest.
fn decayed(magnitude: u64, log: i64) -> u64 {
    let scale = |factor: i64, shift: u32| -> u64 {
        let product = u128::from(magnitude).wrapping_mul(factor.unsigned_abs().into());
        let half = 1_u128.wrapping_shl(shift).wrapping_shr(1);
        product.wrapping_add(half).wrapping_shr(shift) as u64
    };
    if log < -LOG_ONE {
        // e (1 − e^−x) = e x h(x), with x as mantissa and exponent so that slow closing keeps its precision.
        let (mantissa, exponent) = exp2(log);
        let h = polynomial(exp2_fixed(log, SERIES_BITS), &ONE_MINUS_EXP);
        let shift = i64::from(SERIES_BITS).saturating_sub(exponent);
        if shift > 127 {
            return magnitude;
        }
        return magnitude.saturating_sub(scale(multiply(mantissa, h, SERIES_BITS), shift as u32));
    }
    // e^−x = 2^−y with log2 y = log2 x + log2 (1/ln 2); beyond 2^6 nothing of 63 bits is left.
    let log_y = log.saturating_add(LOG2_INVERSE_LN_2);
    if log_y >= 7 << LOG_BITS {
        return 0;
    }
    let (mantissa, exponent) = exp2(exp2_fixed(log_y, LOG_BITS).wrapping_neg());
    let shift = i64::from(SERIES_BITS).saturating_sub(exponent);
    if shift > 127 { 0 } else { scale(mantissa, shift as u32).min(magnitude) }
}
