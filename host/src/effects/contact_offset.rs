//! `contact-offset`: the true touch is not where displacement is zero.

use super::{Count, Effect, Law, Needs, Sign, Strength};
use crate::model::{Act, Stage};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "contact-offset",
    stage: Stage::Motion,
    meaning: "The indenter meets the specimen a little before or after the nominal touch.",
    signature: "At touch-on and touch-off; like the stiffness times a constant in between.",
    confused_with: &["adhesion", "elastic-stiffening"],
    experiment: "Approach slowly and press lightly, so that the touch itself is well sampled.",
    needs: Needs::Nothing,
    laws: &[Law {
        name: "reference",
        formula: "x → x − δ",
        strength: Strength {
            name: "offset",
            unit: "mm",
            meaning: "displacement at which the surfaces meet",
            sign: Sign::Either,
            typical: |scales| 0.01 * scales.compression,
            most: |scales| 0.5 * scales.compression,
            count: Count::Fixed(&[]),
        },
        shapes: &[],
        act: Act::Compression(|_, parameters, _, x| {
            for x in x {
                *x -= parameters[0];
            }
        }),
    }],
};
