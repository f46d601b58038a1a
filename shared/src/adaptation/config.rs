//! The relaxation function and the integer coefficients made of it.

use core::fmt;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use crate::fixed::{Coefficient, fraction_31, product, product_high};

/// Smallest equilibrium share c0: |u| ≤ full scale / c0 then fits, and its error stays below 2 LSB.
pub const MIN_C0: f64 = 1.0 / 32.0;

/// Shortest interval as a part of a time constant: below it the step drowns in the last bits of the coefficients.
pub const MIN_INTERVAL_PER_TIME_CONSTANT: f64 = 1.0 / (1_u32 << 24) as f64;

/// The relaxation function g(t) = c0 + c1 e^(−v1 t) + c2 e^(−v2 t), eq. 3.4; c0 = 1 − c1 − c2.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Relaxation {
    /// Share of the fast term, 0 … 1.
    pub c1: f64,
    /// Rate of the fast term, 1/s.
    pub v1: f64,
    /// Share of the slow term, 0 … 1.
    pub c2: f64,
    /// Rate of the slow term, 1/s; at most `v1`.
    pub v2: f64,
}

impl Relaxation {
    /// Share that never relaxes.
    #[must_use]
    pub fn c0(&self) -> f64 {
        1.0 - self.c1 - self.c2
    }
}

/// Why a [`Config`] cannot be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConfigError {
    /// A share (`c1` or `c2`) is negative, above one or not a number.
    Share {
        /// Name of the parameter.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// c0 = 1 − c1 − c2 is below [`MIN_C0`].
    Equilibrium {
        /// The value of c0.
        c0: f64,
    },
    /// A rate (`v1` or `v2`) is not a positive finite number.
    Rate {
        /// Name of the parameter.
        name: &'static str,
        /// Its value, 1/s.
        value: f64,
    },
    /// The first term must be the fast one: `v1` < `v2`.
    Order {
        /// Rate of the first term, 1/s.
        v1: f64,
        /// Rate of the second term, 1/s.
        v2: f64,
    },
    /// The interval is not a positive finite number, or below [`MIN_INTERVAL_PER_TIME_CONSTANT`] of the slow time constant.
    Interval {
        /// The interval, s.
        interval_s: f64,
        /// The slow time constant, s.
        time_constant_s: f64,
    },
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Share { name, value } => write!(f, "{name} = {value} must lie between 0 and 1"),
            Self::Equilibrium { c0 } => {
                write!(f, "c0 = 1 - c1 - c2 = {c0} must be at least {MIN_C0}")
            }
            Self::Rate { name, value } => {
                write!(f, "{name} = {value} 1/s must be positive and finite")
            }
            Self::Order { v1, v2 } => write!(
                f,
                "the first term must be the fast one, but v1 = {v1} 1/s is below v2 = {v2} 1/s: exchange the terms"
            ),
            Self::Interval { interval_s, time_constant_s } => write!(
                f,
                "a sample interval of {interval_s} s must be positive, finite and at least 2^-24 of the time constant {time_constant_s} s"
            ),
        }
    }
}

impl core::error::Error for ConfigError {}

/// One relaxation function at one sample interval, as integers; serves any number of channels.
///
/// It may be exchanged between samples. The memories are strains and stay what they are, so `s`, FA, SA, equilibrium and
/// latent part do not jump and FA + SA = s holds throughout; the elastic input jumps by the ratio of the c0 if those
/// differ. A recording that is not uniform in time is filtered exactly with one configuration for each distinct interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    pub(super) fast: Row,
    pub(super) slow: Row,
    /// 1/(32 c0), 31 fractional bits.
    pub(super) inverse_c0: i32,
}

/// Coefficients of one memory's increment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Row {
    /// −d_i (1 − k_i): on the memory itself.
    own: Coefficient,
    /// k_i d_j: on the other memory.
    other: Coefficient,
    /// k_i: on the change of the signal; 31 fractional bits.
    change: i32,
}

