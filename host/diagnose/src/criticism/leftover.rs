//! What a model of a diagnosis leaves of the data that it was fitted to.

use super::compare::{Comparison, cells, trace_rms};
use super::dependence::dependences;
use super::diagnose::Diagnosis;
use super::fitted::Fitted;
use super::residuals::Residuals;
use palpate_fit::data::Data;

/// A model against a data set: the comparison, and what the model leaves at each sample.
#[derive(Clone, Debug)]
pub struct Leftover<'a> {
    /// Where the model is wrong.
    pub comparison: Comparison,
    /// By how much, at each sample.
    pub residuals: Residuals<'a>,
}

/// What one of a diagnosis' models leaves of its data. The shares are of what is left beyond the noise of the diagnosis.
#[must_use]
pub fn leftover<'a>(diagnosis: &Diagnosis, fitted: &Fitted, data: &'a Data) -> Leftover<'a> {
    let residuals = Residuals::new(&fitted.chain, &fitted.values, data);
    let cells = cells(data, &residuals, diagnosis.noise.level);
    let comparison = Comparison {
        labels: data.labels.clone(),
        signal: diagnosis.signal.clone(),
        noise: Some(diagnosis.noise.in_short()),
        // Whether it is more than noise is the diagnosis' to say.
        only_noise: false,
        rms: fitted.rms(),
        trace_rms: trace_rms(&cells, data.labels.len()),
        cells,
        dependences: dependences(&residuals),
        left_out: data.left_out.clone(),
    };
    Leftover { comparison, residuals }
}
