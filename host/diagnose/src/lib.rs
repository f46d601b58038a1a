//! Where a model fails, which physical effect it lacks, and how sure that is.
//!
//! - [`criticism`]: where a model fails, which effect is missing, how sure that is.
//! - [`practice`]: data sets with a hidden effect.
//! - [`discover`]: a formula for what no effect of the library explains.
//! - [`promises`]: what every law of the library promises, asked of a law of one's own.
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let press = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/traces/press.csv");
//! use palpate_diagnose::criticism::compare::compare;
//! use palpate_fit::data::Data;
//! use palpate_fit::whole_motion::fit;
//! use palpate_model::{BaseLaw, Separation};
//! use palpate_trace::{FORCE, read};
//!
//! let traces = [read(press.as_ref())?];
//! let data = Data::of(&traces, FORCE)?;
//! let model = fit(BaseLaw::fung(2, Separation::Clamp), &data)?.model(&data, None, &[]);
//! println!("{}", compare(&model, &traces)?.in_words());
//! # Ok(())
//! # }
//! ```
#![forbid(unsafe_code)]

pub mod criticism;
pub mod discover;
pub mod practice;
pub mod promises;
