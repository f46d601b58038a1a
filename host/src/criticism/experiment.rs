//! The next experiment: of a menu, the one on which the members of a credible set would disagree most
//! after each had been refitted to it (T-optimality, Atkinson and Fedorov 1975).

use nalgebra::{DMatrix, DVector};

use super::fitted::Fitted;
use crate::effects::Scales;
use crate::fit::data::Data;
use crate::fit::problem::Problem;
use crate::fit::whitening::Whitening;
use crate::model::{BaseLaw, Chain, Hold, Move, Profile, Stage, Step};
use crate::trace::{Column, DISPLACEMENT, TEMPERATURE, Trace};

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
/// Members of a credible set that are compared with the first.
const MOST_MEMBERS: usize = 4;

/// The experiment that would tell the first member best from the others; none where no experiment of the
/// menu tells them apart beyond the noise.
#[must_use]
pub fn next_experiment(
    members: &[&Fitted],
    data: &Data,
    traces: &[Trace],
    whitening: &Whitening,
) -> Option<Proposal> {
    let members = &members[..members.len().min(MOST_MEMBERS)];
    if members.len() < 2 || data.samples() > MOST_HISTORY {
        return None;
    }
    let scales = data.scales();
    let noise = whitening.standard_deviation();
    MENU.iter()
        .filter(|experiment| experiment.warmer == 0.0 || data.reference_temperature.is_some())
        .filter_map(|experiment| {
            let separates = experiment.separates(members, data, traces, &scales, noise)?;
            Some(Proposal { text: experiment.text.into(), separates })
        })
        .filter(|proposal| proposal.separates > TOLD)
        .max_by(|a, b| a.separates.total_cmp(&b.separates))
}

/// Sum of squares over the noise below which an experiment does not tell.
const TOLD: f64 = 10.0;

impl Experiment {
    /// Predicted misfit of the member worst told from the first.
    fn separates(
        &self,
        members: &[&Fitted],
        data: &Data,
        traces: &[Trace],
        scales: &Scales,
        noise: f64,
    ) -> Option<f64> {
        let mut set: Vec<Trace> = if self.rigid { Vec::new() } else { traces.to_vec() };
        set.push(self.trace(scales, data, traces));
        let all =
            Data::of_motions(&set, &data.signal).ok()?.with_reference(data.reference_temperature);
        let own = set.len() - 1;
        let first = self.predicted(members[0], &all, own, scales);
        members[1..]
            .iter()
            .map(|member| {
                let difference: Vec<f64> = self
                    .predicted(member, &all, own, scales)
                    .iter()
                    .zip(&first)
                    .map(|(a, b)| a - b)
                    .collect();
                if self.rigid {
                    return squares(&difference) / (noise * noise);
                }
                after_refit(member, &all, own, &difference, noise)
            })
            .min_by(f64::total_cmp)
    }

    /// The experiment as a recording after the others.
    fn trace(&self, scales: &Scales, data: &Data, traces: &[Trace]) -> Trace {
        let motion = (self.motion)(scales).motion();
        let mut trace = Trace {
            time: motion.time.to_vec(),
            columns: vec![Column {
                name: DISPLACEMENT.into(),
                values: motion.displacement.to_vec(),
            }],
            ..Trace::default()
        };
        if let Some(reference) = data.reference_temperature {
            let temperature = vec![reference + self.warmer; trace.len()];
            trace.set_column(TEMPERATURE, temperature);
        }
        let last = traces.last();
        trace.head.setup.start_s = last
            .and_then(|last| last.head.setup.start_s.map(|start| start + last.duration()))
            .map(|end| end + self.rest);
        trace
    }

    /// What a member says of the recording with index `own`.
    fn predicted(&self, member: &Fitted, all: &Data, own: usize, scales: &Scales) -> Vec<f64> {
        let (chain, values) = if self.rigid {
            on_a_rigid_block(member, scales)
        } else {
            (member.chain.clone(), member.values.clone())
        };
        let white = Whitening::none();
        let problem = Problem::new(&chain, all, &white, None);
        let mut found = Vec::new();
        problem.each_piece(&[problem.point(&values)], |piece, forces| {
            if piece.trace == own {
                found.extend_from_slice(&forces[0]);
            }
        });
        found
    }
}

/// Only what does not belong to the specimen, on a block that gives a fiftieth of the stroke at full
/// force.
fn on_a_rigid_block(member: &Fitted, scales: &Scales) -> (Chain, Vec<f64>) {
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

/// The misfit that is left of a difference once the member is refitted to the data it has and to the
/// experiment.
fn after_refit(member: &Fitted, all: &Data, own: usize, difference: &[f64], noise: f64) -> f64 {
    let white = Whitening::none();
    let problem = Problem::new(&member.chain, all, &white, None);
    let size = member.point.len();
    let mut curvature = DMatrix::zeros(size, size);
    for block in &member.blocks {
        curvature += &block.raw.curvature;
    }
    let mut along = DVector::zeros(size);
    let mut begin = 0;
    problem.derivatives(&member.point, |piece, residual, columns| {
        if piece.trace != own {
            return;
        }
        let end = begin + residual.len();
        let difference = &difference[begin..end];
        begin = end;
        for (i, column) in &columns {
            along[*i] += dot(column, difference);
            for (j, other) in &columns {
                curvature[(*i, *j)] += dot(column, other);
            }
        }
    });
    let scale = curvature.diagonal().map(|v| if v > 0.0 { 1.0 / v.sqrt() } else { 0.0 });
    let scaled = DMatrix::from_fn(size, size, |i, j| {
        curvature[(i, j)] * scale[i] * scale[j] + if i == j { 1e-9 } else { 0.0 }
    });
    let right = along.component_mul(&scale);
    let taken = scaled.cholesky().map_or(0.0, |factor| right.dot(&factor.solve(&right)));
    (squares(difference) - taken).max(0.0) / (noise * noise)
}

fn squares(values: &[f64]) -> f64 {
    dot(values, values)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
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
