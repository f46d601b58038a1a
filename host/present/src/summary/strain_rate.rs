//! Strain, strain rate and the power law of every hold: chapter 7 for one's own data.

use super::holds::chance;
use super::rates::geometry_words;
use super::{CONCISE, bandwidth_words, concise};
use palpate_analysis::regions::numeral;
use palpate_analysis::strain_rate::{Hold, Order, Study};
use palpate_fit::consistency::consistency;
use palpate_report::number::significant;
use palpate_report::{Axis, Callout, Colour, Column, Plot, Section, Series, Table};

/// Most holds that a report draws one by one.
const MOST_DRAWN: usize = 12;
/// Holds count as at the same displacement when they differ by less than this, relatively.
const SAME_DISPLACEMENT: f64 = 0.02;

/// The law of every hold, what of it is not told, and plots.
#[must_use]
pub fn strain_rate_sections(study: &Study) -> Vec<Section> {
    let mut geometries: Vec<String> = study.geometry.iter().map(geometry_words).collect();
    geometries.dedup();
    let mut section = Section::new("Strain and strain rate")
        .paragraph(format!(
            "{} ε = F/(A E) with E = {} Pa (7.6), positive in compression. {}",
            geometries.join(" "),
            significant(study.modulus_pa, 4),
            order_words(study),
        ))
        .table(law_table(study));
    for hold in &study.holds {
        for doubt in &hold.fit.doubts {
            let text = format!("{}: {doubt}", place(hold));
            section = section.callout(Callout::Warning, "Not identified", text);
        }
    }
    let repeats = equilibrium_table(study);
    if !repeats.rows.is_empty() {
        section = section.table(repeats);
    }
    for hold in study.holds.iter().take(MOST_DRAWN) {
        section = section.figure(strain_plot(hold), "");
        if let Some((plot, caption)) = rate_plot(hold) {
            section = section.figure(plot, caption);
        }
    }
    vec![section]
}

fn place(hold: &Hold) -> String {
    format!("{} from {:.2} s", hold.trace, hold.from_s)
}

fn order_words(study: &Study) -> String {
    match (study.asked, study.order) {
        (Order::LowestOdd, Some(order)) => format!(
            "n = {order}: the lowest odd order that fits all holds together as well as the best, within χ² of 95 % (one degree of freedom, residuals taken as independent)."
        ),
        (_, Some(order)) => format!("n = {order} as asked."),
        (_, None) => {
            "n is a parameter of every hold, so the ν of two holds cannot be compared.".into()
        }
    }
}

fn law_table(study: &Study) -> Table {
    let columns = vec![
        Column::text("hold"),
        Column::number("at", "mm"),
        Column::text("type"),
        Column::number("ε_e", ""),
        Column::number("ε_0 − ε_e", ""),
        Column::text("ν, 1/s"),
        Column::number("n", ""),
        Column::text("odd n that fit"),
        Column::text("gap left"),
        Column::number("R²", ""),
    ];
    let mut table = Table::new("ε̇ = −ν sgn(ε − ε_e) |ε − ε_e|ⁿ (7.2; Tables 7.1, 7.2)", columns);
    for hold in &study.holds {
        let fit = &hold.fit;
        let factor = fit.rate.1.map_or("?".into(), |error| significant(error.exp(), 3));
        let (low, high) = hold.odd_orders;
        table = table.row([
            place(hold),
            significant(hold.displacement_mm, 4),
            numeral(hold.relaxation).to_owned(),
            concise(fit.equilibrium.0, fit.equilibrium.1),
            concise(fit.gap.0, fit.gap.1),
            format!("{} ×/÷ {factor}", significant(fit.rate.0, 3)),
            concise(fit.order.0, fit.order.1),
            if low == high { format!("{low}") } else { format!("{low}–{high}") },
            format!("{:.0} %", 100.0 * fit.left),
            format!("{:.4}", fit.r_squared),
        ]);
    }
    table.note(format!("ν ×/÷ its standard error as a factor. {CONCISE}"))
}

