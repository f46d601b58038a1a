//! The regions of a trace as stretches of time.

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use serde_json::{Value, json};

use palpate_diagnose::criticism::region::{Region, regions};
use palpate_trace::Trace;

/// Samples from which the regions of a trace are found on a thread of their own.
const OWN_THREAD_FROM: usize = 200_000;

/// A stretch of time in one region: first and last sample, s.
type Span = (f64, f64, Region);

/// The stretches of a trace, shared with whoever draws it; of a long trace not known at once.
#[derive(Clone, Debug, Default)]
pub struct Spans(Arc<OnceLock<Vec<Span>>>);

impl Spans {
    /// Of samples whose regions are known, in time.
    #[must_use]
    pub fn new<'a>(samples: impl Iterator<Item = (&'a f64, &'a Region)>) -> Self {
        Self(Arc::new(merged(samples).into()))
    }

    /// Of every trace of a set. A long one is drawn before its regions are known.
    #[must_use]
    pub fn of_set(traces: &Arc<Vec<Trace>>) -> Vec<Self> {
        let of = |index: usize| {
            if traces[index].len() < OWN_THREAD_FROM {
                return Self(Arc::new(of_trace(&traces[index]).into()));
            }
            let (spans, traces) = (Self::default(), traces.clone());
            let found = spans.clone();
            // Nobody else sets them.
            std::thread::spawn(move || found.0.set(of_trace(&traces[index])));
            spans
        };
        (0..traces.len()).map(of).collect()
    }

    /// Within a window of time that is so many pixels wide: those that are wider than a pixel, and of each
    /// region where it begins and ends in the whole trace. Null where they are not known yet.
    #[must_use]
    pub fn json(&self, (from, to): (f64, f64), width: usize) -> (Value, Value) {
        let Some(spans) = self.0.get() else { return (Value::Null, Value::Null) };
        let pixel = (to - from) / width as f64;
        let begin = spans.partition_point(|(_, end, _)| *end < from);
        let seen = spans[begin..].iter().take_while(|(start, ..)| *start <= to);
        let wide = seen.filter(|(start, end, _)| end - start >= pixel);
        let mut extents: BTreeMap<&str, [f64; 2]> = BTreeMap::new();
        for (start, end, region) in spans {
            extents.entry(region.name()).or_insert([*start, *end])[1] = *end;
        }
        (
            wide.map(|(start, end, region)| json!([start, end, region.name()])).collect(),
            json!(extents),
        )
    }
}

/// The stretches of a trace whose displacement is known.
fn of_trace(trace: &Trace) -> Vec<Span> {
    let regions = trace.displacement().map(|displacement| regions(&trace.time, displacement));
    merged(trace.time.iter().zip(&regions.unwrap_or_default()))
}

/// Samples of one region in a row, as one stretch.
fn merged<'a>(samples: impl Iterator<Item = (&'a f64, &'a Region)>) -> Vec<Span> {
    let mut found: Vec<Span> = Vec::new();
    for (&time, &region) in samples {
        match found.last_mut() {
            Some((_, end, last)) if *last == region => *end = time,
            _ => found.push((time, time, region)),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_has_its_own_stretches_and_the_extents_of_all() {
        let time: Vec<f64> = (0..40).map(f64::from).collect();
        let region = |k: usize| [Region::Loading, Region::LateHold][k / 10 % 2];
        let regions: Vec<Region> = (0..40).map(region).collect();
        let spans = Spans::new(time.iter().zip(&regions));
        let (seen, extents) = spans.json((12.0, 22.0), 100);
        assert_eq!(seen, json!([[10.0, 19.0, "late hold"], [20.0, 29.0, "loading"]]));
        assert_eq!(extents, json!({"late hold": [10.0, 39.0], "loading": [0.0, 29.0]}));
        assert_eq!(spans.json((0.0, 39.0), 2).0, json!([]), "none is as wide as a pixel");
    }

    #[test]
    fn a_long_trace_is_there_before_its_regions_are() {
        let time: Vec<f64> = (0..OWN_THREAD_FROM).map(|k| k as f64).collect();
        let mut trace = Trace { time, ..Trace::default() };
        let displacement =
            trace.time.iter().map(|t| (t / OWN_THREAD_FROM as f64).min(0.5) - 0.1).collect();
        trace.set_column(palpate_trace::DISPLACEMENT, displacement);
        let spans = Spans::of_set(&Arc::new(vec![trace])).remove(0);
        let known = spans.0.wait();
        assert!(known.iter().any(|(.., region)| *region == Region::Loading), "{known:?}");
    }
}
