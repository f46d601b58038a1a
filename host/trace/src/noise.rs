//! How noisy a signal is.

use std::ops::Range;

use super::error::SignalError;
use super::holds::{changing, holds};
use super::scatter;
use super::segments::{Kind, segments};
use super::{FORCE, Trace};

/// Samples of rest before the touch that are enough to measure noise in.
const MIN_REST_SAMPLES: usize = 50;

/// Noise of one column of a trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of one sample, in the column's unit.
    pub standard_deviation: f64,
    /// Correlation of neighbouring samples, −1 to 1; only where noise was seen by itself, 50 samples in a row.
    pub lag1: Option<f64>,
    /// Samples it was estimated from.
    pub samples: usize,
    /// How.
    pub source: Source,
}

/// What a noise estimate rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The signal before the first touch, its mean removed.
    BeforeTouch,
    /// The signal on a way to the first touch that knows no rest, about a straight line.
    WayIn,
    /// Second differences within holds. Correlated noise is underestimated by them.
    Holds,
    /// Second differences of the whole trace, in which nothing rests.
    WholeTrace,
}

/// Estimates the noise of a column: from the rest before the first touch where it has 50 samples,
/// else from second differences within the holds, else from those of the whole trace.
///
/// Before the touch only samples at the first displacement count where there are 50 of them: a touch
/// earlier than the nominal one must not pass for noise.
///
/// # Errors
/// [`SignalError::NoColumn`], [`SignalError::Constant`], [`SignalError::EmptyHold`] where fewer than
/// three samples lie together.
pub fn noise(trace: &Trace, column: &str) -> Result<Noise, SignalError> {
    let values = changing(trace, column)?;
    if let Some(quiet) = before_touch(trace)
        && let Some(found) = of_rest(&values[quiet])
    {
        return Ok(found);
    }
    let resting = holds(trace, column).unwrap_or_default();
    let whole = std::iter::once(0..trace.len()).collect();
    for (ranges, source) in [(resting, Source::Holds), (whole, Source::WholeTrace)] {
        let ranges: Vec<Range<usize>> = ranges;
        let differences: Vec<f64> = ranges
            .into_iter()
            .flat_map(|range| {
                scatter::second_differences(&trace.time[range.clone()], &values[range])
            })
            .collect();
        // A handful of differences says nothing if there are more to be had.
        if differences.len() >= MIN_REST_SAMPLES
            || (source == Source::WholeTrace && !differences.is_empty())
        {
            return Ok(Noise {
                standard_deviation: scatter::deviation(&differences),
                lag1: None,
                samples: differences.len(),
                source,
            });
        }
    }
    Err(SignalError::EmptyHold {
        trace: trace.label(),
        from_s: trace.time.first().copied().unwrap_or(0.0),
        samples: trace.len(),
        needed: 3,
    })
}

/// The samples before the first touch that show noise alone.
fn before_touch(trace: &Trace) -> Option<Range<usize>> {
    let x = trace.displacement()?;
    let approach =
        segments(&trace.time, x).into_iter().find(|segment| segment.kind == Kind::Approach)?.range;
    let differences: Vec<f64> =
        scatter::second_differences(&trace.time[approach.clone()], &x[approach.clone()]).collect();
    let band = 6.0 * scatter::deviation(&differences);
    let still = approach.clone().take_while(|&i| (x[i] - x[0]).abs() <= band).count();
    if still >= MIN_REST_SAMPLES {
        return Some(0..still);
    }
    // What is pulled away first may be bonded, and pulls back.
    let pulled = approach.clone().any(|i| x[i] < x[0] - band);
    (!pulled).then_some(approach)
}

/// Noise of a signal at rest; none for fewer than 50 samples or if nothing moves in it.
fn of_rest(values: &[f64]) -> Option<Noise> {
    let count = values.len();
    if count < MIN_REST_SAMPLES {
        return None;
    }
    let (mean, squares) = mean_and_squares(values);
    let neighbours: f64 = values.windows(2).map(|pair| (pair[0] - mean) * (pair[1] - mean)).sum();
    (squares > 0.0).then(|| Noise {
        standard_deviation: (squares / (count - 1) as f64).sqrt(),
        lag1: Some(neighbours / squares),
        samples: count,
        source: Source::BeforeTouch,
    })
}

