//! Fourier transforms of real values, of any length.

use std::sync::Arc;

use realfft::RealFftPlanner;
pub use realfft::{ComplexToReal, RealToComplex};

/// Makes plans of transforms, and keeps what they have in common.
///
/// The transforms are generic code. They are compiled here for `f64`, once for all crates.
pub struct Planner(RealFftPlanner<f64>);

impl Planner {
    /// A planner without plans.
    #[must_use]
    pub fn new() -> Self {
        Self(RealFftPlanner::new())
    }

    /// From so many values to `length / 2 + 1` lines, from frequency 0 to half the sampling rate.
    pub fn forward(&mut self, length: usize) -> Arc<dyn RealToComplex<f64>> {
        self.0.plan_fft_forward(length)
    }

    /// Back from the lines to so many values, `length` times as large as they were.
    pub fn inverse(&mut self, length: usize) -> Arc<dyn ComplexToReal<f64>> {
        self.0.plan_fft_inverse(length)
    }
}

impl Default for Planner {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back_is_the_length_times_as_large() {
        let mut planner = Planner::new();
        for length in [1, 2, 7, 30, 64] {
            let (forward, inverse) = (planner.forward(length), planner.inverse(length));
            let values: Vec<f64> = (0..length).map(|k| (k as f64).sin() + 0.1 * k as f64).collect();
            let (mut from, mut lines) = (values.clone(), forward.make_output_vec());
            forward.process(&mut from, &mut lines).unwrap();
            let mut back = inverse.make_output_vec();
            inverse.process(&mut lines, &mut back).unwrap();
            let off = |(value, back): (&f64, &f64)| (value * length as f64 - back).abs();
            assert!(values.iter().zip(&back).map(off).all(|off| off < 1e-12 * length as f64));
        }
    }
}
