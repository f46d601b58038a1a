//! Answers of the commands as types, as sections of words, tables and plots; the chapters of the dissertation.
//!
//! - [`answers`]: what `--json` prints, with a JSON schema each.
//! - [`summary`]: the same in words, tables and plots.
//! - [`dissertation`]: the figures that the dissertation prints.
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let press = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/traces/press.csv");
//! use palpate_fit::data::Data;
//! use palpate_fit::whole_motion::fit;
//! use palpate_model::{BaseLaw, Separation};
//! use palpate_present::answers::{FitAnswer, json};
//! use palpate_present::summary::FitSummary;
//! use palpate_trace::{FORCE, read};
//!
//! let traces = [read(press.as_ref())?];
//! let data = Data::of(&traces, FORCE)?;
//! let fit = &fit(BaseLaw::fung(2, Separation::Clamp), &data)?;
//! let (held_out, candidates) = (&[], &[]);
//! let summary = FitSummary { fit, data: &data, signal: FORCE, noise: None, held_out, candidates };
//! assert_eq!(json(&FitAnswer::from(&summary))["palpate_fit"], 1);
//! # Ok(())
//! # }
//! ```
#![forbid(unsafe_code)]

pub mod answers;
pub mod bundled;
pub mod dissertation;
pub mod summary;
