//! The strongest line of a spectrum near a frequency.

use std::f64::consts::TAU;

use nalgebra::Complex;

/// How far from the frequency a line is looked for, Hz.
const WITHIN: f64 = 1.0;
/// Longest block, s, in which a line is first looked for whatever its phase in the others.
const BLOCK: f64 = 20.0;
/// Step between frequencies, in turns over the time that they are told apart in.
const STEP: f64 = 0.25;
/// Most frequencies at which the clock of the whole set is followed.
const FINEST: f64 = 4000.0;
/// Two intervals closer than this, relatively, are the same: times are printed with few digits.
const SAME_INTERVAL: f64 = 1e-7;

/// Frequency, Hz, of the strongest line within 1 Hz of `near` in stretches of (time since the set began,
/// s; value), or of the line whose alias they show. First it is found block by block, then as precisely
/// as the clock of the whole set tells.
///
/// Second differences stand in for the values, so that slow changes do not count.
#[must_use]
pub fn strongest_line(stretches: &[(&[f64], &[f64])], near: f64) -> f64 {
    let blocks: Vec<(Vec<f64>, Vec<f64>)> =
        stretches.iter().flat_map(|(time, values)| blocks(time, values)).collect();
    let duration = |(time, _): &(Vec<f64>, Vec<f64>)| time[time.len() - 1] - time[0];
    let longest = blocks.iter().map(duration).fold(0.0, f64::max);
    if longest == 0.0 {
        return near;
    }
    let coarse = strongest(near, WITHIN, STEP / longest, |frequency| {
        blocks.iter().map(|block| transform(block, frequency).norm_sqr()).sum()
    });
    let first = blocks.iter().map(|(time, _)| time[0]).fold(f64::INFINITY, f64::min);
    let last = blocks.iter().map(|(time, _)| time[time.len() - 1]).fold(first, f64::max);
    let (within, step) = (0.5 / longest, STEP / (last - first));
    if within > FINEST * step {
        return coarse;
    }
    strongest(coarse, within, step, |frequency| {
        blocks.iter().map(|block| transform(block, frequency)).sum::<Complex<f64>>().norm_sqr()
    })
}

/// The frequency about `middle` with the greatest power.
fn strongest(middle: f64, within: f64, step: f64, power: impl Fn(f64) -> f64) -> f64 {
    let steps = (within / step).ceil() as i32;
    (-steps..=steps)
        .map(|k| middle + step * f64::from(k))
        .map(|frequency| (frequency, power(frequency)))
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map_or(middle, |(frequency, _)| frequency)
}

/// Second differences of a stretch, cut into blocks.
fn blocks(time: &[f64], values: &[f64]) -> Vec<(Vec<f64>, Vec<f64>)> {
    let inner: Vec<f64> = time.iter().skip(1).take(time.len().saturating_sub(2)).copied().collect();
    let second: Vec<f64> = values.windows(3).map(|v| v[2] - 2.0 * v[1] + v[0]).collect();
    let mut blocks = Vec::new();
    let mut begin = 0;
    while begin < inner.len() {
        let end = begin + inner[begin..].partition_point(|t| t - inner[begin] <= BLOCK);
        blocks.push((inner[begin..end].to_vec(), second[begin..end].to_vec()));
        begin = end;
    }
    blocks
}

/// Fourier transform of a block at one frequency.
fn transform((time, values): &(Vec<f64>, Vec<f64>), frequency: f64) -> Complex<f64> {
    let turn = |seconds: f64| Complex::cis(-TAU * frequency * seconds);
    let mut phase = turn(time[0]);
    let (mut interval, mut step) = (f64::NAN, phase);
    let mut sum = Complex::new(0.0, 0.0);
    for (k, value) in values.iter().enumerate() {
        if k > 0 {
            let now = time[k] - time[k - 1];
            // Recordings are mostly uniform: the turn of an interval serves for the next.
            let same = (now - interval).abs() <= SAME_INTERVAL * now;
            if !same {
                (interval, step) = (now, turn(now));
            }
            phase *= step;
        }
        sum += phase * *value;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hum under slow presses, in stretches of 8 s with pauses of 21 s, and in samples of 5 ms.
    fn found(frequency: f64, near: f64) -> f64 {
        let stretches: Vec<(Vec<f64>, Vec<f64>)> = (0..6)
            .map(|j| {
                let time: Vec<f64> =
                    (0..1600).map(|k| 29.0 * f64::from(j) + 0.005 * f64::from(k)).collect();
                let value =
                    |t: &f64| 5.0 * (0.8 * t).sin().max(0.0) + 0.01 * (TAU * frequency * t).sin();
                let values = time.iter().map(value).collect();
                (time, values)
            })
            .collect();
        let stretches: Vec<(&[f64], &[f64])> =
            stretches.iter().map(|(time, values)| (&time[..], &values[..])).collect();
        strongest_line(&stretches, near)
    }

    #[test]
    fn a_hum_is_found_within_what_the_set_tells_apart() {
        for (frequency, near) in [(50.0, 50.0), (49.71, 50.0), (60.083, 60.0), (150.02, 150.0)] {
            let found = found(frequency, near);
            assert!((found - frequency).abs() <= 0.3 / 153.0, "{found} for {frequency}");
        }
    }

    #[test]
    fn without_samples_it_is_where_it_was_looked_for() {
        assert_eq!(strongest_line(&[], 50.0), 50.0);
        assert_eq!(strongest_line(&[(&[0.0, 1.0], &[0.0, 1.0])], 60.0), 60.0);
    }
}
