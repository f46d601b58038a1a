//! `thermal-output`: the zero of the sensor follows the temperature.

use super::memory::body_warmth;
use super::shapes::BODY_TIME;
use super::{Count, Covariate, Effect, Law, Needs, Sign, Strength};
use crate::{Act, Stage};

const OUTPUT: Strength = Strength {
    name: "output",
    unit: "N/K",
    meaning: "how far the zero moves for each kelvin",
    sign: Sign::Either,
    typical: |scales| 0.005 * scales.force / scales.warmth.max(0.1),
    most: |scales| scales.force / scales.warmth.max(0.1),
    count: Count::Fixed(&[]),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "thermal-output",
    stage: Stage::Sensor,
    meaning: "A gauge and what it is bonded to expand differently, which reads as load.",
    signature: "Follows the temperature, the same under load and off the specimen.",
    against: Covariate::Temperature,
    confused_with: &["warm-up", "drift", "zero-shift"],
    experiment: "Step the temperature by 5 K with no load.",
    needs: Needs::Temperature,
    laws: &[
        Law {
            name: "reference",
            formula: "F → F + β (T − T0)",
            strength: OUTPUT,
            shapes: &[],
            act: Act::Added(|scene, parameters, _, force| {
                for (k, force) in force.iter_mut().enumerate() {
                    *force += parameters[0] * scene.warmth(k);
                }
            }),
        },
        Law {
            name: "lagging",
            formula: "F → F + β (T_s − T0), θ dT_s/dt = T − T_s",
            strength: OUTPUT,
            shapes: &[BODY_TIME],
            act: Act::Added(|scene, parameters, remembered, force| {
                let warmth = body_warmth(scene, remembered, parameters[1]);
                for (force, warmth) in force.iter_mut().zip(warmth) {
                    *force += parameters[0] * warmth;
                }
            }),
        },
        Law {
            name: "compensated",
            formula: "F → F + β (T − T0) − γ (T_s − T0), θ dT_s/dt = T − T_s",
            strength: Strength { count: Count::Fixed(&["output", "compensation"]), ..OUTPUT },
            shapes: &[BODY_TIME],
            act: Act::Added(|scene, parameters, remembered, force| {
                let body = body_warmth(scene, remembered, parameters[2]);
                for (k, (force, body)) in force.iter_mut().zip(body).enumerate() {
                    *force += parameters[0] * scene.warmth(k) - parameters[1] * body;
                }
            }),
        },
        Law {
            name: "quadratic",
            formula: "F → F + β (T − T0) + γ (T − T0)²",
            strength: Strength { count: Count::Fixed(&["output", "curvature"]), ..OUTPUT },
            shapes: &[],
            act: Act::Added(|scene, parameters, _, force| {
                for (k, force) in force.iter_mut().enumerate() {
                    let warmth = scene.warmth(k);
                    *force += (parameters[0] + parameters[1] * warmth) * warmth;
                }
            }),
        },
        Law {
            name: "zeroed",
            formula: "F → F + β (T − T_1), T_1 at the first sample of the set",
            strength: OUTPUT,
            shapes: &[],
            act: Act::Added(|scene, parameters, first, force| {
                for (k, force) in force.iter_mut().enumerate() {
                    let warmth = scene.warmth(k);
                    if first.is_empty() {
                        first.push(warmth);
                    }
                    *force += parameters[0] * (warmth - first[0]);
                }
            }),
        },
    ],
};
