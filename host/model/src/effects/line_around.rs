//! What the samples around each show of a line of the spectrum.
//!
//! Windows in time are raised cosines, so that what is slow does not show: a wide one less a narrow one, which takes out the sample
//! itself and all whose noise may correlate with its own. Noise thus foretells nothing, and a line that keeps its phase for a second does.

use std::f64::consts::{PI, TAU};

use nalgebra::Complex;

/// Half the width of the window, s: the mains keep their phase for longer.
const WIDE: f64 = 2.0;
/// Half the width of what is taken out around the sample, s.
const NARROW: f64 = 0.25;
/// Slowest line, Hz, as the samples show it: a slower one may be what the specimen does.
const SLOWEST: f64 = 5.0;
/// Periods of the line, as the samples show it, in half the width of the window whose mean is what is slow: of these a raised cosine shows
/// no line.
const PERIODS: f64 = 2.0;
/// Weight of the samples around, at least: fewer tell no line.
const FEWEST: f64 = 24.0;

/// Frequency, Hz, as which samples that are `interval`, s, apart show a line.
#[must_use]
pub fn shown(frequency: f64, interval: f64) -> f64 {
    let turns = frequency * interval;
    (turns - turns.round()).abs() / interval
}

/// The line of about this frequency, Hz, at every sample of a signal as those around it show it; zero where they are too few, or so far
/// apart that the line looks slow.
pub(super) fn line_around(time: &[f64], signal: &[f64], frequency: f64) -> Vec<f64> {
    let (Some(first), Some(last)) = (time.first(), time.last()) else { return Vec::new() };
    let samples = time.len() as f64;
    let shown = shown(frequency, (last - first) / (samples - 1.0).max(1.0));
    if shown.is_nan() || shown < SLOWEST {
        return vec![0.0; time.len()];
    }
    let ones = vec![Complex::from(1.0); time.len()];
    let real = signal.iter().map(|&value| Complex::from(value)).collect::<Vec<_>>();
    let slow = |values: &[Complex<f64>]| smoothed(time, values, PERIODS / shown);
    let about = signal.iter().zip(slow(&real).into_iter().zip(slow(&ones)));
    let fast = about.map(|(value, (sum, weight))| value - sum.re / weight.re);
    let turns: Vec<Complex<f64>> = time.iter().map(|t| Complex::cis(TAU * frequency * t)).collect();
    let turned: Vec<_> = turns.iter().zip(fast).map(|(turn, value)| turn.conj() * value).collect();
    let twice: Vec<_> = turns.iter().map(|turn| turn.conj() * turn.conj()).collect();
    let around = |values: &[Complex<f64>]| {
        let (wide, narrow) = (smoothed(time, values, WIDE), smoothed(time, values, NARROW));
        wide.into_iter().zip(narrow).map(|(wide, narrow)| wide - narrow)
    };
    // Of a line the sum is its value times the weighted mean of cos² over the lags: one half, or one where it turns by half a turn a sample.
    let sums = around(&turned).zip(around(&ones)).zip(around(&twice));
    let line = sums.zip(&turns).map(|(((sum, weight), doubled), turn)| {
        let squares = 0.5 * (weight + doubled * turn * turn).re;
        if weight.re >= FEWEST { (sum * turn).re / squares } else { 0.0 }
    });
    line.collect()
}

