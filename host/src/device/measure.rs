//! Short streams: to read zero, and to average counts.

use std::time::{Duration, Instant};

use shared::pipeline::GAUGES;
use shared::wire::{Columns, Source, Start, ToDevice};

use super::heard::Said;
use super::session::{LinkError, Session};

/// Rows that must have come before zero is taken.
const SETTLED: usize = 64;
/// Nothing came for so long: the converter stands still.
const PATIENCE: Duration = Duration::from_secs(2);

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

/// Averages the raw counts of every gauge over some time.
///
/// # Errors
/// [`LinkError`]; [`LinkError::NoRows`].
pub fn mean(session: &mut Session, over: Duration) -> Result<[Mean; GAUGES], LinkError> {
    start(session)?;
    let began = Instant::now();
    let rows = hear_rows(session, |_| began.elapsed() >= over)?;
    session.quiet()?;
    let samples = rows.len();
    let count = samples as f64;
    Ok([0, 1, 2, 3].map(|gauge| {
        let values = || rows.iter().map(|row| f64::from(row[gauge]));
        let counts = values().sum::<f64>() / count;
        let square = values().map(|value| (value - counts).powi(2)).sum::<f64>();
        Mean { counts, deviation: (square / (count - 1.0).max(1.0)).sqrt(), samples }
    }))
}

/// Reads zero from now on, on every gauge.
///
/// # Errors
/// As [`mean`].
pub fn tare(session: &mut Session) -> Result<(), LinkError> {
    start(session)?;
    hear_rows(session, |rows| rows >= SETTLED)?;
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
        if last.elapsed() > PATIENCE {
            return Err(LinkError::NoRows);
        }
        let Some(heard) = session.hear(last + PATIENCE)? else { continue };
        if let Ok((_, Said::Rows(rows))) = &heard.said {
            last = Instant::now();
            let rows = session.rows(rows).into_iter().flatten();
            counts.extend(rows.map(|row| row.counts));
        }
    }
    Ok(counts)
}
