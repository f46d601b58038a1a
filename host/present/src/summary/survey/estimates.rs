//! How each number is distributed over the groups, what lies far out, and how it drifts.

use super::{more, shown};
use palpate_report::{Axis, Block, Column, Panels, Plot, Section, Series, Table};
use palpate_survey::overview::{FAR, Kind, Overview};

/// Most kinds of numbers in tables and figures.
const MOST_KINDS: usize = 24;
/// Most of them that are drawn over time.
const MOST_DRAWN: usize = 8;
/// Most bars of a distribution, and samples for each on average.
const MOST_BARS: usize = 40;
const IN_A_BAR: usize = 5;
/// Fewest values that make a distribution.
const MIN_VALUES: usize = 8;

/// Distributions, what lies far out, drift; nothing where there are no numbers.
pub(super) fn sections(overview: &Overview) -> Vec<Section> {
    if overview.kinds.is_empty() {
        return Vec::new();
    }
    let mut first = Section::new("Estimates").table(table(overview));
    let drawn =
        overview.kinds.iter().filter(|kind| kind.values.len() >= MIN_VALUES).take(MOST_KINDS);
    let figures: Vec<Block> = drawn.map(distribution).collect();
    let (shown, folded) = figures.split_at(figures.len().min(MOST_DRAWN));
    first.blocks.extend(shown.iter().cloned());
    if !folded.is_empty() {
        let (summary, blocks) = ("More distributions".into(), folded.to_vec());
        first = first.block(Block::Details { summary, blocks });
    }
    let mut sections = vec![first];
    sections.extend(far_out(overview));
    sections.extend(drift(overview));
    sections
}

/// Every kind of number with its distribution.
fn table(overview: &Overview) -> Table {
    let columns = vec![
        Column::text("estimate"),
        Column::text("unit"),
        Column::whole("groups"),
        Column::number("5 %", ""),
        Column::number("median", ""),
        Column::number("95 %", ""),
    ];
    let mut table = Table::new("Estimates over all groups", columns);
    for kind in overview.kinds.iter().take(MOST_KINDS) {
        let part = |part| shown(kind.quantile(part));
        let groups = kind.values.len().to_string();
        table = table.row([
            kind.name.clone(),
            kind.unit.clone(),
            groups,
            part(0.05),
            part(0.5),
            part(0.95),
        ]);
    }
    match overview.kinds.len().checked_sub(MOST_KINDS) {
        Some(more @ 1..) => table.note(format!("And {more} more kinds; `--json` lists them all.")),
        _ => table,
    }
}

/// How many groups have a value in each of equal spans. What lies far out stands in the outermost.
fn distribution(kind: &Kind) -> Block {
    let (least, most) = match kind.median_and_spread() {
        Some((median, spread)) => (
            kind.quantile(0.0).max(median - FAR * spread),
            kind.quantile(1.0).min(median + FAR * spread),
        ),
        None => (kind.quantile(0.0), kind.quantile(1.0)),
    };
    let bars = (kind.values.len() / IN_A_BAR).clamp(1, MOST_BARS);
    let width = if most > least { (most - least) / bars as f64 } else { 1.0 };
    let mut counts = vec![0.0; bars];
    for (_, value) in &kind.values {
        let at = ((value.clamp(least, most) - least) / width) as usize;
        counts[at.min(bars - 1)] += 1.0;
    }
    let edges: Vec<f64> = (0..=bars).map(|k| least + k as f64 * width).collect();
    counts.push(0.0);
    let axis = Axis::new(kind.name.clone(), kind.unit.clone());
    let clipped = kind.quantile(0.0) < least || kind.quantile(1.0) > most;
    let caption = match clipped {
        true => format!("In the outermost bars also all beyond {FAR} spreads from the median."),
        false => String::new(),
    };
    let plot = Plot::new(kind.name.clone(), axis, Axis::new("groups", ""))
        .summary(format!("Distribution of {} over the groups", kind.name))
        .series(Series::band("", doubled(&edges), vec![0.0; 2 * edges.len()], steps(&counts)))
        .mark(kind.quantile(0.5), "median")
        .height(120.0);
    Block::Figure { figure: Box::new(plot.into()), caption }
}

/// Each edge twice, so that what is between them has an upright side.
fn doubled(edges: &[f64]) -> Vec<f64> {
    edges.iter().flat_map(|edge| [*edge, *edge]).collect()
}

/// The height left and right of each edge.
fn steps(counts: &[f64]) -> Vec<f64> {
    let before = [0.0].into_iter().chain(counts.iter().copied());
    before.zip(counts).flat_map(|(before, after)| [before, *after]).collect()
}

fn far_out(overview: &Overview) -> Option<Section> {
    let far = overview.far_out();
    if far.is_empty() {
        return None;
    }
    let columns = vec![
        Column::text("group"),
        Column::text("estimate"),
        Column::number("value", ""),
        Column::text("unit"),
        Column::number("from the median", "spreads"),
        Column::whole("group number"),
    ];
    let mut table = Table::new("Far from the others", columns);
    for far in far.iter().take(super::MOST_LISTED) {
        let kind = &overview.kinds[far.kind];
        table = table.row([
            overview.groups[far.row].clone(),
            kind.name.clone(),
            shown(far.value),
            kind.unit.clone(),
            format!("{:+.1}", far.spreads),
            far.row.to_string(),
        ]);
    }
    let note = format!(
        "More than {FAR} spreads from the median; a spread is 1.48 times the median absolute deviation, which is a standard deviation where values are normal."
    );
    Some(Section::new("Far out").table(more(table, far.len()).note(note)))
}

/// The median of each kind over time.
fn drift(overview: &Overview) -> Option<Section> {
    let order = overview.order()?;
    let times = overview.times();
    if times.len() < 2 {
        return None;
    }
    let mut panels = Panels::new(format!("Medians over {order}"))
        .summary(format!("How the median of each estimate changes over {order}"));
    for kind in overview.kinds.iter().take(MOST_DRAWN) {
        let found = overview.over_time(kind);
        let place = |when: &str| times.iter().position(|time| *time == when).unwrap_or_default();
        let x: Vec<f64> = found.iter().map(|(when, ..)| place(when) as f64 + 1.0).collect();
        let y: Vec<f64> = found.iter().map(|(_, median, _)| *median).collect();
        let (x_axis, y_axis) = (
            Axis::new(format!("{order}, in order"), ""),
            Axis::new(kind.name.clone(), kind.unit.clone()),
        );
        panels =
            panels.plot(Plot::new("", x_axis, y_axis).series(Series::line("", x, y)).height(90.0));
    }
    let (first, last) = (times[0], times[times.len() - 1]);
    let caption = format!("1 is {first}, {} is {last}.", times.len());
    Some(Section::new("Drift").figure(panels, caption))
}
