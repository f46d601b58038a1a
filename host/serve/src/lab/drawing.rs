//! One trace as it is drawn: lines over its time, and its regions.

use std::ops::{Deref, Range};
use std::sync::Arc;

use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::envelope::Envelope;
use super::spans::Spans;
use palpate_diagnose::criticism::residuals::{Residuals, Stretch};
use palpate_trace::{Trace, gaps};

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
const MAX_PIXELS: usize = 8192;

/// Numbers of a drawing: its own, or a column of a trace that is shared with whoever fits it.
#[derive(Clone, Debug)]
enum Numbers {
    Own(Vec<f64>),
    Time(Arc<Vec<Trace>>, usize),
    Column(Arc<Vec<Trace>>, usize, usize),
}

impl Deref for Numbers {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        match self {
            Self::Own(numbers) => numbers,
            Self::Time(traces, trace) => &traces[*trace].time,
            Self::Column(traces, trace, column) => &traces[*trace].columns[*column].values,
        }
    }
}

/// One line.
#[derive(Clone, Debug)]
struct Line {
    name: &'static str,
    values: Numbers,
    envelope: Envelope,
}

impl Line {
    fn new(name: &'static str, values: Numbers) -> Self {
        Self { name, envelope: Envelope::new(&values), values }
    }

    /// One value for one sample, two for more.
    fn points(&self, range: Range<usize>) -> impl Iterator<Item = f64> {
        let (pair, count) = match range.len() {
            1 => ([self.values[range.start]; 2], 1),
            _ => (self.envelope.pair(&self.values, range), 2),
        };
        pair.into_iter().take(count)
    }
}

/// A trace with lines over its time, which are broken where samples are missing.
#[derive(Clone, Debug)]
pub struct Drawing {
    time: Numbers,
    /// Samples before which others are missing.
    breaks: Vec<usize>,
    lines: Vec<Line>,
    spans: Spans,
}

impl Drawing {
    /// A column of a trace, without a model; none where there is no such trace.
    #[must_use]
    pub fn of_trace(
        traces: &Arc<Vec<Trace>>,
        trace: usize,
        signal: &str,
        spans: Spans,
    ) -> Option<Self> {
        let own = traces.get(trace)?;
        let column = own.columns.iter().position(|column| column.name == signal)?;
        Some(Self {
            time: Numbers::Time(traces.clone(), trace),
            breaks: gaps(&own.time).iter().map(|gap| gap.index).collect(),
            lines: vec![Line::new("measured", Numbers::Column(traces.clone(), trace, column))],
            spans,
        })
    }

    /// What was measured, what a model predicts and what it leaves.
    #[must_use]
    pub fn of_residuals(left: &Residuals, trace: usize) -> Self {
        let stretches = left.of_trace(trace);
        let join =
            |value: fn(&Stretch) -> &[f64]| stretches.iter().flat_map(value).copied().collect();
        let (measured, predicted): (Vec<f64>, Vec<f64>) =
            (join(|s| &s.measured), join(|s| &s.predicted));
        let residual = measured.iter().zip(&predicted).map(|(y, f)| y - f).collect();
        let times: Vec<&[f64]> = stretches.iter().map(|stretch| &stretch.time[..]).collect();
        let lines = vec![("measured", measured), ("predicted", predicted), ("residual", residual)];
        let regions = stretches.iter().flat_map(|s| s.time.iter().zip(&s.regions));
        Self { spans: Spans::new(regions), ..Self::of_lines(&times, lines) }
    }

