//! A stream for a long time.

use std::path::Path;
use std::time::{Duration, Instant};

use palpate::device::heard::Said;
use palpate::device::replay::inject;
use palpate::device::stream::Stream;
use shared::pipeline::GAUGES;
use shared::wire::{Columns, INJECT_ROWS, Source, Start, ToDevice};

use super::{Checked, Report, open, require};

/// Time between rows, ns: 1 kHz.
const INTERVAL_NS: u32 = 1_000_000;
/// Time of the rows that are injected at once, ns.
const BLOCK_NS: u64 = INJECT_ROWS as u64 * INTERVAL_NS as u64;
/// The line must not take more than this, B/s.
const MOST_BYTES_PER_S: f64 = 30_000.0;

/// Four gauges at 1 kHz, in time, for so long: no row is lost anywhere, the line has room, and the stack does not grow after
/// the first tenth.
///
/// # Errors
/// What was lost or grew.
pub fn check_steady_stream(port: &Path, duration: Duration) -> Checked {
    let mut session = open(port)?;
    let before = session.settle()?;
    let start =
        Start { source: Source::Link { interval_ns: INTERVAL_NS }, columns: Columns::Parts };
    session.command(&ToDevice::Start(start))?;
    let mut stream = Stream::default();
    let began = Instant::now();
    let mut last = began;
    let blocks = (duration.as_nanos() / u128::from(INTERVAL_NS) / INJECT_ROWS as u128) as u64;
    let (mut taken, mut late, mut warm) = (0_u64, Duration::ZERO, None);
    for block in 0..blocks {
        // A computer that was held up catches up at twice the pace: the device has room for two blocks.
        let due = (began + Duration::from_nanos(block * BLOCK_NS))
            .max(last + Duration::from_nanos(BLOCK_NS / 2));
        while let Some(heard) = session.hear(due)? {
            stream.take(&heard);
            if let Ok((_, Said::Status(status))) = &heard.said
                && block > blocks / 10
            {
                warm.get_or_insert(status.stack_used);
            }
        }
        let rows: Vec<[i32; GAUGES]> =
            (0..INJECT_ROWS as u64).map(|row| press(block * INJECT_ROWS as u64 + row)).collect();
        taken += u64::from(inject(&mut session, &rows, None)?.0);
        (late, last) = (late.max(due.elapsed()), Instant::now());
    }
    let passed = began.elapsed();
    session.quiet()?;
    let after = session.status()?;
    while let Some(heard) = session.hear(Instant::now() + Duration::from_millis(300))? {
        stream.take(&heard);
    }
    let (tally, sent) = (*stream.tally(), blocks * INJECT_ROWS as u64);
    require(taken == sent && tally.rows == sent, || {
        format!("of {sent} rows {taken} were taken and {} came back: {tally:?}", tally.rows)
    })?;
    require(after.counters == before.counters, || {
        format!("the device counted losses: {:?} after {:?}", after.counters, before.counters)
    })?;
    let bytes_per_s = tally.bytes as f64 / passed.as_secs_f64();
    require(bytes_per_s <= MOST_BYTES_PER_S, || format!("{bytes_per_s:.0} B/s on the line"))?;
    let stack = warm.unwrap_or(after.stack_used);
    require(after.stack_used <= stack, || {
        format!("the stack grew from {stack} to {} bytes", after.stack_used)
    })?;
    Ok(Report::new("steady stream")
        .with("s", passed.as_secs())
        .with("rows, none lost", tally.rows)
        .with("B/s", format!("{bytes_per_s:.0}"))
        .with("ms behind at most", late.as_millis())
        .with("bytes of stack", after.stack_used))
}

/// A typical press with noise: counts of a row.
fn press(row: u64) -> [i32; GAUGES] {
    let time = (row % 8_000) as f64 * 1e-3;
    let pressed = (time - 1.0).clamp(0.0, 0.4) / 0.4 - (time - 4.4).clamp(0.0, 0.3) / 0.3;
    // Noise from a hash of the row, the same in every run.
    let mut noise = row.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    [900_000.0, 600_000.0, -350_000.0, 280_000.0].map(|full| {
        noise ^= noise >> 29;
        noise = noise.wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let noise = f64::from((noise >> 56) as u8) - 127.5;
        (full * pressed + noise) as i32
    })
}
