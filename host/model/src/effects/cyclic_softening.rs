//! `cyclic-softening`: every loading leaves the specimen a little softer.

use super::memory::loadings_in_trace;
use super::{Count, Covariate, Effect, Law, Needs, RECOVERED, Role, Shape, Sign, Strength};
use crate::{Act, Stage};

const SOFTENING: Strength = Strength {
    name: "softening",
    unit: "",
    meaning: "part of the elastic response lost each time 1 + n grows by a factor e",
    sign: Sign::Positive,
    typical: |_| 0.01,
    most: |scales| 0.9 / (1.0 + scales.loadings.max(1.0)).ln(),
    count: Count::Fixed(&[]),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "cyclic-softening",
    stage: Stage::Elasticity,
    meaning: "Each loading breaks or rearranges some of the network, fewer with every repetition, whatever the amplitude.",
    signature: "A step at every cycle, in proportion to the force, largest between the first and the second.",
    against: Covariate::Cycle,
    confused_with: &["mullins", "thermal-stiffness"],
    experiment: "Repeat one amplitude, then a smaller one, then rest ten minutes and repeat.",
    needs: Needs::Loadings,
    laws: &[
        Law {
            name: "reference",
            formula: "N → N (1 − s ln(1 + n))",
            strength: SOFTENING,
            shapes: &[],
            act: Act::Elastic(|scene, parameters, _, _, elastic| {
                for (elastic, loadings) in elastic.iter_mut().zip(scene.loadings.iter()) {
                    *elastic *= 1.0 - parameters[0] * loadings.ln_1p();
                }
            }),
        },
        Law {
            name: "saturating",
            formula: "N → N (1 − s (1 − e^(−n/n0)))",
            strength: Strength {
                name: "softening",
                unit: "",
                meaning: "part of the elastic response that is lost in the end",
                sign: Sign::Positive,
                typical: |_| 0.03,
                most: |_| 0.9,
                count: Count::Fixed(&[]),
            },
            shapes: &[Shape {
                name: "loadings",
                unit: "",
                meaning: "number of loadings after which most of it is lost",
                grid: |scales| vec![1.5, 0.5 * scales.loadings.max(6.0)],
                role: Role::Fitted(|scales| (0.3, 3.0 * scales.loadings.max(6.0))),
            }],
            act: Act::Elastic(|scene, parameters, _, _, elastic| {
                for (elastic, loadings) in elastic.iter_mut().zip(scene.loadings.iter()) {
                    *elastic *= 1.0 + parameters[0] * (-loadings / parameters[1]).exp_m1();
                }
            }),
        },
        Law {
            name: RECOVERED,
            formula: "N → N (1 − s ln(1 + n)), n within the trace",
            strength: SOFTENING,
            shapes: &[],
            act: Act::Elastic(|scene, parameters, remembered, _, elastic| {
                let loadings = loadings_in_trace(scene, remembered);
                for (elastic, loadings) in elastic.iter_mut().zip(loadings) {
                    *elastic *= 1.0 - parameters[0] * loadings.ln_1p();
                }
            }),
        },
    ],
};
