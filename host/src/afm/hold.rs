//! Relaxation of a hold: eq. 3.4 on the force, and the latency model on the strain of the contact.
//!
//! The latency model speaks of strain: dε/dt = −ν sgn(ε − εe) |ε − εe|^n (eqs 4.9, 7.2), with the closed forms (7.4), (7.5).
//! The strain of a contact under a force is taken from the law of the approach, as the depth that bears the force; so that
//! ν has the unit 1/s whatever n, it is counted in depths of the start of the hold: ε = δ(F)/δ(F at the start).

use std::ops::Range;

use shared::latency::Law;

use super::Estimate;
use super::curve::ForceCurve;
use super::fit::CurveFit;
use super::least::least_squares;
use crate::fit::exponentials::{Fit, Options, Prepared};

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
        strain(self.start.value, self.equilibrium.value, self.rate.value, self.order, time)
    }
}

/// Highest order that is tried.
const HIGHEST: u32 = 8;
/// A higher order must lower the criterion by this.
const BETTER: f64 = 2.0;
/// Fewest samples.
const LEAST: usize = 20;

fn strain(start: f64, equilibrium: f64, rate: f64, order: u32, time: f64) -> f64 {
    match Law::<f64>::new(rate, f64::from(order), time) {
        Ok(law) => equilibrium + law.step(start - equilibrium),
        Err(_) => start,
    }
}

/// Fits a hold; the words say why it cannot be.
pub(super) fn relaxed(
    curve: &ForceCurve,
    range: Range<usize>,
    fit: &CurveFit,
) -> Result<Relaxed, String> {
    if range.len() < LEAST {
        return Err(format!("the hold has {} samples; {LEAST} are needed", range.len()));
    }
    let since = curve.time_s[range.start];
    let time: Vec<f64> = curve.time_s[range.clone()].iter().map(|t| t - since).collect();
    let baseline =
        |i: usize| fit.offset_n + fit.tilt_n_per_m * (curve.piezo_m[i] - fit.contact_m.value);
    let force: Vec<f64> = range.map(|i| curve.force_n[i] - baseline(i)).collect();
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

/// The latency model of an order; coordinates are start, equilibrium and ln of the rate by its start.
fn latency(time: &[f64], strains: &[f64], order: u32) -> Latency {
    let end = strains[strains.len() - 1];
    let gap = (strains[0] - end).abs().max(1e-6);
    let rate = 3.0 / time[time.len() - 1] / gap.powi(order as i32 - 1);
    let residuals = |point: &[f64]| {
        let rate = rate * point[2].exp();
        let at = |t: f64| strain(point[0], point[1], rate, order, t);
        time.iter().zip(strains).map(|(t, measured)| at(*t) - measured).collect()
    };
    let bounds = [(0.0, 3.0), (-1.0, 3.0), (-20.0, 20.0)];
    let fitted = least_squares(&bounds, &[strains[0], end, 0.0], time.len(), residuals);
    let (point, errors) = (&fitted.solution.point, &fitted.standard_errors);
    let count = time.len() as f64;
    let cost = fitted.solution.normal.cost.max(f64::MIN_POSITIVE);
    let value = rate * point[2].exp();
    Latency {
        order,
        start: Estimate { value: point[0], standard_error: errors[0] },
        equilibrium: Estimate { value: point[1], standard_error: errors[1] },
        rate: Estimate { value, standard_error: value * errors[2] },
        rms: fitted.rms,
        criterion: count * (cost / count).ln(),
    }
}
