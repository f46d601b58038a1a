//! An effect added to a model or taken out: what it did to the error, and the parameters after.

use super::{estimate, ladder, overlays, unit_of};
use palpate_diagnose::criticism::change::Change;
use palpate_diagnose::criticism::leftover::Leftover;
use palpate_model::{Parameter, Rung};
use palpate_report::number::significant;
use palpate_report::{Callout, Column, Section, Table};

/// The change of the error, the parameters and the ladder.
#[must_use]
pub fn change_sections(change: &Change) -> Vec<Section> {
    let (title, kind) = match (change.added, change.after.fitted_rms < change.before.fitted_rms) {
        (true, true) => (format!("{} added", change.effect), Callout::Finding),
        (true, false) => (format!("{} added", change.effect), Callout::Warning),
        (false, _) => (format!("{} taken out", change.effect), Callout::Finding),
    };
    let mut section = Section::new(title).callout(kind, "In short", in_short(change));
    for note in &change.notes {
        section = section.paragraph(note.clone());
    }
    section = section.table(parameters(change)).table(rungs(change));
    if change.laws.len() > 1 {
        section = section.table(laws(change));
    }
    for warning in &change.warnings {
        section = section.callout(Callout::Warning, "Beware", warning.clone());
    }
    vec![section]
}

/// What a report shows of a change: the change, the ladder, and every trace with the model after.
#[must_use]
pub fn change_report(change: &Change, left: &Leftover) -> Vec<Section> {
    let mut sections = change_sections(change);
    sections.extend(ladder(&change.model));
    sections.push(overlays(&left.comparison, &left.residuals));
    sections
}

fn in_short(change: &Change) -> String {
    let unit = unit_of(&change.model.base.signal);
    let fitted =
        (significant(change.before.fitted_rms, 3), significant(change.after.fitted_rms, 3));
    let mut text = format!("Error on the traces fitted {} → {} {unit} RMS", fitted.0, fitted.1);
    if let Some((before, after)) = change.before.heldout_rms.zip(change.after.heldout_rms) {
        text += &format!(", held out {} → {}", significant(before, 3), significant(after, 3));
    }
    text + &change.noise.map_or_else(
        || "; the recordings do not determine the noise.".into(),
        |noise| format!("; noise floor {}.", significant(noise.standard_deviation, 3)),
    )
}

/// What each value of the fit is of: the base law or an effect, and its parameter.
pub fn declared(change: &Change) -> Vec<(String, Parameter)> {
    let chain = &change.fit.chain;
    let law = chain.base.name();
    let of_base = chain.base.parameters().into_iter().map(|p| (law.to_owned(), p));
    let of_effects = chain.effects.iter().flat_map(|effect| {
        effect.parameters.iter().map(|parameter| (effect.name.clone(), parameter.clone()))
    });
    of_base.chain(of_effects).collect()
}

fn parameters(change: &Change) -> Table {
    let columns = vec![
        Column::text("of"),
        Column::text("parameter"),
        Column::number("value ± standard error", ""),
        Column::text("unit"),
        Column::text("meaning"),
    ];
    let fit = &change.fit;
    let mut table = Table::new("Parameters", columns);
    for (k, (of, parameter)) in declared(change).iter().enumerate() {
        let value = estimate(fit.values[k], fit.standard_errors[k]);
        table = table.row([
            of.as_str(),
            &parameter.name,
            &value,
            &parameter.unit,
            if parameter.lower < parameter.upper {
                &parameter.meaning
            } else {
                "given, not fitted"
            },
        ]);
    }
    table
}

fn rungs(change: &Change) -> Table {
    let unit = unit_of(&change.model.base.signal);
    let columns = vec![
        Column::text("rung"),
        Column::number("error, fitted", unit),
        Column::number("error, held out", unit),
        Column::number("over the noise", ""),
    ];
    let mut table = Table::new("The ladder", columns);
    let noise = change.noise.map(|noise| noise.standard_deviation);
    let row = |rung: &Rung| {
        let held_out = rung.heldout_rms.map_or("–".into(), |rms| significant(rms, 3));
        let times = noise.map_or("–".into(), |noise| format!("{:.2}", rung.fitted_rms / noise));
        [rung.add.clone(), significant(rung.fitted_rms, 3), held_out, times]
    };
    for rung in &change.model.ladder {
        table = table.row(row(rung));
    }
    table.note("Held out: each trace predicted by a fit to the others.")
}

fn laws(change: &Change) -> Table {
    let columns = vec![Column::text("law"), Column::number("BIC over the best", "")];
    let mut table = Table::new("Laws tried", columns);
    for tried in &change.laws {
        table = table.row([tried.law.clone(), format!("{:.1}", tried.over_best)]);
    }
    table.note(
        "The Bayesian information criterion (BIC) decides: least is best; within 10 the traces cannot distinguish the laws.",
    )
}
