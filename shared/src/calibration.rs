//! Counts of the converter → strain, with tare and temperature compensation.
//!
//! strain = gain (counts − offset) − κ (T − T0) − tare, saturated to 24 bits; formats are those of [`crate::fixed`].
//!
//! The gain is a 31-bit mantissa and a power of two and costs two multiplications of 32 bits; their rounding moves a strain
//! by at most 0.75 LSB, that of κ (T − T0) by 0.5. What does not change from sample to sample, κ (T − T0) + tare, is
//! computed once for a temperature: the zero of a [`Conversion`].

use core::fmt;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use crate::fixed::{STRAIN_FRACTION_BITS, TEMPERATURE_FRACTION_BITS, temperature_from_celsius};
use crate::fixed::{STRAIN_MAX, STRAIN_MIN, round_shift, round_to_i32};
use crate::fixed::{product, product_high_rounded};
use crate::flags::Flags;

/// Smallest and largest |gain|, µε per count.
pub const GAIN_RANGE: core::ops::RangeInclusive<f64> = 1.0 / 268_435_456.0..=0.125;
/// Largest |κ|, µε/°C.
pub const MAX_TEMPERATURE_COEFFICIENT: f64 = 100.0;

/// Fractional bits of κ in LSB/°C.
const COEFFICIENT_BITS: u32 = 16;
/// A difference of two counts has 25 bits; seven zeros below fill the word.
const DIFFERENCE_BITS: u32 = 7;

/// What the calibration of one gauge states, in physical units.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize, Schema)]
pub struct Sheet {
    /// µε per count; negative if the bridge is wired so that pressing lowers the counts. |gain| within [`GAIN_RANGE`].
    pub gain: f64,
    /// Counts without strain, at `reference_celsius`; 24 bits.
    pub offset: i32,
    /// κ, apparent strain per degree, µε/°C; at most [`MAX_TEMPERATURE_COEFFICIENT`].
    pub temperature_coefficient: f64,
    /// T0, °C; −100 … 100.
    pub reference_celsius: f64,
}

/// Why a [`Calibration`] cannot be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CalibrationError {
    /// The gain is zero, not a number or outside [`GAIN_RANGE`], µε per count.
    Gain(f64),
    /// The offset is not a 24-bit number.
    Offset(i32),
    /// κ is not a number or too large, µε/°C.
    TemperatureCoefficient(f64),
    /// T0 is not within −100 … 100 °C.
    ReferenceTemperature(f64),
}

impl fmt::Display for CalibrationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Gain(gain) => {
                let (least, most) = (GAIN_RANGE.start(), GAIN_RANGE.end());
                write!(
                    f,
                    "gain of {gain} microstrain per count must lie between {least:e} and {most}, either sign"
                )
            }
            Self::Offset(offset) => write!(f, "offset of {offset} counts does not fit in 24 bits"),
            Self::TemperatureCoefficient(k) => write!(
                f,
                "temperature coefficient of {k} microstrain/°C must lie within ±{MAX_TEMPERATURE_COEFFICIENT}"
            ),
            Self::ReferenceTemperature(t) => {
                write!(f, "reference temperature of {t} °C must lie within ±100 °C")
            }
        }
    }
}

impl core::error::Error for CalibrationError {}

/// The calibration of one gauge as integers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Calibration {
    /// 0.5 … 1, 31 fractional bits, negative for a negative gain.
    mantissa: i32,
    /// A power of two, as [`Conversion`] takes it.
    scale: i32,
    offset: i32,
    coefficient: i32,
    reference: i16,
    tare: i32,
}

/// A [`Calibration`] at one temperature: what is left to do for every sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conversion {
    /// Counts without strain, `DIFFERENCE_BITS` fractional bits.
    offset: i32,
    mantissa: i32,
    scale: i32,
    /// What a gauge without strain reads, LSB.
    zero: i32,
}

/// A calibrated sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Calibrated {
    /// Strain, LSB, within 24 bits.
    pub strain: i32,
    /// Whether the converter or the result was at its limit.
    pub flags: Flags,
}

