//! A steady vibration: a line of the spectrum that is none of the mains and is there at rest as under load, of the building, a fan, a pump
//! or the drive. No effect of the library is one, and it is no noise: its next period can be foretold.

use std::f64::consts::TAU;

use palpate_fit::fourier::Planner;
use palpate_fit::line::line_near;
use palpate_fit::problem::Problem;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::fitted::Fitted;
use super::hum::{STEPS, autocorrelation, centred, clean, near_the_mains, parts, square_of_line};
use super::residuals::Residuals;
use super::tail::log_tail;

/// A sine of one frequency in every stretch of recording, with an amplitude and a phase of its own in each.
#[derive(Clone, Debug, PartialEq)]
pub struct Vibration {
    /// Its frequency, Hz.
    pub frequency_hz: f64,
    /// Whether it was seen at rest off the specimen.
    pub at_rest: bool,
    /// Its amplitude, root mean square over the samples, in the unit of the signal.
    pub amplitude: f64,
    /// Fall of the sum of squares of the whitened residual.
    pub gain: f64,
    /// Logarithm of the chance of as large a fall under noise alone.
    pub log_chance: f64,
}

/// Periods in the longest rest, at least: what turns fewer times looks like a drift.
const PERIODS: usize = 6;
/// Part of the variance of the signal at rest that a line has, at least.
const SHARE: f64 = 0.1;
/// Chance of as high a line anywhere in the spectrum of noise, at most.
const CHANCE: f64 = 1e-8;
/// Widths of a line, as the longest rest shows it, from it to what is taken for the spectrum around it, and how far that goes.
const AROUND: std::ops::RangeInclusive<usize> = 2..=8;

/// Rests about their means, samples `interval` seconds apart, without the line that stands out of their spectrum, and its frequency, Hz;
/// none where no line does.
pub(super) fn without_vibration(
    mut rests: Vec<Vec<f64>>,
    interval: f64,
) -> (Vec<Vec<f64>>, Option<f64>) {
    let Some(turn) = line(&rests, interval) else { return (rests, None) };
    clean(&mut rests, turn);
    (rests, Some(turn / (TAU * interval)))
}

/// By how much the line that stands out most turns from sample to sample.
fn line(rests: &[Vec<f64>], interval: f64) -> Option<f64> {
    let parts = parts(rests);
    let longest = parts.iter().map(|part| part.len()).max()?;
    let powers = powers(&parts, longest);
    let squares: f64 = parts.iter().flat_map(|part| part.iter()).map(|value| value * value).sum();
    let law = ChiSquared::new(2.0 * parts.len() as f64).ok()?;
    let middle = law.inverse_cdf(0.5);
    let turn = |k: usize| TAU * k as f64 / (STEPS * longest) as f64;
    let far = (PERIODS * STEPS..powers.len())
        .filter(|&k| powers[k] > SHARE * squares)
        .filter(|&k| !near_the_mains(turn(k), interval));
    let (highest, over) = far
        .map(|k| (k, powers[k] / around(&powers, k).max(f64::MIN_POSITIVE)))
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    let told_apart = 0.5 * longest as f64;
    let stands_out = law.sf(over * middle) * told_apart < CHANCE;
    let line = powers[highest] * (1.0 - 1.0 / over);
    (stands_out && line > SHARE * squares).then(|| turn(highest))
}

/// Sum over the parts of 2/n |Σ y e^(−iωk)|² at each of the frequencies from 0 to half a turn a sample.
fn powers(parts: &[&[f64]], longest: usize) -> Vec<f64> {
    let mut planner = Planner::new();
    let products = autocorrelation(parts, longest, &mut planner);
    let transform = planner.forward(STEPS * longest);
    let mut input = transform.make_input_vec();
    input[..longest].copy_from_slice(&products);
    let mut output = transform.make_output_vec();
    // The lengths are the plan's own, the only thing it can refuse.
    let _ = transform.process(&mut input, &mut output);
    output.into_iter().map(|value| value.re.max(0.0)).collect()
}

/// The spectrum around a frequency: the larger of the medians below and above it, so that a slope has no line. Beyond half a turn a sample
/// it comes back.
fn around(powers: &[f64], k: usize) -> f64 {
    let last = powers.len() - 1;
    let reflected = |place: usize| powers[if place > last { 2 * last - place } else { place }];
    let side = |places: std::ops::Range<usize>| {
        let mut own: Vec<f64> = places.map(reflected).collect();
        own.sort_by(f64::total_cmp);
        own.get(own.len() / 2).copied().unwrap_or(0.0)
    };
    let (near, far) = (AROUND.start() * STEPS, AROUND.end() * STEPS);
    let below = side(k.saturating_sub(far).max(1)..k.saturating_sub(near).max(1));
    below.max(side((k + near).min(2 * last)..(k + far).min(2 * last)))
}

