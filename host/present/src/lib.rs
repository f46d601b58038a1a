//! Results in words, tables and plots, and the chapters of the dissertation.
//!
//! - [`summary`]:
//! - [`dissertation`]: the figures that the dissertation prints.
#![forbid(unsafe_code)]

pub mod bundled;
pub mod dissertation;
pub mod summary;
