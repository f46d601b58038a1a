//! `latency-law`: how fast a state relaxes is a power of how far it is off.

use super::{Count, Covariate, Effect, Law, Needs, Role, Shape, Sign, Strength};
use crate::{Act, Growth, Stage};

/// Smallest power n − 1 that is followed: below, a state would be at rest after no time.
const MIN_POWER: f64 = -0.7;

const FULL_STATE: Shape = Shape {
    name: "full_state",
    unit: "N",
    meaning: "state at which the rates are stated",
    grid: |scales| vec![scales.force],
    role: Role::Given,
};

/// The effect.
pub const EFFECT: Effect = Effect {
    name: "latency-law",
    stage: Stage::Relaxation,
    meaning: "The state does not decay exponentially: far from equilibrium it relaxes faster, close to it slower, than any exponential.",
    signature: "Early against late hold, in opposite directions; large presses relax faster than small ones.",
    against: Covariate::Time,
    confused_with: &["slow-relaxation", "fast-mode", "amplitude-dependent-relaxation"],
    experiment: "Hold ten times longer, at a small and at a large amplitude: the time in which half is gone depends on the amplitude.",
    needs: Needs::Nothing,
    laws: &[
        Law {
            name: "reference",
            formula: "dε/dt = −ν sgn(ε − ε_e) |ε − ε_e|^n, |ε − ε_e| in parts of its size at full force",
            strength: Strength {
                name: "excess",
                unit: "",
                meaning: "n − 1, the power by which the rate grows with the state",
                sign: Sign::Either,
                typical: |_| 0.05,
                most: |_| 4.0,
                count: Count::Fixed(&[]),
            },
            shapes: &[FULL_STATE],
            act: Act::Relaxation(|_, parameters, _, _, relaxation| {
                let growth = Growth::Power(parameters[0].max(MIN_POWER), parameters[1]);
                relaxation.growth = growth.on(relaxation.growth);
            }),
        },
        Law {
            name: "eyring",
            formula: "dε/dt = −ν E/s sinh(s (ε − ε_e)/E), E the size of ε − ε_e at full force",
            strength: Strength {
                name: "activation",
                unit: "",
                meaning: "how far beyond thermal the state is at full force",
                sign: Sign::Positive,
                typical: |_| 0.7,
                most: |_| 8.0,
                count: Count::Fixed(&[]),
            },
            shapes: &[FULL_STATE],
            act: Act::Relaxation(|_, parameters, _, _, relaxation| {
                let growth = Growth::Sinh(parameters[0], parameters[1]);
                relaxation.growth = growth.on(relaxation.growth);
            }),
        },
    ],
};
