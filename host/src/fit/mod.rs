//! Exponential sums, bounded least squares, uncertainty.
