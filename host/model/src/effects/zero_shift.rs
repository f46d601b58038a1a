//! `zero-shift`: the zero of the sensor is another in every trace.

use super::{Count, Covariate, Effect, Law, Needs, Sign, Strength};
use crate::{Act, Stage};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "zero-shift",
    stage: Stage::Sensor,
    meaning: "The zero of the force channel was set anew, or wandered, between traces.",
    signature: "A constant in each trace, also before the touch.",
    against: Covariate::SetTime,
    confused_with: &["drift", "warm-up", "thermal-output"],
    experiment: "Record a second of rest before every touch, and tare there.",
    needs: Needs::Nothing,
    laws: &[Law {
        name: "reference",
        formula: "F → F + b, one b for each trace",
        strength: Strength {
            name: "zero",
            unit: "N",
            meaning: "signal without load in this trace",
            sign: Sign::Either,
            typical: |scales| 0.005 * scales.force,
            most: |scales| scales.force,
            count: Count::Traces,
        },
        shapes: &[],
        act: Act::Added(|scene, parameters, _, force| {
            if let Some(zero) = parameters.get(scene.trace) {
                for force in force {
                    *force += zero;
                }
            }
        }),
    }],
};
