//! `fast-mode`: a relaxation faster than those of the base law.

use super::{Count, Covariate, Effect, Law, Needs, Role, Shape, Sign, Strength};
use crate::{Act, Branch, Stage};

const SHARE: Strength = Strength {
    name: "share",
    unit: "",
    meaning: "force that relaxes fast, over the elastic response",
    sign: Sign::Positive,
    typical: |_| 0.03,
    most: |_| 5.0,
    count: Count::Fixed(&[]),
};

const TIME: Shape = Shape {
    name: "time",
    unit: "s",
    meaning: "its time constant, the longest where there are several",
    grid: |scales| [1.0, 4.0, 16.0].map(|times| times * scales.interval.max(0.005)).to_vec(),
    role: Role::Fitted(|scales| (0.3 * scales.interval, (20.0 * scales.interval).max(0.15))),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "fast-mode",
    stage: Stage::Relaxation,
    meaning: "A part of the elastic response relaxes within milliseconds, faster than the exponentials of the base law.",
    signature: "On ramps, growing with the rate, and at the corners.",
    against: Covariate::Velocity,
    confused_with: &["viscous-drag", "sensor-lag", "sync-delay"],
    experiment: "Press a rigid block at fifty times the rate: a sensor still lags there, the specimen is gone.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "g → g + c e^(−t/τ)",
            strength: SHARE,
            shapes: &[TIME],
            act: Act::Relaxation(|_, parameters, _, _, relaxation| {
                relaxation
                    .branches
                    .push(Branch { share: parameters[0], rate: 1.0 / parameters[1] });
                relaxation.on_top += parameters[0];
            }),
        },
        Law {
            name: "band",
            formula: "g → g + Σ c/4 e^(−t/τ_i), τ_i = τ, τ/√10, τ/10, τ/√1000",
            strength: SHARE,
            shapes: &[TIME],
            act: Act::Relaxation(|_, parameters, _, _, relaxation| {
                relaxation.branches.extend((0..4).map(|k| Branch {
                    share: parameters[0] / 4.0,
                    rate: 10f64.powf(0.5 * f64::from(k)) / parameters[1],
                }));
                relaxation.on_top += parameters[0];
            }),
        },
    ],
};
