//! Sums of decaying exponentials: F(t) = N (c0 + Σ c_i e^(−v_i t)), eqs 3.3–3.6, 6.2, appendix A.
//!
//! No starting values are asked for, and the minimum found is the global one within the limits of
//! the rates. [`Prepared::new`] computes once, for given times, what every fit on these times
//! needs; [`Prepared::for_one`] what a single one does; [`Prepared::fit`] then takes a few microseconds for each trace of one or two terms that
//! stand out of the noise, some 0.1 ms where they do not, and some milliseconds for three or four:
//!
//! 1. the trace is projected onto a few orthonormal vectors that span every exponential between
//!    the limits (`basis`), so that the rest works on some twenty numbers;
//! 2. all sets of rates of a coarse grid are scored (`grid`);
//! 3. every promising one is refined by variable projection (`point`, `refine`, `search`), with
//!    exponentials interpolated in ln v (`table`);
//! 4. covariance follows in the coordinates N, c_i, v_i (`covariance`).
//!
//! The sum of squares agrees with that of exact exponentials to 1e-6 of itself as long as the
//! residuals exceed a millionth of the signal; below that, interpolation limits it.
//!
//! Time counts from the first sample: N and c_i describe the signal there.

mod basis;
mod bound;
mod correlated;
mod covariance;
mod engine;
mod error;
mod family;
mod fit;
mod grid;
mod means;
mod nodes;
pub mod plan;
#[allow(clippy::needless_range_loop, reason = "indices as in the formulas")]
mod point;
mod profile;
#[allow(clippy::needless_range_loop, reason = "indices as in the formulas")]
mod refine;
mod search;
mod table;
mod terms;
mod vector;
mod words;

pub use bound::Bound;
pub use correlated::{Correlated, correlated_covariance};
pub use error::Error;
pub use fit::{
    ExponentialSum, Fit, MOST_TERMS, Normalisation, Note, Options, Parameter, Sign, Term,
};
pub use profile::Interval;
pub use refine::Stop;
pub use terms::{Row, SIGNIFICANCE, Terms};

use basis::{MOST_COORDINATES, Spanned};
use engine::{Core, Engine, Sampling};
use family::Family;
use means::Means;
use std::sync::Arc;

/// Duration times the slowest rate fitted by default.
const SLOWEST: f64 = 0.02;
/// Sample whose time is the shortest time constant fitted by default.
const FASTEST: usize = 5;
/// Coordinates of the smaller engine, which spans most holds.
const FEW_COORDINATES: usize = 24;
/// Terms up to which the grid of a single fit costs less than a table for many.
const FEW_TERMS: usize = 2;

/// Everything a fit needs to know of the times, weights and options, computed once. Cheap to
/// clone, and shared between threads.
#[derive(Clone, Debug)]
pub struct Prepared {
    engine: Arc<dyn Engine>,
    samples: usize,
    terms: usize,
    limits: (f64, f64),
}

impl Prepared {
    /// Prepares fits on these times (s, strictly increasing, not necessarily uniform), all
    /// samples weighing the same.
    ///
    /// # Errors
    /// When the times, the limits of the rates or the number of terms cannot be used.
    pub fn new(times: &[f64], options: &Options) -> Result<Self, Error> {
        Self::prepare(times, &[], options, engine)
    }

    /// Prepares for a single trace, which is soon done: together with one fit of one or two terms some 0.2 ms. Each further fit
    /// takes several times as long as after [`Self::new`].
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn for_one(times: &[f64], options: &Options) -> Result<Self, Error> {
        Self::prepare(times, &[], options, engine_for_one)
    }

    /// Prepares fits that weigh the square of each sample's residual; only the proportions of
    /// the weights count, and 0 leaves a sample out. For noise of known spread the best weight
    /// is the reciprocal of its variance.
    ///
    /// # Errors
    /// As [`Self::new`], and when a weight is negative or not finite.
    pub fn weighted(times: &[f64], weights: &[f64], options: &Options) -> Result<Self, Error> {
        if weights.len() != times.len() {
            return Err(Error::Lengths {
                times: times.len(),
                other: weights.len(),
                what: "weights",
            });
        }
        Self::prepare(times, weights, options, engine)
    }

    fn prepare(
        times: &[f64],
        weights: &[f64],
        options: &Options,
        engine: MakeEngine,
    ) -> Result<Self, Error> {
        let terms = options.terms;
        if !(1..=MOST_TERMS).contains(&terms) {
            return Err(Error::Terms { terms });
        }
        check_times(times)?;
        let roots = roots(weights)?;
        let samples = match roots.len() {
            0 => times.len(),
            _ => roots.iter().filter(|root| **root > 0.0).count(),
        };
        if terms > most_terms(samples) {
            let needed = 2 * terms + 2;
            return Err(Error::TooFewSamples { samples, terms, needed });
        }
        let duration = times[times.len() - 1] - times[0];
        let slowest = options.slowest.unwrap_or(SLOWEST / duration);
        let fastest = options
            .fastest
            .unwrap_or_else(|| 1.0 / (times[FASTEST.min(times.len() - 1)] - times[0]));
        if !(slowest > 0.0 && fastest >= 1.01 * slowest && fastest < f64::INFINITY) {
            return Err(Error::RateLimits { slowest, fastest });
        }
        let since: Vec<f64> = times.iter().map(|time| time - times[0]).collect();
        let engine = engine(since, &roots, samples, (slowest, fastest), options);
        Ok(Self {
            engine: engine.ok_or(Error::TooWide { slowest, fastest })?,
            samples: times.len(),
            terms,
            limits: (slowest, fastest),
        })
    }

