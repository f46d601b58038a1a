//! A practice data set: a random specimen with effects that its base law lacks, and noise.

use rand::seq::{IndexedRandom, SliceRandom};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::left::Ground;
use super::sealed::{Truth, VERSION};
use super::session::ten_traces;
use crate::criticism::screen::ABSORBED;
use palpate_fit::data::{Data, DataError};
use palpate_fit::whole_motion::predict;
use palpate_model::effects::{
    Effect, EffectError, LIBRARY, Law, Setting, Sign, chain_of, find, store,
};
use palpate_model::{Applied, BaseLaw, Chain, Model, Separation};
use palpate_trace::{FORCE, Trace};

/// What to hide.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// These effects, by name.
    Named(Vec<String>),
    /// So many, drawn from the library.
    Any(usize),
}

/// A practice data set with its truth.
#[derive(Clone, Debug)]
pub struct Practice {
    /// The traces, in order of recording; their paths are their file names.
    pub traces: Vec<Trace>,
    /// What is in them.
    pub truth: Truth,
}

/// Why a practice set cannot be made.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum HideError {
    #[error(transparent)]
    Effect(#[from] EffectError),
    #[error(transparent)]
    Data(#[from] DataError),
    #[error("no practice set in order: its traces have `start_s` in their heads")]
    NoTraces,
    #[error("the motion has no `displacement_mm`")]
    NoMotion,
    #[error("{0}")]
    Gap(String),
    #[error("`{0}` is named twice")]
    Twice(String),
    #[error("the size is {0}; it must be above 0 and at most {MOST_SIZE}")]
    Size(f64),
    #[error("{0} effects cannot be hidden at once; at most {MOST_EFFECTS}")]
    TooMany(usize),
    #[error(
        "`{effect}` cannot be made to leave {size} times the noise on traces like these; try another seed or size"
    )]
    OutOfReach { effect: String, size: f64 },
}

/// Largest misfit over the noise.
const MOST_SIZE: f64 = 100.0;
/// Most effects hidden at once.
const MOST_EFFECTS: usize = 5;
/// How far a shape is from the grid at most, in parts of its range.
const NEAR_GRID: f64 = 0.04;
/// Refits of the base law to come to the size asked for.
const REFITS: usize = 8;
/// Relative difference from that size that does not count.
const NEAR: f64 = 0.02;
/// Laws and shapes drawn before an effect counts as out of reach.
const DRAWS: usize = 20;
/// Rest before one more recording, s.
const PAUSE_S: f64 = 60.0;
/// Streams of the random numbers: what is hidden changes neither session nor noise.
#[derive(Clone, Copy)]
enum Stream {
    Session,
    Effects,
    Noise,
}

/// Makes ten traces of a random specimen in which effects are hidden, each so strong that the misfit
/// it leaves, after the base law is refitted, is `size` times the noise.
///
/// # Errors
/// When an effect is unknown or named twice, or cannot be made so large.
pub fn hide(choice: &Choice, size: f64, seed: u64) -> Result<Practice, HideError> {
    let (mut wanted, count) = named(choice)?;
    if !(size > 0.0 && size <= MOST_SIZE) {
        return Err(HideError::Size(size));
    }
    if count > MOST_EFFECTS {
        return Err(HideError::TooMany(count));
    }
    let stream = |of: Stream| stream(seed, of as u64);
    let (mut session, mut effects) = (stream(Stream::Session), stream(Stream::Effects));
    let (mut traces, _) = ten_traces(&mut session);
    let base = Chain::new(BaseLaw::fung(2, Separation::Clamp));
    let values = specimen(&mut session);
    let bare = predict(&base, &values, &Data::of_motions(&traces, FORCE)?);
    let range = bare.iter().flatten().fold(0.0, |most: f64, force| most.max(force.abs()));
    let noise = range / session.random_range(200f64.ln()..1000f64.ln()).exp();
    let correlation = session.random_range(0.3..0.7);
    for (trace, force) in traces.iter_mut().zip(bare) {
        trace.set_column(FORCE, force);
    }
    let data = Data::of(&traces, FORCE)?;
    let setting = data.setting();
    let ground = Ground::new(&base, &values, &data);
    if matches!(choice, Choice::Any(_)) {
        wanted.shuffle(&mut effects);
    }
    let (mut chain, mut own) = (base.clone(), Vec::new());
    for effect in &wanted {
        if chain.effects.len() == count {
            break;
        }
        match drawn(effect, &setting, &ground, &base, size * noise, &mut effects) {
            Some((applied, parameters)) => {
                chain.effects.push(applied);
                own.extend(parameters);
            }
            // Drawn from the library, another takes its place.
            None if matches!(choice, Choice::Any(_)) => {}
            None => return Err(HideError::OutOfReach { effect: effect.name.into(), size }),
        }
    }
    let misfit = ground.refitted(&chain, &own).unwrap_or_else(|| ground.misfit(&chain, &own).left);
    let all = [&values[..], &own].concat();
    let unknown = vec![None; all.len()];
    let truth = Truth {
        version: VERSION,
        seed,
        size,
        misfit_over_noise: misfit / noise,
        noise_rms: noise,
        noise_correlation: correlation,
        model: Model {
            name: Some(format!("the truth of practice set {seed}")),
            reference_temperature: data.reference_temperature,
            effects: store(&chain, &all, &unknown),
            ..Model::of(&chain.base, FORCE, &values, &unknown)
        },
    };
    let force = predict(&chain, &all, &data);
    let mut random = stream(Stream::Noise);
    let measured: Vec<Vec<f64>> =
        force.into_iter().map(|force| measured(force, noise, correlation, &mut random)).collect();
    for (trace, measured) in traces.iter_mut().zip(measured) {
        trace.set_column(FORCE, measured);
    }
    Ok(Practice { traces, truth })
}

