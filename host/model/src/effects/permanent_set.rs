//! `permanent-set`: the specimen stays shorter than it was.

use super::memory::{largest, largest_in_trace};
use super::shapes::FULL_COMPRESSION;
use super::{Count, Covariate, Effect, Law, Needs, RECOVERED, Role, Shape, Sign, Strength};
use crate::{Act, Stage};

const SET: Strength = Strength {
    name: "set",
    unit: "",
    meaning: "part of the largest compression so far that stays",
    sign: Sign::Positive,
    typical: |_| 0.01,
    most: |_| 0.5,
    count: Count::Fixed(&[]),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "permanent-set",
    stage: Stage::Elasticity,
    meaning: "The specimen does not come back to its height: part of the largest compression so far stays.",
    signature: "At the end of unloading and at the next touch, which comes later; it grows with the largest loading only.",
    against: Covariate::Displacement,
    confused_with: &["backlash", "contact-offset", "mullins"],
    experiment: "Repeat one amplitude, then a smaller one, then rest ten minutes and look where the touch is.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "x → x − s x_max",
            strength: SET,
            shapes: &[],
            act: Act::Compression(|_, parameters, remembered, x| {
                for x in x {
                    *x -= parameters[0] * largest(remembered, *x);
                }
            }),
        },
        Law {
            name: "yield",
            formula: "x → x − s (x_max − x_y) for x_max > x_y",
            strength: Strength {
                meaning: "part of the compression beyond the yield that stays",
                ..SET
            },
            shapes: &[Shape {
                name: "yield",
                unit: "mm",
                meaning: "compression up to which nothing stays",
                grid: |scales| vec![0.4 * scales.compression],
                role: Role::Fitted(|scales| (0.0, 0.95 * scales.compression)),
            }],
            act: Act::Compression(|_, parameters, remembered, x| {
                for x in x {
                    *x -= parameters[0] * (largest(remembered, *x) - parameters[1]).max(0.0);
                }
            }),
        },
        Law {
            name: "power",
            formula: "x → x − s X (x_max/X)^m",
            strength: SET,
            shapes: &[
                Shape {
                    name: "exponent",
                    unit: "",
                    meaning: "how it grows with the largest compression",
                    grid: |_| vec![2.0],
                    role: Role::Fitted(|_| (0.2, 5.0)),
                },
                FULL_COMPRESSION,
            ],
            act: Act::Compression(|_, parameters, remembered, x| {
                let (set, exponent, full) = (parameters[0], parameters[1], parameters[2]);
                for x in x {
                    *x -= set * full * (largest(remembered, *x) / full).powf(exponent);
                }
            }),
        },
        Law {
            name: "cyclic",
            formula: "x → x − s x_max ln(1 + n)",
            strength: Strength {
                meaning: "part of the largest compression that stays each time 1 + n grows by a factor e",
                typical: |_| 0.005,
                most: |_| 0.1,
                ..SET
            },
            shapes: &[],
            act: Act::Compression(|scene, parameters, remembered, x| {
                for (x, loadings) in x.iter_mut().zip(scene.loadings.iter()) {
                    *x -= parameters[0] * largest(remembered, *x) * loadings.ln_1p();
                }
            }),
        },
        Law {
            name: RECOVERED,
            formula: "x → x − s x_max, x_max of the trace",
            strength: SET,
            shapes: &[],
            act: Act::Compression(|scene, parameters, remembered, x| {
                for x in x {
                    *x -= parameters[0] * largest_in_trace(scene, remembered, *x);
                }
            }),
        },
    ],
};
