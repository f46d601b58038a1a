//! Where a model fails, which physical effect it lacks, and how sure that is.
//!
//! - [`criticism`]: where a model fails, which effect is missing, how sure that is.
//! - [`practice`]: data sets with a hidden effect.
//! - [`discover`]: a formula for what no effect of the library explains.
//! - [`promises`]: what every law of the library promises, asked of a law of one's own.
#![forbid(unsafe_code)]

pub mod criticism;
pub mod discover;
pub mod practice;
pub mod promises;
