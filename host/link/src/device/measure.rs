//! Short streams: to read zero, and to average counts; and whether a signal stands still enough to be averaged.

use std::time::{Duration, Instant};

use shared::pipeline::GAUGES;
use shared::wire::{Columns, Source, Start, ToDevice};

use super::heard::Said;
use super::session::{LinkError, Session};

/// Rows that must have come before zero is taken.
const ROWS_BEFORE_ZERO: usize = 64;
/// Nothing came for so long: the converter stands still.
const STANDSTILL: Duration = Duration::from_secs(2);

/// Raw counts of a gauge over some time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean {
    /// Their mean.
    pub counts: f64,
    /// Their standard deviation.
    pub deviation: f64,
    /// How many.
    pub samples: usize,
}

/// Rows that come in some time of the device, s, at an interval, s: at least one.
#[must_use]
pub fn rows_over(seconds: f64, interval_s: f64) -> usize {
    (seconds / interval_s).round().max(1.0) as usize
}

/// Averages the raw counts of every gauge over some time of the device: as many rows, however late a busy computer hears them.
///
/// # Errors
/// [`LinkError`]; [`LinkError::NoRows`].
pub fn mean(session: &mut Session, over: Duration) -> Result<[Mean; GAUGES], LinkError> {
    start(session)?;
    let wanted = rows_over(over.as_secs_f64(), session.interval_s());
    let rows = hear_rows(session, |rows| rows >= wanted)?;
    session.quiet()?;
    Ok(means(&rows[..wanted.min(rows.len())]))
}

/// The means of every gauge over rows of raw counts, of which there must be one.
#[must_use]
pub fn means(rows: &[[i32; GAUGES]]) -> [Mean; GAUGES] {
    let samples = rows.len();
    let count = samples as f64;
    std::array::from_fn(|gauge| {
        let values = || rows.iter().map(|row| f64::from(row[gauge]));
        let counts = values().sum::<f64>() / count;
        let square = values().map(|value| (value - counts).powi(2)).sum::<f64>();
        Mean { counts, deviation: (square / (count - 1.0).max(1.0)).sqrt(), samples }
    })
}

/// How far raw counts moved over a stretch, by the line of least squares through them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// From the beginning of the stretch to its end.
    pub counts: f64,
    /// Standard deviation about the line.
    pub scatter: f64,
}

impl Drift {
    /// Whether it moved by no more than its scatter, or by no more than the converter's last digit.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        self.counts.abs() <= self.scatter.max(1.0)
    }
}

/// The drift of every gauge over evenly sampled rows; none of fewer than three.
#[must_use]
pub fn drifts(rows: &[[i32; GAUGES]]) -> Option<[Drift; GAUGES]> {
    if rows.len() < 3 {
        return None;
    }
    let count = rows.len() as f64;
    let middle = (count - 1.0) / 2.0;
    let spread: f64 = (0..rows.len()).map(|at| (at as f64 - middle).powi(2)).sum();
    let means = means(rows);
    Some(std::array::from_fn(|gauge| {
        let mean = means[gauge].counts;
        let values = || rows.iter().enumerate().map(|(at, row)| (at as f64 - middle, row[gauge]));
        let common: f64 = values().map(|(at, counts)| at * (f64::from(counts) - mean)).sum();
        let slope = common / spread;
        let away = |(at, counts): (f64, i32)| (f64::from(counts) - mean - slope * at).powi(2);
        let scatter = (values().map(away).sum::<f64>() / (count - 2.0)).sqrt();
        Drift { counts: slope * (count - 1.0), scatter }
    }))
}

/// Reads zero from now on, on every gauge.
///
/// # Errors
/// As [`mean`].
pub fn tare(session: &mut Session) -> Result<(), LinkError> {
    start(session)?;
    hear_rows(session, |rows| rows >= ROWS_BEFORE_ZERO)?;
    session.command(&ToDevice::Tare)?;
    session.quiet()
}

fn start(session: &mut Session) -> Result<(), LinkError> {
    session.settle()?;
    let start = Start { source: Source::Converter, columns: Columns::Parts };
    session.command(&ToDevice::Start(start)).map(drop)
}

fn hear_rows(
    session: &mut Session,
    enough: impl Fn(usize) -> bool,
) -> Result<Vec<[i32; GAUGES]>, LinkError> {
    let mut counts = Vec::new();
    let mut last = Instant::now();
    while counts.is_empty() || !enough(counts.len()) {
        if last.elapsed() > STANDSTILL {
            return Err(LinkError::NoRows);
        }
        let Some(heard) = session.hear(last + STANDSTILL)? else { continue };
        if let Ok((_, Said::Rows(rows))) = &heard.said {
            last = Instant::now();
            let rows = session.rows(rows).into_iter().flatten();
            counts.extend(rows.map(|row| row.counts));
        }
    }
    Ok(counts)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts that climb so far over 1001 rows, with a scatter of about 7.
    fn climbing(by: f64) -> Vec<[i32; GAUGES]> {
        let row = |at: i32| (by * f64::from(at) / 1e3).round() as i32 + (at * 37 % 23) - 11;
        (0..=1_000).map(|at| [row(at); GAUGES]).collect()
    }

    #[test]
    fn means_and_scatter_are_those_of_the_counts() {
        let means = means(&[[1, 0, -5, 7], [3, 0, -5, 7], [5, 0, -5, 7]]);
        assert_eq!(means[0], Mean { counts: 3.0, deviation: 2.0, samples: 3 });
        assert_eq!((means[2].counts, means[2].deviation), (-5.0, 0.0));
    }

    #[test]
    fn what_moves_beyond_its_scatter_is_not_settled() {
        let drift = |by| drifts(&climbing(by)).unwrap()[0];
        for by in [0.0, 3.0, -3.0] {
            assert!(drift(by).is_settled(), "{by}: {:?}", drift(by));
        }
        for by in [50.0, -50.0, 5_000.0] {
            let drift = drift(by);
            assert!((drift.counts - by).abs() < 1.0 && (6.0..8.0).contains(&drift.scatter));
            assert!(!drift.is_settled(), "{by}: {drift:?}");
        }
        assert!(drifts(&[[5; GAUGES]; 3]).unwrap()[0].is_settled(), "nothing moves at all");
        assert_eq!(drifts(&[[5; GAUGES]; 2]), None);
    }
}
