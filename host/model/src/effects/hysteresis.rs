//! `hysteresis`: the signal depends on where the force came from.

use super::shapes::FULL_FORCE;
use super::{Count, Covariate, Effect, Law, Needs, Role, Shape, Sign, Strength};
use crate::{Act, Remembered, Scene, Stage};

const HEIGHT: Strength = Strength {
    name: "height",
    unit: "N",
    meaning: "half the height of a wide loop; above 0 where the signal rises early",
    sign: Sign::Either,
    typical: |scales| 0.005 * scales.force,
    most: |scales| 0.3 * scales.force,
    count: Count::Fixed(&[]),
};

const WIDTH: Shape = Shape {
    name: "width",
    unit: "N",
    meaning: "change of the force in which the loop opens",
    grid: |scales| [0.05, 0.25].map(|part| part * scales.force).to_vec(),
    role: Role::Fitted(|scales| (0.005 * scales.force, scales.force)),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "hysteresis",
    stage: Stage::Sensor,
    meaning: "Glue, backing and the metal under a bonded gauge slip a little, so that the signal depends on where the force came from.",
    signature: "A loop over the force that is the same at every rate, and an offset in the hold that turns with the force.",
    against: Covariate::Force,
    confused_with: &["load-friction", "coulomb-friction"],
    experiment: "Hang dead weights one after the other and take them off again, with a rest at each.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "F → F + h z, dz = (dF − (|dF| z + dF |z|)/2)/D",
            strength: HEIGHT,
            shapes: &[WIDTH],
            act: Act::Force(bouc_wen),
        },
        Law {
            name: "play",
            formula: "F → F + h (F − P)/D, P stays while within [F − D, F + D]",
            strength: HEIGHT,
            shapes: &[WIDTH],
            act: Act::Force(|_, parameters, remembered, force| {
                slip(remembered, &[parameters[1]], |_| parameters[0], force);
            }),
        },
        Law {
            name: "maxwell-slip",
            formula: "F → F + h mean_j (F − P_j)/D_j, P_j stays while within [F − D_j, F + D_j], D_j = D, D/2, D/4",
            strength: HEIGHT,
            shapes: &[Shape { grid: |scales| vec![0.3 * scales.force], ..WIDTH }],
            act: Act::Force(|_, parameters, remembered, force| {
                let widths = [1.0, 0.5, 0.25].map(|part| part * parameters[1]);
                slip(remembered, &widths, |_| parameters[0] / 3.0, force);
            }),
        },
        Law {
            name: "exponential",
            formula: "F → F + h Σ_j w_j (F − P_j)/D_j, P_j stays while within [F − D_j, F + D_j], D_j = j D/4, w_j ∝ j e^(−j/4), Σ_j w_j = 1, j = 1 to 8",
            strength: HEIGHT,
            shapes: &[Shape { grid: |scales| vec![0.2 * scales.force], ..WIDTH }],
            act: Act::Force(|_, parameters, remembered, force| {
                let part = |j: usize| 0.25 * (j + 1) as f64;
                let weight = |j: usize| part(j) * (-part(j)).exp();
                let all: f64 = (0..8).map(weight).sum();
                let widths = std::array::from_fn::<_, 8, _>(|j| part(j) * parameters[1]);
                let heights = std::array::from_fn::<_, 8, _>(|j| parameters[0] * weight(j) / all);
                slip(remembered, &widths, |j| heights[j], force);
            }),
        },
        Law {
            name: "preisach",
            formula: "F → F + h Σ_j (F − P_j)/Σ_j D_j, P_j stays while within [F − D_j, F + D_j], D_j = j F0/16, j = 1 to 8",
            strength: HEIGHT,
            shapes: &[FULL_FORCE],
            act: Act::Force(|_, parameters, remembered, force| {
                let widths =
                    std::array::from_fn::<_, 8, _>(|j| (j + 1) as f64 * parameters[1] / 16.0);
                // 36 = 1 + 2 + … + 8: elements of one stiffness.
                slip(remembered, &widths, |j| parameters[0] * (j + 1) as f64 / 36.0, force);
            }),
        },
    ],
};

/// After Bouc and Wen, with n = 1 and β = γ = 1/2: in each interval the law is a straight line towards
/// z = 0 and an exponential away from it.
fn bouc_wen(_: &Scene, parameters: &[f64], remembered: &mut Remembered, force: &mut [f64]) {
    let (height, width) = (parameters[0], parameters[1]);
    for force in force {
        if remembered.is_empty() {
            *remembered = vec![0.0, *force];
        }
        let (z, change) = (remembered[0], (*force - remembered[1]) / width);
        let sign = if change < 0.0 { -1.0 } else { 1.0 };
        // In the direction of the change, so that the loop has one branch to follow.
        let straight = sign * z + change.abs();
        let along = if straight <= 0.0 {
            straight
        } else {
            let begin = (sign * z).max(0.0);
            let rest = straight - begin;
            1.0 - (1.0 - begin) * (-rest).exp()
        };
        *remembered = vec![sign * along, *force];
        *force += height * sign * along;
    }
}

/// Adds elements that stick until the force has moved by their width and then slip. Each adds up to its
/// `heights`.
fn slip(
    remembered: &mut Remembered,
    widths: &[f64],
    heights: impl Fn(usize) -> f64,
    force: &mut [f64],
) {
    for force in force {
        remembered.resize(widths.len(), *force);
        let mut held = 0.0;
        for (j, (place, width)) in remembered.iter_mut().zip(widths).enumerate() {
            *place = place.max(*force - width).min(*force + width);
            held += heights(j) * (*force - *place) / width;
        }
        *force += held;
    }
}
