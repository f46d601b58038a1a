//! `fast-mode`: a relaxation faster than those of the base law.

use super::{Count, Effect, Law, Needs, Role, Shape, Sign, Strength};
use crate::model::{Act, Branch, Stage};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "fast-mode",
    stage: Stage::Relaxation,
    meaning: "A part of the elastic response relaxes within milliseconds, faster than the exponentials of the base law.",
    signature: "On ramps, growing with the rate, and at the corners.",
    confused_with: &["viscous-drag", "sensor-lag"],
    experiment: "Press a rigid block at fifty times the rate: a sensor still lags there, the specimen is gone.",
    needs: Needs::Nothing,
    laws: &[Law {
        name: "reference",
        formula: "g → g + c (e^(−t/τ) − 1)",
        strength: Strength {
            name: "share",
            unit: "",
            meaning: "share of the elastic response that relaxes fast",
            sign: Sign::Positive,
            typical: |_| 0.03,
            most: |_| 0.9,
            count: Count::Fixed(&[]),
        },
        shapes: &[Shape {
            name: "time",
            unit: "s",
            meaning: "its time constant",
            grid: |scales| {
                [1.0, 4.0, 16.0].map(|times| times * scales.interval.max(0.005)).to_vec()
            },
            role: Role::Fitted(|scales| (0.3 * scales.interval, 0.2 * scales.duration)),
        }],
        act: Act::Relaxation(|_, parameters, _, relaxation| {
            relaxation.branches.push(Branch { share: parameters[0], rate: 1.0 / parameters[1] });
        }),
    }],
};
