//! A diagnosis as tables, plots and words, and as the answer that other programs read.

use serde_json::{Map, Value, json};

use super::unit_of;
use crate::criticism::diagnose::Diagnosis;
use crate::criticism::{screen, search};
use crate::report::{Callout, Column, Section, Table};

/// The diagnosis as one JSON object, as the format has it, with more beside.
#[must_use]
pub fn diagnosis_json(diagnosis: &Diagnosis) -> Value {
    let found = &diagnosis.found;
    let steps: Vec<Value> = found
        .steps
        .iter()
        .enumerate()
        .map(|(index, step)| {
            let before = if index == 0 { &found.base } else { &found.models[index - 1] };
            let after = &found.models[index];
            let held_out =
                |index: usize| diagnosis.held_out[index].as_ref().map(|held_out| held_out.rms);
            let rivals: Vec<Value> = step
                .rivals
                .iter()
                .map(|rival| {
                    json!({
                        "effect": rival.effect,
                        "law": rival.fitted.chain.effects.last().map(|effect| &effect.law),
                        "delta_bic_to_best": rival.fitted.bic() - step.rivals[0].fitted.bic(),
                        "won": rival.won,
                        "rms_N": rival.fitted.rms(),
                    })
                })
                .collect();
            json!({
                "effect": step.effect,
                "law": law_of(diagnosis, index),
                "credible_set": step.credible,
                "parameters": parameters(diagnosis, index),
                "rms_before_N": before.rms(),
                "rms_after_N": after.rms(),
                "heldout_rms_before_N": held_out(index),
                "heldout_rms_after_N": held_out(index + 1),
                "delta_bic": before.bic() - after.bic(),
                "p_value": step.p_value,
                "rivals": rivals,
            })
        })
        .collect();
    let places: Vec<Value> = diagnosis
        .places
        .iter()
        .map(|cell| {
            json!({
                "trace": diagnosis.labels[cell.trace],
                "phase": cell.region.name(),
                "share_of_excess": cell.share_of_excess,
                "rms_N": cell.rms,
            })
        })
        .collect();
    let untestable: Vec<Value> = diagnosis
        .untestable
        .iter()
        .map(|(effect, reason)| json!({"effect": effect, "reason": reason}))
        .collect();
    json!({
        "palpate_diagnosis": 1,
        "verdict": diagnosis.verdict.word(),
        "signal": diagnosis.signal,
        "unit": unit_of(&diagnosis.signal),
        "noise_rms_N": diagnosis.noise.whitening.standard_deviation(),
        "base_rms_N": found.base.rms(),
        "final_rms_N": found.model().rms(),
        "steps": steps,
        "where": places,
        "untestable": untestable,
        "next_experiment": diagnosis.next_experiment,
        "adequacy": {"before": diagnosis.before.p_value, "after": diagnosis.after.p_value, "unexplained": diagnosis.unexplained},
        "notes": diagnosis.notes,
        "seeds": {"null": screen::SEED, "resampling": search::SEED},
    })
}

fn law_of(diagnosis: &Diagnosis, index: usize) -> Option<String> {
    let model = diagnosis.found.model();
    let first = diagnosis.found.base.chain.effects.len();
    model.chain.effects.get(first + index).map(|effect| effect.law.clone())
}

/// Parameters of the effect of a step, in the last model.
fn parameters(diagnosis: &Diagnosis, index: usize) -> Map<String, Value> {
    let model = diagnosis.found.model();
    let place = diagnosis.found.base.chain.effects.len() + index;
    let effect = &model.chain.effects[place];
    model
        .chain
        .range(place)
        .zip(&effect.parameters)
        .map(|(k, parameter)| {
            let value = json!({
                "value": model.values[k],
                "standard_error": diagnosis.standard_errors[k],
                "unit": parameter.unit,
            });
            (parameter.name.to_string(), value)
        })
        .collect()
}

/// The verdict, the evidence and what to do next.
#[must_use]
pub fn diagnosis_sections(diagnosis: &Diagnosis) -> Vec<Section> {
    let mut section = Section::new("Verdict").callout(
        Callout::Finding,
        "In short",
        diagnosis.verdict.word().to_owned(),
    );
    let columns = vec![Column::text("effect"), Column::number("p", "")];
    let mut table = Table::new("Steps", columns);
    for step in &diagnosis.found.steps {
        table = table.row([step.effect.clone(), format!("{:.5}", step.p_value)]);
    }
    section = section.table(table);
    vec![section]
}
