//! A recording as it is: a table of what it holds, and plots of its columns.

use super::{name_of, unit_of};
use palpate_report::number::{duration, significant};
use palpate_report::{Axis, Colour, Column, Panels, Plot, Series, Table};
use palpate_trace::{DISPLACEMENT, FORCE, Kind, TEMPERATURE, Trace, gaps, sampling, segments};

/// One line for each trace: samples, duration, rate, gaps, largest compression and force.
#[must_use]
pub fn overview(traces: &[Trace]) -> Table {
    let columns = vec![
        Column::text("trace"),
        Column::whole("samples"),
        Column::text("duration"),
        Column::text("sampling"),
        Column::whole("gaps"),
        Column::number("largest displacement", "mm"),
        Column::number("largest force", "N"),
    ];
    let mut table = Table::new("", columns);
    for trace in traces {
        let largest = |column: Option<&[f64]>| {
            column.map_or("–".into(), |values| {
                significant(values.iter().copied().fold(f64::NEG_INFINITY, f64::max), 4)
            })
        };
        let rate = sampling(&trace.time).map_or("–".into(), |sampling| {
            let rate = significant(sampling.rate_hz(), 4);
            if sampling.is_uniform() {
                format!("{rate} Hz")
            } else {
                format!("about {rate} Hz, uneven")
            }
        });
        table = table.row([
            trace.label(),
            trace.len().to_string(),
            duration(trace.duration()),
            rate,
            gaps(&trace.time).len().to_string(),
            largest(trace.displacement()),
            largest(trace.force()),
        ]);
    }
    table
}

/// The columns of a trace over time, those of one kind in one panel, the motion's segments shaded.
#[must_use]
pub fn trace_panels(trace: &Trace) -> Panels {
    let gauges = trace.gauges();
    let known = [DISPLACEMENT, FORCE, TEMPERATURE];
    let others: Vec<&str> = trace
        .columns
        .iter()
        .map(|column| column.name.as_str())
        .filter(|name| !known.contains(name) && !gauges.contains(name))
        .collect();
    let mut panels = Panels::new(trace.label()).summary(format!(
        "{} samples over {}",
        trace.len(),
        duration(trace.duration())
    ));
    for name in [DISPLACEMENT, FORCE] {
        if trace.column(name).is_some() {
            panels = panels.plot(panel(trace, &[name]));
        }
    }
    if !gauges.is_empty() {
        panels = panels.plot(panel(trace, &gauges));
    }
    for name in others.into_iter().chain([TEMPERATURE]) {
        if trace.column(name).is_some() {
            panels = panels.plot(panel(trace, &[name]));
        }
    }
    panels
}

/// Some columns of one unit over time; gaps in time are gaps in the lines.
fn panel(trace: &Trace, names: &[&str]) -> Plot {
    let label = if names.len() == 1 { name_of(names[0]) } else { "strain".into() };
    let mut plot =
        Plot::new("", Axis::new("time", "s"), Axis::new(label, unit_of(names[0]))).height(190.0);
    for (index, name) in names.iter().enumerate() {
        let Some(values) = trace.column(name) else { continue };
        let (time, values) = with_gaps(&trace.time, values);
        plot = plot.series(Series::line(name_of(name), time, values).colour(Colour::Hue(index)));
    }
    for (from, to, word) in moves(trace) {
        plot = plot.span(from, to, word);
    }
    plot
}

/// The segments of the motion on the specimen, each with a word.
fn moves(trace: &Trace) -> Vec<(f64, f64, &'static str)> {
    let Some(displacement) = trace.displacement() else { return Vec::new() };
    segments(&trace.time, displacement)
        .into_iter()
        .filter_map(|segment| {
            let word = match segment.kind {
                Kind::Load => "load",
                Kind::Hold => "hold",
                Kind::Unload => "unload",
                Kind::Approach | Kind::After => return None,
            };
            let last = segment.range.end.min(trace.len() - 1);
            Some((trace.time[segment.range.start], trace.time[last], word))
        })
        .collect()
}

/// A column with a missing value in each gap, so that no line crosses it.
fn with_gaps(time: &[f64], values: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut x, mut y) = (time.to_vec(), values.to_vec());
    for gap in gaps(time).into_iter().rev() {
        x.insert(gap.index, 0.5 * (gap.from_s + gap.to_s));
        y.insert(gap.index, f64::NAN);
    }
    (x, y)
}

/// Force against displacement, every trace a line.
#[must_use]
pub fn loops(traces: &[Trace]) -> Option<Plot> {
    let both: Vec<_> = traces
        .iter()
        .filter_map(|trace| Some((trace, trace.displacement()?, trace.force()?)))
        .collect();
    if both.is_empty() {
        return None;
    }
    let mut plot = Plot::new(
        "Force against displacement",
        Axis::new("displacement", "mm"),
        Axis::new("force", "N"),
    )
    .summary("The loop between loading and unloading is the energy that is lost");
    for (index, (trace, displacement, force)) in both.into_iter().enumerate() {
        plot = plot
            .series(Series::line(trace.label(), displacement, force).colour(Colour::Hue(index)));
    }
    Some(plot)
}
