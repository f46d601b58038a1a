//! `inertia`: the sensor feels the mass that it moves.

use super::{Count, Covariate, Effect, Law, Needs, Role, Shape, Sign, Strength};
use crate::low_pass;
use crate::{Act, Stage};

/// Newtons for each kg mm/s².
const NEWTON: f64 = 1e-3;

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "inertia",
    stage: Stage::Contact,
    meaning: "The force sensor accelerates the mass between it and the specimen.",
    signature: "Spikes at the corners of the motion, also off the specimen, and nothing at steady speed.",
    against: Covariate::Acceleration,
    confused_with: &["viscous-drag", "sync-delay", "sensor-lag"],
    experiment: "The same motion off the specimen: the spikes stay.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "F → F + m a",
            strength: MASS,
            shapes: &[],
            act: Act::Added(|scene, parameters, _, force| {
                for (force, acceleration) in force.iter_mut().zip(scene.acceleration.iter()) {
                    *force += parameters[0] * NEWTON * acceleration;
                }
            }),
        },
        Law {
            name: "lagging",
            formula: "F → F + m y, τ dy/dt = a − y",
            strength: MASS,
            shapes: &[Shape {
                name: "time",
                unit: "s",
                meaning: "time in which the mount takes up the acceleration",
                grid: |scales| vec![2.0 * scales.interval],
                role: Role::Fitted(|scales| (0.05 * scales.interval, 50.0 * scales.interval)),
            }],
            act: Act::Added(|scene, parameters, _, force| {
                let (time, acceleration) = (&scene.motion.time, &scene.acceleration);
                let mut felt = 0.0;
                for (k, force) in force.iter_mut().enumerate().skip(1) {
                    let turns = (time[k] - time[k - 1]) / parameters[1];
                    felt = low_pass(felt, acceleration[k - 1], acceleration[k], turns);
                    *force += parameters[0] * NEWTON * felt;
                }
            }),
        },
    ],
};

const MASS: Strength = Strength {
    name: "mass",
    unit: "kg",
    meaning: "mass between sensor and specimen",
    sign: Sign::Positive,
    typical: |scales| 0.01 * scales.force / (NEWTON * scales.acceleration),
    most: |scales| 5.0 * scales.force / (NEWTON * scales.acceleration),
    count: Count::Fixed(&[]),
};
