//! `inertia`: the sensor feels the mass that it moves.

use super::{Count, Covariate, Effect, Law, Needs, Sign, Strength};
use crate::model::{Act, Stage};

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
    laws: &[Law {
        name: "reference",
        formula: "F → F + m a",
        strength: Strength {
            name: "mass",
            unit: "kg",
            meaning: "mass between sensor and specimen",
            sign: Sign::Positive,
            typical: |scales| 0.01 * scales.force / (NEWTON * scales.acceleration),
            most: |scales| 5.0 * scales.force / (NEWTON * scales.acceleration),
            count: Count::Fixed(&[]),
        },
        shapes: &[],
        act: Act::Force(|scene, parameters, _, force| {
            for (force, acceleration) in force.iter_mut().zip(&scene.acceleration) {
                *force += parameters[0] * NEWTON * acceleration;
            }
        }),
    }],
};
