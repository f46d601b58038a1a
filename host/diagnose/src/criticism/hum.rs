//! A line of the mains in stretches of rest, and the stretches without it: a hum is no noise.
//!
//! The powers of all frequencies come from one Fourier transform of the summed autocorrelations, so that
//! the cost grows like the number of samples, whatever the number of frequencies.

use std::f64::consts::TAU;
use std::ops::Range;

use nalgebra::{Matrix2, Vector2};
use palpate_fit::data::Data;
use palpate_fit::fourier::Planner;
use palpate_model::effects::shown;

/// Frequencies of the mains, Hz.
pub(super) const MAINS: [f64; 2] = [50.0, 60.0];
/// How far from them a line is looked for, Hz.
const WITHIN: f64 = 3.0;
/// How far from them a line is theirs for certain, Hz.
const OWN: f64 = 1.5;
/// Widths of a line, as the longest block shows it, over which its surroundings reach: most of a narrower band is the line.
const WIDTHS: f64 = 6.0;
/// Steps between frequencies in one turn over the longest block.
pub(super) const STEPS: usize = 4;
/// Longest block, in samples, over which a line keeps its phase: the mains wander, and memory is bounded.
const BLOCK: usize = 1 << 16;
/// Slowest line, Hz, as the samples show it, whose power is taken: a slower one is what a law leaves of the motion.
const SLOWEST: f64 = 1.0;
/// Longest time, s, over which the mains keep their phase: they wander by some hundredths of a hertz; and fewest samples of that.
const STEADY: f64 = 4.0;
const FEWEST: usize = 64;
/// Power of a line over the median of its surroundings above which it is one.
const LINE: f64 = 4.0;
/// Where the surroundings of a line are looked at, Hz.
const ASIDE: [f64; 4] = [-3.0, -2.0, 2.0, 3.0];

/// The stretches, samples `interval` seconds apart, about their means and without a line of the mains, if
/// they have one.
pub(super) fn without_hum(stretches: Vec<Vec<f64>>, interval: f64) -> Vec<Vec<f64>> {
    let mut centred: Vec<Vec<f64>> = stretches.into_iter().map(centred).collect();
    let mut powers = powers(&centred, interval);
    powers.sort_by(|a, b| a.power.total_cmp(&b.power));
    let Some(&Line { power: highest, turn, .. }) = powers.iter().rfind(|line| line.off <= WITHIN)
    else {
        return centred;
    };
    if highest > LINE * powers[powers.len() / 2].power {
        clean(&mut centred, turn);
    }
    centred
}

/// Whether what a model leaves of a data set has a line of about this frequency, Hz, whose mean square is more than `least` and stands
/// out of what a misfit has at the frequencies on either side.
pub(super) fn has_line(left: &[Vec<f64>], data: &Data, frequency: f64, least: f64) -> bool {
    let power = power_of_line(left, data, frequency);
    if power <= least {
        return false;
    }
    let mut around = ASIDE.map(|aside| power_of_line(left, data, frequency + aside));
    around.sort_by(f64::total_cmp);
    power > LINE * around[around.len() / 2]
}

/// Mean square of a line of about this frequency, Hz, in what a model leaves of a data set; stretches in which it looks slow have none.
fn power_of_line(left: &[Vec<f64>], data: &Data, frequency: f64) -> f64 {
    let squares = left.iter().zip(&data.pieces).map(|(left, piece)| {
        let (time, samples) = (&piece.motion.time, left.len());
        let interval = (time[samples - 1] - time[0]) / (samples as f64 - 1.0);
        let shown = shown(frequency, interval);
        if shown.is_nan() || shown < SLOWEST {
            return 0.0;
        }
        let block = ((STEADY / interval) as usize).max(FEWEST);
        let squares = left
            .chunks(block)
            .zip(time.chunks(block))
            .map(|(left, time)| square_of_line(left, |k| TAU * frequency * time[k]));
        squares.sum::<f64>()
    });
    squares.sum::<f64>() / data.samples() as f64
}

/// The values about their mean.
pub(super) fn centred(values: Vec<f64>) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.into_iter().map(|value| value - mean).collect()
}

