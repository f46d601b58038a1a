//! Modulus, contact point, relaxation and adhesion of a force curve, told apart by least squares.
//!
//! F = b0 + b1 z + d s + f, with f the force of the hereditary contact ([`Contact`]) in series with the cantilever, and d the
//! drag of the medium on the cantilever, s = 1 on the way in, −1 on the way back, 0 at rest. How many exponentials the
//! relaxation has, and whether there is a pull of adhesion, is told by Bayes' criterion. It counts as many samples as the
//! residual has independent ones; so do the standard errors.

use nalgebra::{DMatrix, DVector};

use super::hereditary::Contact;
use super::law::Law;
use crate::Tip;
use palpate_fit::by_differences::{Fitted, least_squares};
use palpate_fit::least_squares::Effort;
use palpate_model::Relaxation;

/// A curve in numbers about one: ways over the whole way, forces over the whole range of force.
pub(super) struct Samples {
    /// Time, s.
    pub(super) time: Vec<f64>,
    /// Way of the piezo over `way`.
    pub(super) z: Vec<f64>,
    /// Force over `range`.
    pub(super) force: Vec<f64>,
    /// The way the piezo goes: 1 in, −1 back, 0 at rest.
    pub(super) sense: Vec<f64>,
    /// Whether a sample counts.
    pub(super) counts: Vec<bool>,
    /// First sample of the retreat; their number where there is none.
    pub(super) leaves: usize,
    /// Whether the contact of the retreat counts, or only its baseline.
    pub(super) follows_back: bool,
    /// Whole way, m, and range of force, N.
    pub(super) way: f64,
    pub(super) range: f64,
    /// Tip and spring constant, N/m.
    pub(super) tip: Tip,
    pub(super) spring: Option<f64>,
}

/// Where the search begins, in those numbers; the modulus in Pa.
pub(super) struct Start {
    pub(super) offset: f64,
    pub(super) tilt: f64,
    pub(super) contact: f64,
    pub(super) reduced_modulus: f64,
    /// Whether a drag is fitted.
    pub(super) drag: bool,
    /// Most exponentials.
    pub(super) terms: usize,
}

/// Which parameters there are. Their order: offset, tilt, contact, ln of the modulus over that of the start, drag, pull, and for
/// each exponential its share of what the ones before leave, and the logarithm of its rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Model {
    drag: bool,
    pull: bool,
    terms: usize,
}

impl Model {
    fn pull_at(self) -> usize {
        4 + usize::from(self.drag)
    }

    fn terms_at(self) -> usize {
        self.pull_at() + usize::from(self.pull)
    }
}

/// A fit of one model.
pub(super) struct Found {
    pub(super) model: Model,
    fitted: Fitted,
    reduced_modulus: f64,
    residuals: Vec<f64>,
    /// The fit with one exponential more, which was not evident.
    next: Option<Box<Found>>,
}

/// Place of a parameter that every model has.
pub(super) const OFFSET: usize = 0;
pub(super) const TILT: usize = 1;
pub(super) const CONTACT: usize = 2;
const MODULUS: usize = 3;
const DRAG: usize = 4;

/// A pull is taken where it lowers the criterion by this.
const EVIDENT: f64 = 10.0;
/// An exponential more is taken where it raises twice the logarithm of the likelihood by this: about 1 % of curves without it
/// do so by chance. A criterion that spares parameters would leave out what bends the modulus by more than its error.
const LIKELIER: f64 = 10.0;
/// Samples from which on the search for rates averages blocks.
const FEW: usize = 400;
/// Share with which a new exponential begins.
const NEW: f64 = 0.15;
/// Places, in parts of the logarithm from the slowest to the fastest rate, where a new exponential begins.
const PLACES: [f64; 3] = [0.2, 0.5, 0.8];
/// Samples by which the contact point is moved to look for a better fit.
const SHIFTS: [f64; 6] = [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0];
/// Standard error of the logarithm of a modulus that is not told.
const UNTOLD: f64 = 1.0;
/// Largest share of what is left.
const MAX_SHARE: f64 = 0.999;

impl Found {
    pub(super) fn point(&self) -> &[f64] {
        &self.fitted.solution.point
    }

    /// The contact law with the modulus at once.
    pub(super) fn law(&self, samples: &Samples) -> Law {
        samples.law(self.model, self.point(), self.reduced_modulus)
    }

    pub(super) fn relaxation(&self) -> Relaxation {
        relaxation(self.model, self.point())
    }

    pub(super) fn drag(&self) -> f64 {
        if self.model.drag { self.point()[DRAG] } else { 0.0 }
    }

    /// Standard error of a parameter.
    pub(super) fn error(&self, place: usize) -> f64 {
        self.inflation().sqrt() * self.fitted.standard_errors[place]
    }

