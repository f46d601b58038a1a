//! What each candidate of a diagnosis would make of the prediction, before anything is refitted.

use serde_json::{Value, json};

use super::drawing::{Drawing, View};
use palpate_diagnose::criticism::compare::Comparison;
use palpate_diagnose::criticism::diagnose::Diagnosis;
use palpate_diagnose::criticism::foretold::{foretold, most_promising};
use palpate_diagnose::criticism::leftover::Leftover;
use palpate_diagnose::criticism::screen::Direction;
use palpate_fit::data::Data;
use palpate_model::Model;
use palpate_model::effects::find;

/// Candidates that are drawn in the list.
const MAX_DRAWN: usize = 12;
/// Columns of such a picture.
const COLUMNS: usize = 120;

/// What one candidate foretells for every trace.
#[derive(Clone, Debug)]
pub struct Forecast {
    /// Name of the candidate.
    pub effect: String,
    /// The law for which most is foretold.
    law: String,
    /// Root mean square that would be left.
    rms: f64,
    drawings: Vec<Drawing>,
}

impl Forecast {
    /// Runs the model with a candidate; none where the screen foretells nothing for it.
    #[must_use]
    pub fn new(diagnosis: &Diagnosis, data: &Data, effect: &str) -> Option<Self> {
        let index = diagnosis.candidates.iter().position(|candidate| candidate.name == effect)?;
        let direction: &Direction = most_promising(&diagnosis.found.first, index)?;
        let form = &diagnosis.candidates[index].forms[direction.form];
        let predicted = foretold(&diagnosis.found.base, direction, form, data);
        let left: Vec<Vec<f64>> = data
            .pieces
            .iter()
            .zip(&predicted)
            .map(|(piece, f)| piece.measured.iter().zip(f).map(|(y, f)| y - f).collect())
            .collect();
        let squares: f64 = left.iter().flatten().map(|r| r * r).sum();
        let drawing = |trace: usize| {
            let own = || data.pieces.iter().enumerate().filter(move |(_, p)| p.trace == trace);
            let pick = |of: &[Vec<f64>]| own().flat_map(|(k, _)| &of[k]).copied().collect();
            let times: Vec<Vec<f64>> = own().map(|(_, piece)| piece.recorded_time()).collect();
            let times: Vec<&[f64]> = times.iter().map(Vec::as_slice).collect();
            Drawing::of_lines(&times, vec![("foretold", pick(&predicted)), ("left", pick(&left))])
        };
        Some(Self {
            effect: effect.into(),
            law: form.applied.law.clone(),
            rms: (squares / data.samples() as f64).sqrt(),
            drawings: (0..data.labels.len()).map(drawing).collect(),
        })
    }

    /// Prediction and residual that are foretold, within a view; none where there is no such trace.
    #[must_use]
    pub fn json(&self, view: &View) -> Option<Value> {
        let mut found = self.drawings.get(view.trace)?.json(view);
        found["effect"] = self.effect.clone().into();
        found["law"] = self.law.clone().into();
        found["rms"] = self.rms.into();
        Some(found)
    }
}

/// Every candidate, the largest foretold gain first: what it is, what speaks for it, and a picture of what
/// it would leave of the trace where most is left.
#[must_use]
pub fn candidates(diagnosis: &Diagnosis, data: &Data, left: &Leftover, model: &Model) -> Value {
    let screen = &diagnosis.found.first;
    let mut ranked: Vec<(usize, f64)> = (0..diagnosis.candidates.len())
        .map(|index| (index, most_promising(screen, index).map_or(0.0, |found| found.gain)))
        .collect();
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
    let worst = worst_trace(&left.comparison);
    let list: Vec<Value> = ranked
        .iter()
        .enumerate()
        .map(|(place, &(index, gain))| {
            let name = &diagnosis.candidates[index].name;
            let drawn =
                (place < MAX_DRAWN && gain > 0.0).then(|| Forecast::new(diagnosis, data, name));
            let forecast = drawn.flatten();
            let mut found = described(name, model);
            found["gain_foretold"] = gain.into();
            found["chance"] = screen.chance[index].into();
            found["rms_foretold"] = json!(forecast.as_ref().map(|forecast| forecast.rms));
            found["law_foretold"] = json!(forecast.as_ref().map(|forecast| &forecast.law));
            found["picture"] = forecast
                .map_or(Value::Null, |forecast| forecast.drawings[worst].picture("left", COLUMNS));
            found["untestable"] = untestable(diagnosis, name);
            found
        })
        .collect();
    let now = Drawing::of_residuals(&left.residuals, worst).picture("residual", COLUMNS);
    json!({"trace": diagnosis.labels[worst], "now": now, "list": list})
}

/// What is known of an effect: of the library by its declaration, of one's own by what the model says.
fn described(name: &str, model: &Model) -> Value {
    match find(name) {
        Some(effect) => json!({
            "effect": name,
            "stage": effect.stage,
            "meaning": effect.meaning,
            "signature": effect.signature,
            "against": effect.against.symbol(),
            "confused_with": effect.confused_with,
            "experiment": effect.experiment,
            "laws": effect.laws.iter().map(|law| json!({"name": law.name, "formula": law.formula})).collect::<Vec<_>>(),
        }),
        None => {
            let own = model.candidates.iter().find(|own| own.name == name);
            json!({
                "effect": name,
                "stage": own.and_then(|own| own.stage),
                "meaning": own.and_then(|own| own.meaning.as_ref()),
                "expression": own.and_then(|own| own.expression.as_ref()),
                "laws": [],
            })
        }
    }
}

fn untestable(diagnosis: &Diagnosis, name: &str) -> Value {
    let own = diagnosis.untestable.iter().find(|(effect, _)| effect == name);
    own.map_or(Value::Null, |(_, reason)| reason.clone().into())
}

/// The trace of which most is left beyond the noise.
fn worst_trace(comparison: &Comparison) -> usize {
    let share = |trace: usize| -> f64 {
        let own = comparison.cells.iter().filter(|cell| cell.trace == trace);
        own.map(|cell| cell.share_of_excess).sum()
    };
    (0..comparison.labels.len()).max_by(|&a, &b| share(a).total_cmp(&share(b))).unwrap_or(0)
}
