//! Noise of a displacement that its signal would show, and does not: the specimen never went so. A law takes it for motion, and what
//! smooths it, a lag or a delay, then seems to be missing.

use std::ops::Range;

use super::Trace;
use super::control::range;
use super::local_lines::smoothed;
use super::scatter::{scatter, second_differences};

/// The noise of a displacement that its signal does not follow.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionNoise {
    /// Which trace of the set, from 0.
    pub index: usize,
    /// Its name.
    pub trace: String,
    /// Standard deviation of one sample, mm.
    pub standard_deviation_mm: f64,
}

/// Part of the noise of the signal from which that of the displacement matters in it.
const MATTERS: f64 = 0.05;
/// Part of the mean stiffness that a signal shows at least where it follows the displacement from sample to sample.
const FOLLOWS: f64 = 0.5;
/// Standard errors by which it must be less.
const SURE: f64 = 2.0;
/// Standard deviations up to which a sample tells of noise: beyond them the motion turns, or the signal jumps.
const NOISE: f64 = 4.0;
/// Part of its range by which the signal is off its value without displacement where the specimen is touched.
const LOADED: f64 = 0.1;
/// By how many times neighbouring second differences, which share samples, make the variance of their products larger.
const SHARED: f64 = 1.94;
/// Fewest samples that tell.
const MIN_SAMPLES: f64 = 200.0;
/// Correlation of neighbouring second differences up to which they are of noise: −2/3 where it is independent from sample to sample, 1 where a
/// motion bends.
const ALTERNATE: f64 = -0.25;
/// Samples in the middle of a trace from which its scatter is taken: noise is the same everywhere.
const LOOKED_AT: usize = 100_000;

/// The traces of a set whose displacement is noisy: none unless that matters in the signal of one of them, and the signals of all
/// together do not follow it.
#[must_use]
pub fn motion_noise(traces: &[Trace], signal: &str) -> Vec<MotionNoise> {
    let of = |(index, trace): (usize, &Trace)| {
        let x = trace.displacement()?;
        let standard_deviation_mm = scatter_of(trace, x);
        let noisy = standard_deviation_mm > 0.0 && alternates(trace, x, standard_deviation_mm);
        noisy.then(|| MotionNoise { index, trace: trace.label(), standard_deviation_mm })
    };
    let noisy: Vec<MotionNoise> = traces.iter().enumerate().filter_map(of).collect();
    let matter = |own: &MotionNoise| matters(&traces[own.index], signal, own);
    if !noisy.iter().any(matter) || follows(traces, signal, &noisy) {
        return Vec::new();
    }
    noisy
}

impl MotionNoise {
    /// The displacement of its trace without the noise, mm.
    #[must_use]
    pub fn smoothed(&self, trace: &Trace) -> Option<Vec<f64>> {
        Some(smoothed(&trace.time, trace.displacement()?, self.standard_deviation_mm))
    }
}

/// Signal over displacement, both over their whole range.
fn stiffness(trace: &Trace, signal: &str) -> Option<f64> {
    Some(range(trace.column(signal)?) / range(trace.displacement()?))
}

/// Whether the signal would show the noise.
fn matters(trace: &Trace, signal: &str, own: &MotionNoise) -> bool {
    let Some(stiffness) = stiffness(trace, signal) else { return false };
    let scatter = trace.column(signal).map(|values| scatter_of(trace, values));
    scatter.is_some_and(|scatter| own.standard_deviation_mm * stiffness > MATTERS * scatter)
}

/// The samples in the middle of a trace.
fn middle(trace: &Trace) -> Range<usize> {
    let from = trace.len().saturating_sub(LOOKED_AT) / 2;
    from..trace.len() - from
}

/// Standard deviation of the scatter of a column of a trace, from its middle.
fn scatter_of(trace: &Trace, values: &[f64]) -> f64 {
    scatter(&trace.time[middle(trace)], &values[middle(trace)])
}

/// Whether what scatters so goes up and down from sample to sample.
fn alternates(trace: &Trace, x: &[f64], deviation: f64) -> bool {
    let (mut of_pairs, mut of_each, mut before) = (0.0, 0.0, 0.0);
    for own in second_differences(&trace.time[middle(trace)], &x[middle(trace)]) {
        let own = if own.abs() <= NOISE * deviation { own } else { 0.0 };
        of_pairs += before * own;
        of_each += own * own;
        before = own;
    }
    of_pairs < ALTERNATE * of_each
}

