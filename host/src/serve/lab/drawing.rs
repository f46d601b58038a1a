//! One trace as it is drawn: lines over its time, and its regions.

use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::envelope::Envelope;
use crate::criticism::compare::Comparison;
use crate::criticism::region::{Region, regions};
use crate::criticism::residuals::Stretch;
use crate::trace::Trace;

/// What part of a trace a plot shows.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct View {
    /// Which trace of those chosen.
    pub trace: usize,
    /// First time, s; from the first sample where it is not given.
    #[serde(default)]
    pub from: Option<f64>,
    /// Last time, s; to the last sample where it is not given.
    #[serde(default)]
    pub to: Option<f64>,
    /// Width of the plot, pixels.
    #[serde(default = "usual")]
    pub width: usize,
}

fn usual() -> usize {
    800
}

/// Widest plot, pixels.
const WIDEST: usize = 8192;

/// A trace with lines over its time. Between stretches there is a gap.
#[derive(Clone, Debug, Default)]
pub struct Drawing {
    time: Vec<f64>,
    lines: Vec<(&'static str, Envelope)>,
    spans: Vec<(f64, f64, Region)>,
}

impl Drawing {
    /// What was measured, without a model.
    #[must_use]
    pub fn of_trace(trace: &Trace, signal: &str) -> Self {
        let measured = trace.column(signal).unwrap_or_default().to_vec();
        let spans = trace.displacement().map_or_else(Vec::new, |displacement| {
            spans(&trace.time, &regions(&trace.time, displacement))
        });
        let lines = vec![("measured", Envelope::new(measured))];
        Self { time: trace.time.clone(), lines, spans }
    }

    /// What was measured, what a model predicts and what it leaves.
    #[must_use]
    pub fn of_comparison(comparison: &Comparison, trace: usize) -> Self {
        let of_trace = |stretch: &&Stretch| stretch.trace == trace;
        let stretches: Vec<&Stretch> = comparison.stretches.iter().filter(of_trace).collect();
        let times: Vec<&[f64]> = stretches.iter().map(|stretch| &stretch.time[..]).collect();
        let line = |value: fn(&Stretch) -> Vec<f64>| {
            Envelope::new(joined(stretches.iter().map(|stretch| value(stretch))))
        };
        Self {
            lines: vec![
                ("measured", line(|stretch| stretch.measured.clone())),
                ("predicted", line(|stretch| stretch.predicted.clone())),
                ("residual", line(Stretch::residual)),
            ],
            spans: stretches.iter().flat_map(|s| spans(&s.time, &s.regions)).collect(),
            time: joined_times(&times),
        }
    }

    /// Lines over the same times that are not drawn with the rest.
    #[must_use]
    pub fn of_lines(times: &[&[f64]], lines: Vec<(&'static str, Vec<Vec<f64>>)>) -> Self {
        let line = |(name, parts): (&'static str, Vec<Vec<f64>>)| {
            (name, Envelope::new(joined(parts.into_iter())))
        };
        Self {
            time: joined_times(times),
            lines: lines.into_iter().map(line).collect(),
            spans: Vec::new(),
        }
    }

    /// The lines within a view: every sample where there are few, else two for each pixel.
    #[must_use]
    pub fn json(&self, view: &View) -> Value {
        let first = view.from.map_or(0, |from| self.time.partition_point(|&t| t < from));
        let end = view.to.map_or(self.time.len(), |to| self.time.partition_point(|&t| t <= to));
        // One sample more on either side: a line goes on to the edge.
        let range = first.saturating_sub(1)..(end + 1).min(self.time.len()).max(first);
        let width = view.width.clamp(1, WIDEST);
        let few = range.len() <= 2 * width;
        let edge = |k: usize| range.start + k * range.len() / width;
        let mut found = Map::new();
        let time = if few {
            self.time[range.clone()].to_vec()
        } else {
            (0..width).flat_map(|k| [self.time[edge(k)], self.time[edge(k + 1) - 1]]).collect()
        };
        found.insert("time".into(), json!(time));
        for (name, line) in &self.lines {
            let values: Vec<f64> = if few {
                line.values().get(range.clone()).unwrap_or_default().to_vec()
            } else {
                (0..width).flat_map(|k| line.pair(edge(k)..edge(k + 1))).collect()
            };
            found.insert((*name).into(), json!(values));
        }
        let spans = self.spans.iter().map(|(from, to, region)| json!([from, to, region.name()]));
        found.insert("regions".into(), spans.collect());
        let ends = self.time.first().zip(self.time.last());
        found.insert("whole".into(), json!(ends.map_or([0.0; 2], |(first, last)| [*first, *last])));
        Value::Object(found)
    }

    /// The whole of one line in this many columns, as the least and the greatest value of each.
    #[must_use]
    pub fn picture(&self, name: &str, columns: usize) -> Value {
        let line = self.lines.iter().find(|(known, _)| *known == name);
        line.map_or(Value::Null, |(_, line)| {
            let count = line.values().len();
            let edge = |k: usize| k * count / columns.max(1);
            let filled = (0..columns).filter(|&k| edge(k) < edge(k + 1));
            filled.map(|k| json!(line.pair(edge(k)..edge(k + 1)))).collect()
        })
    }
}

/// Stretches one after the other, with a gap between.
fn joined(parts: impl Iterator<Item = Vec<f64>>) -> Vec<f64> {
    let mut all: Vec<f64> = Vec::new();
    for part in parts {
        if !all.is_empty() {
            all.push(f64::NAN);
        }
        all.extend(part);
    }
    all
}

/// Their times; a gap is in the middle between its neighbours.
fn joined_times(parts: &[&[f64]]) -> Vec<f64> {
    let mut all: Vec<f64> = Vec::new();
    for part in parts {
        if let (Some(last), Some(first)) = (all.last().copied(), part.first()) {
            all.push(0.5 * (last + first));
        }
        all.extend_from_slice(part);
    }
    all
}

/// Stretches of one region, in time.
fn spans(time: &[f64], regions: &[Region]) -> Vec<(f64, f64, Region)> {
    let mut found: Vec<(f64, f64, Region)> = Vec::new();
    for (&time, &region) in time.iter().zip(regions) {
        match found.last_mut() {
            Some((_, end, last)) if *last == region => *end = time,
            _ => found.push((time, time, region)),
        }
    }
    found
}
