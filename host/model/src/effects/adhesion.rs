//! `adhesion`: the surfaces pull at each other while they part.

use super::memory::direction;
use super::shapes::FULL_SPEED;
use super::{Count, Covariate, Effect, Law, Needs, Role, Scales, Shape, Sign, Strength};
use crate::{Act, Remembered, Scene, Stage};

const PULL: Strength = Strength {
    name: "pull",
    unit: "N",
    meaning: "largest force of the pull",
    sign: Sign::Positive,
    typical: |scales| 0.01 * scales.force,
    most: |scales| 10.0 * scales.force,
    count: Count::Fixed(&[]),
};

const LENGTH: Shape = Shape {
    name: "length",
    unit: "mm",
    meaning: "distance from the touch at which the pull has faded",
    grid: |scales| {
        let near = [0.03, 0.15].map(|part| part * scales.compression);
        far(scales).into_iter().map(|reach| 0.4 * reach).chain(near).collect()
    },
    role: Role::Fitted(|scales| (1e-3 * scales.compression, 3.0 * reach(scales))),
};

/// Part of the compression beyond which the surfaces parted so far that a long neck could be seen.
const NECK_LENGTH: f64 = 0.2;

/// The way over which a pull could act: the compression, or the parting where that is larger.
fn reach(scales: &Scales) -> f64 {
    scales.compression.max(scales.parting)
}

/// How far a neck could reach off the specimen, mm: none where the surfaces hardly part.
fn far(scales: &Scales) -> Option<f64> {
    (scales.parting > NECK_LENGTH * scales.compression)
        .then(|| scales.parting.min(scales.compression))
}

const WIDTH: Shape = Shape {
    grid: |scales| {
        let near = 0.1 * scales.compression;
        far(scales).into_iter().map(|reach| 0.4 * reach).chain([near]).collect()
    },
    ..LENGTH
};

const PLACE: Shape = Shape {
    name: "place",
    unit: "mm",
    meaning: "compression at which the pull is largest",
    grid: |scales| {
        let near = [0.0, 0.1].map(|part| part * scales.compression);
        far(scales).into_iter().map(|reach| -0.4 * reach).chain(near).collect()
    },
    role: Role::Fitted(|scales| {
        (-scales.parting.max(0.1 * scales.compression), scales.compression)
    }),
};

const EXPONENT: Shape = Shape {
    name: "exponent",
    unit: "",
    meaning: "how the pull grows with the speed",
    grid: |_| vec![0.3],
    role: Role::Bounded(|_| (0.01, 3.0)),
};

/// Part of the length of the pull in which a motion turns from approaching to parting.
const TURN: f64 = 0.1;

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "adhesion",
    stage: Stage::Contact,
    meaning: "Tack or a film of liquid holds the surfaces together when they part, until the neck breaks.",
    signature: "At the end of unloading, where the force goes below zero; nothing on the way in.",
    against: Covariate::Displacement,
    confused_with: &["contact-offset", "permanent-set"],
    experiment: "Part slowly and fast, with the surface as it is and powdered.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "F → F − w e^(−|x|/ℓ) while parting",
            strength: PULL,
            shapes: &[LENGTH],
            act: Act::Added(|scene, parameters, remembered, force| {
                let (pull, length) = (parameters[0], parameters[1]);
                for (k, parting) in parting(scene, remembered, length).into_iter().enumerate() {
                    let x = scene.motion.displacement[k];
                    force[k] -= pull * parting * (-x.abs() / length).exp();
                }
            }),
        },
        Law {
            name: "gaussian",
            formula: "F → F − w e^(−((x − x_p)/ℓ)²) while parting",
            strength: PULL,
            shapes: &[WIDTH, PLACE],
            act: Act::Added(|scene, parameters, remembered, force| {
                let (pull, length, place) = (parameters[0], parameters[1], parameters[2]);
                for (k, parting) in parting(scene, remembered, length).into_iter().enumerate() {
                    let off = (scene.motion.displacement[k] - place) / length;
                    force[k] -= pull * parting * (-off * off).exp();
                }
            }),
        },
        Law {
            name: "neck",
            formula: "F → F − w |v/V|^k e^(−((x − x_p)/ℓ)²) while parting",
            strength: Strength { meaning: "largest force of the pull at full speed", ..PULL },
            shapes: &[WIDTH, PLACE, EXPONENT, FULL_SPEED],
            act: Act::Added(neck),
        },
        Law {
            name: "rate",
            formula: "F → F − w |v/V|^k e^(−|x|/ℓ) while parting",
            strength: Strength { meaning: "largest force of the pull at full speed", ..PULL },
            shapes: &[LENGTH, EXPONENT, FULL_SPEED],
            act: Act::Added(by_rate),
        },
        Law {
            name: "cohesive",
            formula: "F → F − w (s/ℓ) e^(1 − s/ℓ), s the way since the force had gone",
            strength: PULL,
            shapes: &[LENGTH],
            act: Act::Force(cohesive),
        },
    ],
};

/// From 0 in approach to 1 while parting; a rest changes nothing.
fn parting(scene: &Scene, remembered: &mut Remembered, length: f64) -> Vec<f64> {
    let mut parting = direction(remembered, 1.0, TURN * length, &scene.motion.displacement);
    for way in &mut parting {
        *way = 0.5 * (1.0 - *way);
    }
    parting
}

fn neck(scene: &Scene, parameters: &[f64], remembered: &mut Remembered, force: &mut [f64]) {
    let &[pull, length, place, exponent, full] = parameters else { return };
    for (k, parting) in parting(scene, remembered, length).into_iter().enumerate() {
        let off = (scene.motion.displacement[k] - place) / length;
        let fast = (scene.velocity[k] / full).abs().powf(exponent);
        force[k] -= pull * parting * fast * (-off * off).exp();
    }
}

fn by_rate(scene: &Scene, parameters: &[f64], remembered: &mut Remembered, force: &mut [f64]) {
    let &[pull, length, exponent, full] = parameters else { return };
    for (k, parting) in parting(scene, remembered, length).into_iter().enumerate() {
        let x = scene.motion.displacement[k];
        let fast = (scene.velocity[k] / full).abs().powf(exponent);
        force[k] -= pull * parting * fast * (-x.abs() / length).exp();
    }
}

/// Traction that grows and fades with the way of parting from where the contact force had gone. The
/// memory is that place, mm, and the last one.
fn cohesive(scene: &Scene, parameters: &[f64], remembered: &mut Remembered, force: &mut [f64]) {
    let (pull, length) = (parameters[0], parameters[1]);
    if remembered.is_empty() {
        *remembered = vec![f64::NEG_INFINITY, f64::NEG_INFINITY];
    }
    for (force, &x) in force.iter_mut().zip(scene.motion.displacement.iter()) {
        if *force > 0.0 {
            remembered[0] = x;
        } else if x > remembered[1] {
            // On the way back in, the surfaces are apart.
            remembered[0] = f64::NEG_INFINITY;
        }
        let way = (remembered[0] - x) / length;
        if way > 0.0 {
            *force -= pull * way * (1.0 - way).exp();
        }
        remembered[1] = x;
    }
}
