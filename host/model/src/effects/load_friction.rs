//! `load-friction`: a force against the motion in proportion to the load.

use super::coulomb_friction::{PRESLIDING, SLIDING_SPEED};
use super::memory::direction;
use super::{Count, Covariate, Effect, Law, Needs, Sign, Strength};
use crate::{Act, Stage};

const COEFFICIENT: Strength = Strength {
    name: "coefficient",
    unit: "",
    meaning: "force of sliding as a part of the load",
    sign: Sign::Positive,
    typical: |_| 0.01,
    most: |_| 0.5,
    count: Count::Fixed(&[]),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "load-friction",
    stage: Stage::Contact,
    meaning: "The specimen spreads under the indenter and on its base and rubs there, the more the harder it is pressed.",
    signature: "A loop that grows with the force, the same at every speed, and nothing off the specimen.",
    against: Covariate::Force,
    confused_with: &["coulomb-friction", "mullins", "hysteresis"],
    experiment: "Small cycles about several mean compressions; then the same with the contact lubricated.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "F → F (1 + μ tanh(v/v0))",
            strength: COEFFICIENT,
            shapes: &[SLIDING_SPEED],
            act: Act::Force(|scene, parameters, _, force| {
                for (force, velocity) in force.iter_mut().zip(scene.velocity.iter()) {
                    *force *= 1.0 + parameters[0] * (velocity / parameters[1]).tanh();
                }
            }),
        },
        Law {
            name: "dahl",
            formula: "F → F (1 + μ z), dz = (sgn dx − z) |dx|/ℓ",
            strength: COEFFICIENT,
            shapes: &[PRESLIDING],
            act: Act::Force(|scene, parameters, remembered, force| {
                let path = &scene.motion.displacement;
                let direction = direction(remembered, 0.0, parameters[1], path);
                for (force, direction) in force.iter_mut().zip(direction) {
                    *force *= 1.0 + parameters[0] * direction;
                }
            }),
        },
    ],
};
