//! Answers of the commands as types, as sections of words, tables and plots; the chapters of the dissertation.
//!
//! - [`answers`]: what `--json` prints, with a JSON schema each.
//! - [`summary`]: the same in words, tables and plots.
//! - [`dissertation`]: the figures that the dissertation prints.
#![forbid(unsafe_code)]

pub mod answers;
pub mod bundled;
pub mod dissertation;
pub mod summary;
