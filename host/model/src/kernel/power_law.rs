//! `power-law`: a springpot beside a spring.

use statrs::function::gamma::gamma;

use super::{FIRST_ORDERS, Kernel, MemoryOf, OVER, Span, Spectrum};
use crate::coordinate::Coordinate;
use crate::laws::LawParameter;
use crate::{Branch, Constants};

/// Orders β that it may have.
const ORDERS: (f64, f64) = (0.005, 0.95);
/// One with less than this rate times the longest time stands for all that are slower.
const STANDING: f64 = 0.005;
/// Step of the logarithm of the rate for a power law.
const POWER_STEP: f64 = 0.7;

/// g = c0 + c1 (t/1 s)^(−β), c0 + c1 = 1. The elastic response is that one second after a step.
pub(super) static KERNEL: Kernel = Kernel {
    name: "power-law",
    meaning: "a springpot (fractional element) beside a spring: relaxes alike over every decade of time",
    formula: "g = c0 + c1 (t/1 s)^(−β)",
    memory: MemoryOf::Spectrum {
        of: |_, order, span| power_law(order, span),
        later: |order, time| time.powf(-order),
        has_rate: false,
        orders: FIRST_ORDERS,
    },
    parameters: |_| {
        let share = "share of the response after 1 s that relaxes";
        let order = "power of time with which it relaxes";
        vec![
            LawParameter::new("c1", "", share, (0.0, 1.0), Coordinate::Force(1)),
            LawParameter::new("beta", "", order, ORDERS, Coordinate::Order),
        ]
    },
    constants: |values, elastic| Constants { shares: vec![values[0]], order: values[1], ..elastic },
    values: |constants| vec![constants.shares[0], constants.order],
};

/// t^(−β) = 1/Γ(β) ∫ e^(βu) e^(−t e^u) du by the trapezoidal rule, which converges exponentially with the
/// step. What lies beyond either end is a geometric series.
pub(super) fn power_law(order: f64, span: Span) -> Spectrum {
    let size = POWER_STEP / gamma(order);
    let first = ((STANDING / span.longest).ln() / POWER_STEP).floor();
    let last = ((OVER / span.shortest).ln() / POWER_STEP).ceil();
    // Sum of e^(power·u) over all places beyond this one.
    let beyond = |place: f64, power: f64| {
        let step = (-power.abs() * POWER_STEP).exp();
        (power * place * POWER_STEP).exp() * step / (1.0 - step)
    };
    let slow = beyond(first, order);
    let mut branches = vec![Branch { share: size * slow, rate: beyond(first, order + 1.0) / slow }];
    let count = (last - first) as usize;
    branches.extend((0..=count).map(|k| {
        let log = (first + k as f64) * POWER_STEP;
        Branch { share: size * (order * log).exp(), rate: log.exp() }
    }));
    Spectrum { branches, viscosity: size * beyond(last, order - 1.0) }
}
