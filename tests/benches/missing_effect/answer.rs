//! What the library says of a data set, as the score takes it.

use palpate::fit::data::Data;
use palpate::fit::whole_motion::fit;
use palpate::model::{Fung, Separation};
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
///
/// TEMPORARY: the diagnosis is not there yet; until it is, every answer is "adequate".
pub fn answer(set: &DataSet) -> Result<Answer, String> {
    let data = Data::of(&set.traces, set.truth.signal).map_err(|error| error.to_string())?;
    let law = Fung { terms: 2, separation: Separation::Clamp };
    let base = fit(law, &data).map_err(|error| error.to_string())?;
    Ok(Answer { verdict: "adequate".into(), steps: Vec::new(), noise_rms: base.rms() })
}
