//! Sinusoidal stimuli from slow to fast: gain and phase of FA and SA, measured and as the filter's own formula says.

use std::f64::consts::TAU;

use nalgebra::{Complex, Matrix5, Vector5};
use shared::adaptation::Relaxation;

use super::{Fingertip, Indenter, SensorError, Stroke, Touch, channels, clock, feel, within};

/// A series of tones, one after the other: depth = mean + amplitude sin(2πft).
#[derive(Clone, Debug, PartialEq)]
pub struct Tones {
    /// With what.
    pub indenter: Indenter,
    /// Lowest frequency, Hz.
    pub from_hz: f64,
    /// Highest frequency, Hz.
    pub to_hz: f64,
    /// How many, evenly on a logarithmic scale; two at least.
    pub count: usize,
    /// Mean depth, mm.
    pub depth_mm: f64,
    /// Amplitude, mm; below the depth, so that contact is kept.
    pub amplitude_mm: f64,
    /// Samples per second; more than twice the highest frequency.
    pub rate_hz: f64,
}

impl Default for Tones {
    /// 0.1 to 400 Hz in 19 tones of 0.02 mm about 0.4 mm with the blunt tip, at 4 kHz.
    fn default() -> Self {
        Self {
            indenter: Indenter::BLUNT,
            from_hz: 0.1,
            to_hz: 400.0,
            count: 19,
            depth_mm: 0.4,
            amplitude_mm: 0.02,
            rate_hz: 4000.0,
        }
    }
}

/// Gain and phase of one channel, relative to the reading of silicone without memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// Amplitude over that of the reading without memory.
    pub gain: f64,
    /// Lead, degrees.
    pub phase_deg: f64,
}

impl Response {
    fn of(ratio: Complex<f64>) -> Self {
        Self { gain: ratio.norm(), phase_deg: ratio.arg().to_degrees() }
    }
}

/// One tone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tone {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// FA as measured.
    pub fa: Response,
    /// SA as measured.
    pub sa: Response,
    /// FA by the formula of the filter at this rate.
    pub fa_formula: Response,
    /// SA by the formula of the filter at this rate.
    pub sa_formula: Response,
    /// Largest distance between measured and formula in the complex plane, of FA and SA.
    pub distance: f64,
}

/// The tones and what they gave.
#[derive(Clone, Debug)]
pub struct TonesResult {
    /// The whole series, felt by the fingertip.
    pub touch: Touch,
    /// Tone by tone.
    pub tones: Vec<Tone>,
}

/// A tone lasts this many periods, and this long, s, at least.
const PERIODS: f64 = 3.0;
const SHORTEST_S: f64 = 0.5;
/// Rest on the mean depth before the first tone, s.
const REST_S: f64 = 2.0;

impl Tones {
    /// The frequencies, Hz.
    #[must_use]
    pub fn frequencies(&self) -> Vec<f64> {
        let last = self.count.saturating_sub(1).max(1) as f64;
        let part = |k| (self.to_hz / self.from_hz).powf(k as f64 / last);
        (0..self.count).map(|k| self.from_hz * part(k)).collect()
    }

    /// Presses a fingertip with the tones, over its first gauge, and measures the channels of that gauge.
    ///
    /// # Errors
    /// [`SensorError`] for what cannot be done so.
    pub fn run(&self, fingertip: &Fingertip, seed: u64) -> Result<TonesResult, SensorError> {
        self.check()?;
        let spans = self.spans();
        let end_s = spans.last().map_or(REST_S, |span| span.1);
        let time = clock(end_s, self.rate_hz)?;
        let depth = |t: f64| match spans.iter().find(|span| t >= span.0 && t < span.1) {
            Some((from, _, f)) => self.depth_mm + self.amplitude_mm * (TAU * f * (t - from)).sin(),
            None => self.depth_mm,
        };
        let stroke = Stroke {
            depth_mm: time.iter().map(|t| depth(*t)).collect(),
            place_mm: vec![fingertip.gauges_mm[0]; time.len()],
            time,
            pull_n: Vec::new(),
        };
        let name = format!("{} tones from {} Hz to {} Hz", self.count, self.from_hz, self.to_hz);
        let touch = feel(fingertip, self.indenter, &stroke, &name, seed)?;
        let [first, ..] = channels(&touch.trace, &fingertip.settings())?;
        let relaxation = fingertip.relaxation_of_readings();
        let tones = spans.iter().map(|&(from, to, frequency_hz)| {
            let time = &touch.trace.time;
            let range = time.partition_point(|t| *t < from)..time.partition_point(|t| *t < to);
            let measure = |values: &[f64]| {
                fundamental(
                    &time[range.clone()],
                    &values[range.clone()],
                    from,
                    frequency_hz,
                    &relaxation,
                )
            };
            let input = measure(&touch.elastic[0]);
            let (fa, sa) = (measure(&first.fa) / input, measure(&first.sa) / input);
            let formula = filter_response(&relaxation, frequency_hz, 1.0 / self.rate_hz);
            Tone {
                frequency_hz,
                fa: Response::of(fa),
                sa: Response::of(sa),
                fa_formula: Response::of(formula.0),
                sa_formula: Response::of(formula.1),
                distance: (fa - formula.0).norm().max((sa - formula.1).norm()),
            }
        });
        Ok(TonesResult { tones: tones.collect(), touch })
    }

