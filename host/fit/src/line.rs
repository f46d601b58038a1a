//! A line of a spectrum near a frequency.

use std::f64::consts::TAU;

use nalgebra::Complex;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// How far from the frequency a line is looked for, Hz.
const WITHIN: f64 = 1.0;
/// Longest block, s, in which a line is first looked for whatever its phase in the others.
const BLOCK: f64 = 20.0;
/// Step between frequencies, in turns over the time that they are told apart in.
const STEP: f64 = 0.25;
/// Most frequencies at which the clock of the whole set is followed.
const FINEST: f64 = 4000.0;
/// Chance, anywhere near the frequency, of a line as strong in noise.
const CHANCE: f64 = 1e-4;
/// Frequencies that are looked at together: sums of one do not wait for those of another.
const LANES: usize = 8;
/// Two intervals closer than this, relatively, are the same: times are printed with few digits.
const SAME_INTERVAL: f64 = 1e-7;

/// A line of a spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Its frequency, Hz.
    pub frequency: f64,
    /// Its power over the median of those around it.
    pub over: f64,
}

/// The line within 1 Hz of `near` in stretches of (time since the set began, s; value),
/// or of the line whose alias they show; none where no line stands out. First it is found block by
/// block, then as precisely as the clock of the whole set tells.
///
/// Second differences stand in for the values, so that slow changes do not count.
#[must_use]
pub fn line_near(stretches: &[(Vec<f64>, &[f64])], near: f64) -> Option<Line> {
    let blocks: Vec<(Vec<f64>, Vec<f64>)> =
        stretches.iter().flat_map(|(time, values)| blocks(time, values)).collect();
    let duration = |(time, _): &(Vec<f64>, Vec<f64>)| time[time.len() - 1] - time[0];
    let longest = blocks.iter().map(duration).fold(0.0, f64::max);
    if longest == 0.0 {
        return None;
    }
    let mut powers = powers(near, WITHIN, STEP / longest, |frequencies| {
        let mut powers = [0.0; LANES];
        for block in &blocks {
            let found = transforms(block, frequencies);
            powers.iter_mut().zip(found).for_each(|(power, found)| *power += found.norm_sqr());
        }
        powers
    });
    powers.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (middle, (coarse, highest)) = (powers[powers.len() / 2].1, powers[powers.len() - 1]);
    let spread = ChiSquared::new(2.0 * blocks.len() as f64).ok()?;
    let over = highest / middle;
    let chance = spread.sf(over * spread.inverse_cdf(0.5)) * powers.len() as f64;
    if chance.is_nan() || chance > CHANCE {
        return None;
    }
    let first = blocks.iter().map(|(time, _)| time[0]).fold(f64::INFINITY, f64::min);
    let last = blocks.iter().map(|(time, _)| time[time.len() - 1]).fold(first, f64::max);
    let (within, step) = (0.5 / longest, STEP / (last - first));
    if within > FINEST * step {
        return Some(Line { frequency: coarse, over });
    }
    let fine = self::powers(coarse, within, step, |frequencies| {
        let mut sums = [Complex::default(); LANES];
        for block in &blocks {
            let found = transforms(block, frequencies);
            sums.iter_mut().zip(found).for_each(|(sum, found)| *sum += found);
        }
        sums.map(|sum| sum.norm_sqr())
    });
    let (frequency, _) = fine.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(Line { frequency, over })
}

/// The power at frequencies about `middle`.
fn powers(
    middle: f64,
    within: f64,
    step: f64,
    power: impl Fn(&[f64; LANES]) -> [f64; LANES],
) -> Vec<(f64, f64)> {
    let steps = (within / step).ceil() as i32;
    let frequencies: Vec<f64> = (-steps..=steps).map(|k| middle + step * f64::from(k)).collect();
    let together = |some: &[f64]| {
        let lanes = std::array::from_fn(|lane| some[lane.min(some.len() - 1)]);
        some.iter().copied().zip(power(&lanes)).collect::<Vec<_>>()
    };
    frequencies.chunks(LANES).flat_map(together).collect()
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

/// Fourier transform of a block at some frequencies.
fn transforms(
    (time, values): &(Vec<f64>, Vec<f64>),
    frequencies: &[f64; LANES],
) -> [Complex<f64>; LANES] {
    let turns = |seconds: f64| {
        let turns = frequencies.map(|frequency| Complex::cis(-TAU * frequency * seconds));
        (turns.map(|turn| turn.re), turns.map(|turn| turn.im))
    };
    let (mut real, mut imaginary) = turns(time[0]);
    let (mut interval, mut step) = (f64::NAN, (real, imaginary));
    let mut sums = ([0.0; LANES], [0.0; LANES]);
    for (k, value) in values.iter().enumerate() {
        if k > 0 {
            let now = time[k] - time[k - 1];
            // Recordings are mostly uniform: the turn of an interval serves for the next.
            let same = (now - interval).abs() <= SAME_INTERVAL * now;
            if !same {
                (interval, step) = (now, turns(now));
            }
            for lane in 0..LANES {
                let before = real[lane];
                real[lane] = before * step.0[lane] - imaginary[lane] * step.1[lane];
                imaginary[lane] = before * step.1[lane] + imaginary[lane] * step.0[lane];
            }
        }
        for lane in 0..LANES {
            sums.0[lane] += real[lane] * value;
            sums.1[lane] += imaginary[lane] * value;
        }
    }
    std::array::from_fn(|lane| Complex::new(sums.0[lane], sums.1[lane]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// A hum under slow presses, in stretches of 8 s with pauses of 21 s, and in samples of 5 ms.
    fn found(amplitude: f64, frequency: f64, near: f64) -> Option<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let stretches: Vec<(Vec<f64>, Vec<f64>)> = (0..6)
            .map(|j| {
                let time: Vec<f64> =
                    (0..1600).map(|k| 29.0 * f64::from(j) + 0.005 * f64::from(k)).collect();
                let value = |t: &f64| {
                    let noise: f64 = StandardNormal.sample(&mut random);
                    5.0 * (0.8 * t).sin().max(0.0)
                        + amplitude * (TAU * frequency * t).sin()
                        + 0.003 * noise
                };
                let values = time.iter().map(value).collect();
                (time, values)
            })
            .collect();
        let stretches: Vec<(Vec<f64>, &[f64])> =
            stretches.iter().map(|(time, values)| (time.clone(), &values[..])).collect();
        line_near(&stretches, near).map(|line| line.frequency)
    }

    #[test]
    fn a_hum_is_found_within_what_the_set_tells_apart() {
        for (frequency, near) in [(50.0, 50.0), (49.71, 50.0), (60.083, 60.0), (150.02, 150.0)] {
            let found = found(0.01, frequency, near).unwrap();
            assert!((found - frequency).abs() <= 0.3 / 153.0, "{found} for {frequency}");
        }
    }

    #[test]
    fn noise_has_no_line() {
        assert_eq!(found(0.0, 50.0, 50.0), None);
        assert_eq!(line_near(&[], 50.0), None);
        assert_eq!(line_near(&[(vec![0.0, 1.0], &[0.0, 1.0])], 60.0), None);
    }
}
