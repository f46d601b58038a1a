//! A signal that was recorded more slowly than the rows that hold it: its values stay for several rows, then go on. What repeats is no
//! measurement, and lags behind what it seems to measure.

use super::Trace;
use super::outliers::with_rows;
use super::stairs::{Steps, alike, mostly};

/// How the signal of a trace repeats.
#[derive(Clone, Debug, PartialEq)]
pub struct Repeats {
    /// Name of the trace.
    pub trace: String,
    /// Rows for which each value stays, on average.
    pub rows: f64,
    /// The time for which it stays, s.
    pub seconds: f64,
}

/// Fewest rows for which a value usually stays.
const MIN_ROWS: usize = 2;
/// A value that stays for longer than this many times as usual was recorded anew meanwhile, and was the same.
const ANEW: f64 = 1.5;

/// The traces of a set whose signal repeats in time with an instrument slower than the rows; none unless it does so in all of them,
/// alike.
#[must_use]
pub fn repeats(traces: &[Trace], signal: &str) -> Vec<Repeats> {
    let own = |trace: &Trace| {
        let steps = slow(trace, signal)?;
        let (rows, seconds) = (steps.period(), steps.seconds(trace));
        Some(Repeats { trace: trace.label(), rows, seconds })
    };
    let all: Option<Vec<Repeats>> = traces.iter().map(own).collect();
    all.filter(|all| alike(all.iter().map(|own| own.seconds))).unwrap_or_default()
}

/// The steps of a signal that come in time with an instrument slower than the rows, and not because it is rounded.
fn slow(trace: &Trace, signal: &str) -> Option<Steps> {
    let steps = Steps::of_values(trace.column(signal)?, MIN_ROWS)?;
    let period = steps.period();
    let (least, most) = (period.floor() as usize, period.ceil() as usize);
    let usual = steps.distances().filter(|rows| (*rows as f64) < ANEW * period);
    let even = mostly(usual, |rows| (least..=most).contains(&rows));
    (even && steps.are_in_time() && !steps.are_single()).then_some(steps)
}

/// A trace whose signal repeats with the rows alone in which that was recorded.
#[must_use]
pub fn without_repeats(trace: &Trace, signal: &str) -> Trace {
    let Some(steps) = slow(trace, signal) else { return trace.clone() };
    let period = steps.period();
    let mut kept = vec![0];
    for next in steps.at.into_iter().chain([trace.len()]) {
        // The same value again, recorded anew.
        let (last, mut count) = (kept[kept.len() - 1], 1.0);
        while last as f64 + (count + ANEW - 1.0) * period < next as f64 {
            kept.push(last + (count * period).round() as usize);
            count += 1.0;
        }
        if next < trace.len() {
            kept.push(next);
        }
    }
    with_rows(trace, &kept)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FORCE;

    /// Two courses at 200 Hz, seen as `seen` has it.
    fn traces(seen: impl Fn(f64) -> f64) -> Vec<Trace> {
        let course = |speed: f64| {
            let time: Vec<f64> = (0..800).map(|k| f64::from(k) / 200.0).collect();
            let force = time.iter().map(|t| seen(*t) * speed).collect();
            let mut trace = Trace { time, ..Trace::default() };
            trace.set_column(FORCE, force);
            trace
        };
        vec![course(1.0), course(2.3)]
    }

    fn force(t: f64) -> f64 {
        (3.0 * t).sin() + 1e-3 * (977.0 * t).sin()
    }

    #[test]
    fn rows_that_repeat_a_slow_signal_are_left_out() {
        for hz in [20.0, 50.0, 80.0] {
            let held = |t: f64| ((t * hz + 1e-9).floor() / hz).max(0.0);
            let traces = traces(|t| force(held(t)));
            let found = repeats(&traces, FORCE);
            assert_eq!(found.len(), 2, "{hz} Hz");
            for (trace, own) in traces.iter().zip(&found) {
                assert!((own.rows - 200.0 / hz).abs() < 0.1, "{hz} Hz: {own:?}");
                let left = without_repeats(trace, FORCE);
                let count = 4.0 * hz;
                assert!((left.len() as f64 - count).abs() <= 2.0, "{} of {count}", left.len());
                let values = left.column(FORCE).unwrap();
                assert!(values.windows(2).all(|pair| pair[0] != pair[1]));
            }
        }
    }

    #[test]
    fn values_that_stay_because_they_rest_are_kept_as_often() {
        let held = |t: f64| (t * 50.0 + 1e-9).floor() / 50.0;
        let rests = |t: f64| if held(t) < 1.0 { 0.0 } else { force(held(t)) };
        let traces = traces(rests);
        let left = without_repeats(&traces[0], FORCE);
        assert!((left.len() as f64 - 200.0).abs() <= 2.0, "{}", left.len());
        assert!(left.time.windows(2).all(|pair| pair[1] - pair[0] < 0.031));
    }

    #[test]
    fn a_signal_that_is_fast_or_rounded_does_not_repeat() {
        assert_eq!(repeats(&traces(force), FORCE), []);
        assert_eq!(repeats(&traces(|t| (force(t) / 0.05).round() * 0.05), FORCE), []);
        assert_eq!(repeats(&traces(|t| (t / 0.1).round() * 0.1), FORCE), []);
    }
}
