//! The latency model: strain moves towards its equilibrium at a rate set by how far away it is.
//!
//! Linear, ε̇ = −ν (ε − ε_e) (eq. 4.9), and power law, ε̇ = −ν sgn(ε − ε_e) |ε − ε_e|^n (eq. 7.2; linear is n = 1). With the
//! gap e = ε − ε_e and a constant ε_e, one step over Δt has a closed form, eqs. 4.5, 7.4 and 7.5 written for both signs:
//!
//! ```text
//! e⁺ = e exp(−ν Δt)                                          n = 1
//! e⁺ = e (1 + (n−1) ν |e|^(n−1) Δt)^(−1/(n−1))               n > 1
//! ```
//!
//! So a step is exact for any Δt, never overshoots and is unconditionally stable. (The footnote of section 4.2.2 finds the
//! equilibrium "by assuming t → 0"; it is t → ∞ that leads there.)
//!
//! # One definition
//! Both laws, in `f64` and in fixed point, are the few lines of [`Law::step`]. It works with logarithms to base 2 because
//! r = ν Δt |e|^(n−1) runs over hundreds of powers of two: with k = n − 1 the gap is multiplied by exp(−x), where
//! x = r for k = 0 and x = ln(1 + k r) / k otherwise.

use core::fmt;
use core::ops::{Add, Sub};

mod fixed_point;

pub use fixed_point::FixedGap;

/// A gap e = ε − ε_e and the arithmetic that one step of the latency model needs.
pub trait Gap: Copy {
    /// A logarithm to base 2.
    type Log: Copy + Add<Output = Self::Log> + Sub<Output = Self::Log>;

    /// The logarithm whose value is `value`, |value| < 2^19.
    fn log(value: f64) -> Self::Log;
    /// log2 |e|; `None` when the gap is closed.
    fn log2(self) -> Option<Self::Log>;
    /// `factor` (a number, not the logarithm of one) times `log`.
    fn times(factor: Self::Log, log: Self::Log) -> Self::Log;
    /// log2 ln(1 + 2^log).
    fn log2_ln_1p(log: Self::Log) -> Self::Log;
    /// e exp(−2^log): towards zero, never across it.
    #[must_use]
    fn decayed(self, log: Self::Log) -> Self;
}

/// Why a [`Law`] cannot be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LawError {
    /// ν is not a positive finite number.
    Rate(f64),
    /// n is below 1, above [`MAX_ORDER`] or not a number.
    Order(f64),
    /// Δt is not a positive finite number.
    Interval(f64),
}

impl fmt::Display for LawError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Rate(rate) => write!(f, "rate {rate} must be positive and finite"),
            Self::Order(order) => write!(f, "order {order} must lie between 1 and {MAX_ORDER}"),
            Self::Interval(interval) => {
                write!(f, "interval of {interval} s must be positive and finite")
            }
        }
    }
}

impl core::error::Error for LawError {}

/// Largest exponent n of the power law.
pub const MAX_ORDER: f64 = 64.0;

/// The latency model with its parameters and an interval: `Law<f64>` or `Law<FixedGap>`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law<G: Gap> {
    /// log2 (ν Δt).
    log_pace: G::Log,
    /// k = n − 1 and its logarithm; `None` for the linear law.
    excess: Option<(G::Log, G::Log)>,
}

impl<G: Gap> Law<G> {
    /// `rate` ν in 1/(s · unit^(n−1)), where unit is that of the gap: for `f64` any, for [`FixedGap`] the microstrain;
    /// `order` n, a real number from 1 (linear) to [`MAX_ORDER`]; `interval_s` Δt in s.
    ///
    /// # Errors
    /// [`LawError`] says which argument is out of range.
    ///
    /// ```
    /// use palpate_shared::latency::{FixedGap, Law};
    /// // Order 5 as in section 7.3: a gap of 200 µε closes to 100 µε in 1.5 s.
    /// let rate = (0.01_f64.powi(4) - 0.005_f64.powi(4)) / 4.0 / 1.5;
    /// let law = Law::<f64>::new(rate, 5.0, 1.5)?;
    /// assert!((law.step(200.0) - 100.0).abs() < 1e-9);
    /// let law = Law::<FixedGap>::new(rate, 5.0, 1.5)?;
    /// assert!((law.step(FixedGap::from_microstrain(200.0)).microstrain() - 100.0).abs() < 1e-6);
    /// # Ok::<(), palpate_shared::latency::LawError>(())
    /// ```
    pub fn new(rate: f64, order: f64, interval_s: f64) -> Result<Self, LawError> {
        if !(rate.is_finite() && rate > 0.0) {
            return Err(LawError::Rate(rate));
        }
        if !(1.0..=MAX_ORDER).contains(&order) {
            return Err(LawError::Order(order));
        }
        if !(interval_s.is_finite() && interval_s > 0.0) {
            return Err(LawError::Interval(interval_s));
        }
        let k = order - 1.0;
        Ok(Self {
            log_pace: G::log(libm::log2(rate) + libm::log2(interval_s)),
            excess: (k > 0.0).then(|| (G::log(k), G::log(libm::log2(k)))),
        })
    }