impl Vibration {
    /// The vibration that a model leaves near the frequency, Hz, of one in the rests.
    #[must_use]
    pub fn of(samples: &Problem, fitted: &Fitted, near: f64) -> Option<Self> {
        let problem = samples.with_chain(&fitted.chain);
        Self::near(&problem, &left_by(&problem, fitted), near)
    }

    /// The vibration that stands out of what a model leaves, wherever that is: of a model that leaves nothing slow.
    #[must_use]
    pub fn anywhere(samples: &Problem, fitted: &Fitted) -> Option<Self> {
        let problem = samples.with_chain(&fitted.chain);
        let left = left_by(&problem, fitted);
        let interval = problem.data().shortest_interval();
        let centred: Vec<Vec<f64>> = left.iter().cloned().map(centred).collect();
        let near = line(&centred, interval)? / (TAU * interval);
        Some(Self { at_rest: false, ..Self::near(&problem, &left, near)? })
    }

    fn near(problem: &Problem, left: &[Vec<f64>], near: f64) -> Option<Self> {
        let pieces = &problem.data().pieces;
        let stretches: Vec<(Vec<f64>, &[f64])> =
            pieces.iter().zip(left).map(|(piece, left)| (piece.set_time(), &left[..])).collect();
        let frequency = line_near(&stretches, near)?.frequency;
        let (mut square, mut gain) = (0.0, 0.0);
        for (index, (times, left)) in stretches.iter().enumerate() {
            let phase = |k: usize| TAU * frequency * times[k];
            square += square_of_line(left, phase);
            let mut white = left.to_vec();
            problem.whiten_residual(index, &mut white);
            gain += square_of_line(&white, phase);
        }
        Some(Self {
            frequency_hz: frequency,
            at_rest: true,
            amplitude: (2.0 * square / problem.data().samples() as f64).sqrt(),
            gain,
            log_chance: log_tail(gain, 2 * left.len(), false),
        })
    }
}

/// What a model leaves, stretch by stretch.
fn left_by(problem: &Problem, fitted: &Fitted) -> Vec<Vec<f64>> {
    Residuals::new(&fitted.chain, &fitted.values, problem.data()).values()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Rests with noise whose neighbours correlate, and a sine of this amplitude and frequency, with a phase of its own in each.
    fn rests(correlation: f64, amplitude: f64, hz: f64, interval: f64, seed: u64) -> Vec<Vec<f64>> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut rest = |length: usize| {
            let mut before = 0.0;
            let values = (0..length).map(|k| {
                let drawn: f64 = StandardNormal.sample(&mut random);
                before = correlation * before + (1.0 - correlation * correlation).sqrt() * drawn;
                before + amplitude * (TAU * hz * interval * k as f64 + length as f64).sin()
            });
            centred(values.collect())
        };
        [180, 220, 150, 260, 200, 90].map(&mut rest).into()
    }

    #[test]
    fn a_vibration_is_found_and_taken_off() {
        for (correlation, hz) in [(0.0, 12.3), (0.8, 7.1), (0.0, 34.0), (0.5, 31.0)] {
            let quiet = rests(correlation, 0.0, hz, 0.01, 5);
            let (cleaned, found) = without_vibration(rests(correlation, 1.2, hz, 0.01, 5), 0.01);
            let found = found.unwrap();
            assert!((found - hz).abs() < 0.1, "{found} Hz for {hz}");
            let square = |of: &[Vec<f64>]| of.concat().iter().map(|v| v * v).sum::<f64>();
            let ratio = square(&cleaned) / square(&quiet);
            assert!((0.9..1.05).contains(&ratio), "{ratio} of the noise is left at {hz} Hz");
        }
    }

    #[test]
    fn noise_has_no_line_and_that_of_the_mains_is_none() {
        for seed in 0..1500 {
            for correlation in [0.0, 0.5, 0.9, 0.98] {
                let noise = rests(correlation, 0.0, 1.0, 0.01, seed);
                assert_eq!(line(&noise, 0.01), None, "{correlation}, seed {seed}");
            }
        }
        assert_eq!(line(&rests(0.0, 2.0, 50.0, 0.004, 3), 0.004), None);
    }
}
