//! `thermal-stiffness`: the specimen is softer or stiffer when warm.

use super::memory::body_warmth;
use super::shapes::BODY_TIME;
use super::{Count, Covariate, Effect, Law, Needs, Sign, Strength};
use crate::{Act, Stage};

const COEFFICIENT: Strength = Strength {
    name: "coefficient",
    unit: "1/K",
    meaning: "part by which the elastic response grows for each kelvin",
    sign: Sign::Either,
    typical: |_| 0.003,
    // A specimen keeps some stiffness.
    most: |scales| 0.9 / scales.warmth.max(0.1),
    count: Count::Fixed(&[]),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "thermal-stiffness",
    stage: Stage::Elasticity,
    meaning: "The elastic response changes with the temperature of the specimen.",
    signature: "In proportion to the force, and from trace to trace as the temperature.",
    against: Covariate::Temperature,
    confused_with: &["cyclic-softening", "time-temperature"],
    experiment: "Step the temperature by 5 K, wait until the specimen has it, and press and hold as before.",
    needs: Needs::Temperature,
    laws: &[
        Law {
            name: "reference",
            formula: "N → N (1 + α (T − T0))",
            strength: COEFFICIENT,
            shapes: &[],
            act: Act::Elastic(|scene, parameters, _, _, elastic| {
                for (k, elastic) in elastic.iter_mut().enumerate() {
                    *elastic *= 1.0 + parameters[0] * scene.warmth(k);
                }
            }),
        },
        Law {
            name: "lagging",
            formula: "N → N (1 + α (T_s − T0)), θ dT_s/dt = T − T_s",
            strength: COEFFICIENT,
            shapes: &[BODY_TIME],
            act: Act::Elastic(|scene, parameters, remembered, _, elastic| {
                let warmth = body_warmth(scene, remembered, parameters[1]);
                for (elastic, warmth) in elastic.iter_mut().zip(warmth) {
                    *elastic *= 1.0 + parameters[0] * warmth;
                }
            }),
        },
    ],
};
