//! `saturation`: the sensor cannot read more than so much.

use super::{Count, Covariate, Effect, Law, Needs, Role, Shape, Sign, Strength};
use crate::{Act, Stage};

const LOSS: Strength = Strength {
    name: "loss",
    unit: "",
    meaning: "part of what lies above the limit that is lost; 1 is a hard stop",
    sign: Sign::Part,
    typical: |_| 0.5,
    most: |_| 1.0,
    count: Count::Fixed(&[]),
};

const LIMIT: Shape = Shape {
    name: "limit",
    unit: "N",
    meaning: "force above which the sensor loses",
    grid: |scales| [0.8, 0.9, 0.97].map(|part| part * scales.force).to_vec(),
    role: Role::Fitted(|scales| (0.7 * scales.force, 1.05 * scales.force)),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "saturation",
    stage: Stage::Sensor,
    meaning: "Amplifier, converter or a stop that protects the load cell cuts off what is larger than its range.",
    signature: "Flat tops, all at the same force.",
    against: Covariate::Force,
    confused_with: &["gauge-nonlinearity"],
    experiment: "Hang a dead weight heavier than the largest force, or press at a lower gain.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "F → F − s max(F − F_c, 0); s = 1: F → min(F, F_c)",
            strength: LOSS,
            shapes: &[LIMIT],
            act: Act::Force(|_, parameters, _, force| {
                let (loss, limit) = (parameters[0], parameters[1]);
                for force in force {
                    *force -= loss * (*force - limit).max(0.0);
                }
            }),
        },
        Law {
            name: "soft",
            formula: "F → F − s w ln(1 + e^((F − F_c)/w)), w = u F_c",
            strength: LOSS,
            shapes: &[
                Shape {
                    grid: |scales| [0.85, 0.95].map(|part| part * scales.force).to_vec(),
                    ..LIMIT
                },
                Shape {
                    name: "width",
                    unit: "",
                    meaning: "part of the limit over which it sets in",
                    grid: |_| vec![0.04],
                    role: Role::Fitted(|_| (0.002, 0.3)),
                },
            ],
            act: Act::Force(|_, parameters, _, force| {
                let (loss, limit) = (parameters[0], parameters[1]);
                let width = parameters[2] * limit;
                for force in force {
                    // Far below the limit the logarithm is its exponential, far above its argument.
                    let above = (*force - limit) / width;
                    let soft = if above > 30.0 { above } else { above.exp().ln_1p() };
                    *force -= loss * width * soft;
                }
            }),
        },
    ],
};
