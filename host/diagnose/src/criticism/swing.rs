//! A slow swing: a sine of one frequency through all traces and the pauses between them, of the building, the air
//! conditioning or the supply. No effect of the library is one, and to noise that was seen for a second it looks like flicker.

use std::f64::consts::TAU;

use palpate_fit::problem::Problem;

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
    /// Time since the set began, s.
    time: f64,
    /// Its sum over the root of the number of samples: of variance one where it is noise.
    value: f64,
}

impl Swing {
    /// Numbers that describe one: frequency, amplitude and phase.
    pub const NUMBERS: usize = 3;

    /// The sine that describes what a model leaves of all samples best; none where no slow one would fit into a trace.
    #[must_use]
    pub fn of(samples: &Problem, fitted: &Fitted) -> Option<Self> {
        let problem = samples.with_chain(&fitted.chain);
        let data = problem.data();
        let interval = data.shortest_interval();
        let fastest = FASTEST_HZ.min(1.0 / (IN_A_PERIOD * interval));
        let together = ((1.0 / (IN_A_PERIOD * fastest * interval)) as usize).max(1);
        let mut blocks = blocks(&problem, &fitted.point, together);
        let lasts = blocks.last()?.time - blocks.first()?.time;
        let step = 1.0 / (FINER * lasts.max(interval));
        let slowest = IN_A_TRACE / data.longest();
        let count = ((fastest - slowest) / step).min(MOST / blocks.len() as f64) as usize;
        let (frequency, [cosine, sine]) = waves(&blocks, slowest, step, count)
            .into_iter()
            .max_by(|a, b| power(&blocks, a.1).total_cmp(&power(&blocks, b.1)))?;
        for block in &mut blocks {
            let turn = TAU * frequency * block.time;
            block.value -= cosine * turn.cos() + sine * turn.sin();
        }
        let (from, to) = ((frequency / AROUND).max(slowest), (frequency * AROUND).min(fastest));
        let around = ((to - from) / step) as usize;
        let else_there: f64 = waves(&blocks, from, step, around)
            .into_iter()
            .map(|(_, wave)| power(&blocks, wave))
            .sum();
        // The power of noise has a mean of one.
        let level = (else_there / around.max(1) as f64).max(1.0);
        let (amplitude, gain) = exactly(&problem, &fitted.point, frequency)?;
        let log_chance = (-0.5 * gain / level + (count as f64).ln()).min(0.0);
        Some(Self { frequency_hz: frequency, amplitude, gain, log_chance })
    }
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
            let (sum, time) = (values.iter().sum::<f64>(), times.iter().sum::<f64>() / count);
            blocks.push(Block { time, value: -sum / count.sqrt() });
        }
    });
    blocks
}

/// Cosine and sine of every frequency of a grid in the blocks, by least squares as if they were at right angles.
fn waves(blocks: &[Block], from: f64, step: f64, count: usize) -> Vec<(f64, [f64; 2])> {
    let turned = |frequency: f64| -> (Vec<f64>, Vec<f64>) {
        blocks.iter().map(|block| (TAU * frequency * block.time).sin_cos()).unzip()
    };
    // From one frequency to the next the phase of each block turns by the same angle.
    let ((mut sines, mut cosines), (sine_of_step, cosine_of_step)) = (turned(from), turned(step));
    let values: Vec<f64> = blocks.iter().map(|block| block.value).collect();
    let scale = 2.0 / blocks.len() as f64;
    let wave = |k: usize| {
        let (mut cosine, mut sine) = (0.0, 0.0);
        for place in 0..values.len() {
            let (s, c) = (sines[place], cosines[place]);
            cosine += values[place] * c;
            sine += values[place] * s;
            sines[place] = s * cosine_of_step[place] + c * sine_of_step[place];
            cosines[place] = c * cosine_of_step[place] - s * sine_of_step[place];
        }
        (from + step * k as f64, [scale * cosine, scale * sine])
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
