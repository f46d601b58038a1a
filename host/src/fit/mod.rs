//! Exponential sums, bounded least squares, uncertainty.

pub mod exponentials;
