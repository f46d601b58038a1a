//! A comparison as tables, plots and words.

use super::dependence::{dependence_plot, scale};
use super::{ladder, name_of, unit_of};
use palpate_diagnose::criticism::compare::{Cell, Comparison};
use palpate_diagnose::criticism::dependence::{Dependence, SEED};
use palpate_diagnose::criticism::region::Region;
use palpate_diagnose::criticism::residuals::Residuals;
use palpate_model::Model;
use palpate_report::number::{percent, share, significant};
use palpate_report::{
    Axis, Block, Callout, CellFormat, Colour, Column, HeatMap, Panels, Plot, Section, Series, Table,
};
use palpate_trace::Trace;

/// Most traces that a report draws one by one.
const MOST_DRAWN: usize = 12;

/// Where the model fails, what the failure depends on, and the ladder.
#[must_use]
pub fn compare_sections(model: &Model, comparison: &Comparison, traces: &[Trace]) -> Vec<Section> {
    failures(comparison, traces).into_iter().chain(ladder(model)).collect()
}

/// What a report shows of a comparison: the same, and every trace before the ladder.
#[must_use]
pub fn compare_report(
    model: &Model,
    comparison: &Comparison,
    left: &Residuals,
    traces: &[Trace],
) -> Vec<Section> {
    let drawn = std::iter::once(overlays(comparison, left));
    failures(comparison, traces).into_iter().chain(drawn).chain(ladder(model)).collect()
}

fn failures(comparison: &Comparison, traces: &[Trace]) -> [Section; 2] {
    [place(comparison), dependence_section(comparison, traces)]
}

fn place(comparison: &Comparison) -> Section {
    let unit = unit_of(&comparison.signal);
    let kind = if comparison.only_noise { Callout::Finding } else { Callout::Warning };
    let floor = comparison.noise.map_or_else(
        || "; the recordings do not determine the noise".into(),
        |noise| {
            format!(
                ", {:.2} times the noise of {} {unit}",
                comparison.rms / noise.standard_deviation,
                significant(noise.standard_deviation, 3)
            )
        },
    );
    let rms = significant(comparison.rms, 3);
    let text = format!("The model leaves {rms} {unit} RMS{floor}. {}", comparison.in_words());
    let mut section = Section::new("Where the model fails").callout(kind, "In short", text);
    for what in &comparison.left_out {
        section = section.callout(Callout::Warning, "Left out", what.clone());
    }
    if !comparison.only_noise {
        section = section.figure(heat_map(comparison), "");
    }
    section.table(error_table(comparison))
}

fn cell(comparison: &Comparison, trace: usize, region: Region) -> Option<&Cell> {
    comparison.cells.iter().find(|cell| cell.trace == trace && cell.region == region)
}

/// Root mean square error of every region of every trace.
fn error_table(comparison: &Comparison) -> Table {
    let unit = unit_of(&comparison.signal);
    let columns = std::iter::once(Column::text("trace"))
        .chain(Region::ALL.map(|region| Column::number(region.name(), "")))
        .chain([Column::number("whole trace", "")])
        .collect();
    let mut table = Table::new(format!("Root mean square error, {unit}"), columns);
    for (trace, label) in comparison.labels.iter().enumerate() {
        let cells = Region::ALL.map(|region| {
            cell(comparison, trace, region).map_or("–".into(), |cell| significant(cell.rms, 3))
        });
        let whole = significant(comparison.trace_rms[trace], 3);
        table = table.row(std::iter::once(label.clone()).chain(cells).chain([whole]));
    }
    if comparison.only_noise {
        return table;
    }
    let shares = Region::ALL.map(|region| {
        let of_region = comparison.by_region().into_iter().find(|(r, _)| *r == region);
        of_region.map_or(String::new(), |(_, part)| share(part))
    });
    let first = "share of what is left".to_owned();
    table.row(std::iter::once(first).chain(shares).chain([String::new()]))
}

/// Share of what is left in every region of every trace.
pub(super) fn heat_map(comparison: &Comparison) -> HeatMap {
    let part = |trace, region| {
        cell(comparison, trace, region).map_or(f64::NAN, |cell| cell.share_of_excess)
    };
    HeatMap {
        title: "Share of what is left beyond the noise".into(),
        summary: comparison.in_words(),
        row_label: "Trace".into(),
        column_label: "Region".into(),
        rows: comparison.labels.clone(),
        columns: Region::ALL.map(|region| region.name().to_owned()).to_vec(),
        values: (0..comparison.labels.len())
            .map(|trace| Region::ALL.map(|region| part(trace, region)).to_vec())
            .collect(),
        format: CellFormat::Percent,
        strongest: None,
    }
}

