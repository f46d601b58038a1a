//! A fit that begins where the touch shows: with displacement in the coordinates of a rig, what the law does to describe the
//! traces without an offset is no start for one.

use rayon::prelude::*;

use super::fitted::Fitted;
use palpate_fit::data::Data;
use palpate_fit::least_squares::{Effort, LeastSquares, Solution, minimise_with};
use palpate_fit::problem::Problem;
use palpate_fit::touch::touched_at;
use palpate_model::effects::Candidate;
use palpate_model::{Coordinate, Separation};

/// The effect whose strength is where the touch shows, and its law.
const OFFSET: (&str, &str) = ("contact-offset", "reference");

/// The base law with an offset of the contact, fitted from where the touch shows, and which candidate that is; none where the touch
/// is near zero, the model has effects, or the offset is no candidate.
pub fn begun_at_touch(
    problem: &Problem,
    data: &Data,
    from: &Fitted,
    candidates: &[Candidate],
) -> Option<(usize, Fitted)> {
    let law = from.chain.base;
    if !from.chain.effects.is_empty() || law.separation == Separation::Bonded {
        return None;
    }
    let touch = touched_at(data)?;
    let candidate = candidates.iter().position(|candidate| candidate.name == OFFSET.0)?;
    let forms = &candidates[candidate].forms;
    let offset = forms.iter().map(|form| &form.applied).find(|applied| applied.law == OFFSET.1)?;
    let chain = from.chain.with(offset.clone());
    let problem = problem.with_chain(&chain);
    let largest = problem.coordinates().reference();
    let span = data.span();
    let rates = problem.coordinates().list().iter();
    let rates = rates.filter(|coordinate| matches!(coordinate, Coordinate::Rate(_))).count();
    // The law may have spent its rates on what the offset describes.
    let spread = |branch: usize| {
        let part = (branch as f64 - 0.5) / rates as f64;
        -(span.shortest.ln() + part * (span.longest / span.shortest).ln())
    };
    let start = |shape: f64, spreads: bool| -> Vec<f64> {
        // The same force at the largest compression.
        let ratio = law.elastic.unit(shape, largest) / law.elastic.unit(shape, largest - touch);
        let begin = |(coordinate, x): (&Coordinate, &f64)| match *coordinate {
            Coordinate::Force(_) | Coordinate::Total => ratio * x,
            Coordinate::Shape => shape,
            Coordinate::Rate(branch) if spreads => spread(branch),
            _ => *x,
        };
        let base = problem.coordinates().list().iter().zip(&from.point).map(begin);
        let point = base.chain([touch]).zip(problem.bounds());
        point.map(|(x, (lower, upper))| x.clamp(*lower, *upper)).collect()
    };
    let shapes = law.elastic.shapes(largest - touch);
    let starts = shapes.iter().flat_map(|&shape| [start(shape, false), start(shape, true)]);
    let starts: Vec<Vec<f64>> = starts.collect();
    // A few steps for all tell which is worth going on with.
    let trials = starts.par_iter().map(|start| minimise_with(&problem, start, Effort::TRIAL));
    let trials: Vec<Solution> = trials.filter(|trial| trial.normal.cost.is_finite()).collect();
    let best = trials.iter().min_by(|a, b| a.normal.cost.total_cmp(&b.normal.cost))?;
    let fitted = Fitted::new(&problem, &best.point, Effort::FULL);
    Some((candidate, fitted))
}
