//! The latency model of a hold in closed form: linear (4.5)–(4.10) and power law (7.2)–(7.5).
//!
//! Strain moves towards its equilibrium at a rate set by how far away it is. Compression is negative in
//! the strains of chapter 4, as printed there; the power law is the same for either sign.
//!
//! The footnote of 4.2.2 finds the equilibrium "by assuming t → 0"; it is t → ∞ that leads there.

/// A hold of the linear model: F = N0 (c0 + c1 e^(−v1 t)) with c0 + c1 = 1 and ε = −F/α.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear {
    /// N0: force at the start of the hold, N.
    pub initial_force_n: f64,
    /// c0: share of the force that stays; above 1 for Type II.
    pub constant: f64,
    /// v1, 1/s.
    pub rate: f64,
    /// α: force per strain at the contact, N.
    pub stiffness_n: f64,
}

impl Linear {
    /// c1 = 1 − c0.
    #[must_use]
    pub fn share(&self) -> f64 {
        1.0 - self.constant
    }

    /// Force at `t` s after the start of the hold, N (4.4).
    #[must_use]
    pub fn force(&self, t: f64) -> f64 {
        self.initial_force_n * (self.constant + self.share() * (-self.rate * t).exp())
    }

    /// Strain of the contact at `t` s (4.5).
    #[must_use]
    pub fn strain(&self, t: f64) -> f64 {
        -self.force(t) / self.stiffness_n
    }

    /// Strain rate at `t` s, 1/s (4.6).
    #[must_use]
    pub fn strain_rate(&self, t: f64) -> f64 {
        self.rate * self.initial_force_n * self.share() * (-self.rate * t).exp() / self.stiffness_n
    }

    /// Slope m = −v1, 1/s, and intercept l, 1/s, of strain rate over strain (4.7).
    #[must_use]
    pub fn line(&self) -> (f64, f64) {
        (-self.rate, self.rate * self.equilibrium())
    }

    /// Strain rate at a strain, 1/s (4.7)–(4.9).
    #[must_use]
    pub fn strain_rate_at(&self, strain: f64) -> f64 {
        -self.rate * (strain - self.equilibrium())
    }

    /// ε_e: the strain at which the rate vanishes (4.9).
    #[must_use]
    pub fn equilibrium(&self) -> f64 {
        -self.initial_force_n * self.constant / self.stiffness_n
    }

    /// When the strain is reached, s (4.10); none if the hold never passes it, before its start included.
    #[must_use]
    pub fn time_at(&self, strain: f64) -> Option<f64> {
        let gone = (strain - self.equilibrium()) / (self.strain(0.0) - self.equilibrium());
        passed(-gone.ln() / self.rate)
    }

    /// When the strain rate is reached, s (4.10); none if it never is.
    #[must_use]
    pub fn time_at_rate(&self, strain_rate: f64) -> Option<f64> {
        passed(-(strain_rate / self.strain_rate(0.0)).ln() / self.rate)
    }
}

/// A hold of the power law: ε̇ = −ν sgn(ε − ε_e) |ε − ε_e|^n, n ≥ 1 (7.2). For n = 1 it is the linear
/// model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Power {
    /// ν, 1/s for strains without unit.
    pub rate: f64,
    /// n.
    pub order: f64,
    /// ε_e.
    pub equilibrium: f64,
    /// ε_0: strain at the start of the hold.
    pub initial: f64,
}

impl Power {
    /// Relative rate at the start of the hold, ν |ε_0 − ε_e|^(n−1), 1/s.
    #[must_use]
    pub fn pace(&self) -> f64 {
        self.rate * (self.initial - self.equilibrium).abs().powf(self.order - 1.0)
    }

    /// Strain at `t` s after the start of the hold: (7.4) below the equilibrium, (7.5) above it.
    #[must_use]
    pub fn strain(&self, t: f64) -> f64 {
        self.equilibrium + (self.initial - self.equilibrium) * decay(self.pace() * t, self.order)
    }

    /// Strain rate at a strain, 1/s (7.2).
    #[must_use]
    pub fn strain_rate_at(&self, strain: f64) -> f64 {
        let gap = strain - self.equilibrium;
        -self.rate * gap.signum() * gap.abs().powf(self.order)
    }

    /// When the strain is reached, s; none if the hold never passes it.
    #[must_use]
    pub fn time_at(&self, strain: f64) -> Option<f64> {
        let gone = (strain - self.equilibrium) / (self.initial - self.equilibrium);
        let k = self.order - 1.0;
        let relative = if k == 0.0 { -gone.ln() } else { (-k * gone.ln()).exp_m1() / k };
        passed(relative / self.pace())
    }
}

