//! Creep in holds of a force: chapter 6 and appendix B for one's own data.

use super::holds::{chance, coefficient_table, left_out_words, plot, spread_table};
use super::terms::{place, residual_plot, terms_tables};
use palpate_analysis::conditioning::Butterworth;
use palpate_analysis::creep::{Hold, spreads};
use palpate_fit::exponentials::Parameter;
use palpate_fit::hold::{HoldError, HoldFit, Spread};
use palpate_report::number::significant;
use palpate_report::{Callout, Column, Section, Table};
use palpate_trace::Trace;

/// Most holds that a report draws one by one.
const MOST_DRAWN: usize = 6;

/// Filter of the force and the sampling rate it ran at, Hz.
pub type Conditioning = (Butterworth, f64);

/// Coefficients, repeats, doubts and number of exponentials of every hold.
#[must_use]
pub fn creep_sections(
    holds: &[Hold],
    left_out: &[HoldError],
    traces: &[Trace],
    signal: &str,
    conditioning: Option<Conditioning>,
) -> Vec<Section> {
    let fits: Vec<HoldFit> = holds.iter().map(|hold| hold.fit.clone()).collect();
    let mut table = coefficient_table(&fits, signal);
    table.caption = "Creep of each hold: N (1 + Σ ci e^(−vi t)), N is D (6.1, 6.2)".into();
    table.notes[0] = table.notes[0].replace(
        "N is the signal at the start of the hold.",
        "N is D, the signal after infinite time, and c0 = 1.",
    );
    let mut first = Section::new("Creep function");
    if let Some(conditioning) = conditioning {
        first = first.paragraph(conditioning_words(conditioning));
    }
    first = first.table(force_table(holds)).table(table);
    for text in left_out_words(left_out) {
        first = first.callout(Callout::Warning, "Left out", text);
    }
    for hold in holds {
        for doubt in &hold.doubts {
            let text = format!("{}: {doubt}", place(&hold.fit));
            first = first.callout(Callout::Warning, "Not identified", text);
        }
    }
    let spreads = spreads(holds);
    if !spreads.is_empty() {
        first = first.table(spread_table(&spreads, signal, "N"));
    }
    if let Some(words) = asymptote_words(&spreads) {
        first = first.callout(Callout::Finding, "Asymptote", words);
    }
    let pairs: Vec<_> = holds.iter().map(|hold| (&hold.fit, &hold.terms)).collect();
    let mut number = Section::new("Number of exponentials");
    for table in terms_tables(&pairs, signal) {
        number = number.table(table);
    }
    for hold in holds.iter().take(MOST_DRAWN) {
        let trace = traces.iter().find(|trace| trace.label() == hold.fit.trace);
        if let Some((trace, values)) = trace.and_then(|trace| Some((trace, trace.column(signal)?)))
        {
            first = first.figure(plot(&hold.fit, trace, signal), "");
            let left = residual_plot(&hold.fit, &hold.terms, &trace.time, values, signal);
            number = number.figure(left, "");
        }
    }
    vec![first, number]
}

fn force_table(holds: &[Hold]) -> Table {
    let columns = vec![
        Column::text("hold"),
        Column::number("lasts", "s"),
        Column::number("force", "N"),
        Column::number("its scatter", "N"),
        Column::number("D over force", ""),
    ];
    let mut table = Table::new("What was held", columns);
    for hold in holds {
        let force = |of: fn((f64, f64)) -> f64| {
            hold.force.map_or("–".into(), |force| significant(of(force), 4))
        };
        table = table.row([
            place(&hold.fit),
            significant(hold.fit.duration_s, 4),
            force(|force| force.0),
            force(|force| force.1),
            hold.force.map_or("–".into(), |f| significant(hold.fit.fit.sum.scale / f.0, 4)),
        ]);
    }
    table
}

fn conditioning_words((filter, rate): Conditioning) -> String {
    let ways = if filter.zero_phase {
        "forward and backward, so without delay".to_owned()
    } else {
        "forward only, so delayed".to_owned()
    };
    format!(
        "The force was filtered: Butterworth, order {}, {} Hz, {ways}; together 3 dB down at {} Hz.",
        filter.order,
        significant(filter.cutoff_hz, 4),
        significant(filter.three_db_hz(rate), 4),
    )
}

/// Whether holds of one force settle at the same place (6.4.4).
fn asymptote_words(spreads: &[Spread]) -> Option<String> {
    let asymptotes = spreads.iter().filter(|spread| spread.parameter == Parameter::Scale);
    let said: Vec<String> = asymptotes
        .filter_map(|spread| {
            let test = spread.consistency?;
            let verdict = if test.p_value < 0.01 { "differ by more than" } else { "agree within" };
            let level =
                spread.level.map_or(String::new(), |f| format!(" at {} N", significant(f, 3)));
            Some(format!(
                "{} holds{level} settle at places that {verdict} their standard errors (p {})",
                spread.holds,
                chance(test.p_value)
            ))
        })
        .collect();
    (!said.is_empty()).then(|| said.join("; ") + ".")
}
