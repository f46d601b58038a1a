//! The next experiment: of a menu, the one that would set the members of a credible set furthest apart.

use super::compare::Cell;
use super::fitted::Fitted;
use super::search::Found;
use super::separation::{Condition, Rivals, TELLS, signal_of, squares};
use palpate_fit::data::Data;
use palpate_fit::whitening::Whitening;
use palpate_model::effects::Scales;
use palpate_model::{BaseLaw, Chain, Hold, Move, Profile, Stage, Step};
use palpate_trace::Trace;

/// An experiment of the menu.
pub struct Experiment {
    /// What to do.
    pub text: &'static str,
    /// Seconds of rest before it.
    rest: f64,
    /// Temperature above the reference, K.
    warmer: f64,
    /// Whether a rigid block takes the specimen's place.
    rigid: bool,
    /// The motion.
    motion: fn(&Scales) -> Profile,
}

/// How far an experiment would set the members of a credible set apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposal {
    /// What to do.
    pub text: String,
    /// Predicted misfit, in sums of squares over the noise, of the member that is then worst told from
    /// the first, after it is refitted.
    pub separates: f64,
}

/// The menu.
pub const MENU: [Experiment; 10] = [
    Experiment {
        text: "repeat one cycle three times at the same amplitude",
        rest: 60.0,
        warmer: 0.0,
        rigid: false,
        motion: |scales| cycles(scales, &[0.7, 0.7, 0.7], 1.0),
    },
    Experiment {
        text: "rest ten minutes, then repeat one cycle twice",
        rest: 600.0,
        warmer: 0.0,
        rigid: false,
        motion: |scales| cycles(scales, &[1.0, 1.0], 1.0),
    },
    Experiment {
        text: "cycles of descending amplitude",
        rest: 60.0,
        warmer: 0.0,
        rigid: false,
        motion: |scales| cycles(scales, &[1.0, 0.75, 0.5, 0.25], 1.0),
    },
    Experiment {
        text: "triangles without holds, slow and fast",
        rest: 60.0,
        warmer: 0.0,
        rigid: false,
        motion: triangles,
    },
    Experiment {
        text: "small cycles, slow and fast",
        rest: 60.0,
        warmer: 0.0,
        rigid: false,
        motion: small_cycles,
    },
    Experiment {
        text: "the same stroke without contact",
        rest: 60.0,
        warmer: 0.0,
        rigid: false,
        motion: |scales| {
            path(
                scales,
                -0.1 - 1.1 * scales.compression,
                &[(-0.1, 1.0), (-1.1, 1.0), (-0.1, 0.1), (-1.1, 0.1)],
                0.5,
            )
        },
    },
    Experiment {
        text: "press a rigid block at fifty times the rate",
        rest: 60.0,
        warmer: 0.0,
        rigid: true,
        motion: |scales| {
            path(scales, -0.05, &[(0.02, 2.0), (-0.05, 2.0), (0.02, 0.5), (-0.05, 0.5)], 0.3)
        },
    },
    Experiment {
        text: "step the temperature by 5 K, wait, and repeat a press with a hold",
        rest: 1200.0,
        warmer: 5.0,
        rigid: false,
        motion: |scales| cycles(scales, &[0.7], 8.0),
    },
    Experiment {
        text: "an hour with no load",
        rest: 60.0,
        warmer: 0.0,
        rigid: false,
        motion: |_| Profile { rate_hz: 0.5, ..profile(-1.0, 1.0, 200.0, vec![hold(3600.0)]) },
    },
    Experiment {
        text: "a synchronising tap: a few short, fast presses",
        rest: 60.0,
        warmer: 0.0,
        rigid: false,
        motion: |scales| {
            path(scales, -0.05, &[(0.2, 1.0), (-0.05, 1.0), (0.2, 1.0), (-0.05, 1.0)], 0.3)
        },
    },
];

/// Samples of the data set above which the history of the specimen is not simulated again.
const MOST_HISTORY: usize = 300_000;
/// Most members of a credible set that are compared.
pub const MOST_MEMBERS: usize = 4;

/// The experiment that would tell the members best apart; none where no experiment of the menu tells all of
/// them apart beyond the noise.
#[must_use]
pub fn next_experiment(rivals: &Rivals, data: &Data) -> Option<Proposal> {
    let members = &rivals.members[..rivals.members.len().min(MOST_MEMBERS)];
    if members.len() < 2 || data.samples() > MOST_HISTORY {
        return None;
    }
    let rivals = Rivals { members, ..*rivals };
    let scales = data.scales();
    MENU.iter()
        .filter(|experiment| experiment.warmer == 0.0 || data.reference_temperature.is_some())
        .filter_map(|experiment| {
            let separates = experiment.separates(&rivals, &scales)?;
            Some(Proposal { text: experiment.text.into(), separates })
        })
        .filter(|proposal| proposal.separates > TELLS)
        .max_by(|a, b| a.separates.total_cmp(&b.separates))
}

/// The experiment that would decide between the members of the first credible set with several.
pub(super) fn deciding(
    found: &Found,
    data: &Data,
    traces: &[Trace],
    whitening: &Whitening,
) -> Option<String> {
    let members = found.undecided();
    let (name, _) = members.first()?;
    let models: Vec<&Fitted> = members.iter().map(|(_, fitted)| *fitted).collect();
    let rivals = Rivals {
        members: &models,
        signal: &data.signal,
        reference_temperature: data.reference_temperature,
        traces,
        whitening,
    };
    let proposal = next_experiment(&rivals, data);
    // Where no simulation tells them apart, the effect's own declaration may know a way.
    let declared = || data.effects.find(name).map(|effect| effect.experiment.to_owned());
    proposal.map(|proposal| proposal.text).or_else(declared)
}

