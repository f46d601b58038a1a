//! Why a fit or a plan is refused.

use thiserror::Error;

/// Why exponentials cannot be fitted, or a recording cannot be planned.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Error {
    /// The number of terms is not 1 to 4.
    #[error("{terms} exponentials were asked for; 1 to 4 can be fitted")]
    Terms {
        /// Number asked for.
        terms: usize,
    },
    /// There are fewer samples than parameters, or as many.
    #[error(
        "{samples} samples are too few for {terms} exponentials: \
         at least {needed} with a weight above 0 are needed"
    )]
    TooFewSamples {
        /// Samples with a weight above 0.
        samples: usize,
        /// Exponentials asked for.
        terms: usize,
        /// Samples needed.
        needed: usize,
    },
    /// Two arrays that belong together differ in length.
    #[error("there are {times} times but {other} {what}")]
    Lengths {
        /// Number of times.
        times: usize,
        /// Number of the others.
        other: usize,
        /// What the others are.
        what: &'static str,
    },
    /// A time is NaN or infinite.
    #[error("the time of sample {sample} (counted from 0) is not a finite number")]
    TimeNotFinite {
        /// Sample, from 0.
        sample: usize,
    },
    /// Time stands still or goes backwards.
    #[error("time does not increase at sample {sample} (counted from 0)")]
    TimeNotIncreasing {
        /// First sample, from 0, that is not later than the one before.
        sample: usize,
    },
    /// A value is NaN or infinite.
    #[error("the value of sample {sample} (counted from 0) is not a finite number")]
    ValueNotFinite {
        /// Sample, from 0.
        sample: usize,
    },
    /// A weight is negative, NaN or infinite.
    #[error("the weight of sample {sample} (counted from 0) is not a finite number of 0 or more")]
    Weight {
        /// Sample, from 0.
        sample: usize,
    },
    /// The squares of the values over- or underflow.
    #[error("the values are too large or too small to be squared: choose another unit")]
    Magnitude,
    /// All values are the same: there is no relaxation to fit.
    #[error("the signal is constant: nothing relaxes in it")]
    ConstantSignal,
    /// The limits of the rates are not positive, or not in order.
    #[error(
        "rates between {slowest} /s and {fastest} /s cannot be fitted: \
         both limits must be positive and the fastest at least 1 % above the slowest"
    )]
    RateLimits {
        /// Lower limit, 1/s.
        slowest: f64,
        /// Upper limit, 1/s.
        fastest: f64,
    },
    /// The rates span too many decades.
    #[error(
        "rates from {slowest} /s to {fastest} /s on these times are too many decades to search: \
         narrow the limits of the rates"
    )]
    TooWide {
        /// Lower limit, 1/s.
        slowest: f64,
        /// Upper limit, 1/s.
        fastest: f64,
    },
    /// The fitted function is zero where it is normalised, so that the coefficients are undefined.
    #[error(
        "the fitted function is zero {place}, so that its coefficients cannot be normalised there: \
         choose the other normalisation"
    )]
    ZeroScale {
        /// `at the first sample` or `in the limit of long times`.
        place: &'static str,
    },
    /// The samples do not determine the parameters, whatever the noise.
    #[error("these samples do not determine all parameters: the information matrix is singular")]
    Indeterminate,
    /// A plan without a wish.
    #[error("no precision is wanted of any parameter: there is nothing to plan")]
    NothingWanted,
    /// A parameter that the fit does not have.
    #[error("a fit of {terms} exponentials has no {parameter}")]
    NoSuchParameter {
        /// Number of exponentials.
        terms: usize,
        /// The parameter.
        parameter: String,
    },
    /// A probability that is not between 0 and 1, or a quantity that is not positive.
    #[error("{what} is {value}; it must be {wanted}")]
    Argument {
        /// What was given.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        wanted: &'static str,
    },
}
