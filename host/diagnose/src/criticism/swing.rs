//! A slow swing: a sine of one frequency through all traces and the pauses between them, of the building, the air
//! conditioning or the supply. No effect of the library is one, and to noise that was seen for a second it looks like flicker.

use std::f64::consts::TAU;

use palpate_fit::problem::Problem;
use palpate_model::effects::shown;

use super::beside::{Beside, Products};
use super::fitted::Fitted;

/// A sine through the data set.
#[derive(Clone, Debug, PartialEq)]
pub struct Swing {
    /// Its frequency, Hz.
    pub frequency_hz: f64,
    /// Its amplitude, in the unit of the signal.
    pub amplitude: f64,
    /// Fall of the sum of squares of the whitened residual.
    pub gain: f64,
    /// Logarithm of the chance of as large a fall at any frequency, in what else is left around its frequency.
    pub log_chance: f64,
}

/// Highest frequency that counts as slow, Hz: a mains hum is none.
const FASTEST_HZ: f64 = 2.0;
/// How far a line of the mains is from their frequency at most, Hz.
const OFF_THE_MAINS: f64 = 0.5;
/// Samples of the fastest swing in a period, at least.
const IN_A_PERIOD: f64 = 8.0;
/// Periods of the slowest swing in the longest trace: slower ones are zeros of the traces.
const IN_A_TRACE: f64 = 1.0;
/// Frequencies for each that the length of the set tells from its neighbour.
const FINER: f64 = 2.0;
/// Most products of a frequency and a block that are looked at.
const MOST: f64 = 4e7;
/// Factor in frequency about a swing within which else is looked at.
const AROUND: f64 = 1.5;

/// The mean of the whitened residual over a few neighbouring samples.
struct Block {
    /// Time of the first since the set began, s: where a fast line looks slow, its phase there is that which the samples show.
    time: f64,
    /// Its sum over the root of the number of samples: of variance one where it is noise.
    value: f64,
}

impl Swing {
    /// Numbers that describe one: frequency, amplitude and phase.
    pub const NUMBERS: usize = 3;

    /// The slow sine that describes what a model leaves of all samples best; none where no slow one would fit into a trace.
    #[must_use]
    pub fn of(samples: &Problem, fitted: &Fitted) -> Option<Self> {
        let problem = samples.with_chain(&fitted.chain);
        let fastest = FASTEST_HZ.min(1.0 / (IN_A_PERIOD * problem.data().shortest_interval()));
        strongest(&problem, &fitted.point, |slow| slow, fastest)
    }

    /// Whether samples that are `interval`, s, apart show a line of the `mains`, Hz, as a slow one.
    #[must_use]
    pub fn looks_slow(mains: f64, interval: f64) -> bool {
        mains * interval > 0.5 && shown(mains, interval) < OFF_THE_MAINS
    }

    /// The same of a line of the `mains`, Hz, in samples that are `interval`, s, apart: its own frequency is given. None where it would
    /// not [look slow](Self::looks_slow).
    #[must_use]
    pub fn alias(samples: &Problem, fitted: &Fitted, mains: f64, interval: f64) -> Option<Self> {
        if !Self::looks_slow(mains, interval) {
            return None;
        }
        let problem = samples.with_chain(&fitted.chain);
        let still = (mains * interval).round() / interval;
        let sides = [-1.0, 1.0].into_iter().filter_map(|side| {
            let fastest = OFF_THE_MAINS + side * (mains - still);
            let fastest = fastest.min(1.0 / (IN_A_PERIOD * interval));
            strongest(&problem, &fitted.point, |slow| still + side * slow, fastest)
        });
        sides.max_by(|a, b| a.gain.total_cmp(&b.gain))
    }
}

