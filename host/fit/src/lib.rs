//! Exponential sums, bounded least squares, uncertainty.
//!
//! - [`exponentials`]: sums of decaying exponentials, without starting values.
//! - [`hold`]: relaxation and creep during the holds of a recording.
//! - [`relaxation_form`]: sums of exponentials, power law and stretched exponential compared.
//! - [`consistency`]: whether repeats differ by more than their standard errors.
//! - [`whole_motion`]: a law over loading, holds and unloading of every trace together.
//! - [`robust`]: the same with a bound on what a single sample can do.
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let press = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/traces/press.csv");
//! use palpate_fit::data::Data;
//! use palpate_fit::whole_motion::fit;
//! use palpate_model::{BaseLaw, Separation};
//! use palpate_trace::{FORCE, read};
//!
//! let traces = [read(press.as_ref())?];
//! let data = Data::of(&traces, FORCE)?;
//! let fitted = fit(BaseLaw::fung(2, Separation::Clamp), &data)?;
//! assert!(fitted.r_squared > 0.99 && fitted.stop.converged());
//! # Ok(())
//! # }
//! ```
#![forbid(unsafe_code)]

pub mod base_anew;
pub mod by_differences;
mod carried;
pub mod choice;
mod columns;
mod compression;
pub mod consistency;
pub mod coordinates;
mod covariates;
pub mod data;
pub mod elastic_law;
pub mod exponentials;
pub mod fold;
pub mod fourier;
pub mod hold;
mod jackknife;
pub mod least_squares;
pub mod levels;
pub mod line;
mod log_blocks;
pub mod loudness;
mod many_exp;
pub mod means;
mod meant;
pub mod power_law;
pub mod problem;
pub mod ranking;
pub mod ranks;
pub mod relaxation_form;
pub mod remembering;
pub mod robust;
pub mod slope;
mod spare;
mod start;
mod straight;
pub mod touch;
mod uncertainty;
pub mod unknown_past;
pub mod warning;
pub mod watch;
pub mod welch;
mod whitened_blocks;
pub mod whitening;
pub mod whole_motion;

pub use uncertainty::{Uncertainty, uncertainty};