/// Whether a line that turns by this much from sample to sample looks like one of the mains.
pub(super) fn near_the_mains(turn: f64, interval: f64) -> bool {
    MAINS.into_iter().any(|mains| {
        let turns = mains * interval;
        let shown = TAU * (turns - turns.round()).abs();
        (turn - shown).abs() <= TAU * OWN * interval
    })
}

/// The blocks of all stretches.
pub(super) fn parts(stretches: &[Vec<f64>]) -> Vec<&[f64]> {
    let blocks = stretches.iter().flat_map(|values| blocks(values.len()).map(|it| &values[it]));
    blocks.filter(|values| !values.is_empty()).collect()
}

/// Blocks of about the same length, none longer than [`BLOCK`].
fn blocks(samples: usize) -> impl Iterator<Item = Range<usize>> {
    let count = samples.div_ceil(BLOCK).max(1);
    (0..count).map(move |k| k * samples / count..(k + 1) * samples / count)
}

/// A frequency near one of the mains.
#[derive(Clone, Copy)]
struct Line {
    /// Power summed over all blocks.
    power: f64,
    /// By how much it turns from sample to sample.
    turn: f64,
    /// How far it is from that of the mains, Hz.
    off: f64,
}

/// Every frequency near those of the mains.
///
/// |Σ y e^(−iωk)|² is the transform of the autocorrelation of y, and transforms add: one serves for all.
fn powers(stretches: &[Vec<f64>], interval: f64) -> Vec<Line> {
    let parts = parts(stretches);
    let longest = parts.iter().map(|values| values.len()).max().unwrap_or(1);
    let mut planner = Planner::new();
    let products = autocorrelation(&parts, longest, &mut planner);
    let turns = STEPS * longest;
    let step = TAU / turns as f64;
    let transform = planner.forward(turns);
    let near = |mains: f64| {
        let middle = TAU * mains * interval;
        // Σ A(l) cos((middle + k step) l) by two real transforms, for k and −k at once.
        let turned = |part: fn(f64) -> f64| {
            let mut input = transform.make_input_vec();
            for (lag, (slot, product)) in input.iter_mut().zip(&products).enumerate() {
                *slot = product * part(middle * lag as f64);
            }
            let mut output = transform.make_output_vec();
            // The lengths are the plan's own, the only thing it can refuse.
            let _ = transform.process(&mut input, &mut output);
            output
        };
        let (cosine, sine) = (turned(f64::cos), turned(f64::sin));
        let bins = bins(longest, interval, mains);
        let side = move |sign: f64| {
            let (cosine, sine) = (cosine.clone(), sine.clone());
            move |k: usize| Line {
                power: cosine[k].re + sign * sine[k].im,
                turn: middle + sign * k as f64 * step,
                off: k as f64 * step / (TAU * interval),
            }
        };
        let below = (1..=bins).rev().map(side(-1.0));
        below.chain((0..=bins).map(side(1.0))).collect::<Vec<_>>()
    };
    MAINS.into_iter().flat_map(near).collect()
}

/// Frequencies on either side of that of the mains. Where samples are so far apart that the band holds
/// every frequency they tell apart, each is looked at once. A line that looks slow keeps to the narrow band: noise that wanders fills a
/// wide one unevenly.
fn bins(longest: usize, interval: f64, mains: f64) -> usize {
    let (turns, samples) = (mains * interval, longest as f64);
    let shown = (turns - turns.round()).abs();
    let wide = if shown * samples > 2.0 * WIDTHS { WIDTHS } else { 0.0 };
    let within = (WITHIN * interval * samples).max(wide);
    let within = (within * STEPS as f64).ceil() as usize;
    within.min(STEPS * longest / 2)
}

