//! `amplitude-dependent-relaxation`: how much relaxes, or how fast, depends on the compression.

use super::shapes::FULL_COMPRESSION;
use super::{Count, Covariate, Effect, Law, Needs, Sign, Strength};
use crate::{Act, Stage};

const GROWTH: Strength = Strength {
    name: "growth",
    unit: "1/mm",
    meaning: "part by which the relaxing shares grow for each millimetre",
    sign: Sign::Either,
    typical: |scales| 0.1 / scales.compression,
    most: |scales| 6.0 / scales.compression,
    count: Count::Fixed(&[]),
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "amplitude-dependent-relaxation",
    stage: Stage::Relaxation,
    meaning: "Relaxation is not a function of time alone: the deeper the press, the larger or smaller the part that relaxes.",
    signature: "In the hold; its sign flips from small to large amplitude.",
    against: Covariate::Time,
    confused_with: &["latency-law"],
    experiment: "Step and hold at five amplitudes, reached in the same time.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "c_i → c_i (1 + κ x)",
            strength: GROWTH,
            shapes: &[],
            act: Act::Relaxation(|_, parameters, _, x, relaxation| {
                let factor = |&x: &f64| (1.0 + parameters[0] * x.abs()).max(0.0);
                multiply(&mut relaxation.share_factor, x, factor);
            }),
        },
        Law {
            name: "driven",
            formula: "modes driven by N (1 + κ x)",
            strength: GROWTH,
            shapes: &[],
            act: Act::Relaxation(|_, parameters, _, x, relaxation| {
                let factor = |&x: &f64| (1.0 + parameters[0] * x.abs()).max(0.0);
                multiply(&mut relaxation.drive_factor, x, factor);
            }),
        },
        Law {
            name: "pipkin-rogers",
            formula: "modes driven by N (x/X)^k",
            strength: Strength {
                name: "exponent",
                unit: "",
                meaning: "power of the compression by which the relaxing part grows",
                sign: Sign::Either,
                typical: |_| 0.05,
                most: |_| 0.9,
                count: Count::Fixed(&[]),
            },
            shapes: &[FULL_COMPRESSION],
            act: Act::Relaxation(|_, parameters, _, x, relaxation| {
                let (exponent, full) = (parameters[0], parameters[1]);
                let factor = |x: &f64| (x.abs() / full).max(MIN_COMPRESSION).powf(exponent);
                multiply(&mut relaxation.drive_factor, x, factor);
            }),
        },
        Law {
            name: "rates",
            formula: "v_i → v_i e^(κ x)",
            strength: Strength {
                meaning: "part by which the rates of relaxation grow for each millimetre",
                ..GROWTH
            },
            shapes: &[],
            act: Act::Relaxation(|_, parameters, _, x, relaxation| {
                if parameters[0] != 0.0 {
                    let factor = |x: &f64| (parameters[0] * x.abs()).min(20.0).exp();
                    multiply(&mut relaxation.rate_factor, x, factor);
                }
            }),
        },
    ],
};

/// Part of the full compression below which the power of the compression stays what it is.
const MIN_COMPRESSION: f64 = 1e-4;

/// Multiplies a factor on the relaxation, sample by sample, by another.
fn multiply(factor: &mut Option<Vec<f64>>, x: &[f64], by: impl Fn(&f64) -> f64) {
    let factor = factor.get_or_insert_with(|| vec![1.0; x.len()]);
    for (factor, x) in factor.iter_mut().zip(x) {
        *factor *= by(x);
    }
}