    /// Lines over stretches of time; each is as long as all of them.
    #[must_use]
    pub fn of_lines(times: &[&[f64]], lines: Vec<(&'static str, Vec<f64>)>) -> Self {
        let ends = times.iter().scan(0, |end, stretch| {
            *end += stretch.len();
            Some(*end)
        });
        let time = times.concat();
        Self {
            breaks: ends.filter(|end| *end < time.len()).collect(),
            time: Numbers::Own(time),
            lines: lines.into_iter().map(|(name, v)| Line::new(name, Numbers::Own(v))).collect(),
            spans: Spans::default(),
        }
    }

    /// First and last time, s.
    fn whole(&self) -> (f64, f64) {
        self.time.first().zip(self.time.last()).map_or((0.0, 0.0), |(first, last)| (*first, *last))
    }

    /// The samples of a view, together where they share a pixel; one more on either side, for a line goes on
    /// to the edge.
    fn parts(&self, (from, to): (f64, f64), width: usize) -> Vec<Range<usize>> {
        let all = self.time.len();
        let first = self.time.partition_point(|&t| t < from);
        let end = self.time.partition_point(|&t| t <= to).max(first);
        let one = |k: usize| k..k + 1;
        if end - first <= 2 * width {
            return (first.saturating_sub(1)..(end + 1).min(all)).map(one).collect();
        }
        let mut parts = Vec::with_capacity(width + 2);
        parts.extend(first.checked_sub(1).map(one));
        let mut start = first;
        for pixel in 1..=width {
            let edge = from + (to - from) * pixel as f64 / width as f64;
            let within = self.time[start..end].partition_point(|&t| t < edge);
            let next = if pixel == width { end } else { start + within };
            if next > start {
                parts.push(start..next);
            }
            start = next;
        }
        parts.extend((end < all).then(|| one(end)));
        parts
    }

    /// The lines within a view: every sample where there are few, else two values for each pixel. Where
    /// samples are missing stands a time without values.
    #[must_use]
    pub fn json(&self, view: &View) -> Value {
        let whole = self.whole();
        let window = (view.from.unwrap_or(whole.0), view.to.unwrap_or(whole.1));
        let width = view.width.clamp(1, MAX_PIXELS);
        let parts = self.parts(window, width);
        let broken = |k: usize| k > 0 && self.breaks.binary_search(&parts[k].start).is_ok();
        let mut time = Vec::with_capacity(2 * parts.len());
        for (k, part) in parts.iter().enumerate() {
            if broken(k) {
                time.push(0.5 * (self.time[part.start - 1] + self.time[part.start]));
            }
            time.push(self.time[part.start]);
            time.extend((part.len() > 1).then(|| self.time[part.end - 1]));
        }
        let mut found = Map::new();
        for line in &self.lines {
            let mut values = Vec::with_capacity(time.len());
            for (k, part) in parts.iter().enumerate() {
                values.extend(broken(k).then_some(f64::NAN));
                values.extend(line.points(part.clone()));
            }
            found.insert(line.name.into(), json!(values));
        }
        let (regions, extents) = self.spans.json(window, width);
        found.insert("time".into(), json!(time));
        found.insert("regions".into(), regions);
        found.insert("extents".into(), extents);
        found.insert("whole".into(), json!([whole.0, whole.1]));
        Value::Object(found)
    }

    /// The whole of one line in this many columns, as the least and the greatest value of each.
    #[must_use]
    pub fn picture(&self, name: &str, columns: usize) -> Value {
        let Some(line) = self.lines.iter().find(|line| line.name == name) else {
            return Value::Null;
        };
        let edge = |k: usize| k * line.values.len() / columns.max(1);
        let filled = (0..columns).map(|k| edge(k)..edge(k + 1)).filter(|part| !part.is_empty());
        filled.map(|part| json!(line.envelope.pair(&line.values, part))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(value: &Value) -> Vec<Option<f64>> {
        value.as_array().unwrap().iter().map(Value::as_f64).collect()
    }

    /// A line y = t at 1 kHz with half a second missing from 1 s on and a spike at 2 s.
    fn trace() -> Arc<Vec<Trace>> {
        let there = (0..4000).filter(|k| !(1000..1500).contains(k));
        let time: Vec<f64> = there.map(|k| f64::from(k) / 1e3).collect();
        let mut trace = Trace { time: time.clone(), ..Trace::default() };
        trace
            .set_column("force_N", time.iter().map(|&t| if t == 2.0 { 99.0 } else { t }).collect());
        Arc::new(vec![trace])
    }

    fn drawn(view: View) -> Value {
        Drawing::of_trace(&trace(), 0, "force_N", Spans::default()).unwrap().json(&view)
    }

    #[test]
    fn a_line_is_broken_where_samples_are_missing() {
        for width in [50, 4000] {
            let found = drawn(View { trace: 0, from: None, to: None, width });
            let (time, values) = (numbers(&found["time"]), numbers(&found["measured"]));
            assert_eq!(time.len(), values.len());
            assert!(time.len() <= 2 * width + 3 && time.windows(2).all(|pair| pair[0] < pair[1]));
            let broken: Vec<f64> = time
                .iter()
                .zip(&values)
                .filter(|(_, y)| y.is_none())
                .map(|(t, _)| t.unwrap())
                .collect();
            assert_eq!(broken.len(), 1, "{broken:?}");
            assert!((1.0..1.5).contains(&broken[0]));
            assert!(values.contains(&Some(99.0)), "the spike stays visible");
        }
    }

    #[test]
    fn a_window_goes_one_sample_beyond_its_edges_and_is_of_the_same_pixels_for_every_line() {
        let found = drawn(View { trace: 0, from: Some(2.0005), to: Some(3.0005), width: 100 });
        let time = numbers(&found["time"]);
        assert_eq!((time[0], *time.last().unwrap()), (Some(2.0), Some(3.001)));
        assert_eq!(time.len(), 202);
        assert_eq!(found["whole"], json!([0.0, 3.999]));
    }

    #[test]
    fn a_window_without_samples_or_the_wrong_way_round_is_no_error() {
        for (from, to) in [(1.1, 1.2), (3.0, 2.0), (9.0, 10.0), (-5.0, -1.0), (f64::NAN, f64::NAN)]
        {
            let found = drawn(View { trace: 0, from: Some(from), to: Some(to), width: 10 });
            assert!(numbers(&found["time"]).len() <= 4000, "{from} {to}");
        }
    }
}