/// Whether signals follow the noise of their displacements, as they do where it is motion: a slope of their second differences that is
/// not surely less than half of the mean stiffness. So few samples that nothing is sure count as that.
fn follows(traces: &[Trace], signal: &str, noisy: &[MotionNoise]) -> bool {
    let mut sums = Sums::default();
    for own in noisy {
        sums.add(&traces[own.index], signal, own.standard_deviation_mm);
    }
    sums.count < MIN_SAMPLES || sums.slope() + SURE * sums.standard_error() > FOLLOWS
}

/// Sums over second differences where the specimen is loaded: of the displacement, times the stiffness, and of the signal.
#[derive(Default)]
struct Sums {
    of_motion: f64,
    of_signal: f64,
    of_both: f64,
    count: f64,
}

impl Sums {
    fn add(&mut self, trace: &Trace, signal: &str, deviation: f64) {
        let (Some(x), Some(values)) = (trace.displacement(), trace.column(signal)) else { return };
        let Some(stiffness) = stiffness(trace, signal).filter(|it| it.is_finite()) else { return };
        let zero = x.iter().zip(values).min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        let Some((_, &zero)) = zero else { return };
        let loaded = LOADED * range(values);
        let most = NOISE * scatter_of(trace, values);
        let motions = second_differences(&trace.time, x);
        let signals = second_differences(&trace.time, values);
        for ((motion, own), value) in motions.zip(signals).zip(&values[1..]) {
            let is_noise = motion.abs() <= NOISE * deviation && own.abs() <= most;
            if is_noise && (value - zero).abs() > loaded {
                let expected = stiffness * motion;
                self.of_motion += expected * expected;
                self.of_signal += own * own;
                self.of_both += expected * own;
                self.count += 1.0;
            }
        }
    }

    /// Change of the signal for a change of the displacement, over the mean stiffness.
    fn slope(&self) -> f64 {
        self.of_both / self.of_motion
    }

    fn standard_error(&self) -> f64 {
        (SHARED * self.of_signal / (self.of_motion * self.count)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DISPLACEMENT, FORCE};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// A press to 5 mm with a hold, mm.
    fn motion(t: f64) -> f64 {
        (8.0 * (t - 1.0)).min(5.0 - 8.0 * (t - 4.0)).clamp(0.0, 5.0)
    }

    /// A press of 2 N/mm at 200 Hz whose displacement is read with noise, and moves with more.
    fn press(read: f64, moved: f64) -> Trace {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut drawn = |deviation: f64| -> f64 {
            let drawn: f64 = StandardNormal.sample(&mut random);
            deviation * drawn
        };
        let time: Vec<f64> = (0..1200).map(|k| f64::from(k) / 200.0).collect();
        let at: Vec<f64> = time.iter().map(|&t| motion(t) + drawn(moved)).collect();
        let x = at.iter().map(|at| at + drawn(read)).collect();
        let force = at.iter().map(|at| 2.0 * at.max(0.0) + drawn(0.01)).collect();
        let mut trace = Trace { time, ..Trace::default() };
        trace.set_column(DISPLACEMENT, x);
        trace.set_column(FORCE, force);
        trace
    }

    #[test]
    fn noise_that_the_force_does_not_follow_is_no_motion() {
        let trace = press(0.02, 0.0);
        let found = motion_noise(std::slice::from_ref(&trace), FORCE);
        assert_eq!(found.len(), 1);
        let deviation = found[0].standard_deviation_mm;
        assert!((deviation - 0.02).abs() < 0.002, "{deviation}");
        let error = |x: &[f64]| {
            let off = trace.time.iter().zip(x).map(|(&t, x)| (x - motion(t)).powi(2));
            (off.sum::<f64>() / x.len() as f64).sqrt()
        };
        let (before, after) =
            (error(trace.displacement().unwrap()), error(&found[0].smoothed(&trace).unwrap()));
        assert!(after < 0.3 * before, "{before} to {after}");
    }

    #[test]
    fn a_motion_that_the_force_follows_stays_as_it_is() {
        assert_eq!(motion_noise(&[press(0.0, 0.02)], FORCE), []);
        assert_eq!(motion_noise(&[press(0.0, 0.0)], FORCE), []);
        // Nor what the force would not show.
        assert_eq!(motion_noise(&[press(0.001, 0.0)], FORCE), []);
    }
}
