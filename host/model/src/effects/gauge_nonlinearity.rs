//! `gauge-nonlinearity`: the signal is not in proportion to the force.

use super::shapes::FULL_FORCE;
use super::{Count, Covariate, Effect, Law, Needs, Sign, Strength};
use crate::{Act, Stage};

const DEVIATION: Strength = Strength {
    name: "deviation",
    unit: "",
    meaning: "part of the full force that is lost there",
    sign: Sign::Either,
    typical: |_| 0.01,
    most: |_| 1.0,
    count: Count::Fixed(&[]),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "gauge-nonlinearity",
    stage: Stage::Sensor,
    meaning: "Bridge, gauge or the body it is bonded to answer the force along a slightly curved line.",
    signature: "At the peak force, at any rate; a function of the force alone.",
    against: Covariate::Force,
    confused_with: &["fixture-compliance", "saturation", "elastic-stiffening"],
    experiment: "Hang known dead weights: a nonlinear gauge reads them wrong, a compliant fixture does not.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "F → F − k2 F²/F0 − k3 F³/F0²",
            strength: Strength { count: Count::Fixed(&["k2", "k3"]), ..DEVIATION },
            shapes: &[FULL_FORCE],
            act: Act::Force(|_, parameters, _, force| {
                let (square, cube, full) = (parameters[0], parameters[1], parameters[2]);
                for force in force {
                    let part = *force / full;
                    *force -= full * part * part * (square + cube * part);
                }
            }),
        },
        Law {
            name: "quadratic",
            formula: "F → F − k2 F²/F0",
            strength: DEVIATION,
            shapes: &[FULL_FORCE],
            act: Act::Force(|_, parameters, _, force| {
                for force in force {
                    *force -= parameters[0] * *force * *force / parameters[1];
                }
            }),
        },
        Law {
            name: "cubic",
            formula: "F → F − k3 F³/F0²",
            strength: DEVIATION,
            shapes: &[FULL_FORCE],
            act: Act::Force(|_, parameters, _, force| {
                for force in force {
                    *force -= parameters[0] * force.powi(3) / parameters[1].powi(2);
                }
            }),
        },
        Law {
            name: "bridge",
            formula: "F → F/(1 + k |F|/F0)",
            strength: DEVIATION,
            shapes: &[FULL_FORCE],
            act: Act::Force(|_, parameters, _, force| {
                for force in force {
                    *force /= (1.0 + parameters[0] * force.abs() / parameters[1]).max(0.1);
                }
            }),
        },
    ],
};