    fn check(&self) -> Result<(), SensorError> {
        within("the number of tones", self.count as f64, 2.0, 1000.0)?;
        within("the rate (Hz)", self.rate_hz, 10.0, 1e5)?;
        within("the lowest frequency (Hz)", self.from_hz, 1e-3, 0.49 * self.rate_hz)?;
        within("the highest frequency (Hz)", self.to_hz, self.from_hz, 0.49 * self.rate_hz)?;
        within("the mean depth (mm)", self.depth_mm, 1e-6, 1e3)?;
        within("the amplitude (mm)", self.amplitude_mm, 1e-9, 0.5 * self.depth_mm)
    }

    /// Begin and end, s, and frequency, Hz, of each tone: whole periods.
    fn spans(&self) -> Vec<(f64, f64, f64)> {
        let mut from = REST_S;
        let span = |f: f64| {
            let begin = from;
            from += PERIODS.max((SHORTEST_S * f).ceil()) / f;
            (begin, from, f)
        };
        self.frequencies().into_iter().map(span).collect()
    }
}

/// Amplitude and phase of a tone that began at `from`: least squares of a constant, the two modes dying out, cosine and
/// sine. The filter is linear, so nothing else is there but the harmonics of the contact, which are orthogonal.
fn fundamental(
    time: &[f64],
    values: &[f64],
    from: f64,
    frequency_hz: f64,
    relaxation: &Relaxation,
) -> Complex<f64> {
    let (mut curvature, mut right) = (Matrix5::zeros(), Vector5::zeros());
    for (t, value) in time.iter().zip(values) {
        let t = t - from;
        let (sin, cos) = (TAU * frequency_hz * t).sin_cos();
        let modes = [(-relaxation.v1 * t).exp(), (-relaxation.v2 * t).exp()];
        let row = Vector5::new(cos, sin, 1.0, modes[0], modes[1]);
        curvature += row * row.transpose();
        right += row * *value;
    }
    let found = curvature.svd(true, true).solve(&right, 1e-14).unwrap_or_default();
    // cos and sin of a wave: its real part is Re[(a − ib) e^(iωt)].
    Complex::new(found[0], -found[1])
}

/// Response of FA and SA to a reading without memory at a frequency, with samples `interval_s` apart: each mode is
/// c b (z − 1)/(z − a), a = e^(−vT), b = (1 − a)/(vT), z = e^(iωT), which is exact for input that is linear between samples.
pub(super) fn filter_response(
    relaxation: &Relaxation,
    frequency_hz: f64,
    interval_s: f64,
) -> (Complex<f64>, Complex<f64>) {
    let z = Complex::cis(TAU * frequency_hz * interval_s);
    let one = Complex::new(1.0, 0.0);
    let mode = |share: f64, rate: f64| {
        let lost = -(-rate * interval_s).exp_m1();
        (z - one) / (z - one + lost) * (share * lost / (rate * interval_s))
    };
    let fa = mode(relaxation.c1, relaxation.v1);
    let sa = mode(relaxation.c2, relaxation.v2) + relaxation.c0();
    (fa, sa)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::Silicone;

    #[test]
    fn the_formula_is_that_of_the_differential_equation_far_below_the_rate() {
        let relaxation = Relaxation { c1: 0.2, v1: 4.0, c2: 0.3, v2: 0.5 };
        for f in [0.01, 0.1, 1.0, 10.0] {
            let iw = Complex::new(0.0, TAU * f);
            let (fa, sa) = filter_response(&relaxation, f, 1e-5);
            assert!((fa - iw / (iw + 4.0) * 0.2).norm() < 1e-6);
            assert!((sa - (iw / (iw + 0.5) * 0.3 + 0.5)).norm() < 1e-6);
        }
    }

    #[test]
    fn measured_and_formula_agree_over_all_tones() {
        let fingertip = Fingertip::new(Silicone::of("7:3".parse().unwrap()), 4.0).unwrap();
        let tones = Tones { from_hz: 0.3, count: 9, ..Tones::default() };
        let result = tones.run(&fingertip, 3).unwrap();
        for tone in &result.tones {
            assert!(tone.distance < 2e-3, "{tone:?}");
        }
        let gains: Vec<f64> = result.tones.iter().map(|tone| tone.fa.gain).collect();
        assert!(gains.windows(2).all(|pair| pair[1] > pair[0] - 2e-3), "{gains:?}");
    }

    #[test]
    fn tones_beyond_half_the_rate_are_refused() {
        let fingertip = Fingertip::new(Silicone::of("7:3".parse().unwrap()), 4.0).unwrap();
        let tones = Tones { rate_hz: 500.0, ..Tones::default() };
        let error = tones.run(&fingertip, 1).unwrap_err().to_string();
        assert!(error.contains("highest frequency"), "{error}");
    }
}
