//! Elasticity: the force of an instantaneous compression.

use super::Number;

/// Elastic response N(x) = p/(q+1) x^(q+1) for x > 0, else 0, in N (eq. 3.2).
///
/// `compression` in mm, `p` in N/mm^(q+1).
pub fn elastic_response<T: Number>(p: T, q: T, compression: T) -> T {
    if compression.re() <= 0.0 {
        return T::from(0.0);
    }
    let exponent = q + 1.0;
    p / exponent * (exponent * compression.ln()).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::seeded;

    #[test]
    fn follows_the_power_law_and_is_zero_off_the_specimen() {
        assert!((elastic_response(0.3, 1.0, 2.0_f64) - 0.3 / 2.0 * 4.0).abs() < 1e-15);
        assert_eq!(elastic_response(0.3, 1.0, 0.0), 0.0);
        assert_eq!(elastic_response(0.3, 1.0, -1.0), 0.0);
    }

    #[test]
    fn its_derivative_to_the_compression_is_the_stiffness() {
        let x = seeded(&[2.5], 0)[0];
        let force = elastic_response(0.2.into(), 0.7.into(), x);
        let stiffness = 0.2 * 2.5f64.powf(0.7);
        let derivative = force.eps.unwrap_generic(nalgebra::Const, nalgebra::U1)[0];
        assert!((derivative - stiffness).abs() < 1e-14);
    }
}