impl Config {
    /// Coefficients for samples `interval_s` seconds apart.
    ///
    /// Meant for 100 Hz to 4 kHz and time constants of 5 ms to 60 s; accepts any interval down to 2^-24 of the slow time
    /// constant, without upper limit.
    ///
    /// # Errors
    /// [`ConfigError`] names the parameter that is out of range.
    ///
    /// ```
    /// use palpate_shared::adaptation::{Config, Relaxation, State};
    /// let sushi = Relaxation { c1: 0.2472, v1: 3.981, c2: 0.2676, v2: 0.5325 }; // eq. 3.6
    /// let config = Config::new(&sushi, 1.0 / 200.0)?;
    /// let mut state = State::at_rest(0);
    /// let touched = state.step(&config, 100_000);
    /// assert_eq!(touched.fa + touched.sa(), 100_000);
    /// assert!(touched.latent() > 0); // the force will decay: Type I
    /// # Ok::<(), palpate_shared::adaptation::ConfigError>(())
    /// ```
    pub fn new(relaxation: &Relaxation, interval_s: f64) -> Result<Self, ConfigError> {
        validate(relaxation, interval_s)?;
        let Relaxation { c1, v1, c2, v2 } = *relaxation;
        let c0 = relaxation.c0();
        let d1 = -libm::expm1(-v1 * interval_s);
        let d2 = -libm::expm1(-v2 * interval_s);
        let k1_over_r = c1 * d1 / (v1 * interval_s);
        let k2_over_r = c2 * d2 / (v2 * interval_s);
        let r = 1.0 / (c0 + k1_over_r + k2_over_r);
        let (k1, k2) = (k1_over_r * r, k2_over_r * r);
        Ok(Self {
            fast: Row::new(d1, k1, d2),
            slow: Row::new(d2, k2, d1),
            inverse_c0: fraction_31(MIN_C0 / c0),
        })
    }
}

impl Row {
    fn new(d_own: f64, k: f64, d_other: f64) -> Self {
        Self {
            own: Coefficient::from_f64(-d_own * (1.0 - k)),
            other: Coefficient::from_f64(k * d_other),
            change: fraction_31(k),
        }
    }
}

fn validate(relaxation: &Relaxation, interval_s: f64) -> Result<(), ConfigError> {
    let Relaxation { c1, v1, c2, v2 } = *relaxation;
    for (name, value) in [("c1", c1), ("c2", c2)] {
        if !(0.0..=1.0).contains(&value) {
            return Err(ConfigError::Share { name, value });
        }
    }
    if relaxation.c0() < MIN_C0 {
        return Err(ConfigError::Equilibrium { c0: relaxation.c0() });
    }
    for (name, value) in [("v1", v1), ("v2", v2)] {
        if !(value.is_finite() && value > 0.0) {
            return Err(ConfigError::Rate { name, value });
        }
    }
    if v1 < v2 {
        return Err(ConfigError::Order { v1, v2 });
    }
    let long_enough = interval_s * v2 >= MIN_INTERVAL_PER_TIME_CONSTANT;
    if !(long_enough && (interval_s * v1).is_finite()) {
        return Err(ConfigError::Interval { interval_s, time_constant_s: 1.0 / v2 });
    }
    Ok(())
}

impl Row {
    /// The memory one sample later; `own` and `other` are the multiplied parts of both memories.
    ///
    /// Memories are within 2^61, `own` and `other` within 2^31, `change` within 2^30, and the coefficients sum to less than
    /// three, so the result stays within 2^63.
    #[inline]
    pub(super) fn advance(&self, memory: i64, own: i32, other: i32, change: i32) -> i64 {
        let low = product_high(own, self.own.low).wrapping_add(product_high(other, self.other.low));
        memory
            .wrapping_add(product(own, self.own.high))
            .wrapping_add(product(other, self.other.high))
            .wrapping_add(product(change, self.change))
            .wrapping_add(i64::from(low))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SUSHI: Relaxation = Relaxation { c1: 0.2472, v1: 3.981, c2: 0.2676, v2: 0.5325 };

    #[test]
    fn parameters_out_of_range_are_refused_by_name() {
        let refused = |r: Relaxation, t: f64| Config::new(&r, t).unwrap_err();
        let share = refused(Relaxation { c1: -0.1, ..SUSHI }, 0.005);
        assert_eq!(share, ConfigError::Share { name: "c1", value: -0.1 });
        assert!(matches!(
            refused(Relaxation { c2: f64::NAN, ..SUSHI }, 0.005),
            ConfigError::Share { name: "c2", .. }
        ));
        let little = Relaxation { c1: 0.5, c2: 0.49, ..SUSHI };
        assert!(matches!(refused(little, 0.005), ConfigError::Equilibrium { .. }));
        assert!(matches!(
            refused(Relaxation { v2: 0.0, ..SUSHI }, 0.005),
            ConfigError::Rate { name: "v2", .. }
        ));
        assert!(matches!(
            refused(Relaxation { v1: 0.1, ..SUSHI }, 0.005),
            ConfigError::Order { .. }
        ));
        for interval in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9] {
            assert!(matches!(refused(SUSHI, interval), ConfigError::Interval { .. }));
        }
    }
}
