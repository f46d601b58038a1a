//! `viscous-drag`: a force against the motion in proportion to its speed.

use super::shapes::{FULL_COMPRESSION, FULL_SPEED};
use super::{Count, Covariate, Effect, Law, Needs, Role, Shape, Sign, Strength};
use crate::{Act, Stage};

const VISCOSITY: Strength = Strength {
    name: "viscosity",
    unit: "N s/mm",
    meaning: "force for each mm/s",
    sign: Sign::Positive,
    typical: |scales| 0.005 * scales.force / scales.speed,
    most: |scales| scales.force / scales.speed,
    count: Count::Fixed(&[]),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "viscous-drag",
    stage: Stage::Contact,
    meaning: "Grease, air or a wet surface resist the motion in proportion to the speed.",
    signature: "In proportion to the speed, of either sign, and gone in the hold.",
    against: Covariate::Velocity,
    confused_with: &["fast-mode", "rate-drag", "coulomb-friction", "inertia"],
    experiment: "Small cycles about a mean compression, slow and fast; and strokes off the specimen.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "F → F + η v",
            strength: VISCOSITY,
            shapes: &[],
            act: Act::Added(|scene, parameters, _, force| {
                for (force, velocity) in force.iter_mut().zip(scene.velocity.iter()) {
                    *force += parameters[0] * velocity;
                }
            }),
        },
        Law {
            name: "in-contact",
            formula: "F → F + η v where F > 0",
            strength: VISCOSITY,
            shapes: &[],
            act: Act::Force(|scene, parameters, _, force| {
                for (force, velocity) in force.iter_mut().zip(scene.velocity.iter()) {
                    if *force > 0.0 {
                        *force += parameters[0] * velocity;
                    }
                }
            }),
        },
        Law {
            name: "area",
            formula: "F → F + η v x/X for x > 0",
            strength: Strength { meaning: "force for each mm/s at full compression", ..VISCOSITY },
            shapes: &[FULL_COMPRESSION],
            act: Act::Added(|scene, parameters, _, force| {
                let path = scene.motion.displacement.iter();
                for ((force, velocity), x) in force.iter_mut().zip(scene.velocity.iter()).zip(path)
                {
                    *force += parameters[0] * velocity * x.max(0.0) / parameters[1];
                }
            }),
        },
        Law {
            name: "power",
            formula: "F → F + η V sgn(v) |v/V|^m",
            strength: Strength { meaning: "force for each mm/s at full speed", ..VISCOSITY },
            shapes: &[
                Shape {
                    name: "exponent",
                    unit: "",
                    meaning: "how it grows with the speed: below 1 for a film that thins",
                    grid: |_| vec![0.85],
                    role: Role::Fitted(|_| (0.7, 2.0)),
                },
                FULL_SPEED,
            ],
            act: Act::Added(|scene, parameters, _, force| {
                let &[viscosity, exponent, full] = parameters else { return };
                for (force, velocity) in force.iter_mut().zip(scene.velocity.iter()) {
                    let speed = (velocity / full).abs().powf(exponent);
                    *force += viscosity * full * velocity.signum() * speed;
                }
            }),
        },
    ],
};