impl Calibration {
    /// Rounds a sheet to integers; no tare.
    ///
    /// # Errors
    /// [`CalibrationError`] names the entry that is out of range.
    ///
    /// ```
    /// use palpate_shared::calibration::{Calibration, Sheet};
    /// let sheet = Sheet { gain: 0.004, offset: 1_000, temperature_coefficient: 2.0, reference_celsius: 20.0 };
    /// let calibration = Calibration::new(&sheet)?;
    /// let at_25_celsius = 25 * 256;
    /// assert_eq!(calibration.apply(251_000, at_25_celsius).strain, (1_000 - 10) * 256);
    /// # Ok::<(), palpate_shared::calibration::CalibrationError>(())
    /// ```
    pub fn new(sheet: &Sheet) -> Result<Self, CalibrationError> {
        let Sheet { gain, offset, temperature_coefficient, reference_celsius } = *sheet;
        if !GAIN_RANGE.contains(&libm::fabs(gain)) {
            return Err(CalibrationError::Gain(gain));
        }
        if !(STRAIN_MIN..=STRAIN_MAX).contains(&offset) {
            return Err(CalibrationError::Offset(offset));
        }
        let most = MAX_TEMPERATURE_COEFFICIENT;
        if !(-most..=most).contains(&temperature_coefficient) {
            return Err(CalibrationError::TemperatureCoefficient(temperature_coefficient));
        }
        if !(-100.0..=100.0).contains(&reference_celsius) {
            return Err(CalibrationError::ReferenceTemperature(reference_celsius));
        }
        // Two upper words take away 2^64 and the difference brings 2^7: in LSB the gain is mantissa × scale × 2^-57. The
        // scale is a power of two that leaves the mantissa 31 bits (the largest of all is 2^31 − 1).
        let gain = libm::ldexp(gain, STRAIN_FRACTION_BITS as i32);
        let (_, exponent) = libm::frexp(gain);
        let scale = round_to_i32(libm::ldexp(1.0, exponent.saturating_add(26)));
        let coefficient_bits = COEFFICIENT_BITS.saturating_add(STRAIN_FRACTION_BITS) as i32;
        Ok(Self {
            mantissa: round_to_i32(libm::ldexp(gain, 57) / f64::from(scale)),
            scale,
            offset,
            coefficient: round_to_i32(libm::ldexp(temperature_coefficient, coefficient_bits)),
            reference: temperature_from_celsius(reference_celsius),
            tare: 0,
        })
    }

    /// The calibration at a temperature (2^-8 °C).
    #[must_use]
    pub fn at(&self, temperature: i16) -> Conversion {
        Conversion {
            offset: self.offset << DIFFERENCE_BITS,
            mantissa: self.mantissa,
            scale: self.scale,
            zero: self.apparent(temperature).saturating_add(self.tare),
        }
    }

    /// Strain of a count at a temperature (2^-8 °C). A count beyond 24 bits is taken as the rail.
    #[must_use]
    pub fn apply(&self, counts: i32, temperature: i16) -> Calibrated {
        self.at(temperature).apply(counts)
    }

    /// The same calibration with the tare that makes this sample read zero.
    #[must_use]
    pub fn tared(&self, counts: i32, temperature: i16) -> Self {
        let untared = self.untared();
        let counts = counts.clamp(STRAIN_MIN, STRAIN_MAX);
        Self { tare: untared.at(temperature).unlimited(counts), ..untared }
    }

    /// The same calibration with a tare, LSB of strain.
    #[must_use]
    pub const fn with_tare(&self, tare: i32) -> Self {
        Self { tare, ..*self }
    }

    /// The same calibration without tare.
    #[must_use]
    pub const fn untared(&self) -> Self {
        Self { tare: 0, ..*self }
    }

    /// The tare, LSB of strain; 0 without.
    #[must_use]
    pub const fn tare(&self) -> i32 {
        self.tare
    }

    /// Strain that a temperature feigns, LSB: at most 228 °C from the reference, 23 bits.
    fn apparent(&self, temperature: i16) -> i32 {
        let warmer = i32::from(temperature).wrapping_sub(i32::from(self.reference));
        let bits = COEFFICIENT_BITS.saturating_add(TEMPERATURE_FRACTION_BITS);
        round_shift(product(warmer, self.coefficient), bits) as i32
    }
}

impl Conversion {
    /// Strain of a count. A count beyond 24 bits is taken as the rail.
    #[inline]
    #[must_use]
    pub fn apply(&self, counts: i32) -> Calibrated {
        match self.ordinary(counts) {
            Some(strain) => Calibrated { strain, flags: Flags::NONE },
            None => self.limited(counts),
        }
    }

    /// Strain of a count, if there is nothing to warn of.
    #[inline(always)]
    pub(crate) fn ordinary(&self, counts: i32) -> Option<i32> {
        let strain = self.unlimited(counts);
        // One test for both: the rails of the converter are its largest sizes, a strain may have them.
        let warn = (size(counts).wrapping_add(1) | size(strain)) >= 1 << 23;
        if warn { None } else { Some(strain) }
    }

