//! Gain and offset of a gauge, from counts under known strains.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use shared::calibration::{Calibration, CalibrationError, Sheet};
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

/// Points of each gauge, counted from 0.
pub type Points = Vec<(u8, Vec<Point>)>;

/// The points of a CSV file with the columns `gauge` (from 1), `strain_ustrain` and `counts`.
///
/// # Errors
/// [`PointsError`] names the line.
pub fn read_points(path: &Path) -> Result<Points, PointsError> {
    let wrong = |reason: String| PointsError { path: path.into(), reason };
    let file = std::fs::File::open(path).map_err(|error| wrong(error.to_string()))?;
    points_of(file).map_err(wrong)
}

/// The same of what such a file holds.
///
/// # Errors
/// Names the line.
pub fn points_of(file: impl Read) -> Result<Points, String> {
    let mut reader =
        csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(file);
    let rows = reader.deserialize().map(|record| {
        let Record { gauge, strain_ustrain, counts } = record.map_err(|e| e.to_string())?;
        Ok((gauge, Point { strain: strain_ustrain, counts }))
    });
    by_gauge(rows)
}

/// Points with the gauge that each is of, counted from 1, gauge by gauge.
///
/// # Errors
/// Names the gauge that does not exist, or the point that is none.
pub fn by_gauge(
    rows: impl IntoIterator<Item = Result<(u8, Point), String>>,
) -> Result<Points, String> {
    let mut points: BTreeMap<u8, Vec<Point>> = BTreeMap::new();
    for row in rows {
        let (gauge, point) = row?;
        let at = from_one(gauge)?;
        if !(point.strain.is_finite() && point.counts.is_finite()) {
            return Err(format!("gauge {gauge}: strain and counts must be finite"));
        }
        points.entry(at).or_default().push(point);
    }
    if points.is_empty() {
        return Err("there are no points in it".into());
    }
    Ok(points.into_iter().collect())
}

/// A gauge counted from 0 of one counted from 1.
///
/// # Errors
/// Says which there are.
pub fn from_one(gauge: u8) -> Result<u8, String> {
    let at = gauge.checked_sub(1).filter(|at| usize::from(*at) < GAUGES);
    at.ok_or_else(|| format!("there is no gauge {gauge}; they are 1 to 4"))
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

    /// How far the line's strain is above that of a point, µε.
    #[must_use]
    pub fn residual(&self, point: &Point) -> f64 {
        self.gain * (point.counts - self.offset) - point.strain
    }
}

/// What a gauge's calibration is to become.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibrated {
    /// The gauge, from 0.
    pub gauge: u8,
    /// Its new sheet, within the device's range.
    pub sheet: Sheet,
    /// The line that it came from; none if gain and offset were given.
    pub line: Option<Line>,
}

/// Why a gauge cannot be calibrated so.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)]
pub enum SheetError {
    #[error("gauge {}: {source}", gauge + 1)]
    Line { gauge: u8, source: CalibrateError },
    #[error("gauge {}: {source}", gauge + 1)]
    Range { gauge: u8, source: CalibrationError },
}

impl Calibrated {
    /// By the line through points; temperature is compensated as `before`.
    ///
    /// # Errors
    /// [`SheetError`].
    pub fn by_points(gauge: u8, points: &[Point], before: &Sheet) -> Result<Self, SheetError> {
        let wrong = |source| SheetError::Line { gauge, source };
        let line = line(points).map_err(wrong)?;
        let sheet = line.sheet(before).map_err(wrong)?;
        Self { gauge, sheet, line: Some(line) }.checked()
    }

    /// By gain, µε per count, and offset, counts.
    ///
    /// # Errors
    /// [`SheetError::Range`].
    pub fn by_numbers(
        gauge: u8,
        gain: f64,
        offset: i32,
        before: &Sheet,
    ) -> Result<Self, SheetError> {
        Self { gauge, sheet: Sheet { gain, offset, ..*before }, line: None }.checked()
    }

    fn checked(self) -> Result<Self, SheetError> {
        let wrong = |source| SheetError::Range { gauge: self.gauge, source };
        Calibration::new(&self.sheet).map(|_| self).map_err(wrong)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::answers::CalibratedAnswer;

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
    fn a_residual_is_the_strain_that_the_line_says_too_much() {
        let given = points(&[(1.0, 1.9), (2.0, 4.1), (3.0, 6.1), (4.0, 7.9)]);
        let line = line(&given).unwrap();
        for (point, expected) in given.iter().zip([-0.05, 0.05, 0.05, -0.05]) {
            assert!((line.residual(point) - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn a_sheet_beyond_the_device_is_refused_with_its_gauge() {
        let before =
            Sheet { gain: 1e-3, offset: 0, temperature_coefficient: 0.5, reference_celsius: 20.0 };
        let given = points(&[(0.0, 100.0), (500.0, 250_100.0)]);
        let made = Calibrated::by_points(2, &given, &before).unwrap();
        assert_eq!((made.sheet.offset, made.sheet.temperature_coefficient), (100, 0.5));
        assert_eq!(CalibratedAnswer::from(&made).gauge, 3);
        let steep = points(&[(0.0, 0.0), (500.0, 1.0)]);
        let refused = Calibrated::by_points(2, &steep, &before).unwrap_err().to_string();
        assert!(refused.starts_with("gauge 3: gain of 500"), "{refused}");
        let refused = Calibrated::by_numbers(0, f64::NAN, 0, &before).unwrap_err().to_string();
        assert!(refused.starts_with("gauge 1: gain of NaN"), "{refused}");
    }

    #[test]
    fn a_file_of_points_names_what_is_wrong_in_it() {
        let read = |text: &str| points_of(text.as_bytes());
        let found = read("gauge, strain_ustrain, counts\n2, 0, 5\n1, 3, 4\n").unwrap();
        assert_eq!(found, [(0, points(&[(3.0, 4.0)])), (1, points(&[(0.0, 5.0)]))]);
        for (text, expected) in [
            ("gauge,strain_ustrain,counts\n5,1,2\n", "there is no gauge 5"),
            ("gauge,strain_ustrain,counts\n1,x,2\n", "line"),
            ("gauge,strain_ustrain,counts\n1,inf,2\n", "must be finite"),
            ("gauge,strain_ustrain,counts\n", "no points"),
            ("a,b\n1,2\n", "missing field"),
        ] {
            let refused = read(text).unwrap_err();
            assert!(refused.contains(expected), "{text}: {refused}");
        }
    }

    #[test]
    fn points_that_give_no_line_are_refused() {
        assert_eq!(line(&points(&[(1.0, 5.0)])), Err(CalibrateError::OneStrain));
        assert_eq!(line(&points(&[(1.0, 5.0), (1.0, 6.0)])), Err(CalibrateError::OneStrain));
        assert_eq!(line(&points(&[(1.0, 5.0), (2.0, 5.0)])), Err(CalibrateError::NoChange));
    }
}
