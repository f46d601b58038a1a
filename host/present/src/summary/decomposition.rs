//! A decomposed recording: its regions as a table, FA and SA as plots, all of it as columns.

use shared::phase::{Region, RelaxationType};

use super::{name_of, unit_of};
use palpate_analysis::decomposition::Channel;
use palpate_analysis::regions::{Regions, Stretch, code, name, type_code, type_name};
use palpate_report::number::{counted, significant};
use palpate_report::{Axis, Colour, Column, Legend, Panels, Plot, Section, Series, Table};
use palpate_trace::{DISPLACEMENT, FORCE, Trace};

/// The regions of the grasp and the parts of every channel.
#[must_use]
pub fn decomposition_sections(trace: &Trace, channels: &[(Channel, Regions)]) -> Vec<Section> {
    let Some((first, regions)) = channels.first() else { return Vec::new() };
    let mut section =
        Section::new(trace.label()).table(region_table(trace, first, &regions.stretches()));
    section = section.figure(
        part_panels(trace, channels),
        "FA answers to change and is gone in a steady hold; SA keeps what is held. The dashed line is where the signal settles if the motion stops now.",
    );
    vec![section]
}

/// One line for each stretch of one region.
#[must_use]
pub fn region_table(trace: &Trace, channel: &Channel, stretches: &[Stretch]) -> Table {
    let mut columns = vec![
        Column::text(""),
        Column::text("region"),
        Column::number("from", "s"),
        Column::number("to", "s"),
    ];
    let shown: Vec<&str> =
        [DISPLACEMENT, FORCE].into_iter().filter(|name| trace.column(name).is_some()).collect();
    columns.extend(shown.iter().map(|name| Column::number(name_of(name), unit_of(name))));
    if !shown.contains(&channel.signal.as_str()) {
        columns.push(Column::number(name_of(&channel.signal), unit_of(&channel.signal)));
    }
    let mut table = Table::new("Regions of the grasp (Fig. 3.10)", columns);
    for stretch in stretches {
        let (points, word) = name(stretch.region);
        let last = stretch.range.end - 1;
        let until = trace.time[(last + 1).min(trace.len() - 1)];
        let mut cells = vec![
            points.to_owned(),
            format!("{word}{}", type_word(stretch)),
            format!("{:.3}", trace.time[stretch.range.start]),
            format!("{until:.3}"),
        ];
        for name in &shown {
            cells.push(trace.column(name).map_or(String::new(), |values| values[last].to_string()));
        }
        if !shown.contains(&channel.signal.as_str()) {
            cells.push(channel.input[last].to_string());
        }
        table = table.row(cells);
    }
    let measured = 4..table.columns.len();
    table
        .alike(measured, 4)
        .note("Displacement, force and strain are those at the end of each region.")
}

/// The type of relaxation, where the region is one of relaxing.
fn type_word(stretch: &Stretch) -> String {
    match (stretch.region, stretch.relaxation) {
        (_, RelaxationType::None) => String::new(),
        (Region::Relaxation, relaxation) => format!(", {}", type_name(relaxation)),
        _ => String::new(),
    }
}

/// Signal, FA and SA of every channel, one panel each, regions shaded.
#[must_use]
pub fn part_panels(trace: &Trace, channels: &[(Channel, Regions)]) -> Panels {
    let mut panels = Panels::new("Fast and slow adapting parts").summary(format!(
        "Signal, FA and SA of {} over {} s",
        counted(channels.len(), "channel"),
        significant(trace.duration(), 3)
    ));
    for (channel, regions) in channels {
        let unit = unit_of(&channel.signal);
        let line = |label: &str, values: &[f64]| Series::line(label, &trace.time[..], values);
        let mut plot =
            Plot::new("", Axis::new("time", "s"), Axis::new(name_of(&channel.signal), unit))
                .series(line("signal", &channel.input).colour(Colour::MEASURED))
                .series(line("SA", &channel.sa).colour(Colour::SA))
                .series(line("FA", &channel.fa).colour(Colour::FA))
                .series(line("equilibrium", &channel.equilibrium).colour(Colour::Muted))
                .height(190.0);
        let first = panels.plots.is_empty();
        if !first {
            plot = plot.legend(Legend::Hidden);
        }
        plot = shaded(plot, &region_spans(trace, regions), first);
        panels = panels.plot(plot);
    }
    panels
}

/// The regions but rest as spans of time, s, with their points.
#[must_use]
pub fn region_spans(trace: &Trace, regions: &Regions) -> Vec<(f64, f64, &'static str)> {
    regions
        .stretches()
        .into_iter()
        .filter(|stretch| stretch.region != Region::Rest)
        .map(|stretch| {
            let end = stretch.range.end.min(trace.len() - 1);
            (trace.time[stretch.range.start], trace.time[end], name(stretch.region).0)
        })
        .collect()
}

/// The plot with regions shaded; below each other, only the topmost panel need name them.
#[must_use]
pub fn shaded(mut plot: Plot, spans: &[(f64, f64, &'static str)], named: bool) -> Plot {
    for &(from, to, name) in spans {
        plot = plot.span(from, to, if named { name } else { "" });
    }
    plot
}

/// The recording with the parts of every channel as further columns.
#[must_use]
pub fn decomposed_trace(trace: &Trace, channels: &[(Channel, Regions)]) -> Trace {
    let mut result = trace.clone();
    result.head.computed_by = Some("palpate decompose".into());
    for (channel, regions) in channels {
        let (stem, unit) = match channel.signal.rsplit_once('_') {
            Some((stem, unit)) => (stem, format!("_{unit}")),
            None => (channel.signal.as_str(), String::new()),
        };
        let rectified: Vec<f64> = channel.fa.iter().map(|fa| fa.abs()).collect();
        let parts = [
            ("fa", &channel.fa),
            ("fa_rectified", &rectified),
            ("sa", &channel.sa),
            ("elastic", &channel.elastic),
            ("equilibrium", &channel.equilibrium),
            ("latent", &channel.latent),
        ];
        for (part, values) in parts {
            result.set_column(format!("{stem}_{part}{unit}"), values.clone());
        }
        let codes = regions.region.iter().copied().map(code).collect();
        result.set_column(format!("{stem}_region"), codes);
        let types = regions.relaxation.iter().copied().map(type_code).collect();
        result.set_column(format!("{stem}_relaxation"), types);
    }
    result
}
