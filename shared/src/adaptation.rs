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

use crate::fixed::{STRAIN_MAX, STRAIN_MIN, product_high_rounded, saturate_to_24_bits};

mod config;

pub use config::{Config, ConfigError, MIN_C0, MIN_INTERVAL_PER_TIME_CONSTANT, Relaxation};

/// A memory's upper part, the one that is multiplied, has 7 fractional bits.
const BELOW_MULTIPLIED: u32 = 30;
/// Memories are held within ±2^24 LSB, twice full scale.
const MEMORY_MAX: i64 = (1 << 61) - 1;
const MEMORY_MIN: i64 = -(1 << 61);
/// A memory of zero: half a unit of the multiplied part, so that cutting off what lies below rounds to nearest.
const NO_MEMORY: i64 = 1 << (BELOW_MULTIPLIED - 1);

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
    /// The last signal, 6 fractional bits.
    raised: i32,
    saturations: u32,
}

impl State {
    /// A channel that has long been settled at `signal` (LSB): no memory, equilibrium at the signal. Start a recording with
    /// its first sample.
    #[must_use]
    pub const fn at_rest(signal: i32) -> Self {
        let signal = saturate_to_24_bits(signal as i64);
        Self { fast: NO_MEMORY, slow: NO_MEMORY, raised: signal << 6, saturations: 0 }
    }

    /// Takes the next sample (LSB of strain), one interval of `config` after the last. A sample beyond 24 bits is saturated
    /// and counted.
    #[inline(always)]
    pub fn step(&mut self, config: &Config, signal: i32) -> Output {
        let admitted = signal.clamp(STRAIN_MIN, STRAIN_MAX);
        if admitted != signal {
            self.count_saturation();
        }
        self.advance(config, admitted);
        self.output(config)
    }

    /// Takes the next sample, of 24 bits; whether a memory had to be saturated.
    #[inline(always)]
    pub(crate) fn advance(&mut self, config: &Config, signal: i32) -> bool {
        let raised = signal << 6;
        // 25 bits and six zeros: fits.
        let change = raised.wrapping_sub(self.raised);
        self.raised = raised;

        let (fast, slow) = (multiplied(self.fast), multiplied(self.slow));
        self.fast = config.fast.advance(self.fast, fast, slow, change);
        self.slow = config.slow.advance(self.slow, slow, fast, change);
        let saturates = (beyond(self.fast) | beyond(self.slow)) >= 1 << 30;
        if saturates {
            self.saturate_memories();
        }
        saturates
    }

    /// What the filter says about its last sample.
    #[inline(always)]
    #[must_use]
    pub const fn output(&self, config: &Config) -> Output {
        let equilibrium = less(less(self.raised, self.fast), self.slow);
        Output {
            signal: self.raised >> 6,
            fa: upper_word(self.fast).wrapping_add(16) >> 5,
            equilibrium: halve_rounded(equilibrium >> 5),
            // 6 + 31 fractional bits, and 1/c0 is 32 times its coefficient.
            elastic: product_high_rounded(equilibrium, config.inverse_c0),
        }
    }

    /// Declares that the last sample now reads `signal`, as after a tare: the memories stay, the equilibrium moves along,
    /// and the next sample is not taken for a step.
    pub const fn rebase(&mut self, signal: i32) {
        self.raised = saturate_to_24_bits(signal as i64) << 6;
    }

    /// How many samples had to be saturated, on the way in or inside; stops at the largest `u32`.
    #[must_use]
    pub const fn saturations(&self) -> u32 {
        self.saturations
    }

    #[cold]
    fn count_saturation(&mut self) {
        self.saturations = self.saturations.saturating_add(1);
    }

    /// Only an exchange of shares or rates can bring a memory here.
    #[cold]
    fn saturate_memories(&mut self) {
        self.count_saturation();
        self.fast = self.fast.clamp(MEMORY_MIN, MEMORY_MAX);
        self.slow = self.slow.clamp(MEMORY_MIN, MEMORY_MAX);
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

/// A memory's upper word, 5 fractional bits.
#[inline]
const fn upper_word(memory: i64) -> i32 {
    (memory >> 32) as i32
}

/// A level of 6 fractional bits less a memory rounded down to them: twice its upper word and one bit of its lower. The
/// memory is at most four times as large as a signal, so only the second of two can make this saturate.
#[inline]
const fn less(level: i32, memory: i64) -> i32 {
    let (upper, bit) = (upper_word(memory), (memory as u32) >> 31);
    level.wrapping_sub(bit as i32).saturating_sub(upper.saturating_add(upper))
}

/// 2^30 or more where a memory left ±2^61: where the three highest bits differ.
#[inline]
const fn beyond(memory: i64) -> u32 {
    let upper = upper_word(memory);
    (upper ^ (upper << 1)) as u32
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
