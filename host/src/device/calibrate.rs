//! Gain and offset of a gauge, from counts under known strains.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use shared::calibration::Sheet;
use shared::pipeline::GAUGES;

/// One known strain, and what the converter made of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Strain, µε.
    pub strain: f64,
    /// Mean of the raw counts.
    pub counts: f64,
}

/// A line through points: strain = gain (counts − offset).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// µε per count.
    pub gain: f64,
    /// Counts without strain.
    pub offset: f64,
    /// Standard errors of gain and offset; none from two points, which every line of two parameters meets.
    pub errors: Option<(f64, f64)>,
    /// Largest distance of a point from the line over the range of strains.
    pub nonlinearity: f64,
}

/// Why points give no line.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)]
pub enum CalibrateError {
    #[error("two different strains are needed")]
    OneStrain,
    #[error("the counts do not change with the strain; is the gauge connected?")]
    NoChange,
    #[error("the offset would be {0:.0} counts, beyond the converter's 24 bits")]
    Offset(f64),
}

/// The line of least squares. Strains are known and counts are measured, so the counts scatter about it.
///
/// # Errors
/// [`CalibrateError`].
pub fn line(points: &[Point]) -> Result<Line, CalibrateError> {
    let count = points.len() as f64;
    let mean = |value: fn(&Point) -> f64| points.iter().map(value).sum::<f64>() / count;
    let (strain, counts) = (mean(|point| point.strain), mean(|point| point.counts));
    let sum = |value: &dyn Fn(&Point) -> f64| points.iter().map(value).sum::<f64>();
    let spread = sum(&|point| (point.strain - strain).powi(2));
    let common = sum(&|point| (point.strain - strain) * (point.counts - counts));
    if points.len() < 2 || spread <= 0.0 {
        return Err(CalibrateError::OneStrain);
    }
    let slope = common / spread;
    if slope == 0.0 || !slope.is_finite() {
        return Err(CalibrateError::NoChange);
    }
    let (gain, offset) = (slope.recip(), counts - slope * strain);
    let away = |point: &Point| point.counts - offset - slope * point.strain;
    let errors = (points.len() > 2).then(|| {
        let scatter = (sum(&|point| away(point).powi(2)) / (count - 2.0)).sqrt();
        let of_slope = scatter / spread.sqrt();
        let of_offset = scatter * (count.recip() + strain * strain / spread).sqrt();
        (of_slope / slope.powi(2), of_offset)
    });
    let ends = points.iter().map(|point| point.strain);
    let range = ends.clone().fold(f64::MIN, f64::max) - ends.fold(f64::MAX, f64::min);
    let most = points.iter().map(|point| (away(point) * gain).abs()).fold(0.0, f64::max);
    Ok(Line { gain, offset, errors, nonlinearity: most / range })
}

/// Why a file gives no points.
#[derive(Debug, thiserror::Error)]
#[error("{}: {reason}", path.display())]
pub struct PointsError {
    path: PathBuf,
    reason: String,
}

#[derive(Deserialize)]
struct Record {
    gauge: u8,
    strain_ustrain: f64,
    counts: f64,
}

/// Points of each gauge, counted from 0, from a CSV file with the columns `gauge` (from 1), `strain_ustrain` and `counts`.
///
/// # Errors
/// [`PointsError`] names the line.
pub fn read_points(path: &Path) -> Result<Vec<(u8, Vec<Point>)>, PointsError> {
    let wrong = |reason: String| PointsError { path: path.into(), reason };
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_path(path)
        .map_err(|error| wrong(error.to_string()))?;
    let mut points: BTreeMap<u8, Vec<Point>> = BTreeMap::new();
    for record in reader.deserialize() {
        let Record { gauge, strain_ustrain: strain, counts } =
            record.map_err(|error| wrong(error.to_string()))?;
        let at = gauge.checked_sub(1).filter(|at| usize::from(*at) < GAUGES);
        let at = at.ok_or_else(|| wrong(format!("there is no gauge {gauge}; they are 1 to 4")))?;
        if !(strain.is_finite() && counts.is_finite()) {
            return Err(wrong(format!("gauge {gauge}: strain and counts must be finite")));
        }
        points.entry(at).or_default().push(Point { strain, counts });
    }
    if points.is_empty() {
        return Err(wrong("there are no points in it".into()));
    }
    Ok(points.into_iter().collect())
}

impl Line {
    /// The sheet with this line, and `before`'s compensation of temperature.
    ///
    /// # Errors
    /// [`CalibrateError::Offset`].
    pub fn sheet(&self, before: &Sheet) -> Result<Sheet, CalibrateError> {
        if self.offset.abs() >= 8_388_608.0 {
            return Err(CalibrateError::Offset(self.offset));
        }
        Ok(Sheet { gain: self.gain, offset: self.offset.round() as i32, ..*before })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(given: &[(f64, f64)]) -> Vec<Point> {
        given.iter().map(|&(strain, counts)| Point { strain, counts }).collect()
    }

    #[test]
    fn two_points_give_a_line_without_errors() {
        let line = line(&points(&[(0.0, 1_000.0), (500.0, 251_000.0)])).unwrap();
        assert!((line.gain - 0.002).abs() < 1e-15 && (line.offset - 1_000.0).abs() < 1e-9);
        assert_eq!(line.errors, None);
        assert!(line.nonlinearity < 1e-12);
    }

    #[test]
    fn errors_and_nonlinearity_are_those_of_the_text_book() {
        // y = 1.9, 4.1, 6.1, 7.9 over x = 1 … 4: slope 2.00, intercept 0.00; residuals −0.1, 0.1, 0.1, −0.1.
        let line = line(&points(&[(1.0, 1.9), (2.0, 4.1), (3.0, 6.1), (4.0, 7.9)])).unwrap();
        assert!((line.gain - 0.5).abs() < 1e-12 && line.offset.abs() < 1e-12, "{line:?}");
        let scatter = (0.04_f64 / 2.0).sqrt();
        let (gain, offset) = line.errors.unwrap();
        assert!((gain - scatter / 5_f64.sqrt() / 4.0).abs() < 1e-12);
        assert!((offset - scatter * 1.5_f64.sqrt()).abs() < 1e-12);
        assert!((line.nonlinearity - 0.05 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn points_that_give_no_line_are_refused() {
        assert_eq!(line(&points(&[(1.0, 5.0)])), Err(CalibrateError::OneStrain));
        assert_eq!(line(&points(&[(1.0, 5.0), (1.0, 6.0)])), Err(CalibrateError::OneStrain));
        assert_eq!(line(&points(&[(1.0, 5.0), (2.0, 5.0)])), Err(CalibrateError::NoChange));
    }
}
