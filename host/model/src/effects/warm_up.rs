//! `warm-up`: the zero of the sensor moves until the electronics are warm.

use super::{Count, Covariate, Effect, Law, Needs, Role, Shape, Sign, Strength};
use crate::{Act, Stage};

const ZERO: Strength = Strength {
    name: "zero",
    unit: "N",
    meaning: "how far the zero moves in the end",
    sign: Sign::Either,
    typical: |scales| 0.005 * scales.force,
    most: |scales| scales.force,
    count: Count::Fixed(&[]),
};

const TIME: Shape = Shape {
    name: "time",
    unit: "s",
    meaning: "time in which the electronics become warm",
    grid: |scales| [0.05, 0.3].map(|part| part * scales.set_duration).to_vec(),
    role: Role::Fitted(|scales| (0.005 * scales.set_duration, 30.0 * scales.set_duration)),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "warm-up",
    stage: Stage::Sensor,
    meaning: "Gauges and amplifier heat themselves after they are switched on, and the zero moves until they are warm.",
    signature: "A zero that moves in the first traces, also off the specimen, and then stays.",
    against: Covariate::SetTime,
    confused_with: &["drift", "thermal-output", "zero-shift"],
    experiment: "Switch on, and record half an hour with no load at steady temperature.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "F → F + b (1 − e^(−t_set/τ))",
            strength: ZERO,
            shapes: &[TIME],
            act: Act::Added(|scene, parameters, _, force| {
                for (k, force) in force.iter_mut().enumerate() {
                    *force -= parameters[0] * (-scene.set_time(k) / parameters[1]).exp_m1();
                }
            }),
        },
        Law {
            name: "hyperbolic",
            formula: "F → F + b t_set/(t_set + τ)",
            strength: ZERO,
            shapes: &[TIME],
            act: Act::Added(|scene, parameters, _, force| {
                for (k, force) in force.iter_mut().enumerate() {
                    let time = scene.set_time(k);
                    *force += parameters[0] * time / (time + parameters[1]);
                }
            }),
        },
        Law {
            name: "zeroed-warm",
            formula: "F → F + b e^(−t_set/τ)",
            strength: Strength { meaning: "how far the zero is off at the beginning", ..ZERO },
            shapes: &[TIME],
            act: Act::Added(|scene, parameters, _, force| {
                for (k, force) in force.iter_mut().enumerate() {
                    *force += parameters[0] * (-scene.set_time(k) / parameters[1]).exp();
                }
            }),
        },
    ],
};
