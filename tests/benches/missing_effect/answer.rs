//! What the library says of a data set, as the score takes it.

use palpate::criticism::diagnose::diagnose;
use palpate::criticism::search;
use palpate::fit::data::Data;
use palpate::fit::whole_motion::fit;
use palpate::model::{BaseLaw, Model, Separation};
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
    /// Error on traces left out, after it was added, in the unit of the signal.
    pub heldout_rms_after: f64,
}

/// Fits the base and asks what it lacks.
pub fn answer(set: &DataSet) -> Result<Answer, String> {
    let signal = set.truth.signal;
    let data = Data::of(&set.traces, signal).map_err(|error| error.to_string())?;
    let law = BaseLaw::fung(2, Separation::Clamp);
    let base = fit(law, &data).map_err(|error| error.to_string())?;
    let model = Model::of(&law, signal, &base.values, &base.standard_errors);
    let diagnosis = diagnose(&model, &set.traces).map_err(|error| error.to_string())?;
    let step = |(index, step): (usize, &search::Step)| Step {
        effect: step.effect.clone(),
        credible_set: step.credible.clone(),
        ranking: step.rivals.iter().map(|rival| rival.effect.clone()).collect(),
        heldout_rms_after: diagnosis.held_out[index + 1]
            .as_ref()
            .map_or(f64::NAN, |held_out| held_out.rms),
    };
    Ok(Answer {
        verdict: diagnosis.verdict.word().into(),
        steps: diagnosis.found.steps.iter().enumerate().map(step).collect(),
        noise_rms: diagnosis.noise.whitening.standard_deviation(),
    })
}