/// Random numbers of a seed that no other stream of it has.
fn stream(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(stream);
    random
}

/// Records one more motion on the specimen of a practice set, a minute after the last of its traces.
///
/// # Errors
/// When the traces are not those of the set, or the motion is not usable.
pub fn record(truth: &Truth, traces: &[Trace], motion: &Trace) -> Result<Trace, HideError> {
    let last = traces.last().ok_or(HideError::NoTraces)?;
    let begin = last.head.setup.start_s.ok_or(HideError::NoTraces)? + last.duration() + PAUSE_S;
    let number = traces.len() + 1;
    let (_, around) = ten_traces(&mut stream(truth.seed, Stream::Session as u64));
    let displacement = motion.displacement().ok_or(HideError::NoMotion)?;
    let mut trace = around.recorded(&motion.time, displacement, number, begin);
    trace.head.name = Some(format!("practice, recording {number}"));
    trace.path = Some(format!("recording-{number:02}.csv").into());
    let set: Vec<Trace> = traces.iter().cloned().chain([trace.clone()]).collect();
    let data = Data::of_motions(&set, FORCE)?.with_reference(truth.model.reference_temperature);
    if let Some(what) = data.left_out.first() {
        return Err(HideError::Gap(what.clone()));
    }
    let (chain, values) = chain_of(&truth.model, &data.setting())?;
    let force = predict(&chain, &values, &data).pop().unwrap_or_default();
    let mut random = stream(truth.seed, Stream::Noise as u64 + number as u64);
    let force = measured(force, truth.noise_rms, truth.noise_correlation, &mut random);
    trace.set_column(FORCE, force);
    Ok(trace)
}

/// The effects to take from, and how many of them.
fn named(choice: &Choice) -> Result<(Vec<&'static Effect>, usize), HideError> {
    let names = match choice {
        Choice::Any(count) => return Ok((LIBRARY.to_vec(), *count)),
        Choice::Named(names) => names,
    };
    let mut wanted: Vec<&Effect> = Vec::new();
    for name in names {
        let effect = find(name).ok_or_else(|| EffectError::Unknown(name.clone()))?;
        if wanted.iter().any(|known| known.name == effect.name) {
            return Err(HideError::Twice(name.clone()));
        }
        wanted.push(effect);
    }
    let count = wanted.len();
    Ok((wanted, count))
}

/// p, q, c1, c2, v1, v2 of a soft fingertip: 2 to 10 N at 12 mm.
fn specimen(random: &mut ChaCha8Rng) -> Vec<f64> {
    let force = random.random_range(2f64.ln()..10f64.ln()).exp();
    let q = random.random_range(0.3..1.0);
    let p = force * (q + 1.0) / 12f64.powf(q + 1.0);
    let shares = [random.random_range(0.18..0.32), random.random_range(0.15..0.3)];
    let rates = [random.random_range(2.5..7.0), random.random_range(0.3..0.8)];
    vec![p, q, shares[0], shares[1], rates[0], rates[1]]
}

