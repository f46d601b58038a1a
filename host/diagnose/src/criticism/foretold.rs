//! What a candidate would make of the prediction, before anything is refitted: the straight line that the
//! screen judges it by.

use super::fitted::Fitted;
use super::screen::{Direction, Screen};
use palpate_fit::data::Data;
use palpate_fit::least_squares::LeastSquares;
use palpate_fit::problem::Problem;
use palpate_fit::whitening::Whitening;
use palpate_model::effects::Form;

/// The law and shapes of a candidate for which the screen foretells most; none where it foretells nothing.
#[must_use]
pub fn most_promising(screen: &Screen, candidate: usize) -> Option<&Direction> {
    let own = screen.directions.iter().filter(|d| d.candidate == candidate && d.gain > 0.0);
    own.max_by(|a, b| a.gain.total_cmp(&b.gain))
}

/// Predicted signal of every stretch with one law of a candidate more and the model's own parameters moved
/// along, both as the screen foretells and both to first order.
#[must_use]
pub fn foretold(fitted: &Fitted, direction: &Direction, form: &Form, data: &Data) -> Vec<Vec<f64>> {
    let chain = fitted.chain.with(form.applied.clone());
    let white = Whitening::none();
    let problem = Problem::new(&chain, data, &white, None);
    // The screen takes the slope at the size that is typical of the effect; so does this.
    let most = direction.strengths.iter().fold(0.0, |most: f64, strength| most.max(strength.abs()));
    let part = if most > form.typical.abs() { form.typical.abs() / most } else { 1.0 };
    let at = |part: f64| -> Vec<f64> {
        let model = fitted.point.iter().zip(&direction.shift).map(|(x, step)| x + part * step);
        let strengths = direction.strengths.iter().map(|strength| part * strength);
        let point = model.chain(strengths).chain(direction.shapes.iter().copied());
        point.zip(problem.bounds()).map(|(x, (lower, upper))| x.clamp(*lower, *upper)).collect()
    };
    let (still, mut moved) = (problem.predict(&at(0.0)), problem.predict(&at(part)));
    for (moved, still) in moved.iter_mut().zip(&still) {
        for (moved, still) in moved.iter_mut().zip(still) {
            *moved = still + (*moved - still) / part;
        }
    }
    moved
}