/// Sum of the values around each, weighted by a raised cosine that vanishes half a width, s, away.
fn smoothed(time: &[f64], values: &[Complex<f64>], half: f64) -> Vec<Complex<f64>> {
    let turns: Vec<Complex<f64>> = time.iter().map(|t| Complex::cis(PI * t / half)).collect();
    let mut sums = vec![[Complex::from(0.0); 3]];
    for (value, turn) in values.iter().zip(&turns) {
        let [flat, ahead, behind] = sums[sums.len() - 1];
        sums.push([flat + value, ahead + value * turn.conj(), behind + value * turn]);
    }
    let (mut begin, mut end) = (0, 0);
    let at = |(t, turn): (&f64, &Complex<f64>)| {
        while time[begin] < t - half {
            begin += 1;
        }
        while end < time.len() && time[end] <= t + half {
            end += 1;
        }
        let [flat, ahead, behind] = [0, 1, 2].map(|which| sums[end][which] - sums[begin][which]);
        flat * 0.5 + (ahead * turn + behind * turn.conj()) * 0.25
    };
    time.iter().zip(&turns).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times that are this far apart on average, s.
    fn times(interval: f64, uneven: f64) -> Vec<f64> {
        (0..3000)
            .map(|k| interval * (f64::from(k) + uneven * (12.9 * f64::from(k)).sin()))
            .collect()
    }

    #[test]
    fn sums_are_those_term_by_term() {
        let time = times(0.004, 0.3);
        let signal: Vec<f64> = time.iter().map(|t| 3.0 * t + (400.0 * t * t).sin()).collect();
        let found = line_around(&time, &signal, 50.03);
        let raised = |lag: f64, half: f64| {
            if lag.abs() <= half { 0.5 + 0.5 * (PI * lag / half).cos() } else { 0.0 }
        };
        let mean = |t: f64, own: &dyn Fn(f64) -> f64, value: &dyn Fn(usize, f64) -> f64| {
            let lags = time.iter().map(|other| t - other);
            let (sum, weight) = lags.enumerate().fold((0.0, 0.0), |(sum, weight), (i, lag)| {
                (sum + own(lag) * value(i, lag), weight + own(lag))
            });
            sum / weight
        };
        let shown = 50.03;
        let fast: Vec<f64> = (0..3000)
            .map(|k| signal[k] - mean(time[k], &|lag| raised(lag, 2.0 / shown), &|i, _| signal[i]))
            .collect();
        for k in [0, 1, 700, 1503, 2999] {
            let own = |lag| raised(lag, WIDE) - raised(lag, NARROW);
            let turned = |i: usize, lag: f64| fast[i] * (TAU * 50.03 * lag).cos();
            let square = |_: usize, lag: f64| (TAU * 50.03 * lag).cos().powi(2);
            let expected = mean(time[k], &own, &turned) / mean(time[k], &own, &square);
            assert!((found[k] - expected).abs() < 1e-9, "{} {expected} at {k}", found[k]);
        }
    }

    #[test]
    fn a_line_that_wanders_and_swells_is_followed_beside_what_is_slow() {
        for (interval, uneven) in [(0.004, 0.0), (0.001, 0.0), (0.005, 0.2), (0.01, 0.0)] {
            let time = times(interval, uneven);
            let line = |t: f64| (1.0 + 0.1 * t) * (TAU * (50.03 * t + 0.1 * (0.3 * t).sin())).sin();
            let slow = |t: f64| 500.0 * (0.4 * t).sin().max(0.0);
            let signal: Vec<f64> = time.iter().map(|&t| slow(t) + line(t)).collect();
            let found = line_around(&time, &signal, 50.0);
            let square = |of: &dyn Fn(usize) -> f64| {
                (0..time.len()).map(|k| of(k).powi(2)).sum::<f64>() / time.len() as f64
            };
            let left = square(&|k| line(time[k]) - found[k]);
            let all = square(&|k| line(time[k]));
            assert!(left < 0.02 * all, "{left} of {all} is left at {interval} s");
        }
    }

    #[test]
    fn a_line_that_looks_slow_or_is_seen_by_few_is_none() {
        for (interval, frequency) in [(0.02, 50.01), (1.0 / 49.0, 50.0), (1.0, 50.3)] {
            let time = times(interval, 0.0);
            let signal: Vec<f64> = time.iter().map(|t| (TAU * frequency * t).sin()).collect();
            assert!(line_around(&time, &signal, frequency).iter().all(|line| *line == 0.0));
        }
        assert!(line_around(&[], &[], 50.0).is_empty());
        assert_eq!(line_around(&[0.0], &[1.0], 50.0), [0.0]);
        assert!(
            line_around(&[0.0, 0.003, 0.007], &[1.0, 3.0, 2.0], 50.0).iter().all(|l| *l == 0.0)
        );
    }
}