    /// Relative standard error of the modulus at once.
    pub(super) fn modulus_error(&self) -> f64 {
        self.averaged(|found| (found.law_modulus().ln(), found.error(MODULUS)))
    }

    fn law_modulus(&self) -> f64 {
        self.reduced_modulus * self.point()[MODULUS].exp()
    }

    /// Standard error of a quantity whose value and error each model tells. A number of exponentials is not what a specimen
    /// has: the next one weighs in with its likelihood (Akaike's weight; Buckland and others 1997).
    fn averaged(&self, of: impl Fn(&Self) -> (f64, f64)) -> f64 {
        let (value, error) = of(self);
        let Some(next) = self.next.as_ref() else { return error };
        let (other, _) = of(next);
        let odds = (0.5 * next.likelier(self) - 2.0).exp();
        let weight = odds / (1.0 + odds);
        (error.powi(2) + weight * (other - value).powi(2)).sqrt()
    }

    /// The pull with its standard error, over the range. On a specimen that hardly gives in it only moves the jump, which lies
    /// between two samples.
    pub(super) fn pull(&self, samples: &Samples) -> Option<(f64, f64)> {
        let place = self.model.pull_at();
        let between = samples.spring.map_or(f64::INFINITY, |k| {
            let to_force = k * samples.way / samples.range;
            let contact = self.point()[CONTACT];
            (samples.step(contact) / 12f64.sqrt()).hypot(self.error(CONTACT)) * to_force
        });
        self.model.pull.then(|| (self.point()[place], self.error(place).min(between)))
    }

    /// Share c0 that never relaxes, and the relative standard error of the modulus times c0.
    pub(super) fn equilibrium(&self) -> (f64, f64) {
        let error = self.averaged(|found| {
            let (share, error) = found.own_equilibrium();
            ((found.law_modulus() * share).ln(), error)
        });
        (self.own_equilibrium().0, error)
    }

    fn own_equilibrium(&self) -> (f64, f64) {
        let first = self.model.terms_at();
        let mut slope = vec![0.0; self.point().len()];
        slope[MODULUS] = 1.0;
        let mut share = 1.0;
        for k in 0..self.model.terms {
            let left = 1.0 - self.point()[first + 2 * k];
            slope[first + 2 * k] = -1.0 / left;
            share *= left;
        }
        (share, self.error_along(slope))
    }

    /// Standard error of a quantity with this slope.
    fn error_along(&self, slope: Vec<f64>) -> f64 {
        let slope = DVector::from(slope);
        let variance = |c: &DMatrix<f64>| slope.dot(&(c * &slope));
        let variance = self.fitted.covariance.as_ref().map_or(f64::INFINITY, variance);
        (self.inflation() * variance).sqrt()
    }

    /// Shares and rates with their standard errors, the fastest first.
    pub(super) fn terms(&self) -> Vec<[(f64, f64); 2]> {
        let first = self.model.terms_at();
        let shares = relaxation(self.model, self.point()).branches;
        let count = self.point().len();
        let mut found: Vec<[(f64, f64); 2]> = (0..self.model.terms)
            .map(|k| {
                // c_k = s_k Π (1 − s_j), j < k.
                let mut slope = vec![0.0; count];
                slope[first + 2 * k] = shares[k].share / self.point()[first + 2 * k].max(1e-12);
                for j in 0..k {
                    slope[first + 2 * j] = -shares[k].share / (1.0 - self.point()[first + 2 * j]);
                }
                let rate = shares[k].rate;
                [
                    (shares[k].share, self.error_along(slope)),
                    (rate, rate * self.error(first + 2 * k + 1)),
                ]
            })
            .collect();
        found.sort_by(|a, b| b[1].0.total_cmp(&a[1].0));
        found
    }

    /// Root mean square of the residual per degree of freedom, over the range.
    pub(super) fn rms(&self) -> f64 {
        self.fitted.rms
    }

    /// Samples that carry as much as one independent one: 1 + 2 Σ of the correlations of the residual (Bartlett's weights).
    fn inflation(&self) -> f64 {
        let r = &self.residuals;
        let square: f64 = r.iter().map(|r| r * r).sum();
        let lags = (2.0 * (r.len() as f64).cbrt()) as usize;
        let sum: f64 = (1..=lags.min(r.len().saturating_sub(1)))
            .map(|lag| {
                let product: f64 = r.iter().zip(&r[lag..]).map(|(a, b)| a * b).sum();
                (1.0 - lag as f64 / (lags + 1) as f64) * product / square.max(f64::MIN_POSITIVE)
            })
            .sum();
        (1.0 + 2.0 * sum).max(1.0)
    }

    /// Independent samples.
    fn samples(&self) -> f64 {
        self.residuals.len() as f64 / self.inflation()
    }

    fn cost(&self) -> f64 {
        self.fitted.solution.normal.cost.max(f64::MIN_POSITIVE)
    }

