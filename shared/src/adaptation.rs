//! The dual-exponential filter: gauge signal → FA + SA, elastic input, equilibrium, latent part.
//!
//! # The model
//! The relaxation function g(t) = c0 + c1 e^(−v1 t) + c2 e^(−v2 t) (eq. 3.4, c0 + c1 + c2 = 1) turns an input `u` without
//! memory into the signal s = c0 u + y1 + y2, where y_i' = −v_i y_i + c_i u'. The filter runs this backwards: from `s` it
//! finds the fast memory y1, the slow memory y2 and `u`.
//!
//! # One sample
//! With `u` linear between samples the model's step over an interval T is exact, with d_i = 1 − e^(−v_i T) and
//! b_i = d_i / (v_i T). Solved for the memories, with R = 1/(c0 + c1 b1 + c2 b2), k_i = c_i b_i R and Δs = s⁺ − s:
//!
//! ```text
//! y1⁺ = y1 − d1 (1 − k1) y1 + k1 d2 y2 + k1 Δs
//! y2⁺ = y2 − d2 (1 − k2) y2 + k2 d1 y1 + k2 Δs
//! ```
//!
//! Only multiplications and additions, on a positive system: for every sequence of intervals |y_i| stays below twice full
//! scale and the equilibrium c0 u = s − y1 − y2 within full scale, because it is a moving average of `s`.
//!
//! # Fixed point
//! A memory is an `i32` in 2^-6 LSB and a remainder of 31 bits below it: what one sample's increment leaves over is carried
//! to the next (error feedback). So the multiplications are 32 × 32 → 64 bits, and nothing stalls however slow the signal.
//! The memory is rounded by at most 2^-7 LSB when it is multiplied and again when it is put out; since the weights with
//! which the equilibrium remembers that rounding are positive and sum to one, the equilibrium is off by at most 2^-5 LSB
//! before its own rounding, and the elastic input by 1/(32 c0) ≤ 1 LSB. [`MIN_C0`] is chosen for this.

use core::fmt;

use crate::fixed::{
    Coefficient, STRAIN_MAX, STRAIN_MIN, product, product_high, round_shift, round_to_i32,
};

/// Smallest equilibrium share c0: |u| ≤ full scale / c0 then fits, and its error stays below 2 LSB.
pub const MIN_C0: f64 = 1.0 / 32.0;

/// Shortest interval as a part of a time constant: below it the step drowns in the last bits of the coefficients.
pub const MIN_INTERVAL_PER_TIME_CONSTANT: f64 = 1.0 / (1_u32 << 24) as f64;

/// Fractional bits of a memory, in LSB.
const MEMORY_FRACTION_BITS: u32 = 6;
/// Bits of the remainder below a memory.
const REMAINDER_BITS: u32 = 31;
/// Memories are held within ±2^24 LSB, twice full scale.
const MEMORY_MAX: i32 = (1 << 30) - 1;
const MEMORY_MIN: i32 = -(1 << 30);

/// The relaxation function g(t) = c0 + c1 e^(−v1 t) + c2 e^(−v2 t), eq. 3.4; c0 = 1 − c1 − c2.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    fast: Row,
    slow: Row,
    /// 1/(32 c0), 31 fractional bits.
    inverse_c0: i32,
}

/// Coefficients of one memory's increment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Row {
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
    /// use shared::adaptation::{Config, Relaxation, State};
    /// let sushi = Relaxation { c1: 0.2472, v1: 3.981, c2: 0.2676, v2: 0.5325 }; // eq. 3.6
    /// let config = Config::new(&sushi, 1.0 / 200.0)?;
    /// let mut state = State::new();
    /// state.step(&config, 0);
    /// let touched = state.step(&config, 100_000);
    /// assert_eq!(touched.fa + touched.sa(), 100_000);
    /// assert!(touched.latent() > 0); // the force will decay: Type I
    /// # Ok::<(), shared::adaptation::ConfigError>(())
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

fn fraction_31(value: f64) -> i32 {
    round_to_i32(value * 2_147_483_648.0)
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

/// What the filter says about one sample; all in LSB of strain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    /// The signal, saturated to 24 bits.
    pub signal: i32,
    /// Fast adapting part, c1 x1: what the fast term still remembers; zero when held.
    pub fa: i32,
    /// Where the signal will settle if the motion stops now, c0 u.
    pub equilibrium: i32,
    /// Elastic input `u`: the response a specimen without memory would give to the same motion.
    pub elastic: i32,
}

impl Output {
    /// Slow adapting part, c0 u + c2 x2; FA + SA is the signal, bit for bit.
    #[must_use]
    pub const fn sa(&self) -> i32 {
        self.signal.wrapping_sub(self.fa)
    }

