//! The data of a figure for the page's script: what was drawn, where, in which units.

use serde_json::{Value, json};

use super::axis::{Axis, Scale};
use super::curve::{self, Map};
use super::draw::Frame;
use super::plot::Style;

/// The data of a figure as JSON that may stand inside a `<script>` element.
pub(super) fn json(x: &Axis, x_exponent: i32, frames: &[Frame<'_>]) -> String {
    let Some(first) = frames.first() else { return "{}".to_owned() };
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let panels: Vec<Value> = frames.iter().map(|frame| panel(frame, &mut columns)).collect();
    let columns: Vec<Value> = columns.iter().map(|c| numbers(c)).collect();
    let data = json!({
        "x": axis(x, &first.x, x_exponent),
        "columns": columns,
        "panels": panels,
    });
    // `</script>` or `<!--` in a name must not end the element.
    data.to_string().replace('<', "\\u003c")
}

fn axis(axis: &Axis, map: &Map, exponent: i32) -> Value {
    json!({
        "label": axis.label, "unit": axis.unit, "log": axis.scale == Scale::Log,
        "range": [map.range.0, map.range.1], "drawn": [map.drawn.0, map.drawn.1],
        "exponent": exponent,
    })
}

/// Columns are shared: series drawn over the same x say which column it is.
fn panel(frame: &Frame<'_>, columns: &mut Vec<Vec<f64>>) -> Value {
    let mut column = |values: &[f64]| match columns.iter().position(|c| c == values) {
        Some(index) => index,
        None => {
            columns.push(values.to_vec());
            columns.len() - 1
        }
    };
    let series: Vec<Value> = frame.plot.series.iter().zip(&frame.samples).map(|(series, samples)| {
        let kind = match series.style {
            Style::Line => "line",
            Style::Step => "step",
            Style::Points => "points",
            Style::Band { .. } => "band",
            Style::ErrorBars { .. } => "bars",
        };
        let marker = match series.style {
            Style::Points | Style::ErrorBars { .. } => curve::marker(series, samples),
            _ => String::new(),
        };
        json!({
            "name": series.name, "kind": kind, "colour": series.colour.class(), "marker": marker,
            "x": column(&samples.x), "y": numbers(&samples.y), "other": numbers(&samples.other),
        })
    }).collect();
    json!({ "y": axis(&frame.plot.y, &frame.y, frame.y_exponent), "series": series })
}

/// Seven significant digits of each value or of the span of them all, whichever is finer: the hover
/// shows five, and a zoom still has steps to show. Gaps are `null`.
fn numbers(values: &[f64]) -> Value {
    let finite = || values.iter().copied().filter(|v| v.is_finite());
    let low = finite().fold(f64::INFINITY, f64::min);
    let high = finite().fold(f64::NEG_INFINITY, f64::max);
    let span = high - low;
    let digits = |v: f64| {
        let extra = if span > 0.0 { (v.abs() / span).log10().ceil().clamp(0.0, 9.0) } else { 0.0 };
        6 + extra as usize
    };
    values
        .iter()
        .map(|&v| {
            let rounded: f64 = format!("{v:.*e}", digits(v)).parse().unwrap_or(f64::NAN);
            if rounded == rounded.trunc() && rounded.abs() < 1e15 {
                json!(rounded as i64)
            } else {
                json!(rounded)
            }
        })
        .map(|v| if v.is_number() { v } else { Value::Null })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_exact_enough_and_gaps_are_null() {
        let text = numbers(&[0.1, 2.0, f64::NAN, 1.0 / 3.0, f64::INFINITY, 1e-9]).to_string();
        assert_eq!(text, "[0.1,2,null,0.3333333,null,1e-9]");
        let offset = numbers(&[1_000_000.001, 1_000_000.002]).to_string();
        assert_eq!(offset, "[1000000.001,1000000.002]");
    }
}
