//! What markers say: the law of every gap between them, as a table and plots.

use super::{CONCISE, concise, name_of};
use palpate_analysis::markers::{Gap, Study};
use palpate_analysis::strain_rate::Order;
use palpate_report::number::significant;
use palpate_report::{Axis, Callout, Colour, Column, Plot, Section, Series, Table};

/// Most gaps that a report draws one by one.
const MOST_DRAWN: usize = 12;

/// The law of every gap, what of it is not told, and plots.
#[must_use]
pub fn markers_sections(study: &Study) -> Vec<Section> {
    let mut section = Section::new("Gaps between markers")
        .paragraph(format!(
            "The length between two markers goes to an equilibrium by e' = −ν sgn e |e|ⁿ, e its distance from there (4.9, 7.2). {}",
            order_words(study)
        ))
        .table(gap_table(study));
    for gap in &study.gaps {
        for doubt in &gap.fit.doubts {
            section = section.callout(
                Callout::Warning,
                "Not identified",
                format!("{}: {doubt}", place(gap)),
            );
        }
    }
    for gap in study.gaps.iter().take(MOST_DRAWN) {
        section = section.figure(markers_figure(gap), "");
    }
    vec![section]
}

fn order_words(study: &Study) -> String {
    match (study.asked, study.order) {
        (Order::LowestOdd, Some(order)) => format!(
            "n = {order}: the lowest odd order that fits all gaps together as well as the best, within χ² of 95 % (one degree of freedom, residuals taken as independent)."
        ),
        (_, Some(order)) => format!("n = {order} as asked."),
        (_, None) => "n is a parameter of every gap.".into(),
    }
}

fn between(gap: &Gap) -> String {
    gap.between.iter().map(|name| name_of(name)).collect::<Vec<_>>().join(" to ")
}

fn place(gap: &Gap) -> String {
    format!("{}, {} from {:.2} s", gap.trace, between(gap), gap.from_s)
}

fn gap_table(study: &Study) -> Table {
    let columns = vec![
        Column::text("gap"),
        Column::number("from", "s"),
        Column::number("at first", "mm"),
        Column::number("ends at", "mm"),
        Column::text("ν, 1/s"),
        Column::number("n", ""),
        Column::text("odd n that fit"),
        Column::text("left at the end"),
        Column::number("RMS", "mm"),
    ];
    let mut table = Table::new("The gaps in every hold", columns);
    for gap in &study.gaps {
        let fit = &gap.fit;
        let factor = fit.rate.1.map_or("?".into(), |error| significant(error.exp(), 3));
        let (low, high) = gap.odd_orders;
        table = table.row([
            format!("{}, {}", gap.trace, between(gap)),
            format!("{:.2}", gap.from_s),
            concise(fit.initial.0, fit.initial.1),
            concise(fit.equilibrium.0, fit.equilibrium.1),
            format!("{} ×/÷ {factor}", significant(fit.rate.0, 3)),
            concise(fit.order.0, fit.order.1),
            if low == high { format!("{low}") } else { format!("{low}–{high}") },
            format!("{:.0} %", 100.0 * fit.left),
            significant(fit.noise, 2),
        ]);
    }
    table.note(format!(
        "ν in 1/s at a distance of 1 mm, ×/÷ its standard error as a factor. {CONCISE}"
    ))
}

/// A gap over its hold, with the fitted law.
#[must_use]
pub fn markers_figure(gap: &Gap) -> Plot {
    let last = gap.time.last().copied().unwrap_or(0.0);
    let (t, fitted): (Vec<f64>, Vec<f64>) =
        (0..=200).map(|k| last * f64::from(k) / 200.0).map(|t| (t, gap.fit.law.strain(t))).unzip();
    Plot::new(place(gap), Axis::new("time in the hold", "s"), Axis::new("gap", "mm"))
        .summary("The gap between two markers over a hold, and the fitted latency model")
        .series(Series::points("seen", &gap.time[..], &gap.gap[..]).colour(Colour::MEASURED))
        .series(
            Series::line(format!("n = {}", significant(gap.fit.law.order, 3)), t, fitted)
                .colour(Colour::MODEL),
        )
        .level(gap.fit.law.equilibrium, "ends at")
}
