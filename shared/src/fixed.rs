//! Number formats and units, stated here and nowhere else, and the arithmetic they need.
//!
//! | quantity | type | unit of the last bit | range |
//! |-|-|-|-|
//! | converter counts | `i32` | 1 count | −2^23 … 2^23 − 1 |
//! | strain | `i32` | 2^-8 µε, one *LSB* | −2^23 … 2^23 − 1 (±32768 µε) |
//! | FA, SA | `i32` | 1 LSB | ±2^24, ±3 × 2^23 |
//! | equilibrium, latent, elastic input | `i32` | 1 LSB | ±2^23, ±2^24, ±2^28; four times that after an exchange of shares |
//! | filter memory | `i64` | 2^-37 LSB | ±2^24 LSB |
//! | coefficient | `i32` × 2^-30 + `i32` × 2^-62 | 2^-62 | −1 … 1 |
//! | share k_i, 1/(32 c0) | `i32` | 2^-31 | 0 … 1 |
//! | temperature | `i16` | 2^-8 °C | ±128 °C |
//! | gap of the latency model | `i64` | 2^-40 µε | ±2^23 µε |
//! | logarithm to base 2 | `i64` | 2^-44 | ±2^19 |
//!
//! Conversions from `f64` round to nearest and saturate; a NaN becomes 0, so callers validate first.

/// Fractional bits of a strain in microstrain: one LSB is 2^-8 µε.
pub const STRAIN_FRACTION_BITS: u32 = 8;

/// Largest strain, also the largest count of the 24-bit converter.
pub const STRAIN_MAX: i32 = 0x7f_ffff;

/// Smallest strain, also the smallest count of the 24-bit converter.
pub const STRAIN_MIN: i32 = -0x80_0000;

/// Fractional bits of a temperature in °C: one unit is 2^-8 °C.
pub const TEMPERATURE_FRACTION_BITS: u32 = 8;

const STRAIN_UNITS_PER_MICROSTRAIN: f64 = 256.0;
const TEMPERATURE_UNITS_PER_CELSIUS: f64 = 256.0;

/// Strain (LSB) of a value in microstrain, rounded and saturated to 24 bits.
#[must_use]
pub fn strain_from_microstrain(microstrain: f64) -> i32 {
    round_to_i32(microstrain * STRAIN_UNITS_PER_MICROSTRAIN).clamp(STRAIN_MIN, STRAIN_MAX)
}

/// Microstrain of a strain (LSB), exact.
#[must_use]
pub fn microstrain(strain: i32) -> f64 {
    f64::from(strain) / STRAIN_UNITS_PER_MICROSTRAIN
}

/// Temperature (2^-8 °C) of a value in °C, rounded and saturated to ±128 °C.
#[must_use]
pub fn temperature_from_celsius(celsius: f64) -> i16 {
    libm::round(celsius * TEMPERATURE_UNITS_PER_CELSIUS) as i16
}

/// °C of a temperature (2^-8 °C), exact.
#[must_use]
pub fn celsius(temperature: i16) -> f64 {
    f64::from(temperature) / TEMPERATURE_UNITS_PER_CELSIUS
}

/// Saturates to the 24 bits of a strain or a count.
#[must_use]
pub const fn saturate_to_24_bits(value: i64) -> i32 {
    if value > STRAIN_MAX as i64 {
        STRAIN_MAX
    } else if value < STRAIN_MIN as i64 {
        STRAIN_MIN
    } else {
        value as i32
    }
}

/// Divides by 2^`bits` and rounds to nearest, halves upwards. `bits` is at most 62.
#[must_use]
pub const fn round_shift(value: i64, bits: u32) -> i64 {
    match bits {
        0 => value,
        _ => {
            let half = 1_i64.wrapping_shl(bits.wrapping_sub(1));
            value.saturating_add(half).wrapping_shr(bits)
        }
    }
}