fn dependence_section(comparison: &Comparison, traces: &[Trace]) -> Section {
    let columns = vec![
        Column::text("quantity"),
        Column::text(""),
        Column::number("explains", ""),
        Column::number("p value", ""),
        Column::number("trend", ""),
    ];
    let mut table = Table::new("What the residual depends on", columns);
    for dependence in &comparison.dependences {
        table = table.row([
            dependence.covariate.name().to_owned(),
            dependence.covariate.symbol().to_owned(),
            percent(dependence.explained, 2),
            format!("{:.3}", dependence.p_value),
            format!("{:+.2}", dependence.trend),
        ]);
    }
    let shuffles = format!(
        "p value: chance of explaining as much, from 199 circular shifts within the traces (seed {SEED}). \
         Trend: correlation of the mean residual with the quantity."
    );
    let mut section = Section::new("What the failure depends on");
    let (unit, most) = (unit_of(&comparison.signal), scale(&comparison.dependences));
    let plot = |dependence: &Dependence| dependence_plot(dependence, unit, most);
    let (told, chance): (Vec<&Dependence>, Vec<&Dependence>) = by_p_value(comparison)
        .into_iter()
        .partition(|dependence| dependence.p_value <= SHOWN_P_VALUE);
    for dependence in told {
        section = section.figure(plot(dependence), "");
    }
    if !chance.is_empty() {
        let summary = format!("{} that explain no more than chance does", counted(chance.len()));
        let folded = chance
            .into_iter()
            .map(plot)
            .fold(Section::new(""), |folded, plot| folded.figure(plot, ""));
        section = section.block(Block::Details { summary, blocks: folded.blocks });
    }
    section = section.table(table.note(shuffles));
    if traces.iter().any(|trace| trace.head.setup.start_s.is_none()) {
        section = section.paragraph(
            "Not every head says when its trace began (`start_s`): the time in the data set is counted as if the \
             traces followed each other without a pause.",
        );
    }
    section
}

/// Chance below which a dependence is shown unasked.
const SHOWN_P_VALUE: f64 = 0.05;

fn counted(quantities: usize) -> String {
    if quantities == 1 { "1 quantity".into() } else { format!("{quantities} quantities") }
}

/// The surest first; of those as sure, what explains most.
fn by_p_value(comparison: &Comparison) -> Vec<&Dependence> {
    let mut found: Vec<&Dependence> = comparison.dependences.iter().collect();
    found.sort_by(|a, b| a.p_value.total_cmp(&b.p_value).then(b.explained.total_cmp(&a.explained)));
    found
}

/// Measurement and model of every trace with what is left, on one scale for all, regions shaded.
#[must_use]
pub fn overlays(comparison: &Comparison, left: &Residuals) -> Section {
    let mut section = Section::new("Each trace");
    let drawn = || left.stretches().take(MOST_DRAWN);
    let largest =
        |residual: Vec<f64>| residual.iter().fold(0.0_f64, |most, left| most.max(left.abs()));
    let most = drawn().map(|stretch| 1.05 * largest(stretch.residual())).fold(0.0, f64::max);
    let mut residual = Axis::new("residual", unit_of(&comparison.signal));
    // A law that is exact leaves nothing.
    if most > 0.0 && most.is_finite() {
        residual = residual.range(-most, most);
    }
    for stretch in drawn() {
        let (name, unit) = (name_of(&comparison.signal), unit_of(&comparison.signal));
        let time = || Axis::new("time", "s");
        let line = |label: &str, values: &[f64]| Series::line(label, &stretch.time[..], values);
        let mut overlay = Plot::new("", time(), Axis::new(name, unit))
            .series(line("measured", &stretch.measured).colour(Colour::MEASURED))
            .series(line("model", &stretch.predicted).colour(Colour::MODEL).width(1.8));
        let mut left = Plot::new("", time(), residual.clone())
            .series(line("residual", &stretch.residual()).colour(Colour::RESIDUAL))
            .height(140.0);
        if let Some(noise) = comparison.noise {
            left =
                left.level(noise.standard_deviation, "noise").level(-noise.standard_deviation, "");
        }
        for (from, to, region) in spans(&stretch.time, &stretch.regions) {
            overlay = overlay.span(from, to, region.name());
            left = left.span(from, to, "");
        }
        let label = &comparison.labels[stretch.trace];
        let summary = format!(
            "{label}: measured and predicted, and the residual of {} {unit} RMS",
            significant(comparison.trace_rms[stretch.trace], 3)
        );
        let panels = Panels::new(label.as_str()).summary(summary).plot(overlay).plot(left);
        section = section.figure(panels, "");
    }
    let count = left.stretches().len();
    if count > MOST_DRAWN {
        section = section.paragraph(format!("The first {MOST_DRAWN} of {count} are drawn."));
    }
    section
}

/// Stretches of one region on the specimen, in time.
pub(super) fn spans(time: &[f64], regions: &[Region]) -> Vec<(f64, f64, Region)> {
    let mut found: Vec<(f64, f64, Region)> = Vec::new();
    for (&time, &region) in time.iter().zip(regions) {
        match found.last_mut() {
            Some((_, end, last)) if *last == region => *end = time,
            _ => found.push((time, time, region)),
        }
    }
    found.retain(|(_, _, region)| !matches!(region, Region::Approach | Region::After));
    found
}
