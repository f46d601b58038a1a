//! A slow swing: a sine of one frequency through all traces and the pauses between them, of the building, the air
//! conditioning or the supply. No effect of the library is one, and to noise that was seen for a second it looks like flicker.

use std::f64::consts::TAU;

use palpate_fit::data::Data;
use palpate_fit::problem::Problem;
use palpate_fit::whitening::Whitening;

use super::beside::{Own, Products};
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

    /// The sine that describes what a model leaves best; none where no slow one would fit into a trace.
    #[must_use]
    pub fn of(problem: &Problem, fitted: &Fitted, whitening: &Whitening) -> Option<Self> {
        let problem = problem.with_chain(&fitted.chain);
        let data = problem.data();
        let interval = data.shortest_interval();
        let fastest = FASTEST_HZ.min(1.0 / (IN_A_PERIOD * interval));
        let samples = ((1.0 / (IN_A_PERIOD * fastest * interval)) as usize).max(1);
        let mut blocks = blocks(&problem, fitted, whitening, samples);
        let lasts = blocks.last()?.time - blocks.first()?.time;
        let step = 1.0 / (FINER * lasts.max(interval));
        let slowest = IN_A_TRACE / data.longest();
        let count = ((fastest - slowest) / step).min(MOST / blocks.len() as f64) as usize;
        let powers = (0..count).map(|k| {
            let frequency = slowest + step * k as f64;
            (frequency, wave(&blocks, frequency))
        });
        let (frequency, [cosine, sine]) =
            powers.max_by(|a, b| power(&blocks, a.1).total_cmp(&power(&blocks, b.1)))?;
        for block in &mut blocks {
            let turn = TAU * frequency * block.time;
            block.value -= cosine * turn.cos() + sine * turn.sin();
        }
        let (from, to) = ((frequency / AROUND).max(slowest), (frequency * AROUND).min(fastest));
        let around = ((to - from) / step) as usize;
        let else_there = (0..around).map(|k| power(&blocks, wave(&blocks, from + step * k as f64)));
        // The power of noise has a mean of one.
        let level = (else_there.sum::<f64>() / around.max(1) as f64).max(1.0);
        let (amplitude, gain) = exactly(&problem, fitted, whitening, frequency)?;
        let log_chance = (-0.5 * gain / level + (count as f64).ln()).min(0.0);
        Some(Self { frequency_hz: frequency, amplitude, gain, log_chance })
    }
}

fn blocks(problem: &Problem, fitted: &Fitted, whitening: &Whitening, samples: usize) -> Vec<Block> {
    let mut blocks = Vec::new();
    problem.each_piece(std::slice::from_ref(&fitted.point), |piece, forces| {
        let mut residual: Vec<f64> =
            piece.measured.iter().zip(&forces[0]).map(|(y, f)| y - f).collect();
        whitening.apply(&mut residual);
        let times = set_times(problem.data(), piece);
        for (values, times) in residual.chunks(samples).zip(times.chunks(samples)) {
            let count = values.len() as f64;
            let (sum, time) = (values.iter().sum::<f64>(), times.iter().sum::<f64>() / count);
            blocks.push(Block { time, value: sum / count.sqrt() });
        }
    });
    blocks
}

fn set_times(data: &Data, piece: &palpate_fit::data::Piece) -> Vec<f64> {
    let scene = data.scene(piece);
    (0..scene.len()).map(|k| scene.set_time(k)).collect()
}

/// Cosine and sine of a frequency in the blocks, by least squares as if they were at right angles.
fn wave(blocks: &[Block], frequency: f64) -> [f64; 2] {
    let (mut cosine, mut sine) = (0.0, 0.0);
    for block in blocks {
        let (sin, cos) = (TAU * frequency * block.time).sin_cos();
        cosine += block.value * cos;
        sine += block.value * sin;
    }
    [cosine, sine].map(|sum| 2.0 * sum / blocks.len() as f64)
}

/// Half of what a wave takes off the sum of squares.
fn power(blocks: &[Block], [cosine, sine]: [f64; 2]) -> f64 {
    0.25 * blocks.len() as f64 * (cosine * cosine + sine * sine)
}

/// Amplitude and gain of a frequency beside the model's own derivatives.
fn exactly(
    problem: &Problem,
    fitted: &Fitted,
    whitening: &Whitening,
    frequency: f64,
) -> Option<(f64, f64)> {
    let mut own = Own::new(fitted.point.len(), problem.data().labels.len(), whitening);
    let mut waves: Option<[Products; 2]> = None;
    problem.derivatives(&fitted.point, |piece, mut residual, columns| {
        residual.iter_mut().for_each(|r| *r = -*r);
        let stretch = own.add(piece.trace, residual, columns);
        let turns = set_times(problem.data(), piece).into_iter().map(|time| TAU * frequency * time);
        let (sines, cosines): (Vec<f64>, Vec<f64>) = turns.map(f64::sin_cos).unzip();
        let here = [stretch.products(cosines), stretch.products(sines)];
        match &mut waves {
            Some(sums) => sums.iter_mut().zip(&here).for_each(|(sum, here)| sum.add(here)),
            None => waves = Some(here),
        }
    });
    let beside = own.solved()?;
    // Over many periods sine and cosine are at right angles.
    let [cosine, sine] = waves?.map(|products| beside.judge(&products));
    let ((cosine, first), (sine, second)) = (cosine?, sine?);
    Some((cosine.hypot(sine), first + second))
}
