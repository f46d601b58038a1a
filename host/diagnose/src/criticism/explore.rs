//! The ladder of a diagnosis, and the model at its top.

use super::diagnose::Diagnosis;
use super::fitted::Fitted;
use palpate_fit::data::Data;
use palpate_model::effects::store;
use palpate_model::{FitRecord, Model, Rung, StoredEffect};

/// The rungs of a diagnosis: the model that was diagnosed, refitted, and one for each effect found.
#[must_use]
pub fn rungs(diagnosis: &Diagnosis) -> Vec<Rung> {
    let found = &diagnosis.found;
    let base = &found.base.chain;
    let own = base.effects.last().map_or(base.base.name(), |effect| &effect.name);
    let names = std::iter::once(own).chain(found.steps.iter().map(|step| step.effect.as_str()));
    let models = std::iter::once(&found.base).chain(&found.models);
    let held_out = diagnosis.held_out.iter().map(|held_out| held_out.as_ref().map(|h| h.rms));
    names
        .zip(models)
        .zip(held_out)
        .map(|((add, fitted), heldout_rms)| Rung {
            add: add.into(),
            fitted_rms: fitted.rms(),
            heldout_rms,
        })
        .collect()
}

/// The model with every effect that a diagnosis found. The rungs that `model` has already stay; its
/// last one gets the errors of the refit on these data. `unit` is that of the signal.
#[must_use]
pub fn explored(model: &Model, diagnosis: &Diagnosis, data: &Data, unit: &str) -> Model {
    let fitted = diagnosis.found.model();
    let (values, errors) = (&fitted.values, &diagnosis.standard_errors);
    let count = fitted.chain.base.count();
    let mut better =
        Model::of(&fitted.chain.base, &diagnosis.signal, &values[..count], &errors[..count]);
    better.name.clone_from(&model.name);
    better.reference_temperature = data.reference_temperature;
    better.effects = store(&fitted.chain, values, errors);
    for effect in &mut better.effects {
        effect.meaning = meaning(model, &effect.name);
    }
    let tried = |own: &&StoredEffect| better.effects.iter().all(|effect| effect.name != own.name);
    better.candidates = model.candidates.iter().filter(tried).cloned().collect();
    better.fit = Some(record(diagnosis, fitted, data, unit));
    better.ladder.clone_from(&model.ladder);
    better.ladder.pop();
    better.ladder.extend(rungs(diagnosis));
    better
}

/// What a law of the user's own means, as the model says it.
fn meaning(model: &Model, name: &str) -> Option<String> {
    let mut own = model.effects.iter().chain(&model.candidates);
    own.find(|effect| effect.name == name).and_then(|effect| effect.meaning.clone())
}

fn record(diagnosis: &Diagnosis, fitted: &Fitted, data: &Data, unit: &str) -> FitRecord {
    let noise = &diagnosis.noise;
    FitRecord {
        traces: data.labels.clone(),
        samples: fitted.rows(),
        unit: unit.into(),
        residual_rms: fitted.rms(),
        noise_rms: noise.is_known().then_some(noise.level),
        r_squared: 1.0 - fitted.rms().powi(2) / variance(data),
        largest_compression_mm: Some(data.largest_compression()),
        stop: format!(
            "least squares over whitened residuals; found by search, verdict {}",
            diagnosis.verdict.word()
        ),
    }
}

/// Mean square of the measured signal about its mean.
fn variance(data: &Data) -> f64 {
    let values = || data.pieces.iter().flat_map(|piece| piece.measured);
    let count = data.samples() as f64;
    let mean = values().sum::<f64>() / count;
    values().map(|value| (value - mean).powi(2)).sum::<f64>() / count
}
