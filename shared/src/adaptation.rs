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
//! A memory is an `i64` in 2^-37 LSB. Only its upper part, an `i32` in 2^-7 LSB, is multiplied, so every product is one of
//! 32 × 32 → 64 bits; what lies below stays in the memory and is carried to the next sample (error feedback), so nothing
//! stalls however slow the signal. The multiplied part is off by at most 2^-8 LSB. The weights with which the equilibrium
//! remembers this are positive and sum to one, so the two memories move it by at most 2^-7 LSB; putting it out in 2^-6 LSB
//! adds at most 6 × 2^-8. Divided by c0 ≥ [`MIN_C0`] this is at most 1 LSB of the elastic input, and rounding to whole LSB
//! and the last bit of k_i and 1/c0 add less than 0.8.

use core::fmt;

use crate::fixed::{
    Coefficient, STRAIN_MAX, STRAIN_MIN, fraction_31, product, product_high, round_shift,
    saturate_to_24_bits,
};

/// Smallest equilibrium share c0: |u| ≤ full scale / c0 then fits, and its error stays below 2 LSB.
pub const MIN_C0: f64 = 1.0 / 32.0;

/// Shortest interval as a part of a time constant: below it the step drowns in the last bits of the coefficients.
pub const MIN_INTERVAL_PER_TIME_CONSTANT: f64 = 1.0 / (1_u32 << 24) as f64;

/// FA is rounded from half LSB: a memory has 37 fractional bits.
const BELOW_FA: u32 = 36;
/// A memory's upper part, the one that is multiplied, has 7 fractional bits.
const BELOW_MULTIPLIED: u32 = 30;
/// The equilibrium is put out from memories of 6 fractional bits: whole, it has two bits to spare.
const BELOW_EQUILIBRIUM: u32 = 31;
/// Memories are held within ±2^24 LSB, twice full scale.
const MEMORY_MAX: i64 = (1 << 61) - 1;
const MEMORY_MIN: i64 = -(1 << 61);
/// A memory of zero: half a unit of the multiplied part, so that cutting off what lies below rounds to nearest.
const NO_MEMORY: i64 = 1 << (BELOW_MULTIPLIED - 1);

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
    /// let mut state = State::at_rest(0);
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct State {
    fast: i64,
    slow: i64,
    signal: i32,
    saturations: u32,
}

impl State {
    /// A channel that has long been settled at `signal` (LSB): no memory, equilibrium at the signal. Start a recording with
    /// its first sample.
    #[must_use]
    pub const fn at_rest(signal: i32) -> Self {
        let signal = saturate_to_24_bits(signal as i64);
        Self { fast: NO_MEMORY, slow: NO_MEMORY, signal, saturations: 0 }
    }

    /// Takes the next sample (LSB of strain), one interval of `config` after the last. A sample beyond 24 bits is saturated
    /// and counted.
    #[inline]
    pub fn step(&mut self, config: &Config, signal: i32) -> Output {
        let signal = self.admit(signal);
        // 25 bits and six zeros: fits.
        let change = signal.wrapping_sub(self.signal) << 6;
        self.signal = signal;

        let (fast, slow) = (multiplied(self.fast), multiplied(self.slow));
        self.fast = config.fast.advance(self.fast, fast, slow, change);
        self.slow = config.slow.advance(self.slow, slow, fast, change);
        if overflows(self.fast) | overflows(self.slow) {
            self.saturate_memories();
        }

        let equilibrium = (signal << 6)
            .saturating_sub((self.fast >> BELOW_EQUILIBRIUM) as i32)
            .saturating_sub((self.slow >> BELOW_EQUILIBRIUM) as i32);
        Output {
            signal,
            fa: halve_rounded((self.fast >> BELOW_FA) as i32),
            equilibrium: halve_rounded(equilibrium >> 5),
            // 6 + 31 fractional bits, and 1/c0 is 32 times its coefficient.
            elastic: round_shift(product(equilibrium, config.inverse_c0), 32) as i32,
        }
    }

    /// Declares that the last sample now reads `signal`, as after a tare: the memories stay, the equilibrium moves along,
    /// and the next sample is not taken for a step.
    pub const fn rebase(&mut self, signal: i32) {
        self.signal = saturate_to_24_bits(signal as i64);
    }

    /// How many samples had to be saturated, on the way in or inside; stops at the largest `u32`.
    #[must_use]
    pub const fn saturations(&self) -> u32 {
        self.saturations
    }