    /// Twice the logarithm of the likelihood over that of another model, in the independent samples of this one.
    fn likelier(&self, other: &Self) -> f64 {
        self.samples() * (other.cost() / self.cost()).ln()
    }

    /// By how much Bayes' criterion is below that of a simpler model.
    fn evidence(&self, simpler: &Self) -> f64 {
        let more = self.point().len() as f64 - simpler.point().len() as f64;
        self.likelier(simpler) - more * self.samples().ln()
    }
}

fn relaxation(model: Model, point: &[f64]) -> Relaxation {
    let mut left = 1.0;
    let (mut shares, mut rates) = (Vec::new(), Vec::new());
    for pair in point[model.terms_at()..].chunks_exact(2) {
        shares.push(left * pair[0]);
        rates.push(pair[1].exp());
        left *= 1.0 - pair[0];
    }
    Relaxation::new(&shares, &rates)
}

impl Samples {
    fn law(&self, model: Model, point: &[f64], reduced_modulus: f64) -> Law {
        let pull = if model.pull { point[model.pull_at()] } else { 0.0 };
        Law {
            tip: self.tip,
            reduced_modulus: reduced_modulus * point[MODULUS].exp(),
            adhesion_n: pull * self.range,
        }
    }

    /// Force of the contact at every sample, over the range.
    pub(super) fn contact(&self, law: Law, relaxation: &Relaxation, contact: f64) -> Vec<f64> {
        let mut follow = Contact::new(law, relaxation, self.spring);
        let end = if self.follows_back { self.z.len() } else { self.leaves };
        let mut forces = vec![0.0; self.z.len()];
        for (k, force) in forces.iter_mut().enumerate().take(end) {
            let z = (self.z[k] - contact) * self.way;
            *force = follow.follow(self.time[k], z, k >= self.leaves) / self.range;
        }
        forces
    }

    /// Predicted less measured, at the samples that count.
    fn residuals(&self, model: Model, point: &[f64], reduced_modulus: f64) -> Vec<f64> {
        let law = self.law(model, point, reduced_modulus);
        let contact = self.contact(law, &relaxation(model, point), point[CONTACT]);
        let drag = if model.drag { point[DRAG] } else { 0.0 };
        (0..self.z.len())
            .filter(|&k| self.counts[k])
            .map(|k| {
                let baseline = point[OFFSET] + point[TILT] * self.z[k] + drag * self.sense[k];
                baseline + contact[k] - self.force[k]
            })
            .collect()
    }

    /// Slowest and fastest rate that the contact can show, 1/s.
    fn rates(&self, start: &Start) -> (f64, f64) {
        let end = if self.follows_back { self.z.len() } else { self.leaves };
        let touched = (0..end).find(|&k| self.z[k] > start.contact).unwrap_or(0);
        let lasts = (self.time[end - 1] - self.time[touched]).max(f64::MIN_POSITIVE);
        let interval = lasts / (end - touched).max(2) as f64;
        (0.1 / lasts, 0.5 / interval)
    }

    /// Means of blocks of samples that go the same way, so that so many are left or few more.
    pub(super) fn thinned(&self, left: usize) -> Self {
        let size = self.z.len().div_ceil(left);
        let mut thin = Self {
            time: Vec::new(),
            z: Vec::new(),
            force: Vec::new(),
            sense: Vec::new(),
            counts: Vec::new(),
            leaves: 0,
            ..*self
        };
        let mut begin = 0;
        while begin < self.z.len() {
            let limit = (begin + size.max(1)).min(self.z.len());
            let alike = |k: &usize| {
                self.sense[*k] == self.sense[begin] && self.counts[*k] == self.counts[begin]
            };
            let end = (begin..limit).find(|k| !alike(k)).unwrap_or(limit);
            let mean =
                |values: &[f64]| values[begin..end].iter().sum::<f64>() / (end - begin) as f64;
            thin.leaves += usize::from(begin < self.leaves);
            thin.time.push(mean(&self.time));
            thin.z.push(mean(&self.z));
            thin.force.push(mean(&self.force));
            thin.sense.push(self.sense[begin]);
            thin.counts.push(self.counts[begin]);
            begin = end;
        }
        thin
    }

