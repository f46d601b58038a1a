//! `mullins`: the specimen is softer where it has been before.

use super::memory::{largest, largest_in_trace};
use super::{Count, Covariate, Effect, Law, Needs, RECOVERED, Role, Shape, Sign, Strength};
use crate::{Act, Remembered, Scene, Stage};

const DEPTH: Strength = Strength {
    name: "depth",
    unit: "",
    meaning: "largest part of the elastic response that is lost below the largest compression",
    sign: Sign::Positive,
    typical: |_| 0.05,
    most: |_| 0.95,
    count: Count::Fixed(&[]),
};

const WIDTH: Shape = Shape {
    name: "width",
    unit: "mm",
    meaning: "distance below the largest compression over which it sets in",
    grid: |scales| [0.03, 0.15, 0.6].map(|part| part * scales.compression).to_vec(),
    role: Role::Fitted(|scales| (0.01 * scales.compression, 10.0 * scales.compression)),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "mullins",
    stage: Stage::Elasticity,
    meaning: "Chains and filler bonds that the largest stretch broke no longer carry load below it.",
    signature: "In unloading, and in reloading below the largest compression so far; absent in first loadings.",
    against: Covariate::Displacement,
    confused_with: &["cyclic-softening"],
    experiment: "Repeat one amplitude, then a smaller one, then rest ten minutes and repeat.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "N → N (1 − r tanh((x_max − x)/w))",
            strength: DEPTH,
            shapes: &[WIDTH],
            act: Act::Elastic(|_, parameters, remembered, x, elastic| {
                soften(parameters, x, elastic, |x| largest(remembered, x));
            }),
        },
        Law {
            name: "energy",
            formula: "N → N (1 − r erf((W_max − W)/(m W_max))), W = N x",
            strength: DEPTH,
            shapes: &[Shape {
                name: "width",
                unit: "",
                meaning: "part of the largest energy over which it sets in",
                grid: |_| vec![0.2, 0.8],
                role: Role::Fitted(|_| (0.05, 20.0)),
            }],
            act: Act::Elastic(by_energy),
        },
        Law {
            name: "relative",
            formula: "N → N (1 − r (1 − x/x_max)^k)",
            strength: DEPTH,
            shapes: &[Shape {
                name: "exponent",
                unit: "",
                meaning: "how late it sets in below the largest compression",
                grid: |_| vec![0.5, 1.5],
                role: Role::Fitted(|_| (0.1, 6.0)),
            }],
            act: Act::Elastic(by_part),
        },
        Law {
            name: RECOVERED,
            formula: "N → N (1 − r tanh((x_max − x)/w)), x_max of the trace",
            strength: DEPTH,
            shapes: &[WIDTH],
            act: Act::Elastic(|scene, parameters, remembered, x, elastic| {
                soften(parameters, x, elastic, |x| largest_in_trace(scene, remembered, x));
            }),
        },
    ],
};

/// By the distance below the largest compression.
fn soften(parameters: &[f64], x: &[f64], elastic: &mut [f64], mut largest: impl FnMut(f64) -> f64) {
    let (depth, width) = (parameters[0], parameters[1]);
    for (&x, elastic) in x.iter().zip(elastic) {
        let x = x.abs();
        *elastic *= 1.0 - depth * ((largest(x) - x) / width).tanh();
    }
}

/// After Ogden and Roxburgh (1999), with the energy of the elastic response up to a factor.
fn by_energy(
    _: &Scene,
    parameters: &[f64],
    remembered: &mut Remembered,
    x: &[f64],
    elastic: &mut [f64],
) {
    let (depth, width) = (parameters[0], parameters[1]);
    for (x, elastic) in x.iter().zip(elastic) {
        let energy = *elastic * x;
        let most = largest(remembered, energy);
        if most > 0.0 {
            let below = (most - energy) / (width * most);
            *elastic *= 1.0 - depth * statrs::function::erf::erf(below);
        }
    }
}

fn by_part(
    _: &Scene,
    parameters: &[f64],
    remembered: &mut Remembered,
    x: &[f64],
    elastic: &mut [f64],
) {
    let (depth, exponent) = (parameters[0], parameters[1]);
    for (&x, elastic) in x.iter().zip(elastic) {
        let x = x.abs();
        let most = largest(remembered, x);
        if most > 0.0 {
            *elastic *= 1.0 - depth * (1.0 - x / most).powf(exponent);
        }
    }
}
