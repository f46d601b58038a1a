//! Relaxation of a hold: eq. 3.4 on the force, and the latency model on the strain of the contact.
//!
//! The latency model speaks of strain: dε/dt = −ν sgn(ε − εe) |ε − εe|^n (eqs 4.9, 7.2), with the closed forms (7.4), (7.5).
//! The strain of a contact under a force is taken from the law of the approach, as the depth that bears the force; so that
//! ν has the unit 1/s whatever n, it is counted in depths of the start of the hold: ε = δ(F)/δ(F at the start).

use std::ops::Range;

use super::Estimate;
use super::curve::ForceCurve;
use super::fit::CurveFit;

use palpate_fit::exponentials::{Fit, Options, Prepared};
use palpate_fit::power_law;
use palpate_model::latency::Power;

/// What a hold says.
#[derive(Clone, Debug)]
pub struct Relaxed {
    /// How long it lasted, s.
    pub duration_s: f64,
    /// The force by eq. 3.4 with two exponentials.
    pub exponentials: Fit,
    /// The strain by the linear latency model, n = 1.
    pub linear: Latency,
    /// The strain by the latency model of the order that fits best; of equals the lowest.
    pub power: Latency,
    /// Time since the hold began, s, and strain: what the models were fitted to.
    pub strain: Vec<(f64, f64)>,
}

/// The latency model fitted to a hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Latency {
    /// Order n.
    pub order: u32,
    /// Strain at the start ε0.
    pub start: Estimate,
    /// Equilibrium strain εe.
    pub equilibrium: Estimate,
    /// Rate ν, 1/s.
    pub rate: Estimate,
    /// Root mean square of what is left, strain.
    pub rms: f64,
    /// Bayesian criterion; the lower the better.
    pub criterion: f64,
}

impl Latency {
    /// Strain at a time since the hold began, s.
    #[must_use]
    pub fn at(&self, time: f64) -> f64 {
        let (initial, equilibrium) = (self.start.value, self.equilibrium.value);
        let order = f64::from(self.order);
        Power { rate: self.rate.value, order, equilibrium, initial }.strain(time)
    }
}

/// Highest order that is tried.
const HIGHEST: u32 = 8;
/// A higher order must lower the criterion by this.
const BETTER: f64 = 2.0;
/// Fewest samples.
const MIN_SAMPLES: usize = 20;

/// Fits a hold; the words say why it cannot be.
pub(super) fn relaxed(
    curve: &ForceCurve,
    range: Range<usize>,
    fit: &CurveFit,
) -> Result<Relaxed, String> {
    if range.len() < MIN_SAMPLES {
        return Err(format!("the hold has {} samples; {MIN_SAMPLES} are needed", range.len()));
    }
    let since = curve.time_s[range.start];
    let time: Vec<f64> = curve.time_s[range.clone()].iter().map(|t| t - since).collect();
    let force: Vec<f64> = range.map(|i| curve.force_n[i] - fit.baseline_n[i]).collect();
    let tenth = (force.len() / 10).max(2);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let fall = mean(&force[..tenth]) - mean(&force[force.len() - tenth..]);
    let seen = 3.0 * fit.noise_n / (tenth as f64).sqrt();
    if fall.abs() <= seen {
        return Err("the force does not change beyond the noise".into());
    }
    let prepared = Prepared::new(&time, &Options::default()).map_err(|error| error.to_string())?;
    let exponentials = prepared.fit(&force).map_err(|error| error.to_string())?;
    // F ∝ δ^m with the pull of adhesion on top; forces below it are no contact.
    let depth =
        |force: f64| (force + fit.law.adhesion_n).max(0.0).powf(1.0 / fit.law.tip.exponent());
    let whole = depth(exponentials.sum.at(0.0));
    if whole <= 0.0 {
        return Err("the hold begins without force".into());
    }
    let strains: Vec<f64> = force.iter().map(|force| depth(*force) / whole).collect();
    let latencies: Vec<Latency> =
        (1..=HIGHEST).map(|order| latency(&time, &strains, order)).collect();
    let lowest = latencies.iter().map(|l| l.criterion).fold(f64::INFINITY, f64::min);
    let power = latencies.iter().find(|latency| latency.criterion <= lowest + BETTER);
    let power = *power.unwrap_or(&latencies[0]);
    Ok(Relaxed {
        duration_s: time[time.len() - 1],
        exponentials,
        linear: latencies[0],
        power,
        strain: time.into_iter().zip(strains).collect(),
    })
}

/// The latency model of an order.
fn latency(time: &[f64], strains: &[f64], order: u32) -> Latency {
    let fit = power_law::fit(time, strains, Some(f64::from(order)));
    let estimate = |(value, error): (f64, Option<f64>)| Estimate {
        value,
        standard_error: error.unwrap_or(f64::NAN),
    };
    let count = time.len() as f64;
    // The fit tells the error of ln ν.
    let rate = (fit.rate.0, fit.rate.1.map(|error| fit.rate.0 * error));
    Latency {
        order,
        start: estimate(fit.initial),
        equilibrium: estimate(fit.equilibrium),
        rate: estimate(rate),
        rms: (fit.rss / count).sqrt(),
        criterion: count * (fit.rss.max(f64::MIN_POSITIVE) / count).ln(),
    }
}
