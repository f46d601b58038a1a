//! Logarithms of small probabilities.

use statrs::function::erf::erfc;

/// Logarithm of the chance that a sum of squares of `count` normal numbers exceeds `squares`; of one
/// number of a known sign where `one_sided`.
#[must_use]
pub fn log_tail(squares: f64, count: usize, one_sided: bool) -> f64 {
    if count == 1 {
        let tail = log_normal_tail(squares.max(0.0).sqrt());
        return if one_sided { tail } else { (tail + std::f64::consts::LN_2).min(0.0) };
    }
    // Wilson and Hilferty: the cube root of a mean square is close to normal.
    let count = count as f64;
    let spread = 2.0 / (9.0 * count);
    log_normal_tail(((squares.max(0.0) / count).cbrt() - 1.0 + spread) / spread.sqrt())
}

/// Logarithm of the chance that a normal number exceeds `z`.
fn log_normal_tail(z: f64) -> f64 {
    if z < 25.0 {
        (0.5 * erfc(z / std::f64::consts::SQRT_2)).ln()
    } else {
        // The asymptotic series; its next term is below 1e-5 here.
        -0.5 * z * z - (z * (2.0 * std::f64::consts::PI).sqrt()).ln() - 1.0 / (z * z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_are_those_of_the_normal_and_the_chi_squared_distribution() {
        assert!((log_tail(1.96f64.powi(2), 1, false).exp() - 0.05).abs() < 1e-4);
        assert!((log_tail(1.645f64.powi(2), 1, true).exp() - 0.05).abs() < 1e-4);
        assert!((log_tail(18.307, 10, false).exp() - 0.05).abs() < 2e-3);
        assert!((log_normal_tail(24.999) - log_normal_tail(25.001)).abs() < 0.06);
        assert!(log_tail(1e6, 1, false) < -4e5);
    }
}