    /// The gap one interval later.
    #[must_use]
    #[allow(clippy::arithmetic_side_effects, reason = "logarithms of both kinds saturate")]
    pub fn step(&self, gap: G) -> G {
        let Some(log_gap) = gap.log2() else { return gap };
        let log_x = match self.excess {
            None => self.log_pace,
            Some((k, log_k)) => {
                let log_r = self.log_pace + G::times(k, log_gap);
                G::log2_ln_1p(log_k + log_r) - log_k
            }
        };
        gap.decayed(log_x)
    }
}

impl Gap for f64 {
    type Log = f64;

    fn log(value: f64) -> f64 {
        value
    }

    fn log2(self) -> Option<f64> {
        (self != 0.0).then(|| libm::log2(libm::fabs(self)))
    }

    fn times(factor: f64, log: f64) -> f64 {
        factor * log
    }

    fn log2_ln_1p(log: f64) -> f64 {
        // Beyond 2^±60, ln(1 + z) is ln z or z to the last bit, and 2^log may not be a number.
        if log > 60.0 {
            libm::log2(log * core::f64::consts::LN_2)
        } else if log < -60.0 {
            log
        } else {
            libm::log2(libm::log1p(libm::exp2(log)))
        }
    }

    fn decayed(self, log: f64) -> f64 {
        self * libm::exp(-libm::exp2(log))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Eqs. 7.4 and 7.5, and for n = 1 the exponential of eq. 4.5, as printed.
    fn closed_form(e0: f64, equilibrium: f64, rate: f64, n: f64, t: f64) -> f64 {
        let e = equilibrium;
        if n == 1.0 {
            return e + (e0 - e) * libm::exp(-rate * t);
        }
        if e > e0 {
            let c = libm::pow(e - e0, 1.0 - n) / (n - 1.0);
            e - libm::pow((n - 1.0) * (rate * t + c), 1.0 / (1.0 - n))
        } else {
            let c = libm::pow(e0 - e, 1.0 - n) / (n - 1.0);
            e + libm::pow((n - 1.0) * (rate * t + c), 1.0 / (1.0 - n))
        }
    }

    /// Order, gap (µε, either sign) and a rate for which the gap closes noticeably within some seconds.
    fn any_case() -> impl Strategy<Value = (f64, f64, f64, f64)> {
        let order = prop_oneof![Just(1.0), 1.001..8.0_f64, (1_u8..6).prop_map(f64::from)];
        (order, 0.01..30_000_f64, any::<bool>(), 0.01..10_f64, 0.001..5_f64).prop_map(
            |(n, gap, negative, pace, t)| {
                let gap = if negative { -gap } else { gap };
                (n, gap, pace / libm::pow(gap.abs(), n - 1.0), t)
            },
        )
    }

    #[test]
    fn linear_law_is_the_decay_of_eq_4_5() {
        // ε_c = −(N0/α)(c0 + c1 e^(−v1 t)): starts at −(N0/α)(c0 + c1), ends at −(N0/α) c0.
        let (scale, c0, c1, v1) = (2.0, 0.6, 0.4, 3.7);
        let law = Law::<f64>::new(v1, 1.0, 0.8).unwrap();
        let strain = -scale * c0 + law.step(-scale * c1);
        let expected = -scale * (c0 + c1 * libm::exp(-v1 * 0.8));
        assert!((strain - expected).abs() <= 1e-15 * expected.abs());
    }

    #[test]
    fn arguments_out_of_range_are_refused() {
        assert_eq!(Law::<f64>::new(0.0, 1.0, 1.0), Err(LawError::Rate(0.0)));
        assert_eq!(Law::<f64>::new(1.0, 0.5, 1.0), Err(LawError::Order(0.5)));
        assert_eq!(Law::<f64>::new(1.0, 2.0, -1.0), Err(LawError::Interval(-1.0)));
        assert!(matches!(Law::<FixedGap>::new(1.0, f64::NAN, 1.0), Err(LawError::Order(_))));
    }

    #[test]
    fn nothing_overflows_between_extreme_gaps_and_rates() {
        for rate in [1e-300, 1.0, 1e300] {
            for gap in [1e-300, 1.0, 1e300] {
                for n in [1.0, 1.0 + 1e-12, 5.0, 64.0] {
                    let next = Law::<f64>::new(rate, n, 1.0).unwrap().step(gap);
                    assert!((0.0..=gap).contains(&next), "{rate} {gap} {n}: {next}");
                }
            }
        }
    }

    proptest! {
        #[test]
        fn f64_step_is_the_closed_form_to_one_in_1e12((n, gap, rate, t) in any_case()) {
            let expected = closed_form(gap, 0.0, rate, n, t);
            let got = Law::<f64>::new(rate, n, t).unwrap().step(gap);
            prop_assert!((got - expected).abs() <= 1e-12 * expected.abs(), "{got} for {expected}");
        }

        #[test]
        fn strain_follows_the_closed_form_about_any_equilibrium(
            (n, gap, rate, t) in any_case(), equilibrium in -10_000.0..10_000_f64,
        ) {
            let expected = closed_form(equilibrium + gap, equilibrium, rate, n, t);
            let got = equilibrium + Law::<f64>::new(rate, n, t).unwrap().step(gap);
            prop_assert!((got - expected).abs() <= 1e-9 * (gap.abs() + equilibrium.abs()));
        }

        #[test]
        fn many_short_steps_end_where_one_long_step_does((n, gap, rate, t) in any_case(), parts in 2_u8..100) {
            let short = Law::<f64>::new(rate, n, t / f64::from(parts)).unwrap();
            let once = Law::<f64>::new(rate, n, t).unwrap().step(gap);
            let many = (0..parts).fold(gap, |gap, _| short.step(gap));
            prop_assert!((once - many).abs() <= 1e-11 * gap.abs());
        }

        #[test]
        fn the_gap_shrinks_without_overshoot_and_alike_on_both_sides((n, gap, rate, t) in any_case()) {
            let law = Law::<f64>::new(rate, n, t).unwrap();
            let next = law.step(gap);
            prop_assert!(next.abs() <= gap.abs() && next * gap >= 0.0);
            prop_assert_eq!(law.step(-gap), -next);
        }

        #[test]
        fn fixed_point_step_is_the_closed_form_to_5e_12_of_the_gap_and_one_unit((n, gap, rate, t) in any_case()) {
            let gap = FixedGap::from_microstrain(gap);
            let expected = closed_form(gap.microstrain(), 0.0, rate, n, t);
            let got = Law::<FixedGap>::new(rate, n, t).unwrap().step(gap).microstrain();
            let allowed = 5e-12 * gap.microstrain().abs() + FixedGap::RESOLUTION_MICROSTRAIN;
            prop_assert!((got - expected).abs() <= allowed, "{got} for {expected}");
        }

        #[test]
        fn fixed_point_steps_may_be_short_or_long((n, gap, rate, t) in any_case(), parts in 2_u8..100) {
            let gap = FixedGap::from_microstrain(gap);
            let short = Law::<FixedGap>::new(rate, n, t / f64::from(parts)).unwrap();
            let once = Law::<FixedGap>::new(rate, n, t).unwrap().step(gap).microstrain();
            let many = (0..parts).fold(gap, |gap, _| short.step(gap)).microstrain();
            let allowed = 1e-10 * gap.microstrain().abs() + f64::from(parts) * FixedGap::RESOLUTION_MICROSTRAIN;
            prop_assert!((once - many).abs() <= allowed, "{many} for {once}");
        }

        #[test]
        fn fixed_point_never_panics_or_overshoots_and_is_alike_on_both_sides(
            raw: i64, rate_exponent in -300.0..300.0_f64, n in 1.0..=MAX_ORDER, t_exponent in -300.0..300.0_f64,
        ) {
            let law = Law::<FixedGap>::new(libm::exp10(rate_exponent), n, libm::exp10(t_exponent)).unwrap();
            let next = law.step(FixedGap::from_bits(raw)).bits();
            prop_assert!(next.unsigned_abs() <= raw.unsigned_abs());
            prop_assert!(next == 0 || (next > 0) == (raw > 0));
            if raw != i64::MIN {
                prop_assert_eq!(law.step(FixedGap::from_bits(-raw)).bits(), -next);
            }
        }
    }
}