/// A repetition of the recording in which most is left: what repeats is no accident.
pub(super) fn repeating(places: &[Cell], labels: &[String]) -> Option<String> {
    let most = places.iter().max_by(|a, b| a.share_of_excess.total_cmp(&b.share_of_excess))?;
    Some(format!(
        "repeat {} twice: what comes back in the {} is the specimen's or the sensor's, what does not was an accident",
        labels[most.trace],
        most.region.name()
    ))
}

impl Experiment {
    /// The motion, where it is one of the specimen as it is: not of a block, nor of a warmer one.
    #[must_use]
    pub fn plain(&self, scales: &Scales) -> Option<Profile> {
        (!self.rigid && self.warmer == 0.0).then(|| (self.motion)(scales))
    }

    /// Predicted misfit of the two members that are told apart least.
    fn separates(&self, rivals: &Rivals, scales: &Scales) -> Option<f64> {
        let motion = (self.motion)(scales).motion();
        let under = Condition { rest: self.rest, warmer: self.warmer };
        let trace = rivals.trace(motion.time.to_vec(), motion.displacement.to_vec(), under);
        if self.rigid {
            on_a_rigid_block(rivals, trace, scales)
        } else {
            Some(rivals.foresee(trace)?.separates())
        }
    }
}

/// Predicted misfit of the member told least from the first where a block takes the specimen's place.
fn on_a_rigid_block(rivals: &Rivals, trace: Trace, scales: &Scales) -> Option<f64> {
    let set = [trace];
    let all = Data::of_motions(&set, rivals.signal).ok()?;
    let all = all.with_reference(rivals.reference_temperature);
    let mut predicted = rivals.members.iter().map(|member| {
        let (chain, values) = without_specimen(member, scales);
        signal_of(&chain, &values, &all, 0)
    });
    let first = predicted.next()?;
    predicted
        .map(|other| {
            let mut difference: Vec<f64> = other.iter().zip(&first).map(|(a, b)| a - b).collect();
            rivals.whitening.apply(&mut difference);
            squares(&difference)
        })
        .min_by(f64::total_cmp)
}

/// Only what does not belong to the specimen, on a block that gives a fiftieth of the stroke at full
/// force.
fn without_specimen(member: &Fitted, scales: &Scales) -> (Chain, Vec<f64>) {
    let base = BaseLaw::fung(1, member.chain.base.separation);
    let mut chain = Chain::new(base);
    let mut values = vec![scales.force / (0.02 * scales.compression), 0.0, 0.0, 1.0];
    for (index, effect) in member.chain.effects.iter().enumerate() {
        if !matches!(effect.stage, Stage::Elasticity | Stage::Relaxation) {
            chain.effects.push(effect.clone());
            values.extend_from_slice(&member.values[member.chain.range(index)]);
        }
    }
    (chain, values)
}

fn profile(start: f64, speed: f64, rate: f64, steps: Vec<Step>) -> Profile {
    Profile {
        version: 1,
        rate_hz: rate,
        start_mm: start,
        speed_mm_per_s: speed,
        acceleration_mm_per_s2: None,
        repeat: 1,
        steps,
    }
}

fn hold(seconds: f64) -> Step {
    Step::Hold(Hold { hold_s: seconds })
}

fn go(to: f64, speed: f64) -> Step {
    Step::Move(Move { to_mm: to, speed_mm_per_s: Some(speed) })
}

fn rate(scales: &Scales) -> f64 {
    (1.0 / scales.interval).clamp(1e-3, 1e4)
}

/// Half the largest speed, mm/s.
fn usual(scales: &Scales) -> f64 {
    (0.5 * scales.speed).max(1e-6)
}

/// Presses to these parts of the largest compression, with a hold after each and a rest between.
fn cycles(scales: &Scales, parts: &[f64], hold_s: f64) -> Profile {
    let (off, speed) = (-0.05 * scales.compression, usual(scales));
    let mut steps = vec![hold(0.5)];
    for part in parts {
        steps.extend([
            go(part * scales.compression, speed),
            hold(hold_s),
            go(off, speed),
            hold(1.0),
        ]);
    }
    profile(off, speed, rate(scales), steps)
}

/// Moves to places, in parts of the largest compression, at parts of the largest speed, with a short rest
/// after each.
fn path(scales: &Scales, start: f64, places: &[(f64, f64)], rest: f64) -> Profile {
    let mut steps = vec![hold(rest)];
    for (place, part) in places {
        let speed = (part * scales.speed).max(1e-6);
        steps.extend([go(place * scales.compression, speed), hold(rest)]);
    }
    profile(start, usual(scales), rate(scales), steps)
}

fn triangles(scales: &Scales) -> Profile {
    let off = -0.05 * scales.compression;
    let mut steps = vec![hold(0.5)];
    for part in [0.05, 0.3, 1.0] {
        let speed = (part * scales.speed).max(1e-6);
        for _ in 0..2 {
            steps.extend([go(scales.compression, speed), go(off, speed)]);
        }
    }
    steps.push(hold(1.0));
    profile(off, usual(scales), rate(scales), steps)
}

fn small_cycles(scales: &Scales) -> Profile {
    let off = -0.05 * scales.compression;
    let mut steps = vec![hold(0.5), go(0.5 * scales.compression, usual(scales)), hold(2.0)];
    for part in [0.02, 0.1, 0.5] {
        let speed = (part * scales.speed).max(1e-6);
        for _ in 0..4 {
            steps.extend([
                go(0.55 * scales.compression, speed),
                go(0.45 * scales.compression, speed),
            ]);
        }
    }
    steps.extend([go(off, usual(scales)), hold(1.0)]);
    profile(off, usual(scales), rate(scales), steps)
}
