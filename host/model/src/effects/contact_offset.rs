//! `contact-offset`: the true touch is not where displacement is zero.

use super::{Count, Covariate, Effect, Law, Needs, Role, Shape, Sign, Strength};
use crate::{Act, Stage};

const OFFSET: Strength = Strength {
    name: "offset",
    unit: "mm",
    meaning: "displacement at which the surfaces meet",
    sign: Sign::Either,
    typical: |scales| 0.01 * scales.compression,
    // A recording may have the coordinates of its rig: the touch is anywhere before the deepest press.
    most: |scales| 0.95 * scales.compression,
    count: Count::Fixed(&[]),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "contact-offset",
    stage: Stage::Motion,
    meaning: "The indenter meets the specimen a little before or after the nominal touch.",
    signature: "At touch-on and touch-off; like the stiffness times a constant in between.",
    against: Covariate::Displacement,
    confused_with: &["adhesion", "elastic-stiffening"],
    experiment: "Approach slowly and press lightly, so that the touch itself is well sampled.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "x → x − δ",
            strength: OFFSET,
            shapes: &[],
            act: Act::Compression(|_, parameters, _, x| {
                for x in x {
                    *x -= parameters[0];
                }
            }),
        },
        Law {
            name: "toe",
            formula: "x → x − δ (1 − e^(−x/ℓ)) for x > 0",
            strength: Strength {
                meaning: "how far an uneven surface is flattened before all of it is met",
                sign: Sign::Positive,
                most: |scales| 0.5 * scales.compression,
                ..OFFSET
            },
            shapes: &[Shape {
                name: "length",
                unit: "mm",
                meaning: "compression in which that happens",
                grid: |scales| vec![0.05 * scales.compression],
                role: Role::Fitted(|scales| {
                    (0.005 * scales.compression, 0.15 * scales.compression)
                }),
            }],
            act: Act::Compression(|_, parameters, _, x| {
                let (offset, length) = (parameters[0], parameters[1]);
                for x in x {
                    *x += offset * (-x.max(0.0) / length).exp_m1();
                }
            }),
        },
    ],
};