    /// Fits one trace sampled at the prepared times.
    ///
    /// # Errors
    /// When a value is not finite, the signal is constant, its length differs from the times', or
    /// it vanishes where it is normalised.
    pub fn fit(&self, values: &[f64]) -> Result<Fit, Error> {
        self.fit_terms(values, self.terms)
    }

    /// The same with fewer exponentials than were prepared for.
    ///
    /// # Errors
    /// As [`Self::fit`], and where it was not prepared for so many.
    pub fn fit_terms(&self, values: &[f64], terms: usize) -> Result<Fit, Error> {
        self.check_length(values)?;
        if !(1..=self.terms).contains(&terms) {
            return Err(Error::Terms { terms });
        }
        self.engine.fit(values, terms)
    }

    /// Fits one to `options.terms` exponentials to one trace and says how many the data tell.
    ///
    /// # Errors
    /// As [`Self::fit`].
    pub fn compare_terms(&self, values: &[f64]) -> Result<Terms, Error> {
        self.check_length(values)?;
        let fits = (1..=self.terms).map(|terms| self.engine.fit(values, terms));
        Ok(Terms::new(fits.collect::<Result<_, _>>()?))
    }

    /// Profile-likelihood interval of one parameter of a fit to these values: wider and truer
    /// than [`Fit::interval`] where the noise is high. `level` is 0.95 for a 95 % interval. Takes
    /// about a millisecond.
    ///
    /// # Errors
    /// As [`Self::fit`], and when the level is not between 0 and 1 or the fit has no such
    /// parameter.
    pub fn profile(
        &self,
        values: &[f64],
        fit: &Fit,
        parameter: Parameter,
        level: f64,
    ) -> Result<Interval, Error> {
        self.check_length(values)?;
        if !(level > 0.0 && level < 1.0) {
            let (what, wanted) = ("the level of confidence", "between 0 and 1");
            return Err(Error::Argument { what, value: level, wanted });
        }
        self.engine.profile(values, fit, parameter, level)
    }

    fn check_length(&self, values: &[f64]) -> Result<(), Error> {
        if values.len() == self.samples {
            Ok(())
        } else {
            Err(Error::Lengths { times: self.samples, other: values.len(), what: "values" })
        }
    }

    /// Slowest and fastest rate that a fit can return, 1/s.
    #[must_use]
    pub fn rate_limits(&self) -> (f64, f64) {
        self.limits
    }
}

/// Most exponentials that so many samples allow, which are to be two more than twice their number; 0 where they allow none.
#[must_use]
pub fn most_terms(samples: usize) -> usize {
    (samples.saturating_sub(2) / 2).min(MOST_TERMS)
}

/// Makes an engine for times since the first sample, s, of which so many have a weight, by its root, between two rates, 1/s.
type MakeEngine = fn(Vec<f64>, &[f64], usize, (f64, f64), &Options) -> Option<Arc<dyn Engine>>;

/// An engine for one fit of few terms; where that is not enough, the one for many.
fn engine_for_one(
    since: Vec<f64>,
    roots: &[f64],
    samples: usize,
    limits: (f64, f64),
    options: &Options,
) -> Option<Arc<dyn Engine>> {
    if options.terms <= FEW_TERMS {
        let means = Means::new(&since, roots);
        let (times, own) = match &means {
            Some(means) => (means.times(), means.block_roots()),
            None => (since.clone(), roots.to_vec()),
        };
        let exact = means.is_none().then(|| (times.clone(), own.clone()));
        let sampling = Sampling { means, samples, exact };
        if let Some(core) =
            Core::<MOST_COORDINATES>::for_one(&times, own, limits, sampling, options)
        {
            return Some(Arc::new(core));
        }
    }
    engine(since, roots, samples, limits, options)
}

/// The smallest engine that spans the exponentials on these times since the first sample, s; so many
/// `samples` have a weight.
fn engine(
    since: Vec<f64>,
    roots: &[f64],
    samples: usize,
    (slowest, fastest): (f64, f64),
    options: &Options,
) -> Option<Arc<dyn Engine>> {
    let means = Means::new(&since, roots);
    let (times, roots) = match &means {
        Some(means) => (means.times(), means.block_roots()),
        None => (since, roots.to_vec()),
    };
    let family = Family::new(times, slowest, fastest);
    let sampling = Sampling { means, samples, exact: None };
    let spanned = Spanned::new(&family, &roots)?;
    if spanned.width() <= FEW_COORDINATES {
        let core = Core::<FEW_COORDINATES>::new(&family, &spanned, roots, sampling, options);
        return Some(Arc::new(core));
    }
    Some(Arc::new(Core::<MOST_COORDINATES>::new(&family, &spanned, roots, sampling, options)))
}

fn check_times(times: &[f64]) -> Result<(), Error> {
    if let Some(sample) = times.iter().position(|time| !time.is_finite()) {
        return Err(Error::TimeNotFinite { sample });
    }
    // `!(a < b)` would also do, but no time is NaN any more.
    match times.windows(2).position(|pair| pair[1] <= pair[0]) {
        Some(before) => Err(Error::TimeNotIncreasing { sample: before + 1 }),
        None => Ok(()),
    }
}

/// Roots of the weights, scaled to a mean weight of 1 over the samples that count.
fn roots(weights: &[f64]) -> Result<Vec<f64>, Error> {
    if let Some(sample) = weights.iter().position(|weight| !(*weight >= 0.0 && weight.is_finite()))
    {
        return Err(Error::Weight { sample });
    }
    let largest = weights.iter().fold(0.0, |a: f64, b| a.max(*b));
    let counted = weights.iter().filter(|weight| **weight > 0.0).count() as f64;
    let mean = weights.iter().map(|weight| weight / largest).sum::<f64>() / counted;
    Ok(weights.iter().map(|weight| (weight / largest / mean).sqrt()).collect())
}

#[cfg(test)]
mod tests;