    #[inline]
    fn admit(&mut self, signal: i32) -> i32 {
        if (STRAIN_MIN..=STRAIN_MAX).contains(&signal) {
            return signal;
        }
        self.saturations = self.saturations.saturating_add(1);
        signal.clamp(STRAIN_MIN, STRAIN_MAX)
    }

    /// Only an exchange of shares or rates can bring a memory here.
    #[cold]
    fn saturate_memories(&mut self) {
        self.saturations = self.saturations.saturating_add(1);
        self.fast = self.fast.clamp(MEMORY_MIN, MEMORY_MAX);
        self.slow = self.slow.clamp(MEMORY_MIN, MEMORY_MAX);
    }
}

impl Row {
    /// The memory one sample later; `own` and `other` are the multiplied parts of both memories.
    ///
    /// Memories are within 2^61, `own` and `other` within 2^31, `change` within 2^30, and the coefficients sum to less than
    /// three, so the result stays within 2^63.
    #[inline]
    fn advance(&self, memory: i64, own: i32, other: i32, change: i32) -> i64 {
        let low = product_high(own, self.own.low).wrapping_add(product_high(other, self.other.low));
        memory
            .wrapping_add(i64::from(low))
            .wrapping_add(product(change, self.change))
            .wrapping_add(product(own, self.own.high))
            .wrapping_add(product(other, self.other.high))
    }
}

#[inline]
const fn multiplied(memory: i64) -> i32 {
    (memory >> BELOW_MULTIPLIED) as i32
}

/// LSB from half LSB, halves upwards; |value| below 2^31.
#[inline]
const fn halve_rounded(value: i32) -> i32 {
    value.wrapping_add(1) >> 1
}

/// Whether a memory left ±2^61; looks at the upper word only.
#[inline]
const fn overflows(memory: i64) -> bool {
    ((memory >> 32) as i32).wrapping_add(1 << 29) as u32 >= 1 << 30
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
    fn a_channel_at_rest_has_no_memory() {
        let first = State::at_rest(123_456).step(&at_200_hz(), 123_456);
        assert_eq!((first.fa, first.latent()), (0, 0));
        assert_eq!(first.elastic, libm::round(123_456.0 / SUSHI.c0()) as i32);
    }

    #[test]
    fn a_press_relaxes_to_c0_of_its_elastic_input_and_a_partial_release_is_type_two() {
        // Eq. 3.6 after a ramp of the elastic input to 1,000,000 within one sample, and down to 600,000 after 20 s.
        let response = |t: f64| {
            let term =
                |c: f64, v: f64| c * -libm::expm1(-v * 0.005) / (v * 0.005) * libm::exp(-v * t);
            SUSHI.c0() + term(SUSHI.c1, SUSHI.v1) + term(SUSHI.c2, SUSHI.v2)
        };
        let config = at_200_hz();
        let mut state = State::at_rest(0);
        for i in 0..8_000 {
            let t = f64::from(i) * 0.005;
            let released = i >= 4_000;
            let force = 1e6 * response(t) - if released { 4e5 * response(t - 20.0) } else { 0.0 };
            let out = state.step(&config, libm::round(force) as i32);
            let u = if released { 600_000 } else { 1_000_000 };
            assert!((out.elastic - u).abs() <= 3, "sample {i}: {} for {u}", out.elastic);
            if i < 1_000 {
                assert!(out.latent() > 0, "held after a press the force must decay");
            }
            if (4_000..4_100).contains(&i) {
                assert!(out.latent() < 0, "held after a partial release the force must recover");
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
        let mut state = State::at_rest(0);
        let out = state.step(&at_200_hz(), i32::MAX);
        assert_eq!(out.signal, STRAIN_MAX);
        state.step(&at_200_hz(), i32::MIN);
        assert_eq!(state.saturations(), 2);
    }

    #[test]
    fn a_tare_moves_the_equilibrium_and_nothing_else() {
        let config = at_200_hz();
        let mut state = State::at_rest(0);
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
            let mut state = State::at_rest(0);
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
            let mut state = State::at_rest(0);
            for signal in samples {
                let out = state.step(&config, signal);
                prop_assert!((STRAIN_MIN..=STRAIN_MAX + 1).contains(&out.equilibrium));
                prop_assert!(out.elastic.unsigned_abs() <= 1 << 28);
            }
            prop_assert_eq!(state.saturations(), 0);
        }
    }
}
