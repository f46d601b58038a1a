//! Elasticity: the force of an instantaneous compression.

/// Elastic response N(x) = p/(q+1) x^(q+1) for x > 0, else 0, in N (eq. 3.2).
///
/// `compression` in mm, `p` in N/mm^(q+1).
#[must_use]
pub fn elastic_response(p: f64, q: f64, compression: f64) -> f64 {
    if compression <= 0.0 {
        return 0.0;
    }
    let exponent = q + 1.0;
    p / exponent * compression.powf(exponent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_the_power_law_and_is_zero_off_the_specimen() {
        assert!((elastic_response(0.3, 1.0, 2.0) - 0.3 / 2.0 * 4.0).abs() < 1e-15);
        assert_eq!(elastic_response(0.3, 1.0, 0.0), 0.0);
        assert_eq!(elastic_response(0.3, 1.0, -1.0), 0.0);
    }
}
