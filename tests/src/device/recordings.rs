//! Every bundled recording through a device, compared bit for bit with the host's own pipeline.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use palpate::device::replay::{Replayed, replay};
use palpate::device::session::Session;
use palpate::trace::{Trace, read};
use shared::pipeline::{Config, GAUGES, Output, Pipeline};
use shared::wire::{Columns, REFERENCE_TEMPERATURE, Row};

use super::{Checked, Report, open, require};
use crate::all_bundled;

/// Counts of the largest value of a signal without gauges.
const LARGEST: f64 = 4e6;
/// What the signal is multiplied by for each gauge: large, small, of the other sign.
const FACTORS: [f64; GAUGES] = [1.0, 0.03, -0.7, 0.4];
/// Injected rows are of this temperature, 2^-8 °C.
pub(super) const TEMPERATURE: i16 = REFERENCE_TEMPERATURE;

/// Injects every bundled recording and compares all that comes back with the host's decomposition.
///
/// # Errors
/// The first difference.
pub fn check_every_recording(port: &Path) -> Checked {
    let mut session = open(port)?;
    let began = Instant::now();
    let (mut recordings, mut rows) = (0, 0);
    for path in all_bundled() {
        rows += check_recording(&mut session, &path)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        recordings += 1;
    }
    let rate = rows as f64 / began.elapsed().as_secs_f64();
    Ok(Report::new("recordings, bit for bit")
        .with("recordings", recordings)
        .with("rows", rows)
        .with("rows a second", format!("{rate:.0}")))
}

/// Injects one recording and compares; how many rows.
///
/// # Errors
/// The first difference.
pub fn check_recording(
    session: &mut Session,
    path: &Path,
) -> Result<usize, Box<dyn Error + Send + Sync>> {
    let trace = read(path)?;
    let (counts, interval_ns) = counts_of(&trace);
    let replayed = replay(session, interval_ns, Columns::All, Some(TEMPERATURE), &counts)?;
    let config = session.settings().1.config(f64::from(interval_ns) * 1e-9)?;
    require(replayed.rows.len() == counts.len(), || {
        format!("{} of {} rows came back: {:?}", replayed.rows.len(), counts.len(), replayed.tally)
    })?;
    compare(&config, interval_ns, &counts, &replayed)?;
    Ok(counts.len())
}

/// Whether every row that came back is the one that the host makes of the same counts.
pub(super) fn compare(
    config: &Config,
    interval_ns: u32,
    counts: &[[i32; GAUGES]],
    replayed: &Replayed,
) -> Result<(), String> {
    let expected = expected(config, interval_ns, counts);
    for row in &replayed.rows {
        let at = usize::try_from(row.number).ok().and_then(|at| expected.get(at));
        require(at == Some(row), || {
            format!("row {} came back as\n{row:?}\nand should be\n{at:?}", row.number)
        })?;
    }
    Ok(())
}

/// The rows that a device must give, with all columns.
fn expected(config: &Config, interval_ns: u32, counts: &[[i32; GAUGES]]) -> Vec<Row> {
    let mut pipeline = Pipeline::new(config);
    let row = |(number, counts): (u64, &[i32; GAUGES])| {
        pipeline.process(counts, TEMPERATURE);
        let outputs = pipeline.outputs();
        let of = |value: fn(&Output) -> i32| outputs.each_ref().map(value);
        Row {
            number,
            time_us: number * u64::from(interval_ns) / 1_000,
            counts: *counts,
            fa: of(|output| output.fa),
            sa: of(Output::sa),
            rest: Some((of(|output| output.elastic), of(|output| output.equilibrium))),
            states: outputs.each_ref().map(Output::state),
            entered: outputs.each_ref().map(|output| output.entered_samples_ago),
        }
    };
    (0..).zip(counts).map(row).collect()
}

/// A recording as counts of four gauges, and the interval between its rows, ns.
fn counts_of(trace: &Trace) -> (Vec<[i32; GAUGES]>, u32) {
    let gauges = trace.gauges();
    let signals: Vec<(&[f64], f64)> = if gauges.is_empty() {
        let force = trace.force().unwrap_or(&[]);
        let largest = force.iter().fold(f64::MIN_POSITIVE, |most, value| most.max(value.abs()));
        FACTORS.iter().map(|factor| (force, LARGEST / largest * factor)).collect()
    } else {
        let column = |name: &str| trace.column(name).unwrap_or(&[]);
        // About the counts of the default calibration.
        gauges.into_iter().map(|name| (column(name), 1_500.0)).collect()
    };
    let row = |at: usize| {
        let mut row = [0; GAUGES];
        for (count, (signal, factor)) in row.iter_mut().zip(&signals) {
            *count = (signal[at] * factor).round().clamp(-8_388_608.0, 8_388_607.0) as i32;
        }
        row
    };
    let interval_s = trace.duration() / (trace.len().max(2) - 1) as f64;
    ((0..trace.len()).map(row).collect(), (interval_s * 1e9).round() as u32)
}
