//! `time-temperature`: the specimen relaxes faster when warm.

use super::memory::body_warmth;
use super::shapes::BODY_TIME;
use super::{Count, Covariate, Effect, Law, Needs, Sign, Strength};
use crate::{Act, Hereditary, Stage};

const COEFFICIENT: Strength = Strength {
    name: "coefficient",
    unit: "1/K",
    meaning: "part by which the rates of relaxation grow for each kelvin",
    sign: Sign::Positive,
    typical: |_| 0.02,
    // Rates e^5 times those at the reference where it is furthest from it.
    most: |scales| 5.0 / scales.warmth.max(0.1),
    count: Count::Fixed(&[]),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "time-temperature",
    stage: Stage::Relaxation,
    meaning: "Warmth speeds up all relaxation by the same factor, as time-temperature superposition has it.",
    signature: "Early in the hold and on fast ramps, and from trace to trace as the temperature.",
    against: Covariate::Temperature,
    confused_with: &["thermal-stiffness"],
    experiment: "Step the temperature by 5 K, wait until the specimen has it, and press and hold as before.",
    needs: Needs::Temperature,
    laws: &[
        Law {
            name: "reference",
            formula: "v_i → v_i e^(κ (T − T0))",
            strength: COEFFICIENT,
            shapes: &[],
            act: Act::Relaxation(|scene, parameters, _, _, relaxation| {
                let warmth = (0..scene.len()).map(|k| scene.warmth(k));
                speed_up(relaxation, parameters[0], &warmth.collect::<Vec<_>>());
            }),
        },
        Law {
            name: "lagging",
            formula: "v_i → v_i e^(κ (T_s − T0)), θ dT_s/dt = T − T_s",
            strength: COEFFICIENT,
            shapes: &[BODY_TIME],
            act: Act::Relaxation(|scene, parameters, remembered, _, relaxation| {
                let warmth = body_warmth(scene, remembered, parameters[1]);
                speed_up(relaxation, parameters[0], &warmth);
            }),
        },
    ],
};

fn speed_up(relaxation: &mut Hereditary, coefficient: f64, warmth: &[f64]) {
    if coefficient == 0.0 {
        return;
    }
    let factor = relaxation.rate_factor.get_or_insert_with(|| vec![1.0; warmth.len()]);
    for (factor, warmth) in factor.iter_mut().zip(warmth) {
        *factor *= (coefficient * warmth).clamp(-20.0, 20.0).exp();
    }
}
