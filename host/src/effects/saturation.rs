//! `saturation`: the sensor cannot read more than so much.

use super::shapes::FULL_FORCE;
use super::{Count, Effect, Law, Needs, Role, Shape, Sign, Strength};
use crate::model::{Act, Stage};

/// The limit is stated as a ratio that is 0 where there is none.
const RATIO: Strength = Strength {
    name: "ratio",
    unit: "",
    meaning: "full force over the largest that the sensor reads; below 1 the data show nothing of it",
    sign: Sign::Positive,
    typical: |_| 1.03,
    most: |_| 3.0,
    count: Count::Fixed(&[]),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "saturation",
    stage: Stage::Sensor,
    meaning: "Amplifier, converter or a stop that protects the load cell cuts off what is larger than its range.",
    signature: "Flat tops, all at the same force.",
    confused_with: &["gauge-nonlinearity"],
    experiment: "Hang a dead weight heavier than the largest force, or press at a lower gain.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "F → min(F, F0/s)",
            strength: RATIO,
            shapes: &[FULL_FORCE],
            act: Act::Force(|_, parameters, _, force| {
                for force in force {
                    *force = force.min(parameters[1] / parameters[0]);
                }
            }),
        },
        Law {
            name: "soft",
            formula: "F → F/(1 + (s |F|/F0)^n)^(1/n)",
            strength: Strength { typical: |_| 0.9, ..RATIO },
            shapes: &[
                Shape {
                    name: "sharpness",
                    unit: "",
                    meaning: "how sharply the range ends",
                    grid: |_| vec![8.0],
                    role: Role::Fitted(|_| (3.0, 40.0)),
                },
                FULL_FORCE,
            ],
            act: Act::Force(|_, parameters, _, force| {
                let (ratio, sharpness, full) = (parameters[0], parameters[1], parameters[2]);
                for force in force {
                    let part = ratio * force.abs() / full;
                    *force /= (1.0 + part.powf(sharpness)).powf(1.0 / sharpness);
                }
            }),
        },
    ],
};
