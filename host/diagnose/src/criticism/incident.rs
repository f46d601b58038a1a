//! Something that happened once: from an instant within a trace on, the zero or the gain of the signal is another.
//!
//! No effect of the library is bound to an instant, but several can imitate one: a zero of its own for each trace
//! takes half of a step within one. So a step at every instant of a grid is tried as a rival of them all, by its score
//! beside the model's own derivatives, as the screen tries the library.

use palpate_fit::data::Piece;
use palpate_fit::problem::Problem;

use super::beside::{Beside, Products, Stretch};
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
    pub fn of(problem: &Problem, fitted: &Fitted) -> Option<Self> {
        let problem = problem.with_chain(&fitted.chain);
        let mut stretches: Vec<Changed> = Vec::new();
        let beside = Beside::of(&problem, &fitted.point, |piece, stretch| {
            stretches.push(Changed::of(&problem, piece, stretch));
        })?;
        let mut trials = Vec::new();
        for (kind, change) in [Change::Zero, Change::Gain].into_iter().enumerate() {
            // What goes on in the stretches after: to the end of the trace, and of the set.
            let (mut in_trace, mut in_set): (Option<Products>, Option<Products>) = (None, None);
            let mut later = None;
            for Changed { trace, whole, after } in stretches.iter().rev() {
                let trace = *trace;
                if later.replace(trace) != Some(trace) {
                    in_trace = None;
                }
                for &(time_s, ref after) in after {
                    for (lasts, later) in [(false, &in_trace), (true, &in_set)] {
                        let products = after[kind].with(later.as_ref());
                        let (size, gain) = beside.judge(&products).unwrap_or_default();
                        let log_chance = 0.0;
                        trials.push(Self { change, trace, time_s, lasts, size, gain, log_chance });
                    }
                }
                in_trace = Some(whole[kind].with(in_trace.as_ref()));
                in_set = Some(whole[kind].with(in_set.as_ref()));
            }
        }
        let tried = trials.len() as f64;
        let mut best = trials.into_iter().max_by(|a, b| a.gain.total_cmp(&b.gain))?;
        best.log_chance = (log_tail(best.gain, 1, false) + tried.ln()).min(0.0);
        Some(best)
    }
}

/// What a change of the zero, and one of the gain, would do in one stretch.
struct Changed {
    trace: usize,
    /// Throughout.
    whole: [Products; 2],
    /// From an instant on, in the time of the trace, s.
    after: Vec<(f64, [Products; 2])>,
}

impl Changed {
    fn of(problem: &Problem, piece: &Piece, stretch: &Stretch) -> Self {
        let shapes = [vec![1.0; stretch.predicted.len()], stretch.predicted.clone()];
        let from = |instant: usize| {
            shapes.each_ref().map(|shape| {
                let mut after = shape.clone();
                after[..instant].fill(0.0);
                stretch.products(after)
            })
        };
        let time = piece.recorded_time();
        let instants = instants(problem, stretch.index, piece);
        Self {
            trace: piece.trace,
            whole: from(0),
            after: instants.into_iter().map(|instant| (time[instant], from(instant))).collect(),
        }
    }
}

/// The samples of a stretch at which something could happen: after its first touch, away from its ends.
fn instants(problem: &Problem, index: usize, piece: &Piece) -> Vec<usize> {
    let parts = problem.parts(index, INSTANTS);
    let aside = ((ASIDE * parts.len() as f64).ceil() as usize).max(1);
    let touch = problem.data().touch(piece).unwrap_or(piece.measured.len());
    let inner = parts.get(aside..(parts.len() + 1).saturating_sub(aside)).unwrap_or_default();
    inner.iter().map(|part| part.start).filter(|&instant| instant >= touch).collect()
}
