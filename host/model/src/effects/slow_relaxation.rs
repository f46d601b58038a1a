//! `slow-relaxation`: a tail slower than the exponentials of the base law.

use super::{Count, Covariate, Effect, Law, Needs, Role, Shape, Sign, Strength};
use crate::{Act, Branch, Hereditary, Stage};

const SHARE: Strength = Strength {
    name: "share",
    unit: "",
    meaning: "share of the elastic response that relaxes in a decade of time",
    sign: Sign::Positive,
    typical: |_| 0.01,
    most: |_| 1.0,
    count: Count::Fixed(&[]),
};

/// Time, s, at which the tail of the power law sets in.
const BEGIN: f64 = 1.0;

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "slow-relaxation",
    stage: Stage::Relaxation,
    meaning: "The specimen goes on relaxing over minutes and hours, about as much in each decade of time.",
    signature: "Late in the hold, where the force still falls, and from trace to trace while the specimen recovers.",
    against: Covariate::Time,
    confused_with: &["drift", "latency-law", "zero-shift"],
    experiment: "Record an hour with no load: a sensor still drifts there. Then hold for an hour.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "g → g − c log10(1 + t/t0)",
            strength: SHARE,
            shapes: &[Shape {
                name: "begin",
                unit: "s",
                meaning: "time at which the tail sets in",
                grid: |_| vec![1.0],
                role: Role::Fitted(|_| (0.01, 100.0)),
            }],
            act: Act::Relaxation(|_, parameters, _, _, relaxation| {
                tail(relaxation, parameters[0], 0.0, parameters[1]);
            }),
        },
        Law {
            name: "power-law",
            formula: "g → g + c Σ (t0/τ_i)^β e^(−t0/τ_i) (e^(−t/τ_i) − 1)/2, τ_i = t0 10^(i/2), t0 = 1 s",
            strength: SHARE,
            shapes: &[Shape {
                name: "exponent",
                unit: "",
                meaning: "how the share of a decade falls with its time",
                grid: |_| vec![-0.3, 0.3],
                role: Role::Fitted(|_| (-0.5, 1.5)),
            }],
            act: Act::Relaxation(|_, parameters, _, _, relaxation| {
                tail(relaxation, parameters[0], parameters[1], BEGIN);
            }),
        },
        Law {
            name: "single",
            formula: "g → g + c (e^(−t/τ) − 1)",
            strength: Strength {
                meaning: "share of the elastic response that relaxes slowly",
                typical: |_| 0.03,
                most: |_| 0.9,
                ..SHARE
            },
            shapes: &[Shape {
                name: "time",
                unit: "s",
                meaning: "its time constant",
                grid: |scales| [0.7, 5.0].map(|times| times * scales.duration).to_vec(),
                role: Role::Fitted(|scales| (0.5 * scales.duration, 100.0 * scales.duration)),
            }],
            act: Act::Relaxation(|_, parameters, _, _, relaxation| {
                relaxation
                    .branches
                    .push(Branch { share: parameters[0], rate: 1.0 / parameters[1] });
            }),
        },
    ],
};

/// Two exponentials in each decade over four decades from `begin` on, s. Their shares are those of the
/// spectrum of log10(1 + t/`begin`) where `exponent` is 0, else of (1 + t/`begin`)^−`exponent`.
fn tail(relaxation: &mut Hereditary, share: f64, exponent: f64, begin: f64) {
    relaxation.branches.extend((-1..=12).map(|k| {
        let times = 10f64.powf(0.5 * f64::from(k));
        let weight = times.powf(-exponent) * (-1.0 / times).exp();
        Branch { share: 0.5 * share * weight, rate: 1.0 / (begin * times) }
    }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Separation;

    #[test]
    fn the_tail_is_a_logarithm() {
        let mut relaxation = Hereditary::linear(Vec::new(), Separation::Clamp);
        tail(&mut relaxation, 0.01, 0.0, 2.0);
        for time in [0.5, 3.0, 30.0, 300.0] {
            let lost: f64 =
                relaxation.branches.iter().map(|b| -b.share * (-b.rate * time).exp_m1()).sum();
            let expected = 0.01 * (1.0 + time / 2.0f64).log10();
            assert!((lost / expected - 1.0).abs() < 0.03, "{lost} for {expected} at {time} s");
        }
    }
}
