//! `drift`: the zero of the sensor wanders steadily.

use super::{Count, Covariate, Effect, Law, Needs, Role, Shape, Sign, Strength};
use crate::{Act, Scene, Stage};

const RATE: Strength = Strength {
    name: "rate",
    unit: "N/min",
    meaning: "how much the zero wanders in a minute",
    sign: Sign::Either,
    typical: |scales| 0.005 * scales.force / (scales.set_duration / MINUTE),
    most: |scales| scales.force / (scales.set_duration / MINUTE),
    count: Count::Fixed(&[]),
};

/// Seconds.
const MINUTE: f64 = 60.0;

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "drift",
    stage: Stage::Sensor,
    meaning: "The zero of the force channel wanders steadily, loaded or not.",
    signature: "A ramp through every phase, also off the specimen, and on from trace to trace.",
    against: Covariate::SetTime,
    confused_with: &["slow-relaxation", "warm-up", "thermal-output", "zero-shift"],
    experiment: "Record an hour with no load.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "F → F + d t_set",
            strength: RATE,
            shapes: &[],
            act: Act::Added(|scene, parameters, _, force| {
                add(force, |k| parameters[0] * minutes(scene, k));
            }),
        },
        Law {
            name: "root",
            formula: "F → F + d √t_set",
            strength: Strength {
                unit: "N/√min",
                meaning: "how much the zero wanders in the first minute",
                typical: |scales| 0.005 * scales.force / (scales.set_duration / MINUTE).sqrt(),
                most: |scales| scales.force / (scales.set_duration / MINUTE).sqrt(),
                ..RATE
            },
            shapes: &[],
            act: Act::Added(|scene, parameters, _, force| {
                add(force, |k| parameters[0] * minutes(scene, k).max(0.0).sqrt());
            }),
        },
        Law {
            name: "onset",
            formula: "F → F + d max(t_set − t_1, 0)",
            strength: RATE,
            shapes: &[Shape {
                name: "onset",
                unit: "s",
                meaning: "time since the data set began at which the zero begins to wander",
                grid: |scales| [0.3, 0.6].map(|part| part * scales.set_duration).to_vec(),
                role: Role::Fitted(|scales| (0.0, 0.95 * scales.set_duration)),
            }],
            act: Act::Added(|scene, parameters, _, force| {
                let onset = parameters[1] / MINUTE;
                add(force, |k| parameters[0] * (minutes(scene, k) - onset).max(0.0));
            }),
        },
        Law {
            name: "accelerating",
            formula: "F → F + d t_set (1 + t_set/T)",
            strength: RATE,
            shapes: &[Shape {
                name: "doubling",
                unit: "s",
                meaning: "time since the data set began in which the zero wanders twice as far as at its first pace",
                grid: |scales| vec![scales.set_duration],
                role: Role::Fitted(|scales| {
                    (0.05 * scales.set_duration, 100.0 * scales.set_duration)
                }),
            }],
            act: Act::Added(|scene, parameters, _, force| {
                let doubling = parameters[1] / MINUTE;
                let way = |time: f64| time * (1.0 + time / doubling);
                add(force, |k| parameters[0] * way(minutes(scene, k)));
            }),
        },
        Law {
            name: "each-trace",
            formula: "F → F + d t, zeroed at the beginning of each trace",
            strength: Strength {
                typical: |scales| 0.005 * scales.force / (scales.duration / MINUTE),
                most: |scales| scales.force / (scales.duration / MINUTE),
                ..RATE
            },
            shapes: &[],
            act: Act::Added(|scene, parameters, _, force| {
                add(force, |k| parameters[0] * scene.since[k] / MINUTE);
            }),
        },
    ],
};

/// Time since the set began, min.
fn minutes(scene: &Scene, k: usize) -> f64 {
    scene.set_time(k) / MINUTE
}

fn add(force: &mut [f64], zero: impl Fn(usize) -> f64) {
    for (k, force) in force.iter_mut().enumerate() {
        *force += zero(k);
    }
}
