//! What is asked of a fit and what it returns.

use super::correlated::Correlated;
use super::refine::Stop;
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::fmt;

/// Most exponentials in a sum.
pub const MOST_TERMS: usize = 4;
/// Most parameters: N, c0 … c4, v1 … v4.
pub(super) const MOST_PARAMETERS: usize = 2 * MOST_TERMS + 2;

/// Sign that coefficients may have, relative to that of the signal's mean (so that c ≥ 0 means
/// the same for a compression recorded as negative numbers).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sign {
    /// Any.
    #[default]
    Free,
    /// c ≥ 0: relaxation, and Type II creep (6.4).
    NotNegative,
    /// c ≤ 0: Type II relaxation, and Type I creep (6.3).
    NotPositive,
}

impl Sign {
    /// +1, −1, or 0 for any.
    pub(super) fn number(self) -> f64 {
        match self {
            Self::Free => 0.0,
            Self::NotNegative => 1.0,
            Self::NotPositive => -1.0,
        }
    }
}

/// What N and the coefficients are relative to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Normalisation {
    /// c0 + c1 + … + cn = 1, N is the value at the first sample (3.3).
    #[default]
    Initial,
    /// c0 = 1, N is the value after infinite time (6.2).
    Asymptotic,
}

/// What to fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Number of exponentials, 1 to 4.
    pub terms: usize,
    /// Sign of c1 … cn.
    pub sign: Sign,
    /// Sign of c0; of no effect with [`Normalisation::Asymptotic`], where c0 = 1.
    pub constant_sign: Sign,
    /// What N and the coefficients are relative to.
    pub normalisation: Normalisation,
    /// Lower limit of the rates, 1/s; by default 0.02 / duration.
    pub slowest: Option<f64>,
    /// Upper limit of the rates, 1/s; by default the rate whose time constant is the time from
    /// the first sample to the sixth.
    pub fastest: Option<f64>,
}

impl Default for Options {
    /// Two exponentials of any sign, Σc = 1, rates within the default limits.
    fn default() -> Self {
        Self {
            terms: 2,
            sign: Sign::Free,
            constant_sign: Sign::Free,
            normalisation: Normalisation::Initial,
            slowest: None,
            fastest: None,
        }
    }
}

impl Options {
    /// Two exponentials with c0, c1, c2 ≥ 0: a relaxation (3.4).
    #[must_use]
    pub fn relaxation() -> Self {
        Self { sign: Sign::NotNegative, constant_sign: Sign::NotNegative, ..Self::default() }
    }
}

/// One exponential of a sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// c_i, no unit.
    pub coefficient: f64,
    /// v_i, 1/s.
    pub rate: f64,
}

/// F(t) = N (c0 + Σ c_i e^(−v_i t)), eqs 3.3 and 6.2.
#[derive(Clone, Debug, PartialEq)]
pub struct ExponentialSum {
    /// N, in the unit of the signal.
    pub scale: f64,
    /// c0.
    pub constant: f64,
    /// c_i and v_i, the fastest first.
    pub terms: Vec<Term>,
}

impl ExponentialSum {
    /// F at a time t in seconds since the first sample.
    #[must_use]
    pub fn at(&self, time: f64) -> f64 {
        let sum: f64 =
            self.terms.iter().map(|term| term.coefficient * (-term.rate * time).exp()).sum();
        self.scale * (self.constant + sum)
    }

    /// A parameter's value; none where the sum has no such term.
    #[must_use]
    pub fn value(&self, parameter: Parameter) -> Option<f64> {
        match parameter {
            Parameter::Scale => Some(self.scale),
            Parameter::Coefficient(0) => Some(self.constant),
            Parameter::Coefficient(i) => self.terms.get(i - 1).map(|term| term.coefficient),
            Parameter::Rate(i) => self.terms.get(i.checked_sub(1)?).map(|term| term.rate),
        }
    }
}

/// One parameter of a sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Parameter {
    /// N.
    Scale,
    /// c_i; 0 is the constant.
    Coefficient(usize),
    /// v_i, from 1.
    Rate(usize),
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scale => f.write_str("N"),
            Self::Coefficient(i) => write!(f, "c{i}"),
            Self::Rate(i) => write!(f, "v{i}"),
        }
    }
}

impl Parameter {
    /// All parameters of a sum in the order N, c0 … cn, v1 … vn.
    pub fn all(terms: usize) -> impl Iterator<Item = Self> {
        std::iter::once(Self::Scale)
            .chain((0..=terms).map(Self::Coefficient))
            .chain((1..=terms).map(Self::Rate))
    }

    /// Place in that order; none where a sum of so many terms has no such parameter.
    pub(super) fn place(self, terms: usize) -> Option<usize> {
        match self {
            Self::Scale => Some(0),
            Self::Coefficient(i) => (i <= terms).then_some(1 + i),
            Self::Rate(i) => (i >= 1 && i <= terms).then_some(1 + terms + i),
        }
    }
}

