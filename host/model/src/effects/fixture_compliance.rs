//! `fixture-compliance`: the set-up yields under the force, and the specimen is pressed less.

use super::shapes::FULL_FORCE;
use super::{Count, Covariate, Effect, Law, Needs, Role, Shape, Sign, Strength};
use crate::{Act, Stage};

/// What a joint yields at full force.
const YIELD: Strength = Strength {
    name: "yield",
    unit: "mm",
    meaning: "how far the set-up yields at full force",
    sign: Sign::Positive,
    typical: |scales| 0.01 * scales.compression,
    most: |scales| 0.3 * scales.compression,
    count: Count::Fixed(&[]),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "fixture-compliance",
    stage: Stage::Motion,
    meaning: "Frame, grip or load cell bend under the force, so that less than the commanded motion reaches the specimen.",
    signature: "Grows with the force times the stiffness, the same at every rate; it follows the force through the hold.",
    against: Covariate::Force,
    confused_with: &["gauge-nonlinearity"],
    experiment: "Hang a known dead weight: a nonlinear gauge reads it wrong, a compliant fixture does not. Or press a rigid block: what moves is the fixture.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "x → x − C F",
            strength: Strength {
                name: "compliance",
                unit: "mm/N",
                meaning: "how far the set-up yields for each newton",
                sign: Sign::Positive,
                typical: |scales| 0.01 * scales.compression / scales.force,
                most: |scales| 0.3 * scales.compression / scales.force,
                count: Count::Fixed(&[]),
            },
            shapes: &[],
            act: Act::Yield(|parameters, force| parameters[0] * force),
        },
        Law {
            name: "joint",
            formula: "x → x − c (F/F0)^m",
            strength: YIELD,
            shapes: &[
                Shape {
                    name: "exponent",
                    unit: "",
                    meaning: "how the yielding grows with the force; below 1 for a joint that closes",
                    grid: |_| vec![0.5, 2.0],
                    role: Role::Fitted(|_| (0.4, 2.5)),
                },
                FULL_FORCE,
            ],
            act: Act::Yield(|parameters, force| {
                let (most, exponent, full) = (parameters[0], parameters[1], parameters[2]);
                most * force.signum() * (force / full).abs().powf(exponent)
            }),
        },
        Law {
            name: "closing-gap",
            formula: "x → x − c (1 − e^(−F/F_c))",
            strength: YIELD,
            shapes: &[Shape {
                name: "closing_force",
                unit: "N",
                meaning: "force at which most of the gap is closed",
                grid: |scales| vec![0.1 * scales.force],
                role: Role::Fitted(|scales| (0.01 * scales.force, scales.force)),
            }],
            act: Act::Yield(|parameters, force| {
                parameters[0] * (1.0 - (-force.max(0.0) / parameters[1]).exp())
            }),
        },
    ],
};