    fn fitted(&self, start: &Start, model: Model, point: &[f64], effort: Effort) -> Found {
        let rates = self.rates(start);
        let mut bounds = vec![(-1e12, 1e12), (-1e6, 1e6), (-0.5, 1.0), (-14.0, 14.0)];
        if model.drag {
            bounds.push((-10.0, 10.0));
        }
        if model.pull {
            bounds.push((0.0, 2.0));
        }
        for _ in 0..model.terms {
            bounds.extend([(0.0, MAX_SHARE), (rates.0.ln(), rates.1.ln())]);
        }
        let residuals = |point: &[f64]| self.residuals(model, point, start.reduced_modulus);
        let count = self.counts.iter().filter(|counts| **counts).count();
        let fitted = least_squares(&bounds, point, count, effort, residuals);
        let residuals = residuals(&fitted.solution.point);
        // On a specimen that hardly gives in the modulus may be anything, and depends on nothing else.
        let fitted = match fitted.standard_errors[MODULUS] > UNTOLD {
            true => fitted.holding(MODULUS),
            false => fitted,
        };
        Found { model, fitted, reduced_modulus: start.reduced_modulus, residuals, next: None }
    }

    /// The model without relaxation and adhesion.
    pub(super) fn simplest(&self, start: &Start) -> Found {
        let model = Model { drag: start.drag, pull: false, terms: 0 };
        let mut point = vec![start.offset, start.tilt, start.contact, 0.0];
        if model.drag {
            point.push(0.0);
        }
        self.fitted(start, model, &point, Effort::LONG)
    }

    /// The model that the curve asks for: exponentials are added while they are evident, with and without a pull.
    pub(super) fn identify(&self, start: &Start) -> Found {
        let thin = (self.z.len() > 2 * FEW).then(|| self.thinned(FEW));
        let thin = thin.as_ref().unwrap_or(self);
        let plain = self.simplest(start);
        let mut best = self.with_pull(start, plain);
        let mut next = None;
        // One more than may be is tried as well, to see what it would change.
        while best.model.terms <= start.terms && start.terms > 0 {
            let more = self.with_pull(start, self.with_term(start, thin, &best, false));
            // The term may have taken over what the pull was thought to do, or may need it.
            let more = if best.model.pull && !more.model.pull {
                let other = self.with_term(start, thin, &best, true);
                if other.evidence(&more) > EVIDENT { other } else { more }
            } else {
                more
            };
            if best.model.terms == start.terms || more.likelier(&best) <= LIKELIER {
                // Whether there is a memory at all is a question of its own.
                next = (best.model.terms > 0).then(|| Box::new(more));
                break;
            }
            best = more;
        }
        let best = self.shifted(start, best);
        let best = self.fitted(start, best.model, best.point(), Effort::FULL);
        Found { next, ..best }
    }

    /// Way from sample to sample where the contact begins.
    fn step(&self, contact: f64) -> f64 {
        let touch = (1..self.leaves).find(|&k| self.z[k] >= contact).unwrap_or(1);
        (self.z[touch] - self.z[touch - 1]).abs()
    }

    /// The best of fits that begin some samples to either side: with a jump into contact the squares have a minimum between
    /// any two samples.
    fn shifted(&self, start: &Start, found: Found) -> Found {
        if !found.model.pull {
            return found;
        }
        let step = self.step(found.point()[CONTACT]);
        let others = SHIFTS.map(|samples| {
            let mut point = found.point().to_vec();
            point[CONTACT] += samples * step;
            self.fitted(start, found.model, &point, Effort::QUICK)
        });
        others.into_iter().fold(found, |a, b| if b.cost() < a.cost() { b } else { a })
    }

    /// The fit with a pull added, where that is evident.
    fn with_pull(&self, start: &Start, without: Found) -> Found {
        if without.model.pull {
            return without;
        }
        let model = Model { pull: true, ..without.model };
        let lowest = (0..self.leaves)
            .filter(|&k| self.counts[k])
            .map(|k| self.force[k] - without.point()[OFFSET] - without.point()[TILT] * self.z[k])
            .fold(0.0, f64::min);
        let mut point = without.point().to_vec();
        point.insert(model.pull_at(), -lowest);
        let with = self.shifted(start, self.fitted(start, model, &point, Effort::LONG));
        if with.evidence(&without) > EVIDENT { with } else { without }
    }

    /// The fit with one exponential more, with or without the pull; its rate is looked for in a thinned curve.
    fn with_term(&self, start: &Start, thin: &Self, before: &Found, pull: bool) -> Found {
        let model = Model { drag: start.drag, pull, terms: before.model.terms + 1 };
        let (slow, fast) = self.rates(start);
        let mut base = before.point().to_vec();
        if before.model.pull && !pull {
            base.remove(before.model.pull_at());
        }
        let starts = PLACES.map(|place| {
            let mut point = base.clone();
            // As stiff as before in the middle of the contact.
            point[MODULUS] -= (1.0 - NEW).ln();
            point.extend([NEW, slow.ln() + place * (fast / slow).ln()]);
            thin.fitted(start, model, &point, Effort::QUICK)
        });
        let [first, rest @ ..] = starts;
        let quick = rest.into_iter().fold(first, |a, b| if b.cost() < a.cost() { b } else { a });
        self.fitted(start, model, quick.point(), Effort::LONG)
    }
}