/// Sum over the parts of 2/n Σ y(k) y(k + l), for the lags l on both sides together.
pub(super) fn autocorrelation(parts: &[&[f64]], longest: usize, planner: &mut Planner) -> Vec<f64> {
    let mut sums = vec![0.0; longest];
    for values in parts {
        let size = (2 * values.len()).next_power_of_two();
        let (forward, back) = (planner.forward(size), planner.inverse(size));
        let mut padded = forward.make_input_vec();
        padded[..values.len()].copy_from_slice(values);
        let mut lines = forward.make_output_vec();
        let _ = forward.process(&mut padded, &mut lines);
        for line in &mut lines {
            *line = (line.norm_sqr()).into();
        }
        let _ = back.process(&mut lines, &mut padded);
        let part = 2.0 / (values.len() * size) as f64;
        for (lag, (sum, product)) in sums.iter_mut().zip(&padded[..values.len()]).enumerate() {
            *sum += product * part * if lag > 0 { 2.0 } else { 1.0 };
        }
    }
    sums
}

/// Sum of squares of the line in the values that has this phase at each.
pub(super) fn square_of_line(values: &[f64], phase: impl Fn(usize) -> f64) -> f64 {
    let (cosine, sine) = components(values, phase);
    // An amplitude has a mean square of half its own.
    2.0 * (cosine * cosine + sine * sine) / values.len() as f64
}

/// Sums of the values times the cosine and the sine of the phase at each.
fn components(values: &[f64], phase: impl Fn(usize) -> f64) -> (f64, f64) {
    values.iter().enumerate().fold((0.0, 0.0), |(cosine, sine), (k, value)| {
        let phase = phase(k);
        (cosine + value * phase.cos(), sine + value * phase.sin())
    })
}

/// Takes the line that turns by `turn` from sample to sample off every block of the stretches.
pub(super) fn clean(stretches: &mut [Vec<f64>], turn: f64) {
    for values in stretches {
        for block in blocks(values.len()) {
            clean_block(&mut values[block], turn);
        }
    }
}

