//! What the library says of a data set, as the score takes it.

use palpate::criticism::diagnose::{Diagnosis, diagnose};
use palpate::criticism::fitted::Fitted;
use palpate::criticism::search;
use palpate::fit::data::Data;
use palpate::fit::whole_motion::{fit, predict};
use palpate::model::{BaseLaw, Model, Separation};
use palpate::trace::Trace;
use palpate_tests::hidden::DataSet;

/// A diagnosis.
#[derive(Clone, Debug)]
pub struct Answer {
    /// adequate, named, ambiguous or unknown.
    pub verdict: String,
    /// Effects in the order in which they were added.
    pub steps: Vec<Step>,
    /// The noise that the library found, in the unit of the signal.
    pub noise_rms: f64,
}

/// One effect that was added.
#[derive(Clone, Debug)]
pub struct Step {
    /// Its name.
    pub effect: String,
    /// Effects that the data do not tell apart, this one included.
    pub credible_set: Vec<String>,
    /// All candidates, the best first.
    pub ranking: Vec<String>,
    /// Error on traces left out, before and after it was added, in the unit of the signal.
    pub heldout_rms: [f64; 2],
    /// Error on fresh traces of the same specimen without noise, with nothing refitted; not a number
    /// where there are none.
    pub fresh_rms: [f64; 2],
}

impl Step {
    /// Whether the answer's own held-out error falls.
    pub fn lowers_held_out(&self) -> bool {
        self.heldout_rms[1] < self.heldout_rms[0]
    }

    /// Whether the error on fresh traces falls.
    pub fn lowers_fresh(&self) -> bool {
        self.fresh_rms[1] < self.fresh_rms[0]
    }
}

/// Fits the base and asks what it lacks; what each step is worth is tried on fresh traces.
pub fn answer(set: &DataSet, fresh: &[Trace]) -> Result<Answer, String> {
    let signal = set.truth.signal;
    let data = Data::of(&set.traces, signal).map_err(|error| error.to_string())?;
    let law = BaseLaw::fung(2, Separation::Clamp);
    let base = fit(law, &data).map_err(|error| error.to_string())?;
    let model = Model::of(&law, signal, &base.values, &base.standard_errors);
    let diagnosis = diagnose(&model, &set.traces).map_err(|error| error.to_string())?;
    let held_out = |index: usize| match &diagnosis.held_out[index] {
        Some(held_out) => held_out.rms,
        None => f64::NAN,
    };
    let on_fresh = errors_on(fresh, &diagnosis, &data)?;
    let step = |(index, step): (usize, &search::Step)| Step {
        effect: step.effect.clone(),
        credible_set: step.credible.clone(),
        ranking: step.rivals.iter().map(|rival| rival.effect.clone()).collect(),
        heldout_rms: [held_out(index), held_out(index + 1)],
        fresh_rms: [on_fresh[index], on_fresh[index + 1]],
    };
    Ok(Answer {
        verdict: diagnosis.verdict.word().into(),
        steps: diagnosis.found.steps.iter().enumerate().map(step).collect(),
        noise_rms: diagnosis.noise.whitening.standard_deviation(),
    })
}

/// Root mean square errors of the model before any step and after each on fresh traces. What a model
/// has of its own for each trace, such as a zero, counts as none: fresh traces have none.
fn errors_on(fresh: &[Trace], diagnosis: &Diagnosis, data: &Data) -> Result<Vec<f64>, String> {
    let found = &diagnosis.found;
    let models = std::iter::once(&found.base).chain(&found.models);
    if fresh.is_empty() {
        return Ok(models.map(|_| f64::NAN).collect());
    }
    let fresh = Data::of(fresh, &data.signal).map_err(|error| error.to_string())?;
    let fresh = fresh.with_reference(data.reference_temperature);
    let error = |model: &Fitted| {
        let mut values = model.values.clone();
        for own in (0..data.labels.len()).flat_map(|trace| model.chain.own_of_trace(trace)) {
            values[own] = 0.0;
        }
        let predicted = predict(&model.chain, &values, &fresh);
        let pairs = fresh.pieces.iter().zip(&predicted);
        let squares = pairs.flat_map(|(piece, predicted)| {
            piece.measured.iter().zip(predicted).map(|(y, f)| (y - f).powi(2))
        });
        (squares.sum::<f64>() / fresh.samples() as f64).sqrt()
    };
    Ok(models.map(error).collect())
}
