//! Held while the hand shakes: a load that changes at 1 to 12 Hz, as a tremor or a walk makes it. Nothing is let go of and
//! nothing slips.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{Fingertip, Indenter, SensorError, Stroke, Touch, clock, feel, within};

/// How to press and shake.
#[derive(Clone, Debug, PartialEq)]
pub struct Shake {
    /// With what.
    pub indenter: Indenter,
    /// Depth about which it shakes, mm.
    pub depth_mm: f64,
    /// Root mean square of the shaking, as a part of the depth.
    pub part: f64,
    /// Where, x and y, mm.
    pub place_mm: [f64; 2],
    /// Slowest and fastest of the shaking, Hz.
    pub band_hz: [f64; 2],
    /// How long it shakes, s.
    pub duration_s: f64,
    /// Samples per second.
    pub rate_hz: f64,
}

/// Rest before the press, s; how far off the tip starts, mm; how fast it comes and goes, mm/s; time in which the shaking
/// begins and ends, s; how many tones there are.
const REST_S: f64 = 0.5;
const OFF_MM: f64 = 0.2;
const PRESS_MM_PER_S: f64 = 10.0;
const FADE_S: f64 = 0.5;
const TONES: usize = 24;

impl Shake {
    /// A blunt tip 0.3 mm deep above the first gauge that shakes by 5 % at 1 to 12 Hz for 20 s, at 1 kHz.
    #[must_use]
    pub const fn above_first_gauge(fingertip: &Fingertip) -> Self {
        Self {
            indenter: Indenter::BLUNT,
            depth_mm: 0.3,
            part: 0.05,
            place_mm: fingertip.gauges_mm[0],
            band_hz: [1.0, 12.0],
            duration_s: 20.0,
            rate_hz: 1000.0,
        }
    }

    /// Presses, shakes, releases. The seed is that of the shaking and of the noise.
    ///
    /// # Errors
    /// [`SensorError`] for what cannot be done so.
    pub fn run(&self, fingertip: &Fingertip, seed: u64) -> Result<Touch, SensorError> {
        let [slowest, fastest] = self.band_hz;
        within("the rate (Hz)", self.rate_hz, 10.0, 1e5)?;
        within("the depth (mm)", self.depth_mm, 1e-3, 1e3)?;
        within("the part that shakes", self.part, 0.0, 0.3)?;
        within("the fastest of the shaking (Hz)", fastest, 1e-3, 0.25 * self.rate_hz)?;
        within("the slowest of the shaking (Hz)", slowest, 1e-3, fastest)?;
        within("the duration (s)", self.duration_s, 2.0 * FADE_S, 1e5)?;
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x5348_414b);
        // So many tones of equal strength have a root mean square of one.
        let strength = (2.0 / TONES as f64).sqrt();
        let tones: Vec<(f64, f64)> = (0..TONES)
            .map(|_| (random.random_range(slowest..=fastest), random.random_range(0.0..TAU)))
            .collect();
        let down_s = REST_S + (OFF_MM + self.depth_mm) / PRESS_MM_PER_S;
        let up_s = down_s + self.duration_s;
        let time = clock(up_s + 1.0, self.rate_hz)?;
        let shaking = |t: f64| {
            let fade = ((t - down_s) / FADE_S).min((up_s - t) / FADE_S).clamp(0.0, 1.0);
            let fade = 0.5 - 0.5 * (0.5 * TAU * fade).cos();
            let sum: f64 = tones.iter().map(|(hz, phase)| (TAU * hz * t + phase).sin()).sum();
            self.part * self.depth_mm * fade * strength * sum
        };
        let depth = |t: f64| {
            let down = (t - REST_S) * PRESS_MM_PER_S - OFF_MM;
            let up = self.depth_mm - (t - up_s) * PRESS_MM_PER_S;
            down.min(up).clamp(-OFF_MM, self.depth_mm) + shaking(t)
        };
        let stroke = Stroke {
            depth_mm: time.iter().map(|t| depth(*t)).collect(),
            place_mm: vec![self.place_mm; time.len()],
            pull_n: Vec::new(),
            time,
        };
        let name = format!("held while it shakes at {slowest} to {fastest} Hz");
        feel(fingertip, self.indenter, &stroke, &name, seed)
    }
}