/// What stands in the way of reading every parameter at face value. Terms count from 1, the
/// fastest. Standard errors are conditional on what a note says is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Note {
    /// The rate is at its lower limit: the recording is too short for this term.
    AtSlowest {
        /// The term.
        term: usize,
    },
    /// The rate is at its upper limit: the sampling is too slow for this term.
    AtFastest {
        /// The term.
        term: usize,
    },
    /// The coefficient is held at 0, by its sign or because the other terms already do all it
    /// could; its rate has no meaning.
    Vanishes {
        /// The term.
        term: usize,
    },
    /// c0 is held at 0 by its sign.
    ConstantAtZero,
    /// Two rates are the same to 0.1 % (of four, to 1 %): together the terms are (a + b t) e^(−v t), their
    /// coefficients nearly cancel and have no meaning one by one.
    Coincide {
        /// The faster term.
        first: usize,
        /// The slower term.
        second: usize,
    },
    /// The data do not determine the rates: their information matrix is singular.
    Singular,
    /// N is within three standard errors of 0, so that the coefficients are hardly determined.
    ScaleNearZero,
}

/// A fitted sum of exponentials.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The fitted function.
    pub sum: ExponentialSum,
    /// What is held at a bound or not determined; empty for an ordinary fit.
    pub notes: Vec<Note>,
    /// Weighted sum of squared residuals; weights have mean 1.
    pub rss: f64,
    /// Root mean square of the residuals, in the unit of the signal.
    pub residual_rms: f64,
    /// Standard deviation of the noise, from the residuals and the degrees of freedom.
    pub noise: f64,
    /// Share of the variance about the mean that is explained.
    pub r_squared: f64,
    /// Samples with a weight above 0.
    pub samples: usize,
    /// Parameters that are free: not held at a bound.
    pub free: usize,
    /// Samples less free parameters.
    pub degrees_of_freedom: usize,
    /// Why the iteration ended.
    pub stop: Stop,
    /// Iterations, over all starts.
    pub iterations: u32,
    /// Covariance in the order of [`Parameter::all`].
    pub(super) covariance: [[f64; MOST_PARAMETERS]; MOST_PARAMETERS],
    /// Whether each parameter has a standard error.
    pub(super) determined: [bool; MOST_PARAMETERS],
    /// What N and the coefficients are relative to.
    pub(super) normalisation: Normalisation,
    /// How the residuals correlate, where the standard errors allow for it; they are those of white noise
    /// otherwise.
    pub correlated: Option<Correlated>,
}

impl Fit {
    /// All parameters in the order N, c0 … cn, v1 … vn.
    pub fn parameters(&self) -> impl Iterator<Item = Parameter> + use<> {
        Parameter::all(self.sum.terms.len())
    }

    /// Whether the fit explains more than a constant does, by the Bayesian information criterion.
    #[must_use]
    pub fn explains(&self) -> bool {
        let samples = self.samples as f64;
        let left = (1.0 - self.r_squared).max(f64::MIN_POSITIVE);
        samples * left.ln() + (self.free as f64 - 1.0) * samples.ln() < 0.0
    }

    /// A parameter's value; none where the fit has no such term.
    #[must_use]
    pub fn value(&self, parameter: Parameter) -> Option<f64> {
        self.sum.value(parameter)
    }

    /// Covariance of two parameters; none where one is held or not determined.
    #[must_use]
    pub fn covariance(&self, a: Parameter, b: Parameter) -> Option<f64> {
        let terms = self.sum.terms.len();
        let (i, j) = (a.place(terms)?, b.place(terms)?);
        (self.determined[i] && self.determined[j]).then(|| self.covariance[i][j])
    }

    /// Standard error of a parameter; none where it is held or not determined.
    #[must_use]
    pub fn standard_error(&self, parameter: Parameter) -> Option<f64> {
        self.covariance(parameter, parameter).map(f64::sqrt)
    }

    /// Correlation of two parameters; none where one is held, not determined or without scatter.
    #[must_use]
    pub fn correlation(&self, a: Parameter, b: Parameter) -> Option<f64> {
        let scatter = self.standard_error(a)? * self.standard_error(b)?;
        (scatter > 0.0).then(|| self.covariance(a, b).map(|both| both / scatter))?
    }

    /// Confidence interval from the standard error and Student's t; for a rate symmetric in its
    /// logarithm. `level` is 0.95 for a 95 % interval. None where the parameter is held or not
    /// determined, or where the level is not between 0 and 1. Where the standard error exceeds
    /// some 10 % of a coefficient or rate, prefer `Prepared::profile`.
    #[must_use]
    pub fn interval(&self, parameter: Parameter, level: f64) -> Option<(f64, f64)> {
        let value = self.value(parameter)?;
        let error = self.standard_error(parameter)?;
        let place = parameter.place(self.sum.terms.len())?;
        let half = match &self.correlated {
            Some(correlated) if level > 0.0 && level < 1.0 => {
                correlated.half(place, self.degrees_of_freedom, level)?
            }
            _ => quantile(self.degrees_of_freedom, level)? * error,
        };
        Some(match parameter {
            Parameter::Rate(_) => (value * (-half / value).exp(), value * (half / value).exp()),
            _ => (value - half, value + half),
        })
    }
}

/// Student's t that the given share of all values stays within on both sides.
pub(super) fn quantile(degrees: usize, level: f64) -> Option<f64> {
    if !(level > 0.0 && level < 1.0) {
        return None;
    }
    let student = StudentsT::new(0.0, 1.0, degrees as f64).ok()?;
    Some(student.inverse_cdf(0.5 + 0.5 * level))
}
