//! The derivative of noisy data, sampled evenly or not: local least squares with a stated bandwidth.
//!
//! At each instant a parabola is fitted to the samples within a half width (Savitzky and Golay's filter,
//! with times as they are); its slope is the derivative. The half width is the smallest, in steps of a
//! fifth, whose noise is small against the fastest rate, up to a tenth of the record. Within a half width of
//! either end a slope would rest on one side only, with ten times the noise: none is given there.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};
use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

/// Noise of the derivative, as a share of the largest, that ends the widening.
const NOISE_SHARE: f64 = 0.05;
/// Widest half width, as a share of the record.
const MAX_HALF_WIDTH: f64 = 0.1;
/// Fewest samples of a window.
const MIN_WINDOW: usize = 5;

/// A derivative at some instants, and what it can show.
#[derive(Clone, Debug, PartialEq)]
pub struct Derivative {
    /// Instants, s.
    pub time: Vec<f64>,
    /// Value of the local parabola there.
    pub smoothed: Vec<f64>,
    /// Its slope, per s.
    pub slope: Vec<f64>,
    /// Samples within so many seconds on each side are used; more where fewer than five are.
    pub half_width_s: f64,
    /// Frequency at which the slope of a sine comes out 3 dB too small, Hz, in the middle of the record;
    /// none where its samples are too few to tell.
    pub bandwidth_hz: Option<f64>,
    /// Standard deviation of the slope for noise of deviation 1, 1/s, in the middle of the record.
    pub noise_gain: f64,
    /// Whether the noise is as small as the rule asks.
    pub quiet: bool,
}

/// The derivative of `values` at `count` instants spread over the samples; `noise` is the standard
/// deviation of one sample. None for fewer than five samples.
#[must_use]
pub fn derivative(time: &[f64], values: &[f64], noise: f64, count: usize) -> Option<Derivative> {
    let samples = time.len();
    if samples < MIN_WINDOW || values.len() != samples {
        return None;
    }
    let length = time[samples - 1] - time[0];
    let step = samples.div_ceil(count.max(2)).max(1);
    let instants: Vec<usize> = (0..samples).step_by(step).collect();
    let mut half_width_s = 2.0 * length / (samples - 1) as f64;
    loop {
        let found = with_width(time, values, &instants, half_width_s);
        let fastest = found.slope.iter().fold(0.0, |most: f64, slope| most.max(slope.abs()));
        let quiet = found.noise_gain * noise <= NOISE_SHARE * fastest;
        if quiet || 1.2 * half_width_s > MAX_HALF_WIDTH * length {
            return Some(Derivative { quiet, ..found });
        }
        half_width_s *= 1.2;
    }
}

fn with_width(time: &[f64], values: &[f64], instants: &[usize], half_width_s: f64) -> Derivative {
    let (first, last) = (time[0] + half_width_s, time[time.len() - 1] - half_width_s);
    let inside = |k: &usize| (first..=last).contains(&time[*k]);
    let inside: Vec<usize> = instants.iter().copied().filter(inside).collect();
    let instants = if inside.is_empty() { &instants[instants.len() / 2..][..1] } else { &inside };
    let (smoothed, slope) = instants
        .iter()
        .map(|&k| {
            let window = window(time, k, half_width_s);
            let weights = weights(&time[window.clone()], time[k]);
            weights
                .iter()
                .zip(&values[window])
                .fold((0.0, 0.0), |(value, slope), (w, y)| (value + w.0 * y, slope + w.1 * y))
        })
        .unzip();
    let middle = instants[instants.len() / 2];
    let window = window(time, middle, half_width_s);
    let weights = weights(&time[window.clone()], time[middle]);
    let around: Vec<f64> = time[window].iter().map(|t| t - time[middle]).collect();
    Derivative {
        time: instants.iter().map(|&k| time[k]).collect(),
        smoothed,
        slope,
        half_width_s,
        bandwidth_hz: bandwidth(&around, &weights),
        noise_gain: weights.iter().map(|w| w.1 * w.1).sum::<f64>().sqrt(),
        quiet: false,
    }
}

/// The samples within the half width of sample `k`, at least five.
fn window(time: &[f64], k: usize, half_width_s: f64) -> Range<usize> {
    let (from, to) = (time[k] - half_width_s, time[k] + half_width_s);
    let mut range = time.partition_point(|t| *t < from)..time.partition_point(|t| *t <= to);
    while range.len() < MIN_WINDOW {
        let below = range.start.checked_sub(1).map(|i| time[k] - time[i]);
        let above = time.get(range.end).map(|t| t - time[k]);
        match (below, above) {
            (Some(below), Some(above)) if below <= above => range.start -= 1,
            (Some(_), None) => range.start -= 1,
            (_, Some(_)) => range.end += 1,
            (None, None) => break,
        }
    }
    range
}