/// The same of one block, by least squares: at half a turn its cosine alone shows.
fn clean_block(values: &mut [f64], turn: f64) {
    let along = |k: usize| Vector2::new((turn * k as f64).cos(), (turn * k as f64).sin());
    let (mut squares, mut products) = (Matrix2::zeros(), Vector2::zeros());
    for (k, value) in values.iter().enumerate() {
        let line = along(k);
        squares += line * line.transpose();
        products += line * *value;
    }
    let Some(inverse) = squares.try_inverse() else { return };
    let amplitudes = inverse * products;
    for (k, value) in values.iter_mut().enumerate() {
        *value -= amplitudes.dot(&along(k));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use palpate_trace::{Column, DISPLACEMENT, FORCE, Trace};

    /// Noise in stretches of several lengths, with a hum.
    fn noisy(lengths: &[usize], interval: f64, hum: f64) -> Vec<Vec<f64>> {
        let mut random = ChaCha8Rng::seed_from_u64(11);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let value = |k: usize| hum * (TAU * 50.07 * interval * k as f64).sin();
        lengths.iter().map(|&length| (0..length).map(|k| value(k) + normal()).collect()).collect()
    }

    /// Power at one frequency, term by term.
    fn power(stretches: &[Vec<f64>], turn: f64) -> f64 {
        let of = |values: &Vec<f64>| {
            let along = |part: fn(f64) -> f64| {
                let term = |(k, value): (usize, &f64)| value * part(turn * k as f64);
                values.iter().enumerate().map(term).sum::<f64>()
            };
            (along(f64::cos).powi(2) + along(f64::sin).powi(2)) * 2.0 / values.len() as f64
        };
        stretches.iter().map(of).sum()
    }

    #[test]
    fn powers_are_those_of_the_sum_term_by_term() {
        for (lengths, interval) in
            [(vec![700, 16, 431], 0.001), (vec![64, 50], 0.3), (vec![1], 1.0)]
        {
            let stretches = noisy(&lengths, interval, 0.5);
            let found = powers(&stretches, interval);
            let longest = lengths.iter().max().copied().unwrap_or(1) as f64 * interval;
            if interval < 0.1 {
                // The frequencies: 3 Hz or six widths either side of both mains in quarters of a turn.
                let aside = (12.0 * longest).max(24.0).ceil();
                assert_eq!(found.len(), 2 * (2 * aside as usize + 1));
                let first = TAU * interval * (50.0 - aside * 0.25 / longest);
                assert!((found[0].turn - first).abs() < 1e-12, "{} for {first}", found[0].turn);
            }
            for Line { power: value, turn, .. } in found {
                let expected = power(&stretches, turn);
                assert!((value - expected).abs() < 1e-9 * (1.0 + expected), "{value} {expected}");
            }
        }
    }

    #[test]
    fn a_line_stands_out_of_a_misfit_and_a_misfit_is_no_line() {
        let time: Vec<f64> = (0..8000).map(|k| 0.002 * f64::from(k)).collect();
        let column = |name: &str, values: Vec<f64>| Column { name: name.into(), values };
        let columns = vec![column(DISPLACEMENT, time.clone()), column(FORCE, time.clone())];
        let traces = [Trace { time: time.clone(), columns, ..Trace::default() }];
        let data = Data::of(&traces, FORCE).expect("a data set");
        // Steps, as a law leaves them where the motion turns: power at every frequency.
        let misfit = |t: f64| if t % 1.37 < 0.4 { 5.0 } else { -2.0 };
        let left = |hum: f64| {
            vec![time.iter().map(|t| misfit(*t) + hum * (TAU * 50.0 * t).sin()).collect()]
        };
        assert!(has_line(&left(1.0), &data, 50.0, 0.1));
        assert!(power_of_line(&left(0.0), &data, 50.0) > 0.0);
        assert!(!has_line(&left(0.0), &data, 50.0, 0.0));
    }

    #[test]
    fn a_hum_goes_and_noise_stays() {
        let lengths = [3000, 900];
        let quiet: Vec<Vec<f64>> = noisy(&lengths, 0.001, 0.0).into_iter().map(centred).collect();
        let cleaned = without_hum(noisy(&lengths, 0.001, 1.0), 0.001);
        for (cleaned, quiet) in cleaned.iter().zip(&quiet) {
            let left: f64 = cleaned.iter().zip(quiet).map(|(a, b)| (a - b).powi(2)).sum();
            let hum = 0.5 * quiet.len() as f64;
            assert!(left < 0.1 * hum, "{left} left of {hum}");
        }
    }

    /// A line that turns by half a turn from sample to sample, or nearly so, in rests of half a second.
    #[test]
    fn a_hum_at_half_the_rate_of_sampling_goes_as_well() {
        let lengths = [50; 8];
        let quiet: Vec<Vec<f64>> = noisy(&lengths, 0.01, 0.0).into_iter().map(centred).collect();
        let square = |stretches: &[Vec<f64>]| stretches.concat().iter().map(|v| v * v).sum::<f64>();
        for hum in [0.0, 4.0] {
            let mut humming = noisy(&lengths, 0.01, 0.0);
            for values in &mut humming {
                let line = |k: usize| hum * (TAU * 0.497 * k as f64 + 1.0).sin();
                values.iter_mut().enumerate().for_each(|(k, value)| *value += line(k));
            }
            let left = square(&without_hum(humming, 0.01)) / square(&quiet);
            let most = 1.05 + 0.1 * (0.5 * hum * hum);
            assert!((0.9..most).contains(&left), "{left} of the noise is left");
        }
    }

    #[test]
    fn work_grows_with_the_samples_alone() {
        // Samples transformed, and frequencies looked at, whatever the length and however slow.
        for samples in [1_000, 100_000, 10_000_000] {
            let blocks: Vec<_> = blocks(samples).collect();
            assert_eq!(blocks.iter().map(Range::len).sum::<usize>(), samples);
            let longest = blocks.iter().map(Range::len).max().unwrap();
            assert!(longest <= BLOCK && blocks.len() <= samples / BLOCK + 1);
            for interval in [1e-4, 1e-3, 1.0, 1e8, f64::INFINITY] {
                assert!(bins(longest, interval, 50.0) <= STEPS / 2 * longest);
            }
        }
        let slow = noisy(&[4000], 1e8, 0.0);
        assert_eq!(powers(&slow, 1e8).len(), 2 * (4 * 4000 + 1));
    }
}
