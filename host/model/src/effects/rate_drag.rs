//! `rate-drag`: a force against the motion that grows weakly with its speed.

use super::shapes::FULL_SPEED;
use super::{Count, Covariate, Effect, Law, Needs, Role, Shape, Sign, Strength};
use crate::{Act, Stage};

const DRAG: Strength = Strength {
    name: "drag",
    unit: "N",
    meaning: "force at full speed",
    sign: Sign::Positive,
    typical: |scales| 0.005 * scales.force,
    most: |scales| scales.force,
    count: Count::Fixed(&[]),
};

const EXPONENT: Shape = Shape {
    name: "exponent",
    unit: "",
    meaning: "how it grows with the speed",
    grid: |_| vec![0.2, 0.4],
    role: Role::Fitted(|_| (0.1, 0.7)),
};

/// Part of the full speed below which the power of the speed goes straight through zero, so that what
/// remains of a speed in a hold does not count.
const MIN_SPEED: f64 = 1e-3;

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "rate-drag",
    stage: Stage::Contact,
    meaning: "A tacky or shear-thinning surface or film resists the motion, only a little more when it is fast.",
    signature: "Loading against unloading, weak in the rate, and gone in the hold.",
    against: Covariate::Velocity,
    confused_with: &["coulomb-friction", "viscous-drag"],
    experiment: "Small cycles about a mean compression, at speeds over three decades.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "F → F + c sgn(v) |v/V|^m",
            strength: DRAG,
            shapes: &[EXPONENT, FULL_SPEED],
            act: Act::Added(|scene, parameters, _, force| {
                for (force, &velocity) in force.iter_mut().zip(scene.velocity.iter()) {
                    *force += power(velocity, parameters);
                }
            }),
        },
        Law {
            name: "in-contact",
            formula: "F → F + c sgn(v) |v/V|^m where F > 0",
            strength: DRAG,
            shapes: &[EXPONENT, FULL_SPEED],
            act: Act::Force(|scene, parameters, _, force| {
                for (force, &velocity) in force.iter_mut().zip(scene.velocity.iter()) {
                    if *force > 0.0 {
                        *force += power(velocity, parameters);
                    }
                }
            }),
        },
        Law {
            name: "eyring",
            formula: "F → F + c asinh(v/v0)/asinh(V/v0)",
            strength: DRAG,
            shapes: &[
                Shape {
                    name: "thinning_speed",
                    unit: "mm/s",
                    meaning: "speed from which on it grows with the logarithm of the speed",
                    grid: |scales| [0.003, 0.05].map(|part| part * scales.speed).to_vec(),
                    role: Role::Fitted(|scales| (1e-4 * scales.speed, 0.2 * scales.speed)),
                },
                FULL_SPEED,
            ],
            act: Act::Added(|scene, parameters, _, force| {
                let (drag, thinning, full) = (parameters[0], parameters[1], parameters[2]);
                for (force, velocity) in force.iter_mut().zip(scene.velocity.iter()) {
                    *force += drag * (velocity / thinning).asinh() / (full / thinning).asinh();
                }
            }),
        },
    ],
};

/// The drag at a velocity.
fn power(velocity: f64, parameters: &[f64]) -> f64 {
    let (drag, exponent, full) = (parameters[0], parameters[1], parameters[2]);
    let speeds = velocity / full;
    drag * speeds * (speeds * speeds + MIN_SPEED * MIN_SPEED).powf(0.5 * (exponent - 1.0))
}
