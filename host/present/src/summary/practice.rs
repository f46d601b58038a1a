//! A practice data set, and its truth when it is opened.

use super::overview;
use palpate_diagnose::practice::{Practice, SEALED, Truth};
use palpate_report::number::significant;
use palpate_report::{Block, Callout, Column, Section, Table};

/// What was made and what to do with it; nothing of the truth.
#[must_use]
pub fn practice_sections(practice: &Practice, folder: &str) -> Vec<Section> {
    let steps = [
        format!("palpate fit fung {folder} -o model.toml"),
        format!("palpate compare model.toml {folder}"),
        format!("palpate diagnose --model model.toml {folder}"),
        format!("palpate add EFFECT model.toml {folder} -o better.toml"),
        format!("palpate hide --open {folder}"),
    ];
    let section = Section::new("A practice set")
        .table(overview(&practice.traces))
        .paragraph(format!(
            "In {folder}: {} traces of one made-up specimen that the base law alone does not describe. \
             The truth is in {SEALED}; seed {}.",
            practice.traces.len(),
            practice.truth.seed
        ))
        .paragraph("What next:")
        .block(Block::Code(steps.join("\n")));
    vec![section]
}

/// What was hidden.
#[must_use]
pub fn truth_sections(truth: &Truth) -> Vec<Section> {
    let names: Vec<&str> = truth.model.effects.iter().map(|effect| effect.name.as_str()).collect();
    let hidden = if names.is_empty() { "nothing".into() } else { names.join(" and ") };
    let columns = vec![
        Column::text("of"),
        Column::text("law"),
        Column::text("parameter"),
        Column::number("value", ""),
        Column::text("unit"),
    ];
    let mut table = Table::new("The specimen", columns);
    let base = truth.model.base.parameters.iter().map(|stored| ("fung", "", stored));
    let effects = truth.model.effects.iter().flat_map(|effect| {
        let law = effect.law.as_deref().unwrap_or_default();
        effect.parameters.iter().map(move |stored| (effect.name.as_str(), law, stored))
    });
    for (of, law, (name, stored)) in base.chain(effects) {
        table = table.row([of, law, name, &significant(stored.value, 4), &stored.unit]);
    }
    let section = Section::new("The truth")
        .callout(
            Callout::Finding,
            "Hidden",
            format!(
                "Hidden is {hidden}. The base law, refitted, leaves {} times the noise of {} N.",
                significant(truth.misfit_over_noise, 3),
                significant(truth.noise_rms, 3)
            ),
        )
        .table(table.note(format!(
            "Noise: correlation from sample to sample {}; seed {}.",
            significant(truth.noise_correlation, 2),
            truth.seed
        )));
    vec![section]
}
