//! Whether repeats of one value differ by more than their standard errors explain.

use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Several estimates of one value, compared by their own standard errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Consistency {
    /// Mean, each value weighing as the inverse of its variance.
    pub mean: f64,
    /// Standard error of that mean, if the values are consistent.
    pub standard_error: f64,
    /// Sum of the squared deviations from that mean, in standard errors.
    pub chi_square: f64,
    /// Values less one.
    pub degrees_of_freedom: usize,
    /// Chance of so large a sum if all values were the same but for their errors.
    pub p_value: f64,
}

/// Compares two or more values with their standard errors; none where an error is not positive.
///
/// # Panics
/// If there are not as many errors as values.
#[must_use]
pub fn consistency(values: &[f64], errors: &[f64]) -> Option<Consistency> {
    assert_eq!(values.len(), errors.len(), "one standard error for each value");
    let usable = errors.iter().all(|error| *error > 0.0 && error.is_finite());
    if values.len() < 2 || !usable {
        return None;
    }
    let weights: Vec<f64> = errors.iter().map(|error| error.powi(-2)).collect();
    let weight: f64 = weights.iter().sum();
    let mean =
        values.iter().zip(&weights).map(|(value, weight)| value * weight).sum::<f64>() / weight;
    let chi_square =
        values.iter().zip(errors).map(|(value, error)| ((value - mean) / error).powi(2)).sum();
    let degrees_of_freedom = values.len() - 1;
    let p_value = ChiSquared::new(degrees_of_freedom as f64).ok()?.sf(chi_square);
    let standard_error = weight.sqrt().recip();
    Some(Consistency { mean, standard_error, chi_square, degrees_of_freedom, p_value })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_is_that_of_the_textbook() {
        // Two values that differ by d with equal errors: χ² = d²/(2 s²), p = erfc(√(χ²/2)).
        let found = consistency(&[1.0, 3.0], &[1.0, 1.0]).unwrap();
        assert!((found.chi_square - 2.0).abs() < 1e-12 && found.degrees_of_freedom == 1);
        assert!((found.p_value - 0.157_299_207_050_285).abs() < 1e-9);
        assert!(
            (found.mean - 2.0).abs() < 1e-12
                && (found.standard_error - 0.5f64.sqrt()).abs() < 1e-12
        );
    }

    #[test]
    fn precise_values_weigh_more() {
        let found = consistency(&[1.0, 3.0], &[0.1, 1.0]).unwrap();
        assert!((found.mean - (100.0 + 3.0) / 101.0).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_said_without_errors_or_repeats() {
        assert_eq!(consistency(&[1.0, 2.0], &[0.0, 1.0]), None);
        assert_eq!(consistency(&[1.0], &[1.0]), None);
    }
}
