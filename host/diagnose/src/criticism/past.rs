//! What the specimen remembers of before the recording: a trace that begins in the midst of a motion carries a force that decays,
//! and the law takes the specimen as having just arrived.

use palpate_fit::problem::Problem;
use palpate_fit::unknown_past::begun_in_motion;

use super::beside::sum_of_squares_falls;
use super::fitted::Fitted;
use super::tail::log_tail;

/// Decays at the beginning of each trace that begins in motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Past {
    /// The traces.
    pub traces: Vec<usize>,
    /// Rates of the decays, 1/s, of an amplitude of their own in each of the traces.
    pub rates: Vec<f64>,
    /// Fall of the sum of squares of the whitened residual.
    pub gain: f64,
    /// Logarithm of the chance of as large a fall under noise alone.
    pub log_chance: f64,
}

/// Factor between neighbouring rates that are tried.
const APART: f64 = 3.0;
/// Samples within the time constant of the fastest.
const SAMPLES: f64 = 4.0;
/// Most rates at once.
const MOST: usize = 3;

impl Past {
    /// The decays that describe what a model leaves best, by the information criterion; none where every trace begins at rest or off the
    /// specimen, or the model is as good without.
    #[must_use]
    pub fn of(samples: &Problem, fitted: &Fitted) -> Option<Self> {
        let problem = samples.with_chain(&fitted.chain);
        let data = problem.data();
        let begun = begun_in_motion(data);
        let count = begun.len();
        if count == 0 {
            return None;
        }
        let tried = rates(1.0 / data.longest(), 1.0 / (SAMPLES * data.shortest_interval()));
        // One column for each stretch that begins so and each rate.
        let decays = |index: usize, time: &[f64]| {
            let Some(own) = begun.iter().position(|it| *it == index) else { return Vec::new() };
            let decay = |v: &f64| time.iter().map(|t| (-v * (t - time[0])).exp()).collect();
            tried.iter().enumerate().map(|(k, v)| (k * count + own, decay(v))).collect()
        };
        let falls = sum_of_squares_falls(&problem, &fitted.point, count * tried.len(), decays)?;
        let gain = |chosen: &[usize]| {
            let columns = chosen.iter().flat_map(|rate| rate * count..(rate + 1) * count);
            falls.with(&columns.collect::<Vec<_>>())
        };
        let bic = |rates: usize, gain: f64| fitted.bic_with(rates * (count + 1), gain);
        let (mut chosen, mut best) = (Vec::new(), 0.0);
        while chosen.len() < MOST {
            let others = (0..tried.len()).filter(|rate| !chosen.contains(rate));
            let more = others.filter_map(|rate| {
                let with = [&chosen[..], &[rate]].concat();
                gain(&with).map(|gain| (gain, with))
            });
            let Some((found, with)) = more.max_by(|a, b| a.0.total_cmp(&b.0)) else { break };
            if bic(with.len(), found) >= bic(chosen.len(), best) {
                break;
            }
            (chosen, best) = (with, found);
        }
        if chosen.is_empty() {
            return None;
        }
        let log_chance = log_tail(best, chosen.len() * count, false);
        let log_chance = (log_chance + chosen.len() as f64 * (tried.len() as f64).ln()).min(0.0);
        let traces = begun.iter().map(|&index| data.pieces[index].trace).collect();
        let rates = chosen.iter().map(|&rate| tried[rate]).collect();
        Some(Self { traces, rates, gain: best, log_chance })
    }
}

/// Rates, 1/s, from the slowest to the fastest, evenly in their logarithm.
fn rates(slowest: f64, fastest: f64) -> Vec<f64> {
    let count = (fastest / slowest).max(1.0).log(APART).floor() as i32;
    (0..=count).map(|k| slowest * APART.powi(k)).collect()
}