/// A law of the effect with parameters that leave the misfit `target`; none where no law drawn can.
fn drawn(
    effect: &Effect,
    setting: &Setting,
    ground: &Ground,
    base: &Chain,
    target: f64,
    random: &mut ChaCha8Rng,
) -> Option<(Applied, Vec<f64>)> {
    effect.needs.missing(setting).is_none().then_some(())?;
    let laws: Vec<_> = effect.laws_on(&setting.scales).collect();
    (0..DRAWS).find_map(|_| {
        let law = *laws.choose(random)?;
        let applied = law.applied(effect, setting);
        let shapes = shapes(law, setting, random);
        let parts = parts(law, applied.strengths, random);
        let chain = base.with(applied.clone());
        let parameters = |strength: f64| -> Vec<f64> {
            parts.iter().map(|part| part * strength).chain(shapes.iter().copied()).collect()
        };
        let left = |strength: f64| ground.misfit(&chain, &parameters(strength));
        let largest = parts.iter().fold(0.0, |most: f64, part| most.max(part.abs()));
        let typical = (law.strength.typical)(&setting.scales);
        let most = ((law.strength.most)(&setting.scales) / largest).min(1e3 * typical);
        let (mut low, mut high) = (1e-4 * typical, most);
        if left(high).left < target || left(low).left > target {
            return None;
        }
        while high / low > 1.0001 {
            let middle = (low * high).sqrt();
            if left(middle).left < target {
                low = middle;
            } else {
                high = middle;
            }
        }
        // The base law bends, and takes up more of a strong effect than its derivatives say.
        let mut strength = high;
        for _ in 0..REFITS {
            let refitted = ground.refitted(&chain, &parameters(strength))?;
            let near = (refitted / target - 1.0).abs() < NEAR;
            // What the base law takes up nearly whole is no exercise.
            if near && refitted > ABSORBED * left(strength).whole {
                return Some((applied, parameters(strength)));
            }
            strength = (strength * (target / refitted).clamp(0.5, 2.0)).min(most);
        }
        None
    })
}

/// Shapes near a point of the grid of each.
fn shapes(law: &Law, setting: &Setting, random: &mut ChaCha8Rng) -> Vec<f64> {
    let scales = &setting.scales;
    let shape = |shape: &palpate_model::effects::Shape| {
        let grid = (shape.grid)(scales);
        let at = random.random_range(0..grid.len());
        let Some((lower, upper)) = shape.role.bounds(scales) else { return grid[at] };
        let gaps = [at.checked_sub(1), Some(at + 1)].into_iter().flatten();
        let near = gaps
            .filter_map(|other| grid.get(other))
            .map(|other| (other - grid[at]).abs())
            .fold(f64::INFINITY, f64::min);
        let room = (0.5 * near).min(NEAR_GRID * (upper - lower));
        (grid[at] + random.random_range(-1.0..1.0) * room).clamp(lower, upper)
    };
    law.shapes.iter().map(shape).collect()
}

/// The strengths in units of one size: of either sign where physics allows, and of several sizes where
/// there are several.
fn parts(law: &Law, count: usize, random: &mut ChaCha8Rng) -> Vec<f64> {
    (0..count)
        .map(|_| {
            let size = if count == 1 { 1.0 } else { random.random_range(0.4..1.6) };
            let negative = law.strength.sign == Sign::Either && random.random_bool(0.5);
            if negative { -size } else { size }
        })
        .collect()
}

/// The force with noise that is a first-order autoregression, as the converter gives it.
fn measured(force: Vec<f64>, noise: f64, correlation: f64, random: &mut ChaCha8Rng) -> Vec<f64> {
    const STEPS: f64 = 1e6;
    let fresh = noise * (1.0 - correlation * correlation).sqrt();
    let mut normal = || -> f64 { StandardNormal.sample(random) };
    let mut error = noise * normal();
    let add = |force: f64| {
        let value = force + error;
        error = correlation * error + fresh * normal();
        (value * STEPS).round() / STEPS
    };
    force.into_iter().map(add).collect()
}