    /// Distance from the equilibrium: positive while the signal decays (Type I), negative while it recovers (Type II).
    /// Equilibrium + latent is the signal, bit for bit.
    #[must_use]
    pub const fn latent(&self) -> i32 {
        self.signal.wrapping_sub(self.equilibrium)
    }
}

/// What one channel remembers between samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct State {
    fast: Memory,
    slow: Memory,
    previous: Option<i32>,
    saturations: u32,
}

/// A memory y_i: `value` in 2^-6 LSB, already rounded, and what it was rounded by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Memory {
    value: i32,
    /// 0 … 2^31 − 1 in 2^-37 LSB; the exact memory is value × 2^-6 + (remainder − 2^30) × 2^-37.
    remainder: i32,
}

impl Default for Memory {
    fn default() -> Self {
        Self { value: 0, remainder: 1 << (REMAINDER_BITS - 1) }
    }
}

impl State {
    /// A channel that has seen nothing. Its first sample is taken as settled: equilibrium at that sample, no memory.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes the next sample (LSB of strain; saturated to 24 bits, and counted if it had to be).
    pub fn step(&mut self, config: &Config, signal: i32) -> Output {
        let clamped = signal.clamp(STRAIN_MIN, STRAIN_MAX);
        self.count(clamped != signal);
        let signal = clamped;
        // At most 25 bits and six zeros: fits.
        let change = signal.wrapping_sub(self.previous.unwrap_or(signal)) << MEMORY_FRACTION_BITS;
        self.previous = Some(signal);

        let (fast, slow) = (self.fast.value, self.slow.value);
        let saturated = self.fast.advance(&config.fast, change, slow)
            | self.slow.advance(&config.slow, change, fast);
        self.count(saturated);

        let (fast, slow) = (self.fast.value, self.slow.value);
        let equilibrium =
            (signal << MEMORY_FRACTION_BITS).saturating_sub(fast).saturating_sub(slow);
        Output {
            signal,
            fa: round_memory(fast),
            equilibrium: round_memory(equilibrium),
            // 2^-6 LSB × 2^-31, times the 32 taken out of 1/c0: 32 fractional bits.
            elastic: round_shift(product(equilibrium, config.inverse_c0), 32) as i32,
        }
    }

    /// Declares that the last sample now reads `signal`, as after a tare: the memories stay, the equilibrium moves along,
    /// and the next sample is not taken for a step. Without effect before the first sample.
    pub fn rebase(&mut self, signal: i32) {
        if self.previous.is_some() {
            self.previous = Some(signal.clamp(STRAIN_MIN, STRAIN_MAX));
        }
    }

    /// How often a sample or a memory had to be saturated; stops at the largest `u32`.
    #[must_use]
    pub const fn saturations(&self) -> u32 {
        self.saturations
    }

    fn count(&mut self, saturated: bool) {
        self.saturations = self.saturations.saturating_add(u32::from(saturated));
    }
}

impl Memory {
    /// Adds one sample's increment; true if the memory had to be saturated, which only a change of configuration can cause.
    ///
    /// Ranges: |change| and |memories| ≤ 2^30, and the coefficients of a row sum to less than 2, so the increment stays
    /// below 2^62 and its upper part below 2^31; the three low products stay below 2^30 each.
    fn advance(&mut self, row: &Row, change: i32, other: i32) -> bool {
        let low =
            product_high(self.value, row.own.low).wrapping_add(product_high(other, row.other.low));
        let increment = i64::from(self.remainder)
            .wrapping_add(i64::from(low))
            .wrapping_add(product(change, row.change))
            .wrapping_add(product(self.value, row.own.high))
            .wrapping_add(product(other, row.other.high));
        let wanted = self.value.saturating_add((increment >> REMAINDER_BITS) as i32);
        self.value = wanted.clamp(MEMORY_MIN, MEMORY_MAX);
        self.remainder = increment as i32 & i32::MAX;
        self.value != wanted
    }
}

