//! `palpate device calibrate`: gain and offset of gauges.

use serde::Serialize;

use crate::device::calibrate::Calibrated;

/// Gain and offset of the gauges that were calibrated.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct CalibrationAnswer {
    /// Version of this answer.
    pub palpate_calibration: u32,
    /// One entry for each gauge that was calibrated.
    pub gauges: Vec<CalibratedAnswer>,
}

/// Gain and offset of one gauge: strain = gain (counts − offset).
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct CalibratedAnswer {
    /// The gauge, 1 to 4.
    pub gauge: u8,
    /// Gain, µε per count.
    pub ustrain_per_count: f64,
    /// Standard error of the gain, µε per count; null from two points, or where the gain was given.
    pub ustrain_per_count_standard_error: Option<f64>,
    /// Counts without strain.
    pub offset_counts: i32,
    /// Standard error of the offset, counts; null from two points, or where the offset was given.
    pub offset_counts_standard_error: Option<f64>,
    /// Largest distance of a point from the line, over the range of strains; null where gain and offset were given.
    pub nonlinearity: Option<f64>,
}

impl From<&[Calibrated]> for CalibrationAnswer {
    fn from(calibrated: &[Calibrated]) -> Self {
        Self {
            palpate_calibration: 1,
            gauges: calibrated.iter().map(CalibratedAnswer::from).collect(),
        }
    }
}

impl From<&Calibrated> for CalibratedAnswer {
    fn from(calibrated: &Calibrated) -> Self {
        let Calibrated { gauge, sheet, line } = calibrated;
        let errors = line.and_then(|line| line.errors);
        Self {
            gauge: gauge + 1,
            ustrain_per_count: sheet.gain,
            ustrain_per_count_standard_error: errors.map(|(gain, _)| gain),
            offset_counts: sheet.offset,
            offset_counts_standard_error: errors.map(|(_, offset)| offset),
            nonlinearity: line.map(|line| line.nonlinearity),
        }
    }
}
