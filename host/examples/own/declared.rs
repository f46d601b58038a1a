//! The law and the effect: all that is to be written for them.

use std::f64::consts::TAU;

use palpate::effects::{Count, Effect, Law, Needs, Role, Shape, Sign, Strength};
use palpate::model::covariate::Covariate;
use palpate::model::elastic::{Acts, ElasticLaw};
use palpate::model::laws::{LawParameter, POSITIVE};
use palpate::model::{Act, Coordinate, Stage};

/// Fung's exponential: the stiffness grows in proportion to the force.
pub static EXPONENTIAL: ElasticLaw = ElasticLaw {
    name: "exponential",
    meaning: "stiffens in proportion to the force, as soft tissue does",
    formula: "p (e^(αx) − 1)/α",
    acts: Acts::OnDisplacement(|alpha, x| (alpha * x.max(0.0)).exp_m1() / alpha),
    parameters: |_, stiffness| {
        let (p, alpha) = ("stiffness at the first touch", "growth of the stiffness");
        vec![
            LawParameter::new("p", "N/mm", p, POSITIVE, stiffness).scaling(),
            LawParameter::new("alpha", "1/mm", alpha, POSITIVE, Coordinate::Shape),
        ]
    },
    constants: |values| (values[0], values[1]),
    values: |p, shape| vec![p, shape],
    bounds: |reach| Some((1e-3 / reach.largest, 20.0 / reach.largest)),
    starts: |reach| [0.1, 1.0, 3.0, 8.0].map(|times| times / reach.largest).to_vec(),
};

/// Force of a rack and pinion under the specimen.
pub static TEETH: Effect = Effect {
    name: "teeth",
    stage: Stage::Contact,
    meaning: "The teeth of the drive push once for each pitch.",
    signature: "Repeats with the displacement, the same in both directions.",
    against: Covariate::Displacement,
    confused_with: &["backlash"],
    experiment: "The same stroke without a specimen.",
    needs: Needs::Nothing,
    laws: &[Law {
        name: "reference",
        formula: "F → F + a sin(2π x/λ)",
        strength: Strength {
            name: "amplitude",
            unit: "N",
            meaning: "largest push",
            sign: Sign::Either,
            typical: |scales| 0.01 * scales.force,
            most: |scales| scales.force,
            count: Count::Fixed(&[]),
        },
        shapes: &[Shape {
            name: "pitch",
            unit: "mm",
            meaning: "from tooth to tooth",
            grid: |_| (0..10).map(|k| 0.5 + 0.1 * f64::from(k)).collect(),
            role: Role::Fitted(|_| (0.3, 3.0)),
        }],
        act: Act::Force(|scene, parameters, _, force| {
            for (force, x) in force.iter_mut().zip(scene.motion.displacement.iter()) {
                *force += parameters[0] * (TAU * x / parameters[1]).sin();
            }
        }),
    }],
};