/// Equilibrium strains at one displacement, on the way in and back.
fn equilibrium_table(study: &Study) -> Table {
    let columns = vec![
        Column::text("at"),
        Column::whole("holds"),
        Column::text("types"),
        Column::text("ε_e of each"),
        Column::text("p that they agree"),
    ];
    let mut table = Table::new("Equilibrium strain at the same displacement (7.3.3)", columns);
    let mut open: Vec<&Hold> = study.holds.iter().collect();
    while let Some(first) = open.first().copied() {
        let x = first.displacement_mm;
        let same = |hold: &&Hold| (hold.displacement_mm - x).abs() <= SAME_DISPLACEMENT * x.abs();
        let (group, rest): (Vec<&Hold>, Vec<&Hold>) = open.into_iter().partition(same);
        open = rest;
        if group.len() < 2 {
            continue;
        }
        let values: Vec<f64> = group.iter().map(|hold| hold.fit.equilibrium.0).collect();
        let errors: Option<Vec<f64>> = group.iter().map(|hold| hold.fit.equilibrium.1).collect();
        let test = errors.and_then(|errors| consistency(&values, &errors));
        let each = group.iter().map(|hold| concise(hold.fit.equilibrium.0, hold.fit.equilibrium.1));
        table = table.row([
            format!("{} mm", significant(x, 4)),
            group.len().to_string(),
            group.iter().map(|hold| numeral(hold.relaxation)).collect::<Vec<_>>().join(", "),
            each.collect::<Vec<_>>().join(", "),
            test.map_or("–".into(), |test| chance(test.p_value)),
        ]);
    }
    table
}

fn strain_plot(hold: &Hold) -> Plot {
    let last = hold.duration_s;
    let step = hold.duration_s / (hold.strain.len().max(2) - 1) as f64;
    let measured = hold.measured.as_ref();
    let (x, y) = match measured {
        Some(measured) => (measured.time.clone(), measured.smoothed.clone()),
        None => {
            (0..hold.strain.len()).map(|k| step * k as f64).zip(hold.strain.iter().copied()).unzip()
        }
    };
    let (t, fitted): (Vec<f64>, Vec<f64>) =
        (0..=200).map(|k| last * f64::from(k) / 200.0).map(|t| (t, hold.fit.law.strain(t))).unzip();
    Plot::new(
        format!("Strain in the hold: {}", place(hold)),
        Axis::new("time in the hold", "s"),
        Axis::new("strain", ""),
    )
    .summary("Strain from the force, locally smoothed, and the fitted power law")
    .series(Series::points("measured, smoothed", x, y).colour(Colour::MEASURED))
    .series(Series::line("(7.4), (7.5)", t, fitted).colour(Colour::MODEL))
    .level(hold.fit.law.equilibrium, "ε_e")
}

fn rate_plot(hold: &Hold) -> Option<(Plot, String)> {
    let measured = hold.measured.as_ref()?;
    let law = &hold.fit.law;
    let (from, to) = (law.initial, law.strain(hold.duration_s));
    let (strain, rate): (Vec<f64>, Vec<f64>) = (0..=100)
        .map(|k| from + (to - from) * f64::from(k) / 100.0)
        .map(|strain| (strain, law.strain_rate_at(strain)))
        .unzip();
    let plot = Plot::new(
        format!("Strain rate over strain: {}", place(hold)),
        Axis::new("strain", ""),
        Axis::new("strain rate", "1/s"),
    )
    .summary("Measured strain rate over strain, and the fitted power law")
    .series(
        Series::points("measured", &measured.smoothed[..], &measured.slope[..])
            .colour(Colour::MEASURED),
    )
    .series(
        Series::line(format!("n = {}", significant(law.order, 3)), strain, rate)
            .colour(Colour::MODEL),
    );
    Some((plot, format!("As in Fig. 7.6. {}", bandwidth_words(measured))))
}
