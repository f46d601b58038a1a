//! Exponential sums, bounded least squares, uncertainty.

pub mod data;
pub mod least_squares;
mod start;
mod uncertainty;
pub mod whole_motion;

pub use uncertainty::{Uncertainty, uncertainty};