/// The strongest of the sines that look no faster than this, Hz; `of` gives the frequency of one that looks so slow.
fn strongest(
    problem: &Problem,
    point: &[f64],
    of: impl Fn(f64) -> f64,
    fastest: f64,
) -> Option<Swing> {
    let (interval, longest) = (problem.data().shortest_interval(), problem.data().longest());
    let slowest = IN_A_TRACE / longest;
    if fastest <= slowest {
        return None;
    }
    let together = ((1.0 / (IN_A_PERIOD * fastest * interval)) as usize).max(1);
    let mut blocks = blocks(problem, point, together);
    let lasts = blocks.last()?.time - blocks.first()?.time;
    let step = 1.0 / (FINER * lasts.max(interval));
    let count = ((fastest - slowest) / step).min(MOST / blocks.len() as f64) as usize;
    let grid = |slow: f64| (of(slow), of(slow + step) - of(slow));
    let (place, [cosine, sine]) = waves(&blocks, grid(slowest), count)
        .into_iter()
        .enumerate()
        .max_by(|a, b| power(&blocks, a.1).total_cmp(&power(&blocks, b.1)))?;
    let slow = slowest + step * place as f64;
    for block in &mut blocks {
        let turn = TAU * of(slow) * block.time;
        block.value -= cosine * turn.cos() + sine * turn.sin();
    }
    let (from, to) = ((slow / AROUND).max(slowest), (slow * AROUND).min(fastest));
    let around = ((to - from) / step) as usize;
    let left = waves(&blocks, grid(from), around);
    let else_there: f64 = left.into_iter().map(|wave| power(&blocks, wave)).sum();
    // The power of noise has a mean of one.
    let level = (else_there / around.max(1) as f64).max(1.0);
    let (amplitude, gain) = exactly(problem, point, of(slow))?;
    let log_chance = (-0.5 * gain / level + (count as f64).ln()).min(0.0);
    Some(Swing { frequency_hz: of(slow), amplitude, gain, log_chance })
}

/// The whitened residual, so many samples together.
fn blocks(problem: &Problem, point: &[f64], together: usize) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut index = 0;
    problem.each_piece(&[point.to_vec()], |piece, forces| {
        let mut residual: Vec<f64> =
            forces[0].iter().zip(piece.measured).map(|(f, y)| f - y).collect();
        problem.whiten_residual(index, &mut residual);
        index += 1;
        let times = piece.set_time();
        for (values, times) in residual.chunks(together).zip(times.chunks(together)) {
            let count = values.len() as f64;
            let sum = values.iter().sum::<f64>();
            blocks.push(Block { time: times[0], value: -sum / count.sqrt() });
        }
    });
    blocks
}

/// Cosine and sine of every frequency, Hz, of a grid in the blocks, by least squares as if they were at right angles.
fn waves(blocks: &[Block], (from, step): (f64, f64), count: usize) -> Vec<[f64; 2]> {
    let turned = |frequency: f64| -> (Vec<f64>, Vec<f64>) {
        blocks.iter().map(|block| (TAU * frequency * block.time).sin_cos()).unzip()
    };
    // From one frequency to the next the phase of each block turns by the same angle.
    let ((mut sines, mut cosines), (sine_of_step, cosine_of_step)) = (turned(from), turned(step));
    let values: Vec<f64> = blocks.iter().map(|block| block.value).collect();
    let scale = 2.0 / blocks.len() as f64;
    let wave = |_| {
        let (mut cosine, mut sine) = (0.0, 0.0);
        for place in 0..values.len() {
            let (s, c) = (sines[place], cosines[place]);
            cosine += values[place] * c;
            sine += values[place] * s;
            sines[place] = s * cosine_of_step[place] + c * sine_of_step[place];
            cosines[place] = c * cosine_of_step[place] - s * sine_of_step[place];
        }
        [scale * cosine, scale * sine]
    };
    (0..count).map(wave).collect()
}

/// Half of what a wave takes off the sum of squares.
fn power(blocks: &[Block], [cosine, sine]: [f64; 2]) -> f64 {
    0.25 * blocks.len() as f64 * (cosine * cosine + sine * sine)
}

/// Amplitude and gain of a frequency beside the model's own derivatives.
fn exactly(problem: &Problem, point: &[f64], frequency: f64) -> Option<(f64, f64)> {
    let mut waves: [Option<Products>; 2] = [None, None];
    let beside = Beside::of(problem, point, |piece, stretch| {
        let turns = piece.set_time().into_iter().map(|time| TAU * frequency * time);
        let (sines, cosines): (Vec<f64>, Vec<f64>) = turns.map(f64::sin_cos).unzip();
        for (sum, wave) in waves.iter_mut().zip([cosines, sines]) {
            *sum = Some(stretch.products(wave).with(sum.as_ref()));
        }
    })?;
    // Over many periods sine and cosine are at right angles.
    let [cosine, sine] = waves.map(|products| beside.judge(&products?));
    let ((cosine, first), (sine, second)) = (cosine?, sine?);
    Some((cosine.hypot(sine), first + second))
}
