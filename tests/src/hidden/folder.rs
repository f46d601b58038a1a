//! Data sets as files: a folder for each, and one `truth.json` beside them.

use std::error::Error;
use std::path::Path;

use palpate::trace::{FORCE, write};
use serde_json::{Map, Value, json};

use super::laws::LawKind;
use super::scenario::{DataSet, Hidden, Truth};

/// Writes the traces of a set into a folder.
///
/// # Errors
/// Where the file system refuses.
pub fn write_traces(folder: &Path, set: &DataSet) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    for trace in &set.traces {
        write(&folder.join(trace.label()), trace)?;
    }
    Ok(())
}

/// Writes `truth.json` for sets under their names.
///
/// # Errors
/// Where the file system refuses.
pub fn write_truth<'a>(
    folder: &Path,
    sets: impl Iterator<Item = (&'a str, &'a Truth)>,
) -> Result<(), Box<dyn Error>> {
    let sets: Map<String, Value> = sets.map(|(name, of)| (name.to_owned(), truth(of))).collect();
    let text = serde_json::to_string_pretty(&json!({ "sets": sets }))?;
    Ok(std::fs::write(folder.join("truth.json"), text)?)
}

fn truth(truth: &Truth) -> Value {
    let effects: Vec<&str> = truth.effects().collect();
    let base = &truth.base;
    let noise = if truth.signal == FORCE { "noise_rms_N" } else { "noise_rms_ustrain" };
    json!({
        "effects": effects,
        "detail": truth.hidden.iter().map(detail).collect::<Vec<_>>(),
        "R": truth.r,
        noise: truth.noise_rms,
        "base": {
            "p": base.p,
            "q": base.q,
            "c1": base.shares[0],
            "c2": base.shares[1],
            "v1_per_s": base.rates[0],
            "v2_per_s": base.rates[1],
        },
    })
}

fn detail(hidden: &Hidden) -> Value {
    let numbers = hidden.parameters.iter().map(|(name, value)| ((*name).to_owned(), json!(value)));
    let mut parameters: Map<String, Value> = numbers.collect();
    parameters.insert("unit".into(), hidden.unit.into());
    let law = match hidden.kind {
        LawKind::Reference => "reference",
        LawKind::Foreign | LawKind::ForeignMore => "another",
        LawKind::Outside | LawKind::OutsideMore | LawKind::Beyond => "outside",
        LawKind::Inexact => "inexact base",
    };
    json!({
        "effect": hidden.effect,
        "law": law,
        "form": hidden.form,
        "parameters": parameters,
        "R_alone": hidden.r,
    })
}