/// The mean, and the sum of squares about it.
fn mean_and_squares(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    (mean, values.iter().map(|y| (y - mean) * (y - mean)).sum())
}

/// Noise in the rests before the touch of all traces together, each about a mean of its own, where one alone has too few
/// samples; none for fewer than 50 beyond the means. Their neighbours' correlation is not estimated: a short rest's own mean takes most
/// of it away.
pub(super) fn of_rests(traces: &[Trace], column: &str) -> Option<Noise> {
    let (mut squares, mut samples, mut means) = (0.0, 0, 0);
    for trace in traces {
        let Some((values, quiet)) = changing(trace, column).ok().zip(before_touch(trace)) else {
            continue;
        };
        let quiet = &values[quiet];
        squares += mean_and_squares(quiet).1;
        samples += quiet.len();
        means += usize::from(!quiet.is_empty());
    }
    let free = samples - means;
    (free >= MIN_REST_SAMPLES && squares > 0.0).then(|| Noise {
        standard_deviation: (squares / free as f64).sqrt(),
        lag1: None,
        samples,
        source: Source::BeforeTouch,
    })
}

/// Noise of the contact force, N.
///
/// # Errors
/// As [`noise`].
pub fn force_noise(trace: &Trace) -> Result<Noise, SignalError> {
    noise(trace, FORCE)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    use super::*;
    use crate::DISPLACEMENT;

    /// Rest, a ramp and a relaxing hold at 200 Hz, noise of 0.02 N with the given correlation.
    fn press(rest_s: f64, correlation: f64) -> Trace {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let normal = Normal::new(0.0, 0.02).unwrap();
        let time: Vec<f64> = (0..2000).map(|i| f64::from(i) * 0.005).collect();
        let x: Vec<f64> = time.iter().map(|t| ((t - rest_s) * 20.0).clamp(0.0, 12.0)).collect();
        let mut error = 0.0;
        let force = time.iter().zip(&x).map(|(t, x)| {
            let fresh = normal.sample(&mut random);
            error = correlation * error + (1.0 - correlation * correlation).sqrt() * fresh;
            x * x * 0.1 * (0.7 + 0.3 * (-(t - rest_s).max(0.0)).exp()) + error
        });
        let force = force.collect();
        let mut trace = Trace { time, ..Trace::default() };
        trace.set_column(DISPLACEMENT, x);
        trace.set_column(FORCE, force);
        trace
    }

    #[test]
    fn noise_before_the_touch_is_measured_with_its_correlation() {
        let found = force_noise(&press(2.0, 0.5)).unwrap();
        assert_eq!((found.source, found.samples), (Source::BeforeTouch, 401));
        assert!((found.standard_deviation / 0.02 - 1.0).abs() < 0.12, "{found:?}");
        assert!((found.lag1.unwrap() - 0.5).abs() < 0.12, "{found:?}");
    }

    #[test]
    fn without_rest_noise_comes_from_the_holds() {
        let found = force_noise(&press(0.1, 0.0)).unwrap();
        assert_eq!(found.source, Source::Holds);
        assert!((found.standard_deviation / 0.02 - 1.0).abs() < 0.06, "{found:?}");
    }

    #[test]
    fn a_coarse_resolution_still_has_noise() {
        let mut trace = press(0.1, 0.0);
        let coarse = trace.force().unwrap().iter().map(|force| (force / 0.25).round() * 0.25);
        let coarse = coarse.collect();
        trace.set_column(FORCE, coarse);
        let found = force_noise(&trace).unwrap();
        assert!((0.01..0.25).contains(&found.standard_deviation), "{found:?}");
    }

    #[test]
    fn a_dead_channel_is_an_error() {
        let mut trace = press(1.0, 0.0);
        trace.set_column(FORCE, vec![0.5; trace.len()]);
        assert!(matches!(force_noise(&trace), Err(SignalError::Constant { .. })));
    }
}
