//! What a model of a diagnosis leaves of the data that it was fitted to.

use super::compare::{Comparison, cells_of};
use super::dependence::dependences;
use super::diagnose::Diagnosis;
use super::fitted::Fitted;
use super::residuals::Residuals;
use palpate_fit::data::Data;
use palpate_fit::problem::Problem;
use palpate_fit::whitening::Whitening;

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
    let white = Whitening::none();
    let problem = Problem::new(&fitted.chain, data, &white, None);
    let noise = diagnosis.noise.level;
    let point = problem.point(&fitted.values);
    let squares = problem.trace_squares(&point);
    let rms = |&(square, samples): &(f64, usize)| (square / (samples as f64).max(1.0)).sqrt();
    let residuals = Residuals::new(&fitted.chain, &fitted.values, data);
    let comparison = Comparison {
        labels: data.labels.clone(),
        signal: diagnosis.signal.clone(),
        noise: Some(diagnosis.noise.in_short()),
        // Whether it is more than noise is the diagnosis' to say.
        only_noise: false,
        rms: fitted.rms(),
        trace_rms: squares.iter().map(rms).collect(),
        cells: cells_of(&problem, &point, noise),
        dependences: dependences(&residuals),
        left_out: data.left_out.clone(),
    };
    Leftover { comparison, residuals }
}
