//! How the rate of a branch grows with its state, and where a state goes that is driven meanwhile.
//!
//! A state x decays as x' = −v h(x) x. Alone it does so in closed form (eqs 7.4, 7.5 for a power). Driven,
//! x' = −v h(x) x + D', it goes by the linear law with the decay of the middle of its way, which is exact for
//! h = 1; one such step and two halves give the error and a better value. Each part of an interval is as long
//! as [`TOLERANCE`] allows. Nothing is capped: the power of a large state is followed by its logarithm.

use super::relaxation::{decay_and_mean, mean_decay};

/// How the rate of a branch grows with its state x: a factor h(x).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Growth {
    /// h = 1: a linear law.
    None,
    /// h = |x/X|^m: power m, and state X, N, at which the rates are stated.
    Power(f64, f64),
    /// h = sinh(s y)/(s y), y = x/X: strength s and state X, N (Eyring).
    Sinh(f64, f64),
}

/// Smallest power or strength that differs from a linear law.
const MIN_GROWTH: f64 = 1e-9;
/// Largest error of two half steps, of state and drive; what is left of it after extrapolation is about a
/// hundredth.
const TOLERANCE: f64 = 1e-6;
/// Turns of the drive by itself within the first part of an interval.
const FIRST_PART: f64 = 0.5;
/// Parts of an interval shorter than this are not divided further.
const SHORTEST_PART: f64 = 1e-5;
/// What is still to come and smaller than this, of the error allowed, is left out.
const NEGLIGIBLE: f64 = 1e-3;
/// A drive smaller than this, of the state, changes no gain.
const NO_DRIVE: f64 = 1e-7;
/// Largest number whose exponential is one.
const LARGEST_EXPONENT: f64 = 700.0;

impl Growth {
    /// This growth on top of another one.
    #[must_use]
    pub fn on(self, base: Self) -> Self {
        match (self, base) {
            (_, Self::None) => self,
            // Powers of the state multiply; the scale of the base law stays.
            (Self::Power(more, _), Self::Power(power, full)) => Self::Power(power + more, full),
            _ => base,
        }
    }

    /// Whether the rate stays what it is.
    pub(super) fn is_none(self) -> bool {
        match self {
            Self::None => true,
            Self::Power(power, _) => power.abs() <= MIN_GROWTH,
            Self::Sinh(strength, _) => strength.abs() <= MIN_GROWTH,
        }
    }

    /// By how many times its e-th part a state x decays where a linear law would do it `turns` times:
    /// ∫ v h(x) dt.
    fn turns(self, x: f64, turns: f64) -> f64 {
        if self.is_none() || x == 0.0 {
            return turns * self.at(x);
        }
        match self {
            Self::None => turns,
            Self::Power(power, full) => {
                let logarithm = power * (x / full).abs().ln() + (power.abs() * turns).ln();
                if logarithm > LARGEST_EXPONENT {
                    // Where the rate grows towards rest, rest is reached within the interval.
                    return if power > 0.0 { logarithm / power } else { f64::INFINITY };
                }
                let gone = (power.signum() * logarithm.exp()).max(-1.0);
                gone.ln_1p() / power
            }
            Self::Sinh(strength, full) => {
                let y = (strength * x / full).abs();
                if y < 1e-6 {
                    return turns;
                }
                // tanh(s y/2) decays exponentially; where it is near 1, its complement keeps its digits.
                let kept = (0.5 * y).tanh() * (-turns).exp();
                let after = if kept < 0.5 {
                    2.0 * kept.atanh()
                } else {
                    let rest = 2.0 / (y.exp() + 1.0) + (0.5 * y).tanh() * -(-turns).exp_m1();
                    ((2.0 - rest) / rest).ln()
                };
                (y / after).ln().max(0.0)
            }
        }
    }

    /// The factor h(x).
    fn at(self, x: f64) -> f64 {
        match self {
            Self::None => 1.0,
            Self::Power(power, full) => (x / full).abs().powf(power),
            Self::Sinh(strength, full) => {
                let y = (strength * x / full).abs();
                if y < 1e-4 { 1.0 + y * y / 6.0 } else { y.sinh() / y }
            }
        }
    }

    /// A state left alone for an interval.
    pub(super) fn alone(self, x: f64, turns: f64) -> f64 {
        if x == 0.0 { 0.0 } else { x * (-self.turns(x, turns)).exp() }
    }

    /// Decay a and gain b of one interval, x⁺ = a x + b change: exact without a drive and for this one, a
    /// secant between.
    pub(super) fn step(self, x: f64, change: f64, turns: f64) -> (f64, f64) {
        if self.is_none() {
            return decay_and_mean(turns);
        }
        let decays = self.turns(x, turns);
        let decay = (-decays).exp();
        if change.abs() > NO_DRIVE * x.abs() {
            let alone = if x == 0.0 { 0.0 } else { x * decay };
            return (decay, (self.driven(x, change, turns) - alone) / change);
        }
        // The derivative of where a state goes to is the ratio of its rates, last to first.
        let first = turns * self.at(x);
        (decay, if first < 1e-8 { 1.0 } else { -(-decays).exp_m1() / first })
    }

    /// Where a state goes that decays `turns` times by a linear law, and is driven evenly by `change`.
    pub(super) fn driven(self, x: f64, change: f64, turns: f64) -> f64 {
        if self.is_none() {
            return x * (-turns).exp() + change * mean_decay(turns);
        }
        if change == 0.0 {
            return self.alone(x, turns);
        }
        let step = |x: f64, part: f64| {
            let change = part * change;
            let decays = self.turns(x + 0.5 * change, part * turns);
            x * (-decays).exp() + change * mean_decay(decays)
        };
        let (mut x, mut done) = (x, 0.0);
        // A first step that crosses rest could mistake itself.
        let mut part = (FIRST_PART / (turns * self.at(change))).clamp(SHORTEST_PART, 1.0);
        loop {
            let once = step(x, part);
            let twice = step(step(x, 0.5 * part), 0.5 * part);
            let error = (twice - once).abs() / 3.0;
            let best = twice + (twice - once) / 3.0;
            let allowed = TOLERANCE * (best.abs() + change.abs());
            let accepted = !(error > allowed && part > SHORTEST_PART);
            if accepted {
                done += part;
                // A state only slows down towards the balance of decay and drive.
                let ahead = (best - x).abs() * (1.0 - done) / part;
                x = best;
                if ahead.is_nan() || ahead <= NEGLIGIBLE * allowed {
                    return x;
                }
            }
            let longer = if error > 0.0 { 0.9 * (allowed / error).cbrt() } else { 5.0 };
            part = (part * longer.clamp(0.1, 5.0)).max(SHORTEST_PART).min(1.0 - done);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        #[test]
        fn by_eyrings_law_a_state_decays_faster_than_by_a_linear_one_however_long_it_rests(
            y in 1e-7..50.0f64,
            turns in 1e-3..1e3f64,
            strength in 0.01..8.0f64,
        ) {
            let after = Growth::Sinh(strength, 1.0).alone(y, turns);
            prop_assert!((0.0..=y * (-turns).exp() * (1.0 + 1e-9)).contains(&after), "{after}");
        }
    }
}
