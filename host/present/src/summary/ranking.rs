//! Base laws ranked: how well each predicts, and how much its parameters move between set-ups.

use super::ladder::error_bars;
use super::unit_of;
use palpate_fit::ranking::{Place, Ranking};
use palpate_model::Rung;
use palpate_report::number::significant;
use palpate_report::{Bars, Callout, Column, Section, Table};

/// The ranking as tables and a plot.
#[must_use]
pub fn ranking_sections(ranking: &Ranking, signal: &str) -> Vec<Section> {
    let mut section = Section::new("Every law on the same traces");
    if let Some(best) = ranking.places.first() {
        section = section.callout(Callout::Finding, "Best", verdict(best, signal));
    }
    section =
        section.table(places_table(ranking, signal)).figure(ranking_bars(ranking, signal), "");
    let mut sections = vec![section];
    if ranking.places.iter().any(|place| !place.spreads.is_empty()) {
        sections.push(
            Section::new("The same parameters in every set-up?")
                .paragraph(setups_in_words(ranking))
                .table(spread_table(ranking)),
        );
    }
    sections
}

fn verdict(best: &Place, signal: &str) -> String {
    let unit = unit_of(signal);
    let name = best.fit.chain.base.in_words();
    match best.held_out {
        Some(rms) => format!("{name}: {} {unit} RMS on traces left out", significant(rms, 3)),
        None => format!(
            "{name}, by the Bayesian information criterion (a single trace cannot be left out)"
        ),
    }
}

fn places_table(ranking: &Ranking, signal: &str) -> Table {
    let unit = unit_of(signal);
    let columns = vec![
        Column::text("law"),
        Column::whole("numbers"),
        Column::number("fitted", unit),
        Column::number("held out", unit),
        Column::number("R²", ""),
        Column::number("ΔBIC", ""),
        Column::number("set-ups", "±%"),
    ];
    let least = ranking.places.iter().map(|place| place.fit.bic()).fold(f64::INFINITY, f64::min);
    let mut table = Table::new("Ranking", columns);
    for place in &ranking.places {
        let fit = &place.fit;
        table = table.row([
            fit.chain.base.in_words(),
            fit.values.len().to_string(),
            significant(fit.rms(), 3),
            place.held_out.map_or("–".into(), |rms| significant(rms, 3)),
            format!("{:.4}", fit.r_squared),
            format!("{:.1}", fit.bic() - least),
            place.typical_deviation().map_or("–".into(), |part| significant(100.0 * part, 2)),
        ]);
    }
    let noise = match &ranking.noise {
        Some(noise) => format!("The noise is {} {unit}.", significant(noise.standard_deviation, 3)),
        None => "The noise is not known without a model.".into(),
    };
    let unfinished: Vec<String> = ranking
        .places
        .iter()
        .filter(|place| !place.fit.stop.converged())
        .map(|place| place.fit.chain.base.short_name())
        .collect();
    let unfinished = match &unfinished[..] {
        [] => String::new(),
        names => format!(" Not converged: {}.", names.join(", ")),
    };
    table.note(format!(
        "Root mean square errors; held out: each trace is predicted by the law fitted to the others. ΔBIC: Bayesian information criterion over the best one's. Set-ups: how much the law's numbers move from set-up to set-up, standard deviation over mean, the median over the numbers. {noise}{unfinished}"
    ))
}

fn ranking_bars(ranking: &Ranking, signal: &str) -> Bars {
    let rung = |place: &Place| Rung {
        add: place.fit.chain.base.in_words(),
        fitted_rms: place.fit.rms(),
        heldout_rms: place.held_out,
    };
    let rungs: Vec<Rung> = ranking.places.iter().map(rung).collect();
    let names = rungs.iter().map(|rung| rung.add.clone()).collect();
    let noise = ranking.noise.as_ref().map(|noise| noise.standard_deviation);
    error_bars(names, &rungs, unit_of(signal), noise)
}

fn setups_in_words(ranking: &Ranking) -> String {
    let each = ranking.setups.iter().map(|setup| {
        let count = setup.traces.len();
        let plural = if count == 1 { "" } else { "s" };
        format!(
            "{} mm at {} mm/s ({count} trace{plural})",
            significant(setup.compression, 3),
            significant(setup.rate, 3)
        )
    });
    format!(
        "Every law was fitted to each set-up by itself: {}. A law that is of the material finds the same numbers in all of them.",
        each.collect::<Vec<_>>().join(", ")
    )
}

fn spread_table(ranking: &Ranking) -> Table {
    let mut columns = vec![Column::text("law"), Column::text("parameter")];
    columns.extend(["least", "mean", "most"].map(|name| Column::number(name, "")));
    columns.push(Column::number("±", "%"));
    columns.push(Column::number("most / least", ""));
    columns.push(Column::text("unit"));
    let mut table = Table::new("Parameters between set-ups", columns);
    for place in &ranking.places {
        for spread in &place.spreads {
            let (least, most) = spread.range();
            table = table.row([
                place.fit.chain.base.short_name(),
                spread.name.clone(),
                significant(least, 3),
                significant(spread.mean(), 3),
                significant(most, 3),
                finite(100.0 * spread.relative_deviation(), 2),
                finite(spread.ratio(), 3),
                spread.unit.clone(),
            ]);
        }
    }
    table.note("±: sample standard deviation (n − 1) over the set-ups, of the mean. A ratio of 100 is two orders of magnitude.")
}

fn finite(value: f64, digits: usize) -> String {
    if value.is_finite() { significant(value, digits) } else { "–".into() }
}