/// What is left of a gap after the time `t` relative to its first pace: (1 + (n−1) t)^(−1/(n−1)), in the
/// limit n = 1 e^(−t).
#[must_use]
pub fn decay(t: f64, order: f64) -> f64 {
    let k = order - 1.0;
    let logarithm = if k == 0.0 { t } else { (k * t).ln_1p() / k };
    (-logarithm).exp()
}

fn passed(time: f64) -> Option<f64> {
    (time >= 0.0 && time.is_finite()).then_some(time)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The strain after `t` s by Runge and Kutta's fourth order in steps small against every rate here.
    fn integrated(rate_at: impl Fn(f64) -> f64, initial: f64, t: f64) -> f64 {
        let steps = 20_000;
        let h = t / f64::from(steps);
        (0..steps).fold(initial, |y, _| {
            let a = rate_at(y);
            let b = rate_at(y + 0.5 * h * a);
            let c = rate_at(y + 0.5 * h * b);
            let d = rate_at(y + h * c);
            y + h * (a + 2.0 * b + 2.0 * c + d) / 6.0
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn the_linear_forms_are_the_integral_of_the_law(
            force in 0.1f64..50.0, constant in 0.2f64..1.5, rate in 0.05f64..5.0, stiffness in 5.0f64..500.0, t in 0.01f64..10.0
        ) {
            prop_assume!((constant - 1.0).abs() > 0.01);
            let hold = Linear { initial_force_n: force, constant, rate, stiffness_n: stiffness };
            let exact = integrated(|strain| hold.strain_rate_at(strain), hold.strain(0.0), t);
            prop_assert!((hold.strain(t) - exact).abs() <= 1e-9 * hold.strain(0.0).abs());
            let (m, l) = hold.line();
            let strain = hold.strain(t);
            let there = hold.strain_rate(t);
            prop_assert!((m * strain + l - there).abs() <= 1e-9 * hold.strain_rate(0.0).abs());
            // (4.10) both ways, as long as what is left is not rounding.
            if rate * t < 10.0 {
                prop_assert!((hold.time_at(strain).unwrap() - t).abs() < 1e-8 * t.max(1.0));
                prop_assert!((hold.time_at_rate(there).unwrap() - t).abs() < 1e-9 * t.max(1.0));
            }
            prop_assert!((hold.strain(1e3 / rate) - hold.equilibrium()).abs() < 1e-12);
        }

        #[test]
        fn the_power_forms_are_the_integral_of_the_law(
            order in prop::sample::select(vec![1.0, 1.5, 2.0, 3.0, 5.0, 9.0]),
            gap in prop_oneof![-0.3f64..-0.01, 0.01f64..0.3], pace in 0.01f64..5.0, equilibrium in -0.5f64..0.5, t in 0.01f64..10.0
        ) {
            let rate = pace / gap.abs().powf(order - 1.0);
            let hold = Power { rate, order, equilibrium, initial: equilibrium + gap };
            let exact = integrated(|strain| hold.strain_rate_at(strain), hold.initial, t);
            prop_assert!((hold.strain(t) - exact).abs() <= 1e-9, "{} {exact}", hold.strain(t));
            if pace * t < 10.0 {
                prop_assert!((hold.time_at(hold.strain(t)).unwrap() - t).abs() < 1e-7 * t.max(1.0));
            }
        }

        #[test]
        fn it_is_the_law_of_the_device(order in 1.0f64..9.0, gap in 0.01f64..0.3, t in 0.01f64..10.0) {
            let rate = 1.3 / gap.powf(order - 1.0);
            let law = shared::latency::Law::<f64>::new(rate, order, t).unwrap();
            let hold = Power { rate, order, equilibrium: 0.0, initial: gap };
            prop_assert!((hold.strain(t) - law.step(gap)).abs() < 1e-12);
        }
    }

    #[test]
    fn equations_7_4_and_7_5_as_printed() {
        // c and the bracket of the text, for both sides of the equilibrium.
        for (initial, equilibrium) in [(0.1, 0.3), (0.4, 0.3)] {
            let (n, nu, t) = (5.0_f64, 2e3_f64, 7.0_f64);
            let hold = Power { rate: nu, order: n, equilibrium, initial };
            let gap: f64 = f64::abs(initial - equilibrium);
            let c = gap.powf(1.0 - n) / (n - 1.0);
            let bracket = ((n - 1.0) * (nu * t + c)).powf(1.0 / (1.0 - n));
            let printed =
                if equilibrium > initial { equilibrium - bracket } else { equilibrium + bracket };
            assert!((hold.strain(t) - printed).abs() < 1e-15);
        }
    }

    #[test]
    fn a_strain_that_is_never_passed_has_no_time() {
        let hold = Power { rate: 1.0, order: 3.0, equilibrium: 0.0, initial: 0.2 };
        assert_eq!(hold.time_at(-0.1), None);
        assert_eq!(hold.time_at(0.3), None);
        assert_eq!(hold.time_at(0.0), None);
    }
}
