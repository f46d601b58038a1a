//! Something that happened once: from an instant within a trace on, the zero or the gain of the signal is another.
//!
//! No effect of the library is bound to an instant, but several can imitate one: a zero of its own for each trace
//! takes half of a step within one. So a step at every instant of a grid is tried as a rival of them all, by its score
//! beside the model's own derivatives, as the screen tries the library.

use palpate_fit::problem::Problem;
use palpate_fit::whitening::Whitening;

use super::beside::{Own, Products};
use super::fitted::Fitted;
use super::tail::log_tail;

/// What is another after an incident.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// The zero of the signal.
    Zero,
    /// The gain of the signal, or the stiffness of the specimen.
    Gain,
}

/// A change at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Incident {
    /// What changes.
    pub change: Change,
    /// The trace.
    pub trace: usize,
    /// The instant, in the time of that trace, s.
    pub time_s: f64,
    /// Whether it lasts to the end of the set; else to that of its trace.
    pub lasts: bool,
    /// The change: of the zero in the unit of the signal, of the gain as a part of it.
    pub size: f64,
    /// Fall of the sum of squares of the whitened residual.
    pub gain: f64,
    /// Logarithm of the chance of as large a fall under noise alone, at any instant.
    pub log_chance: f64,
}

/// Instants that are tried in a stretch.
const INSTANTS: usize = 64;
/// Part of the samples of a stretch that must lie on either side of the instant: what begins with a trace is an
/// effect's.
const ASIDE: f64 = 0.05;

impl Incident {
    /// Numbers that describe one: what, when, and how much.
    pub const NUMBERS: usize = 3;

    /// The change at one instant that describes what a model leaves best; none where none is possible.
    #[must_use]
    pub fn of(problem: &Problem, fitted: &Fitted, whitening: &Whitening) -> Option<Self> {
        let problem = problem.with_chain(&fitted.chain);
        let mut own = Own::new(fitted.point.len(), problem.data().labels.len(), whitening);
        let mut trials: Vec<Trial> = Vec::new();
        problem.derivatives(&fitted.point, |piece, mut residual, columns| {
            let predicted: Vec<f64> =
                residual.iter().zip(piece.measured).map(|(r, y)| r + y).collect();
            residual.iter_mut().for_each(|r| *r = -*r);
            let stretch = own.add(piece.trace, residual, columns);
            let (time, instants) = (piece.recorded_time(), instants(&piece.motion.displacement));
            for (change, shape) in
                [(Change::Zero, vec![1.0; predicted.len()]), (Change::Gain, predicted)]
            {
                let whole = stretch.products(shape.clone());
                let goes_on =
                    |it: &&mut Trial| it.change == change && (it.lasts || it.trace == piece.trace);
                trials.iter_mut().filter(goes_on).for_each(|it| it.products.add(&whole));
                for &instant in &instants {
                    let mut after = shape.clone();
                    after[..instant].fill(0.0);
                    let products = stretch.products(after);
                    trials.extend([false, true].map(|lasts| Trial {
                        change,
                        trace: piece.trace,
                        time_s: time[instant],
                        lasts,
                        products: products.clone(),
                    }));
                }
            }
        });
        let tried = trials.len() as f64;
        let beside = own.solved()?;
        let judged = trials.iter().filter_map(|trial| {
            let (size, gain) = beside.judge(&trial.products)?;
            Some((trial, size, gain))
        });
        let (trial, size, gain) = judged.max_by(|a, b| a.2.total_cmp(&b.2))?;
        let log_chance = (log_tail(gain, 1, false) + tried.ln()).min(0.0);
        let Trial { change, trace, time_s, lasts, .. } = *trial;
        Some(Self { change, trace, time_s, lasts, size, gain, log_chance })
    }
}

/// A change that is tried.
struct Trial {
    change: Change,
    trace: usize,
    time_s: f64,
    lasts: bool,
    products: Products,
}

/// The samples of a stretch at which something could happen: after its first touch, away from its ends.
fn instants(x: &[f64]) -> Vec<usize> {
    let aside = ((ASIDE * x.len() as f64) as usize).max(1);
    let touch = x.iter().position(|&x| x > 0.0).unwrap_or(x.len());
    (touch.max(aside)..x.len().saturating_sub(aside))
        .step_by(x.len().div_ceil(INSTANTS).max(1))
        .collect()
}