    /// Strain of any count. Rare, so that an ordinary sample is spared limits and flags.
    #[cold]
    pub(crate) fn limited(&self, counts: i32) -> Calibrated {
        let unlimited = self.unlimited(counts.clamp(STRAIN_MIN, STRAIN_MAX));
        let strain = unlimited.clamp(STRAIN_MIN, STRAIN_MAX);
        let at_rail = counts >= STRAIN_MAX || counts <= STRAIN_MIN;
        let flags = Flags::CONVERTER_AT_RAIL.when(at_rail)
            | Flags::STRAIN_SATURATED.when(strain != unlimited);
        Calibrated { strain, flags }
    }

    /// Strain of 24 bits of counts before it is limited: a difference of 25 bits times a gain up to 2^5 LSB, less a zero
    /// that is smaller than twice that.
    #[inline(always)]
    fn unlimited(&self, counts: i32) -> i32 {
        let difference = (counts << DIFFERENCE_BITS).wrapping_sub(self.offset);
        product_high_rounded(product_high_rounded(difference, self.mantissa), self.scale)
            .wrapping_sub(self.zero)
    }
}

/// How large a number is; one less for a negative one, so that a number of 24 bits has a size below 2^23.
#[inline]
const fn size(value: i32) -> u32 {
    (value ^ (value >> 31)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SHEET: Sheet =
        Sheet { gain: 0.004, offset: -500, temperature_coefficient: 1.7, reference_celsius: 23.0 };

    fn any_sheet() -> impl Strategy<Value = Sheet> {
        (-27.9..-3.01_f64, any::<bool>(), STRAIN_MIN..=STRAIN_MAX, -100.0..100.0, -100.0..100.0)
            .prop_map(|(log_gain, negative, offset, temperature_coefficient, reference_celsius)| {
                let gain = libm::exp2(log_gain) * if negative { -1.0 } else { 1.0 };
                Sheet { gain, offset, temperature_coefficient, reference_celsius }
            })
    }

    #[test]
    fn a_sheet_out_of_range_is_refused_by_entry() {
        let refused = |sheet: Sheet| Calibration::new(&sheet).unwrap_err();
        assert_eq!(refused(Sheet { gain: 0.0, ..SHEET }), CalibrationError::Gain(0.0));
        assert!(matches!(refused(Sheet { gain: f64::NAN, ..SHEET }), CalibrationError::Gain(_)));
        assert_eq!(refused(Sheet { offset: 1 << 23, ..SHEET }), CalibrationError::Offset(1 << 23));
        assert_eq!(
            refused(Sheet { temperature_coefficient: 101.0, ..SHEET }),
            CalibrationError::TemperatureCoefficient(101.0)
        );
        assert_eq!(
            refused(Sheet { reference_celsius: -273.0, ..SHEET }),
            CalibrationError::ReferenceTemperature(-273.0)
        );
    }

    #[test]
    fn a_converter_at_its_rail_is_flagged_and_so_is_a_strain_that_does_not_fit() {
        let calibration = Calibration::new(&SHEET).unwrap();
        for rail in [STRAIN_MAX, STRAIN_MIN, i32::MAX, i32::MIN] {
            let flags = calibration.apply(rail, 0).flags;
            assert!(flags.contains(Flags::CONVERTER_AT_RAIL), "{rail}");
        }
        assert_eq!(calibration.apply(STRAIN_MAX - 1, 23 * 256).flags, Flags::STRAIN_SATURATED);
        assert_eq!(calibration.apply(0, 23 * 256).flags, Flags::NONE);
    }

    proptest! {
        #[test]
        fn strain_is_the_formula_of_the_head_to_one_lsb(
            sheet in any_sheet(), counts in STRAIN_MIN..=STRAIN_MAX, temperature: i16,
        ) {
            let got = Calibration::new(&sheet).unwrap().apply(counts, temperature).strain;
            let celsius = f64::from(temperature) / 256.0;
            let reference = libm::round(sheet.reference_celsius * 256.0) / 256.0;
            let microstrain = sheet.gain * (f64::from(counts) - f64::from(sheet.offset))
                - sheet.temperature_coefficient * (celsius - reference);
            let expected = (microstrain * 256.0).clamp(f64::from(STRAIN_MIN), f64::from(STRAIN_MAX));
            prop_assert!((f64::from(got) - expected).abs() <= 1.3, "{got} for {expected}");
        }

        #[test]
        fn tare_reads_zero_and_can_be_taken_back(sheet in any_sheet(), counts: i32, temperature: i16) {
            let calibration = Calibration::new(&sheet).unwrap();
            let tared = calibration.tared(counts, temperature);
            prop_assert_eq!(tared.apply(counts, temperature).strain, 0);
            prop_assert_eq!(tared.tared(counts, temperature), tared);
            prop_assert_eq!(tared.untared(), calibration);
        }
    }
}