/// Nearest `i32`, saturated.
#[must_use]
pub fn round_to_i32(value: f64) -> i32 {
    libm::round(value) as i32
}

/// A number in −1 … 1 with 62 fractional bits, in two words so that a product costs two multiplications of 32 bits.
///
/// A rate of one per minute, sampled at 4 kHz, is a coefficient of 4 × 10^-6; the second word gives it 44 significant bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Coefficient {
    /// The number rounded to 2^-30.
    pub high: i32,
    /// What rounding left, in 2^-62, signed.
    pub low: i32,
}

impl Coefficient {
    /// The coefficient nearest to `value`, saturated to −1 … 1.
    #[must_use]
    pub fn from_f64(value: f64) -> Self {
        let scaled = value.clamp(-1.0, 1.0) * 1_073_741_824.0;
        let high = round_to_i32(scaled);
        // The difference is exact and at most half a unit.
        let low = round_to_i32((scaled - f64::from(high)) * 4_294_967_296.0);
        Self { high, low }
    }
}

/// A number in −1 … 1 with 31 fractional bits, rounded and saturated.
#[must_use]
pub fn fraction_31(value: f64) -> i32 {
    round_to_i32(value * 2_147_483_648.0)
}

/// The whole 64-bit product of two words; it cannot overflow.
#[must_use]
pub const fn product(a: i32, b: i32) -> i64 {
    (a as i64).wrapping_mul(b as i64)
}

/// The upper word of a product, rounded down.
#[must_use]
pub const fn product_high(a: i32, b: i32) -> i32 {
    (product(a, b) >> 32) as i32
}

/// The upper word of a product, rounded to nearest, halves upwards.
#[must_use]
pub const fn product_high_rounded(a: i32, b: i32) -> i32 {
    // A product is at most 2^62.
    (product(a, b).wrapping_add(1 << 31) >> 32) as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn one_microstrain_is_256_lsb_and_the_range_is_32768_microstrain() {
        assert_eq!(strain_from_microstrain(1.0), 256);
        assert_eq!(strain_from_microstrain(-32_768.0), STRAIN_MIN);
        assert_eq!(strain_from_microstrain(40_000.0), STRAIN_MAX);
        assert_eq!(strain_from_microstrain(f64::NAN), 0);
        assert_eq!(microstrain(-128), -0.5);
    }

    #[test]
    fn a_temperature_outside_its_range_saturates() {
        assert_eq!(temperature_from_celsius(23.5), 6016);
        assert_eq!(temperature_from_celsius(1e9), i16::MAX);
        assert_eq!(celsius(i16::MIN), -128.0);
    }

    proptest! {
        #[test]
        fn round_shift_is_nearest_with_halves_upwards(value in -(1_i64 << 52)..(1_i64 << 52), bits in 0_u32..40) {
            let scale = (1_u64 << bits) as f64;
            prop_assert_eq!(round_shift(value, bits), libm::floor(value as f64 / scale + 0.5) as i64);
        }

        #[test]
        fn strain_survives_the_way_to_microstrain_and_back(strain in STRAIN_MIN..=STRAIN_MAX) {
            prop_assert_eq!(strain_from_microstrain(microstrain(strain)), strain);
        }

        #[test]
        fn a_coefficient_keeps_every_bit_of_a_small_number(value in -1.0_f64..1.0, exponent in 0_i32..20) {
            let value = libm::ldexp(value, -exponent);
            let c = Coefficient::from_f64(value);
            let back = libm::ldexp(f64::from(c.high), -30) + libm::ldexp(f64::from(c.low), -62);
            prop_assert!((back - value).abs() <= libm::ldexp(1.0, -62));
        }

        #[test]
        fn saturation_keeps_what_fits_and_clamps_the_rest(value: i64) {
            let kept = i64::from(saturate_to_24_bits(value));
            prop_assert_eq!(kept, value.clamp(i64::from(STRAIN_MIN), i64::from(STRAIN_MAX)));
        }
    }
}