/// LSB of a number in 2^-6 LSB, rounded.
const fn round_memory(value: i32) -> i32 {
    round_shift(value as i64, MEMORY_FRACTION_BITS) as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SUSHI: Relaxation = Relaxation { c1: 0.2472, v1: 3.981, c2: 0.2676, v2: 0.5325 };

    fn at_200_hz() -> Config {
        Config::new(&SUSHI, 0.005).unwrap()
    }

    #[test]
    fn the_first_sample_is_taken_as_settled() {
        let first = State::new().step(&at_200_hz(), 123_456);
        assert_eq!((first.fa, first.latent()), (0, 0));
        assert_eq!(first.elastic, libm::round(123_456.0 / SUSHI.c0()) as i32);
    }

    #[test]
    fn a_press_relaxes_to_c0_of_its_elastic_input_and_a_partial_release_is_type_two() {
        // The signal of eq. 3.6 for a step of the elastic input to 1,000,000, then down to 600,000 after 20 s.
        let g = |t: f64| {
            SUSHI.c0() + SUSHI.c1 * libm::exp(-SUSHI.v1 * t) + SUSHI.c2 * libm::exp(-SUSHI.v2 * t)
        };
        let config = at_200_hz();
        let mut state = State::new();
        state.step(&config, 0);
        for i in 0..8_000 {
            // A ramp over one interval is what the filter takes a jump for; g follows from its end on.
            let t = f64::from(i) * 0.005;
            let b = |v: f64| -libm::expm1(-v * 0.005) / (v * 0.005);
            let ramp = |t: f64| {
                SUSHI.c0()
                    + SUSHI.c1 * b(SUSHI.v1) * libm::exp(-SUSHI.v1 * t)
                    + SUSHI.c2 * b(SUSHI.v2) * libm::exp(-SUSHI.v2 * t)
            };
            assert!(ramp(t) <= g(t));
            let s = 1e6 * ramp(t) - if i >= 4_000 { 4e5 * ramp(t - 20.0) } else { 0.0 };
            let out = state.step(&config, libm::round(s) as i32);
            let u = if i >= 4_000 { 600_000 } else { 1_000_000 };
            assert!((out.elastic - u).abs() <= 3, "sample {i}: {} for {u}", out.elastic);
            if (4_000..4_100).contains(&i) {
                assert!(out.latent() < 0, "held after a partial release the force must recover");
            }
            if i < 1_000 {
                assert!(out.latent() > 0, "held after a press the force must decay");
            }
        }
    }

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

    #[test]
    fn a_signal_beyond_24_bits_is_saturated_and_counted() {
        let mut state = State::new();
        let out = state.step(&at_200_hz(), i32::MAX);
        assert_eq!(out.signal, STRAIN_MAX);
        state.step(&at_200_hz(), i32::MIN);
        assert_eq!(state.saturations(), 2);
    }

    #[test]
    fn a_tare_moves_the_equilibrium_and_nothing_else() {
        let config = at_200_hz();
        let mut state = State::new();
        state.step(&config, 0);
        let before = state.step(&config, 50_000);
        let mut tared = state;
        tared.rebase(1_000);
        let (next, shifted) = (state.step(&config, 50_100), tared.step(&config, 1_100));
        assert_eq!(next.fa, shifted.fa);
        assert_eq!(next.latent(), shifted.latent());
        assert!(before.latent() > next.latent());
    }

    fn any_config() -> impl Strategy<Value = Config> {
        (0.0..0.95_f64, 0.0..1.0_f64, -4.0..5.0_f64, -4.0..0.0_f64, 100.0..4000.0_f64).prop_map(
            |(sum, share, log_v1, log_ratio, rate)| {
                let v1 = libm::exp(log_v1);
                let c1 = sum * share;
                let v2 = v1 * libm::exp(log_ratio);
                Config::new(&Relaxation { c1, v1, c2: sum - c1, v2 }, 1.0 / rate).unwrap()
            },
        )
    }

    proptest! {
        #[test]
        fn any_signal_and_any_exchange_of_configurations_keeps_both_sums_and_never_panics(
            configs in prop::collection::vec(any_config(), 1..5),
            samples in prop::collection::vec((any::<i32>(), 0_usize..5), 1..200),
        ) {
            let mut state = State::new();
            for (signal, which) in samples {
                let out = state.step(&configs[which % configs.len()], signal);
                prop_assert_eq!(out.fa + out.sa(), signal.clamp(STRAIN_MIN, STRAIN_MAX));
                prop_assert_eq!(out.equilibrium + out.latent(), out.signal);
                prop_assert!(out.fa.abs() <= 1 << 24);
            }
        }

        #[test]
        fn without_exchange_nothing_inside_saturates_and_the_equilibrium_stays_in_range(
            config in any_config(),
            samples in prop::collection::vec(STRAIN_MIN..=STRAIN_MAX, 1..500),
        ) {
            let mut state = State::new();
            for signal in samples {
                let out = state.step(&config, signal);
                prop_assert!((STRAIN_MIN..=STRAIN_MAX + 1).contains(&out.equilibrium));
                prop_assert!(out.elastic.unsigned_abs() <= 1 << 28);
            }
            prop_assert_eq!(state.saturations(), 0);
        }
    }
}
