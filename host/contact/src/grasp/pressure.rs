//! The general pressure law of soft contacts, p ∝ [1 − ρ^k]^(1/k) (eqs 6.10, 8.1).
//!
//! ρ is 0 in the middle of the contact and 1 at its edge. Hertz is k = 2, softer materials have more, and
//! k → ∞ is a uniform pressure. Pressures are given relative to the mean pressure N/A, so that a profile
//! is a pure number whose mean over the contact is 1.
//!
//! Γ(1 + z) = z Γ(z) turns the constant of eq. 8.2 into
//! Ck = Γ(1 + 3/k) / (Γ(1 + 1/k) Γ(1 + 2/k)), in which nothing overflows and k = ∞ gives 1.

use statrs::function::gamma::ln_gamma;

/// The exponent k of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressureLaw {
    exponent: f64,
}

/// An exponent that the law does not take.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the exponent k of the pressure is {0}; give 1 or more: 2 is Hertz, softer materials have more, inf is uniform"
)]
pub struct ExponentError(pub f64);

impl PressureLaw {
    /// Hertz: k = 2.
    pub const HERTZ: Self = Self { exponent: 2.0 };
    /// The same pressure everywhere: k = ∞.
    pub const UNIFORM: Self = Self { exponent: f64::INFINITY };

    /// The law with exponent k, from 1 to infinity.
    ///
    /// # Errors
    /// For an exponent below 1, or none.
    pub fn new(exponent: f64) -> Result<Self, ExponentError> {
        // Not a number is not at least 1 either.
        if exponent >= 1.0 { Ok(Self { exponent }) } else { Err(ExponentError(exponent)) }
    }

    /// The exponent k.
    #[must_use]
    pub const fn exponent(self) -> f64 {
        self.exponent
    }

    /// [1 − ρ^k]^(1/k), 1 in the middle and 0 from the edge on; `rho` is 0 or more.
    #[must_use]
    pub fn shape(self, rho: f64) -> f64 {
        if rho >= 1.0 {
            0.0
        } else if self.exponent.is_infinite() {
            1.0
        } else {
            // 1 − ρ^k without cancellation close to the edge.
            let rest = -(self.exponent * rho.ln()).exp_m1();
            rest.powf(1.0 / self.exponent)
        }
    }

    /// Ck of a circular or elliptical contact (eq. 8.2): the pressure in the middle over the mean pressure.
    #[must_use]
    pub fn circular_constant(self) -> f64 {
        let z = 1.0 / self.exponent;
        (ln_gamma(1.0 + 3.0 * z) - ln_gamma(1.0 + z) - ln_gamma(1.0 + 2.0 * z)).exp()
    }

    /// Ck of a strip, whose pressure varies along its length only (eq. 6.10): the pressure in the middle over
    /// the mean pressure, Γ(1 + 2/k) / Γ(1 + 1/k)².
    #[must_use]
    pub fn strip_constant(self) -> f64 {
        let z = 1.0 / self.exponent;
        (ln_gamma(1.0 + 2.0 * z) - 2.0 * ln_gamma(1.0 + z)).exp()
    }

    /// Pressure over mean pressure in a circular or elliptical contact; `rho` is the distance from the
    /// middle over that of the edge in the same direction.
    #[must_use]
    pub fn circular(self, rho: f64) -> f64 {
        self.circular_constant() * self.shape(rho)
    }

    /// Pressure over mean pressure in a strip; `rho` is the distance from the middle over *half* the length.
    /// (6.10) is printed with the full length, with which the pressure would not vanish at the edge.
    #[must_use]
    pub fn strip(self, rho: f64) -> f64 {
        self.strip_constant() * self.shape(rho)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// ∫ from 0 to 1 by the rule of tanh and sinh, which takes the steep edge.
    fn integral(f: impl Fn(f64) -> f64) -> f64 {
        let step = 1.0 / 64.0;
        (-400..=400)
            .map(|j| {
                let t = f64::from(j) * step;
                let (sinh, cosh) = (t.sinh(), t.cosh());
                let decay = (-std::f64::consts::PI * sinh).exp();
                let x = 1.0 / (1.0 + decay);
                let weight = std::f64::consts::PI * cosh * decay * x * x;
                if weight.is_finite() && x < 1.0 { step * weight * f(x) } else { 0.0 }
            })
            .sum()
    }

    #[test]
    fn hertz_and_uniform_have_their_closed_forms() {
        let circle = PressureLaw::HERTZ.circular_constant();
        let strip = PressureLaw::HERTZ.strip_constant();
        assert!((circle - 1.5).abs() < 1e-13);
        assert!((strip - 4.0 / std::f64::consts::PI).abs() < 1e-13);
        assert!((PressureLaw::UNIFORM.circular(0.999) - 1.0).abs() < 1e-14);
        assert!((PressureLaw::UNIFORM.strip(0.999) - 1.0).abs() < 1e-14);
        assert_eq!(PressureLaw::UNIFORM.circular(1.0), 0.0);
    }

    #[test]
    fn an_exponent_below_one_is_refused() {
        for wrong in [0.99, 0.0, -2.0, f64::NAN, f64::NEG_INFINITY] {
            assert!(PressureLaw::new(wrong).is_err());
        }
    }

    proptest! {
        #[test]
        fn the_pressure_integrates_to_the_normal_force(log_k in 0f64..2.0) {
            let law = PressureLaw::new(10f64.powf(log_k)).unwrap();
            prop_assert!((integral(|rho| 2.0 * rho * law.circular(rho)) - 1.0).abs() < 1e-11);
            prop_assert!((integral(|rho| law.strip(rho)) - 1.0).abs() < 1e-11);
        }

        #[test]
        fn the_limit_of_large_k_is_uniform(log_k in 3f64..300.0, rho in 0f64..0.99) {
            let law = PressureLaw::new(10f64.powf(log_k)).unwrap();
            let near = 2.0 / law.exponent();
            prop_assert!((law.circular(rho) - 1.0).abs() <= near + 1e-13);
            prop_assert!((law.strip(rho) - 1.0).abs() <= near + 1e-13);
        }

        #[test]
        fn the_pressure_falls_from_the_middle_to_the_edge(
            k in 1f64..200.0, a in 0f64..1.0, b in 0f64..1.0,
        ) {
            let law = PressureLaw::new(k).unwrap();
            let (inner, outer) = (a.min(b), a.max(b));
            prop_assert!(law.shape(inner) >= law.shape(outer) - 1e-15);
        }
    }
}
