//! `coulomb-friction`: a force against the motion that does not depend on its speed.

use super::memory::{direction, turned};
use super::{Count, Covariate, Effect, Law, Needs, Role, Shape, Sign, Strength};
use crate::{Act, Stage};

const FRICTION: Strength = Strength {
    name: "friction",
    unit: "N",
    meaning: "force of sliding",
    sign: Sign::Positive,
    typical: |scales| 0.005 * scales.force,
    most: |scales| 0.5 * scales.force,
    count: Count::Fixed(&[]),
};

/// Speed at which sliding is complete.
pub(super) const SLIDING_SPEED: Shape = Shape {
    name: "sliding_speed",
    unit: "mm/s",
    meaning: "speed at which sliding is complete",
    grid: |scales| [0.002, 0.02].map(|part| part * scales.speed).to_vec(),
    role: Role::Fitted(|scales| (1e-4 * scales.speed, 0.3 * scales.speed)),
};

/// Way after a reversal in which sliding sets in.
pub(super) const PRESLIDING: Shape = Shape {
    name: "presliding",
    unit: "mm",
    meaning: "way after a reversal in which sliding sets in",
    grid: |scales| [0.005, 0.05].map(|part| part * scales.compression).to_vec(),
    role: Role::Fitted(|scales| (5e-4 * scales.compression, 0.5 * scales.compression)),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "coulomb-friction",
    stage: Stage::Contact,
    meaning: "Guides, seals or the rim of the indenter rub with a constant force against the motion.",
    signature: "Flips with the direction, the same at every speed and depth; gone in the hold, or frozen there.",
    against: Covariate::Velocity,
    confused_with: &["rate-drag", "backlash", "load-friction", "viscous-drag"],
    experiment: "Small cycles about a mean compression, slow and fast.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "F → F + F_c tanh(v/v0)",
            strength: FRICTION,
            shapes: &[SLIDING_SPEED],
            act: Act::Added(|scene, parameters, _, force| {
                for (force, velocity) in force.iter_mut().zip(scene.velocity.iter()) {
                    *force += parameters[0] * (velocity / parameters[1]).tanh();
                }
            }),
        },
        Law {
            name: "dahl",
            formula: "F → F + F_c z, dz = (sgn dx − z) |dx|/ℓ",
            strength: FRICTION,
            shapes: &[PRESLIDING],
            act: Act::Added(|scene, parameters, remembered, force| {
                let path = &scene.motion.displacement;
                let direction = direction(remembered, 0.0, parameters[1], path);
                for (force, direction) in force.iter_mut().zip(direction) {
                    *force += parameters[0] * direction;
                }
            }),
        },
        Law {
            name: "in-contact",
            formula: "F → F + F_c tanh(v/v0) where F > 0",
            strength: FRICTION,
            shapes: &[SLIDING_SPEED],
            act: Act::Force(|scene, parameters, _, force| {
                for (force, velocity) in force.iter_mut().zip(scene.velocity.iter()) {
                    if *force > 0.0 {
                        *force += parameters[0] * (velocity / parameters[1]).tanh();
                    }
                }
            }),
        },
        Law {
            name: "dahl-in-contact",
            formula: "F → F + F_c z where F > 0, dz = (sgn dx − z) |dx|/ℓ; z = 0 elsewhere",
            strength: FRICTION,
            shapes: &[PRESLIDING],
            act: Act::Force(|scene, parameters, remembered, force| {
                for (force, &place) in force.iter_mut().zip(scene.motion.displacement.iter()) {
                    let direction = turned(remembered, 0.0, parameters[1], place);
                    if *force > 0.0 {
                        *force += parameters[0] * direction;
                    } else {
                        // What has let go is no longer bent.
                        remembered[0] = 0.0;
                    }
                }
            }),
        },
        Law {
            name: "stribeck",
            formula: "F → F + F_c (1 + e^(−(v/v_s)²)/2) tanh(10 v/v_s)",
            strength: FRICTION,
            shapes: &[Shape {
                name: "stribeck_speed",
                unit: "mm/s",
                meaning: "speed at which the friction has fallen from half as much again to that of sliding",
                grid: |scales| vec![0.1 * scales.speed],
                role: Role::Fitted(|scales| (0.005 * scales.speed, 0.5 * scales.speed)),
            }],
            act: Act::Added(|scene, parameters, _, force| {
                for (force, velocity) in force.iter_mut().zip(scene.velocity.iter()) {
                    let speeds = velocity / parameters[1];
                    let sticking = 1.0 + 0.5 * (-speeds * speeds).exp();
                    *force += parameters[0] * sticking * (10.0 * speeds).tanh();
                }
            }),
        },
    ],
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Motion, Scene};

    #[test]
    fn a_specimen_that_comes_back_in_a_hold_does_not_rub_before_it_moves() {
        // Pressed, drawn back until it lets go, held while it recovers, and pressed on.
        let displacement = [0.0, 2.0, 1.0, 0.5, 0.5, 0.5, 1.0];
        let alone = [0.0, 3.0, 1.0, 0.0, 0.1, 0.2, 1.0];
        let motion = Motion {
            time: (&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0][..]).into(),
            displacement: (&displacement[..]).into(),
            rest_before: None,
        };
        let of_none = &[0.0; 7][..];
        let scene = Scene {
            trace: 0,
            motion: &motion,
            since: of_none.into(),
            begin: 0.0,
            velocity: of_none.into(),
            acceleration: of_none.into(),
            loadings: of_none.into(),
            largest: of_none.into(),
            warmth: None,
            channels: &[],
            measured: &[],
        };
        let law = EFFECT.laws.iter().find(|law| law.name == "dahl-in-contact").unwrap();
        let Act::Force(act) = &law.act else { panic!("friction acts on the force") };
        let mut force = alone;
        act(&scene, &[0.1, 0.001], &mut Vec::new(), &mut force);
        let rubs: Vec<f64> = force.iter().zip(alone).map(|(with, alone)| with - alone).collect();
        for (rubs, expected) in rubs.iter().zip([0.0, 0.1, -0.1, 0.0, 0.0, 0.0, 0.1]) {
            assert!((rubs - expected).abs() < 1e-12, "{rubs:?} for {expected}");
        }
    }
}
