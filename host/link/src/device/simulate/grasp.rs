//! What the gauges of a simulated fingertip feel: press, hold, release, rest, over and over, through the relaxation of
//! silicone.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use shared::pipeline::GAUGES;
use shared::wire::{Capabilities, Inputs, Settings};

use palpate_analysis::decomposition::default_relaxation;

/// Strain of each gauge without relaxation when fully pressed, µε.
const PRESSED: [f64; GAUGES] = [900.0, 620.0, -340.0, 280.0];
/// Strain of each bridge at rest, µε, as from glueing.
const OFFSET: [f64; GAUGES] = [31.0, -18.0, 9.0, 44.0];
/// Noise, µε.
const NOISE: f64 = 0.1;
/// Course of one grasp: at this time (s) the finger is pressed in so far, in between linearly.
const COURSE: [(f64, f64); 6] =
    [(0.0, 0.0), (1.0, 0.0), (1.4, 1.0), (4.4, 1.0), (4.7, 0.0), (7.0, 0.0)];
const PERIOD_S: f64 = 7.0;
/// How much later each further finger of a hand presses, s, and with what part of the strength of the one before.
const LATER_S: f64 = 0.25;
const GENTLER: f64 = 0.85;

/// A fingertip that grasps.
pub(super) struct Grasp {
    noise: ChaCha8Rng,
    scatter: Option<Normal<f64>>,
    /// This much later than the first finger, s, and with this part of its strength.
    later_s: f64,
    strength: f64,
    time_s: f64,
    pressed: f64,
    /// Relaxing parts, as fractions of the fully pressed.
    relaxing: [Branch; 2],
}

/// One exponential of the relaxation function: x' = −v x + u'.
struct Branch {
    share: f64,
    rate: f64,
    value: f64,
}

impl Grasp {
    pub(super) fn new(seed: u64, finger: u8) -> Self {
        let relaxation = default_relaxation();
        let branch = |share, rate| Branch { share, rate, value: 0.0 };
        Self {
            noise: ChaCha8Rng::seed_from_u64(seed),
            scatter: Normal::new(0.0, NOISE).ok(),
            later_s: LATER_S * f64::from(finger),
            strength: GENTLER.powi(finger.into()),
            time_s: 0.0,
            pressed: 0.0,
            relaxing: [branch(relaxation.c1, relaxation.v1), branch(relaxation.c2, relaxation.v2)],
        }
    }

    /// Raw counts at a time, of what the converter measures, with its gains.
    pub(super) fn measured(
        &mut self,
        inputs: Inputs,
        time_us: u64,
        gain: &[u8; GAUGES],
    ) -> [i32; GAUGES] {
        let own = match inputs {
            Inputs::Gauges => return self.counts(time_us, gain),
            Inputs::Shorted => 0,
            Inputs::TestSignal => Capabilities::ads131m04(0).test_counts,
        };
        std::array::from_fn(|gauge| {
            let noise = self.scatter.map_or(0.0, |scatter| scatter.sample(&mut self.noise));
            own + (noise / Settings::DEFAULT.calibration[gauge].gain) as i32
        })
    }

    fn counts(&mut self, time_us: u64, gain: &[u8; GAUGES]) -> [i32; GAUGES] {
        let felt = self.feel(time_us as f64 * 1e-6);
        let sheet = &Settings::DEFAULT.calibration;
        let mut counts = [0; GAUGES];
        for (gauge, counts) in counts.iter_mut().enumerate() {
            let noise = self.scatter.map_or(0.0, |scatter| scatter.sample(&mut self.noise));
            let strain = PRESSED[gauge] * felt + OFFSET[gauge] + noise;
            // The default calibration is that of the default gain.
            let amplified = f64::from(gain[gauge]) / f64::from(Settings::DEFAULT.gain[gauge]);
            let full = strain / sheet[gauge].gain * amplified;
            *counts = full.round().clamp(-8_388_608.0, 8_388_607.0) as i32;
        }
        counts
    }

    /// The signal at a time that does not go back, as a fraction of the fully pressed.
    fn feel(&mut self, time_s: f64) -> f64 {
        // After a reset the device's time begins anew.
        let passed = (time_s - self.time_s).max(0.0);
        let pressed = self.strength * course((time_s - self.later_s).max(0.0) % PERIOD_S);
        let moved = pressed - self.pressed;
        (self.time_s, self.pressed) = (time_s, pressed);
        let mut signal = pressed;
        for Branch { share, rate, value } in &mut self.relaxing {
            let decay = (-*rate * passed).exp();
            // Exact where the motion is linear in between.
            let built = if passed > 0.0 { (1.0 - decay) / (*rate * passed) } else { 1.0 };
            *value = *value * decay + moved * built;
            signal += *share * (*value - pressed);
        }
        signal
    }
}

fn course(time_s: f64) -> f64 {
    let leg = COURSE.windows(2).find(|leg| time_s < leg[1].0);
    leg.map_or(0.0, |leg| {
        let ((from_s, from), (to_s, to)) = (leg[0], leg[1]);
        from + (to - from) * (time_s - from_s) / (to_s - from_s)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_held_press_relaxes_and_a_release_undershoots() {
        let mut grasp = Grasp::new(1, 0);
        let at: Vec<f64> = (0..7_000).map(|ms| grasp.feel(f64::from(ms) * 1e-3)).collect();
        assert!(at[999].abs() < 1e-12);
        assert!(at[1_400] > 0.8 && at[4_399] < at[1_400] - 0.2, "{} {}", at[1_400], at[4_399]);
        assert!(at[4_701] < -0.1 && at[6_999] > at[4_701]);
    }

    #[test]
    fn a_further_finger_presses_later_and_more_gently() {
        let most = |finger| {
            let mut grasp = Grasp::new(1, finger);
            let felt = (0..7_000_i32).map(|ms| (grasp.feel(f64::from(ms) * 1e-3), ms));
            felt.fold((0.0, 0), |most, one| if one.0 > most.0 { one } else { most })
        };
        let ((first, at), (third, later)) = (most(0), most(2));
        assert!((third / first - 0.7225).abs() < 1e-9, "{first} {third}");
        assert!((later - at - 500).abs() <= 1, "{at} {later}");
    }

    #[test]
    fn the_same_seed_feels_the_same_and_half_the_gain_half_as_much() {
        let run = |seed, gain: u8| {
            let mut grasp = Grasp::new(seed, 0);
            (0..100).map(|i| grasp.counts(i * 30_000, &[gain; GAUGES])[0]).collect::<Vec<_>>()
        };
        assert_eq!(run(3, 128), run(3, 128));
        assert_ne!(run(3, 128), run(4, 128));
        for (full, half) in run(3, 128).iter().zip(run(3, 64)) {
            assert!((full - 2 * half).abs() <= 1);
        }
    }
}