/// For each sample, its weight in the value and in the slope of the parabola through them at `at`.
fn weights(time: &[f64], at: f64) -> Vec<(f64, f64)> {
    let reach = time.iter().fold(f64::MIN_POSITIVE, |most, t| most.max((t - at).abs()));
    let row = |t: &f64| {
        let u = (t - at) / reach;
        Vector3::new(1.0, u, u * u)
    };
    let normal: Matrix3<f64> = time.iter().map(|t| row(t) * row(t).transpose()).sum();
    let Some(inverse) = normal.try_inverse() else { return vec![(0.0, 0.0); time.len()] };
    time.iter()
        .map(|t| {
            let weight = inverse * row(t);
            (weight[0], weight[1] / reach)
        })
        .collect()
}

/// Where the slope of a sine comes out 3 dB too small, Hz.
fn bandwidth(around: &[f64], weights: &[(f64, f64)]) -> Option<f64> {
    let gain = |frequency: f64| {
        let omega = TAU * frequency;
        let sum = around.iter().zip(weights).fold((0.0, 0.0), |(re, im), (t, w)| {
            (re + w.1 * (omega * t).cos(), im + w.1 * (omega * t).sin())
        });
        f64::hypot(sum.0, sum.1) / omega
    };
    let reach = around.iter().fold(0.0, |most: f64, t| most.max(t.abs()));
    // The slope over ±reach loses 3 dB near 0.29 / reach; sparse samples may do so elsewhere.
    let (mut low, mut high) = (1e-3 / reach, 4.0 / reach);
    let passes = |frequency: f64| gain(frequency) > FRAC_1_SQRT_2;
    if !reach.is_normal() || !passes(low) {
        return None;
    }
    let first =
        (1..=200).map(|k| low + (high - low) * f64::from(k) / 200.0).find(|f| !passes(*f))?;
    (low, high) = (first - (high - low) / 200.0, first);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if passes(middle) { low = middle } else { high = middle }
    }
    Some(low)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn dense_windows_have_the_bandwidth_of_the_textbook() {
        // Slope over ±h of a dense signal: 3 (sin u − u cos u) / u³ with u = ωh; 1/√2 at u = 1.8142.
        let time: Vec<f64> = (0..2001).map(|k| 0.001 * f64::from(k)).collect();
        let values: Vec<f64> = time.iter().map(|t| t * t).collect();
        let found = with_width(&time, &values, &[1000], 0.2);
        let expected = 1.8142 / (TAU * 0.2);
        assert!((found.bandwidth_hz.unwrap() / expected - 1.0).abs() < 5e-3, "{found:?}");
    }

    #[test]
    fn noise_widens_the_window_and_the_stated_gain_is_the_noise_that_comes_out() {
        let time: Vec<f64> = (0..4000).map(|k| 0.0025 * f64::from(k)).collect();
        let noisy = |k: usize| ((k * 7919 % 4001) as f64 / 4001.0 - 0.5) * 0.02;
        let values: Vec<f64> =
            time.iter().enumerate().map(|(k, t)| (-t).exp() + noisy(k)).collect();
        let quiet = derivative(&time, &values, 0.0, 100).unwrap();
        let found = derivative(&time, &values, 0.02 / 12f64.sqrt(), 100).unwrap();
        assert!(found.half_width_s > 5.0 * quiet.half_width_s && found.quiet);
        for (t, slope) in found.time.iter().zip(&found.slope) {
            assert!((slope + (-t).exp()).abs() < 0.2, "{t}: {slope}");
        }
    }

    #[test]
    fn four_samples_have_no_derivative() {
        assert_eq!(derivative(&[0.0, 1.0, 2.0, 3.0], &[0.0; 4], 0.0, 10), None);
    }

    proptest! {
        #[test]
        fn a_parabola_is_exact_on_any_times(
            steps in prop::collection::vec(0.01f64..1.0, 8..60), a in -3.0f64..3.0, b in -3.0f64..3.0
        ) {
            let time: Vec<f64> = steps.iter().scan(0.0, |now, step| { *now += step; Some(*now) }).collect();
            let values: Vec<f64> = time.iter().map(|t| a * t * t + b * t + 1.0).collect();
            let found = derivative(&time, &values, 0.0, 1000).unwrap();
            for (t, slope) in found.time.iter().zip(&found.slope) {
                prop_assert!((slope - (2.0 * a * t + b)).abs() < 1e-6 * (1.0 + t.abs()), "{slope}");
            }
        }
    }
}
