//! `elastic-stiffening`: the elastic response grows faster at the top than the base law allows.

use super::shapes::FULL_COMPRESSION;
use super::{Count, Covariate, Effect, Law, Needs, Role, Shape, Sign, Strength};
use crate::{Act, Remembered, Scene, Stage};

const FORCE: Strength = Strength {
    name: "force",
    unit: "N",
    meaning: "what is added to the elastic response at full compression",
    sign: Sign::Positive,
    typical: |scales| 0.05 * scales.force,
    most: |scales| 10.0 * scales.force,
    count: Count::Fixed(&[]),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "elastic-stiffening",
    stage: Stage::Elasticity,
    meaning: "Chains stretched to their limit, closing pores, or a stiff layer below add to the elastic response at large compression.",
    signature: "At the top of loading and unloading, at any rate; it relaxes in the hold as the rest does.",
    against: Covariate::Displacement,
    confused_with: &["contact-offset"],
    experiment: "Press in steps to ever larger compression, each from a touch that is well sampled.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "N → N + k (x/X)^m",
            strength: FORCE,
            shapes: &[
                Shape {
                    name: "exponent",
                    unit: "",
                    meaning: "how steeply it grows",
                    grid: |_| vec![3.0, 5.0],
                    role: Role::Fitted(|_| (2.0, 40.0)),
                },
                FULL_COMPRESSION,
            ],
            act: Act::Elastic(|_, parameters, _, x, elastic| {
                let (force, exponent, full) = (parameters[0], parameters[1], parameters[2]);
                for (x, elastic) in x.iter().zip(elastic) {
                    *elastic += (force * (x.abs() / full).powf(exponent)).copysign(*x);
                }
            }),
        },
        Law {
            name: "exponential",
            formula: "N → N + k (e^(x/ℓ) − 1 − x/ℓ)/(e^(X/ℓ) − 1 − X/ℓ)",
            strength: FORCE,
            shapes: &[
                Shape {
                    name: "length",
                    unit: "mm",
                    meaning: "compression over which it grows by a factor e",
                    grid: |scales| vec![0.2 * scales.compression],
                    role: Role::Fitted(|scales| (0.05 * scales.compression, scales.compression)),
                },
                FULL_COMPRESSION,
            ],
            act: Act::Elastic(exponential),
        },
        Law {
            name: "densification",
            formula: "N → N + k (x/X)² (L − X)/(L − x)",
            strength: FORCE,
            shapes: &[
                Shape {
                    name: "limit",
                    unit: "mm",
                    meaning: "compression at which the specimen is dense",
                    grid: |scales| vec![1.2 * scales.compression],
                    role: Role::Fitted(|scales| {
                        (1.02 * scales.compression, 5.0 * scales.compression)
                    }),
                },
                FULL_COMPRESSION,
            ],
            act: Act::Elastic(densification),
        },
        Law {
            name: "layer",
            formula: "N → N + k ((x − x_l)/(X − x_l))² for x > x_l",
            strength: FORCE,
            shapes: &[
                Shape {
                    name: "onset",
                    unit: "mm",
                    meaning: "compression at which a stiff layer below is felt",
                    grid: |scales| vec![0.6 * scales.compression],
                    role: Role::Fitted(|scales| {
                        (0.1 * scales.compression, 0.95 * scales.compression)
                    }),
                },
                FULL_COMPRESSION,
            ],
            act: Act::Elastic(|_, parameters, _, x, elastic| {
                let (force, onset, full) = (parameters[0], parameters[1], parameters[2]);
                for (x, elastic) in x.iter().zip(elastic) {
                    let beyond = (x.abs() - onset).max(0.0);
                    *elastic += (force * (beyond / (full - onset)).powi(2)).copysign(*x);
                }
            }),
        },
    ],
};

fn exponential(_: &Scene, parameters: &[f64], _: &mut Remembered, x: &[f64], elastic: &mut [f64]) {
    let (force, length, full) = (parameters[0], parameters[1], parameters[2]);
    let growth = |x: f64| (x / length).exp_m1() - x / length;
    for (x, elastic) in x.iter().zip(elastic) {
        *elastic += (force * growth(x.abs()) / growth(full)).copysign(*x);
    }
}

fn densification(
    _: &Scene,
    parameters: &[f64],
    _: &mut Remembered,
    x: &[f64],
    elastic: &mut [f64],
) {
    let (force, limit, full) = (parameters[0], parameters[1], parameters[2]);
    for (&x, elastic) in x.iter().zip(elastic) {
        // Beyond the data, where x can pass the limit, the law goes on without its pole.
        let left = (limit - x.abs()).max(0.01 * full);
        *elastic += (force * (x / full).powi(2) * (limit - full) / left).copysign(x);
    }
}
