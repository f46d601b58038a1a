//! Force curves of a tip: approach, hold, retreat (8.2.2).
//!
//! A cantilever of spring constant k carries a tip; the piezo brings it nearer by z and the tip sinks in by
//! δ = z − z0 − F/k. In SI units throughout; z and δ are positive into the specimen.
//!
//! - [`curve`]: a force curve out of a trace, or out of a text export of JPK ([`jpk`]).
//! - [`law`]: force over depth with adhesion, and over the way of the piezo.
//! - [`pressure`]: what the general pressure law (8.1) changes.
//! - [`hereditary`]: the same of a specimen that relaxes, by Lee and Radok and by Ting.
//! - [`fit`]: baseline, contact point, modulus, relaxation, adhesion, with standard errors.
//! - [`hold`]: the force of a pause alone: two exponentials, and the latency model in place of Kelvin and Voigt (Fig. 8.8).
//! - [`rough`]: what a rough surface does to the answer, by Monte Carlo.
//! - [`simulate`]: practice curves.

pub mod curve;
pub mod fit;
pub mod hereditary;
pub mod hold;
mod identify;
pub mod jpk;
pub mod law;
pub mod pressure;
pub mod rough;
pub mod simulate;

/// A value with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard error, in the same unit.
    pub standard_error: f64,
}

/// Why a curve cannot be analysed or simulated.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum AfmError {
    #[error(transparent)]
    Trace(#[from] palpate_trace::Error),
    #[error("{path}: {source}")]
    Io { path: std::path::PathBuf, source: std::io::Error },
    #[error("{curve}, line {line}: {problem}")]
    Jpk { curve: String, line: usize, problem: String },
    #[error("{curve} has no column `{column}`: a force curve needs displacement_mm and force_N")]
    NoColumn { curve: String, column: &'static str },
    #[error(
        "{curve}: the approach has {samples} samples; at least {least} are needed: is displacement positive into the specimen?"
    )]
    Short { curve: String, samples: usize, least: usize },
    #[error(
        "{curve}: no contact: the force at the end of the approach does not stand out of the noise of the baseline"
    )]
    NoContact { curve: String },
    #[error("{name} is {value}; it must lie between {least} and {most}")]
    Range { name: &'static str, value: f64, least: f64, most: f64 },
    #[error(
        "the general pressure law is that of a round contact under a round tip: give --shape paraboloid or sphere"
    )]
    ConeWithPressure,
}

/// Whether a number lies in its range.
fn within(name: &'static str, value: f64, least: f64, most: f64) -> Result<(), AfmError> {
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(AfmError::Range { name, value, least, most })
    }
}
