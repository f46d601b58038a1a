//! A limit surface that grows under creep or shrinks under relaxation.

use palpate_contact::grasp::{Grown, Shape};
use palpate_report::number::{percent, significant};
use palpate_report::{Axis, Callout, Colour, Column, Panels, Plot, Section, Series, Table};

/// Rows of the table at most.
const ROWS: usize = 12;

/// What the contact carries over time, as a table, a finding and plots.
#[must_use]
pub fn growth_sections(grown: &[Grown]) -> Vec<Section> {
    let (Some(first), Some(last)) = (grown.first(), grown.last()) else { return Vec::new() };
    let mut table = Table::new(
        "What the contact carries",
        vec![
            Column::number("time", "s"),
            Column::number("compression", "mm"),
            Column::number("normal force", "N"),
            Column::text("contact (mm)"),
            Column::number("force", "N"),
            Column::number("moment", "N mm"),
        ],
    );
    let step = grown.len().div_ceil(ROWS).max(1);
    let last_is_shown = (grown.len() - 1).is_multiple_of(step);
    let shown = grown.iter().step_by(step).chain(Some(last).filter(|_| !last_is_shown));
    for moment in shown {
        table = table.row([
            significant(moment.held.time, 4),
            significant(moment.held.compression, 4),
            significant(moment.held.normal, 4),
            sizes(&moment.shape),
            significant(moment.force, 4),
            significant(moment.moment, 4),
        ]);
    }
    let change = |from: f64, to: f64| to / from - 1.0;
    let words = |change: f64| match percent(change.abs(), 3) {
        _ if change.abs() < 1e-9 => "is unchanged".to_owned(),
        amount if change > 0.0 => format!("grows by {amount}"),
        amount => format!("falls by {amount}"),
    };
    let finding = format!(
        "From {} s to {} s the largest tangential force {} and the largest moment {}.",
        significant(first.held.time, 3),
        significant(last.held.time, 3),
        words(change(first.force, last.force)),
        words(change(first.moment, last.moment)),
    );
    let section = Section::new("Growth of the limit surface")
        .callout(Callout::Finding, "Growth", finding)
        .table(table)
        .figure(panels(grown), "");
    vec![section]
}

/// The sizes of a contact: a radius, or two sides.
fn sizes(shape: &Shape) -> String {
    let both = |a: f64, b: f64| format!("{} × {}", significant(a, 5), significant(b, 5));
    match *shape {
        Shape::Rectangle { length, width } => both(length, width),
        Shape::Circle { radius } => format!("radius {}", significant(radius, 5)),
        Shape::Ellipse { x, y } => both(x, y),
    }
}

fn panels(grown: &[Grown]) -> Panels {
    let time: Vec<f64> = grown.iter().map(|grown| grown.held.time).collect();
    let line = |label: &str, unit: &str, value: fn(&Grown) -> f64, hue: usize| {
        let values: Vec<f64> = grown.iter().map(value).collect();
        Plot::new("", Axis::new("time", "s"), Axis::new(label, unit))
            .series(Series::line(label, &time[..], values).colour(Colour::Hue(hue)))
            .height(130.0)
    };
    Panels::new("Compression and what the contact carries")
        .plot(line("compression", "mm", |grown| grown.held.compression, 2))
        .plot(line("largest force", "N", |grown| grown.force, 0))
        .plot(line("largest moment", "N mm", |grown| grown.moment, 1))
        .summary(format!("{} times over a hold", grown.len()))
}
