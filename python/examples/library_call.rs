//! What a fit costs without Python: the yardstick of `python/tests/cost.py`.
//!
//! `cargo run --release --example library_call -- TRACE... ` prints the milliseconds of one fit, the least of many.

use std::sync::Arc;
use std::time::Instant;

use palpate::cli::ask;
use palpate::trace::{Column, TIME, Trace, read_set};

/// Fits that are timed.
const TIMES: usize = 40;

fn main() {
    let paths: Vec<String> = std::env::args().skip(1).collect();
    let read = read_set(&paths).expect("traces");
    let best = (0..TIMES).map(|_| once(&read)).fold(f64::INFINITY, f64::min);
    println!("{best}");
}

/// One fit of columns in memory, to its answer, ms.
fn once(read: &[Trace]) -> f64 {
    let columns: Vec<Vec<Column>> = read
        .iter()
        .map(|trace| {
            let time = Column { name: TIME.into(), values: trace.time.clone() };
            std::iter::once(time).chain(trace.columns.clone()).collect()
        })
        .collect();
    let began = Instant::now();
    let traces = columns.into_iter().zip(read);
    let traces = traces.map(|(columns, trace)| Trace::from_columns(trace.head.clone(), columns));
    let traces = Arc::new(traces.collect::<Result<Vec<_>, _>>().expect("traces"));
    let found = ask::fit(Some("fung"), traces, &[]).expect("a fit");
    let rms = found.json()["residual_rms"].as_f64();
    let took = began.elapsed().as_secs_f64() * 1e3;
    assert!(rms.is_some_and(f64::is_finite));
    took
}
