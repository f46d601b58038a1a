//! How the rate of a branch grows with its state, and where a state goes that is driven meanwhile.
//!
//! A state x decays as x' = −v h(x) x. Alone it does so in closed form (eqs 7.4, 7.5 for a power). Driven,
//! x' = −v h(x) x + D', it goes by its Taylor series, whose terms follow from a single power, where that converges
//! within an interval, as it does where a recording resolves the branch. Else it goes by the linear law with the decay
//! of the middle of its way, which is exact for h = 1; one such step and two halves give the error and a better value,
//! and each part of the interval is as long as [`TOLERANCE`] allows, until the state is so near to the [`Balance`] of decay and drive
//! that what is left of its way is known in closed form. Nothing is capped: the power of a large state is followed by its logarithm.

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
/// Largest last term of a Taylor series, of state and drive; what is left out after it is about a tenth.
const SERIES_TOLERANCE: f64 = 1e-8;
/// Part of an interval below which a Taylor series costs more than what else there is.
const SHORTEST_SERIES: f64 = 0.03;
/// Part of its own time, and of the way to rest, that a state may go by one series.
const SERIES_REACH: f64 = 0.4;
/// Decays by the linear law of the balance after which a state is there, to the last digit.
const SETTLED: f64 = 40.0;
/// Part of the error allowed that the third power of the way to the balance may make.
const THIRD: f64 = 0.03;
/// Part of the drive that may be needed to come to rest first: more than enough decays are left after it.
const BEYOND_REST: f64 = 0.25;
/// Largest number whose exponential is one.
const LARGEST_EXPONENT: f64 = 700.0;

/// Where decay and drive are in balance: y' = −rate (y + bend y² + third y³ …), y being how far a state is from it.
#[derive(Clone, Copy, Debug)]
struct Balance {
    at: f64,
    /// Decays in the interval.
    rate: f64,
    bend: f64,
    third: f64,
}

impl Balance {
    /// Where a state comes to within a part of the interval; none where it is too far from the balance for a law of the second order.
    fn reached(&self, x: f64, part: f64, change: f64) -> Option<f64> {
        let away = x - self.at;
        let allowed = THIRD * TOLERANCE * (x.abs() + change.abs());
        let bent = self.bend * away;
        let near = (self.third * away * away * away).abs() <= allowed && bent.abs() < 0.1;
        near.then(|| {
            let kept = (-self.rate * part).exp();
            self.at + away * kept / (1.0 + bent * (1.0 - kept))
        })
    }
}

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

    /// Decay and gain of one interval that are right for this change alone.
    pub(super) fn step_by(self, x: f64, change: f64, turns: f64) -> (f64, f64) {
        if self.is_none() {
            return decay_and_mean(turns);
        }
        let after = self.driven(x, change, turns);
        // Of the larger of the two, so that neither ratio is large.
        if change.abs() > x.abs() {
            (1.0, (after - x) / change)
        } else {
            (if x == 0.0 { 1.0 } else { after / x }, 0.0)
        }
    }

    /// Decay a and gain b of one interval, x⁺ = a x + b change: exact without a drive and for this one, a
    /// secant between.
    pub(super) fn step(self, x: f64, change: f64, turns: f64) -> (f64, f64) {
        if self.is_none() {
            return decay_and_mean(turns);
        }
        if change.abs() > NO_DRIVE * x.abs() {
            let alone = self.driven(x, 0.0, turns);
            let decay = if x == 0.0 { (-self.turns(x, turns)).exp() } else { alone / x };
            return (decay, (self.driven(x, change, turns) - alone) / change);
        }
        let decays = self.turns(x, turns);
        let decay = (-decays).exp();
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
        match self.series(x, change, turns) {
            Ok(x) => x,
            Err(reached) => {
                let balance = self.balance(change, turns);
                let settled = balance.as_ref().and_then(|it| self.settled(reached, change, it));
                settled.unwrap_or_else(|| self.in_parts(reached, change, turns, balance.as_ref()))
            }
        }
    }

    /// Where decay and drive are in balance; none where they are not.
    fn balance(self, change: f64, turns: f64) -> Option<Balance> {
        let at = match self {
            Self::Power(power, full) if power > -1.0 => {
                full * ((change / full).abs() / turns).powf(1.0 / (1.0 + power)) * change.signum()
            }
            Self::Sinh(strength, full) => {
                let steep = strength / full;
                (steep * change / turns).asinh() / steep
            }
            _ => return None,
        };
        let [_, slope, second, third, _] = self.rates(at, change, turns);
        let usable = slope < 0.0 && slope.is_finite() && second.is_finite() && third.is_finite();
        usable.then_some(Balance {
            at,
            rate: -slope,
            bend: 0.5 * second / slope,
            third: third / (6.0 * slope),
        })
    }

    /// The state at which decay and drive are in balance, where a state, `reached` after a part of the interval, surely comes to it
    /// within the rest.
    fn settled(self, (x, done): (f64, f64), change: f64, balance: &Balance) -> Option<f64> {
        let away = x - balance.at;
        let beyond = away * change > 0.0;
        // From either side the way to the balance is no slower than by this linear law: where the rate grows with the state, by that of
        // the balance; where it falls, by its slope there, and from beyond by that of the chord. From beyond rest it is no longer than
        // the drive alone takes to rest.
        let slope = match self {
            Self::Power(power, _) if power < 0.0 => {
                let tangent = (1.0 + power) * change / balance.at;
                // What decays in the whole interval goes with the power 1 + p of the state.
                let chord = change * ((x / balance.at).abs().powf(1.0 + power) - 1.0) / away;
                if beyond { chord.min(tangent) } else { tangent }
            }
            _ => change / balance.at,
        };
        let decays = (1.0 - done) * slope;
        let beyond_rest = -x * change.signum();
        (decays >= SETTLED && beyond_rest <= BEYOND_REST * change.abs() * (1.0 - done))
            .then_some(balance.at)
    }

    /// Where a state goes that was `reached` after a part of the interval, part by part.
    fn in_parts(
        self,
        reached: (f64, f64),
        change: f64,
        turns: f64,
        balance: Option<&Balance>,
    ) -> f64 {
        let step = |x: f64, part: f64| {
            let change = part * change;
            let decays = self.turns(x + 0.5 * change, part * turns);
            x * (-decays).exp() + change * mean_decay(decays)
        };
        let (mut x, mut done) = reached;
        let near = |x: f64, done: f64| balance.and_then(|it| it.reached(x, 1.0 - done, change));
        if let Some(x) = near(x, done) {
            return x;
        }
        // A first step that crosses rest could mistake itself.
        let first = (FIRST_PART / (turns * self.at(change))).clamp(SHORTEST_PART, 1.0);
        let mut part = first.min(1.0 - done);
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
                    // Where the rate is infinite at rest no part leaves it, but the drive does, as far as to the balance.
                    let infinite = matches!(self, Self::Power(power, _) if power < 0.0);
                    return if x == 0.0 && infinite { balance.map_or(x, |it| it.at) } else { x };
                }
                if let Some(x) = near(x, done) {
                    return x;
                }
            }
            let longer = if error > 0.0 { 0.9 * (allowed / error).cbrt() } else { 5.0 };
            part = (part * longer.clamp(0.1, 5.0)).max(SHORTEST_PART).min(1.0 - done);
        }
    }

    /// Where a state goes that decays `turns` times by a linear law and is driven evenly by `change`, by Taylor series; where they
    /// do not reach, the state as far as they do, and that part of the interval.
    fn series(self, x: f64, change: f64, turns: f64) -> Result<f64, (f64, f64)> {
        let (mut x, mut done) = (x, 0.0);
        loop {
            let [f, f1, f2, f3, f4] = self.rates(x, change, turns);
            let square = f1 * f1;
            let terms = [
                f,
                f1 * f / 2.0,
                (f2 * f + square) * f / 6.0,
                ((f3 * f + 4.0 * f2 * f1) * f + square * f1) * f / 24.0,
                (((f4 * f + 7.0 * f3 * f1 + 4.0 * f2 * f2) * f + 11.0 * f2 * square) * f
                    + square * square)
                    * f
                    / 120.0,
            ];
            // How fast the terms shrink: the last one could vanish by itself.
            let quick = f1.abs().max((f / x).abs());
            let last = terms[4].abs() + 0.2 * quick * terms[3].abs();
            let allowed = SERIES_TOLERANCE * (x.abs() + change.abs());
            let reaches = |part: f64| {
                let square = part * part;
                last * square * square * part <= allowed && part * quick <= SERIES_REACH
            };
            let mut part = 1.0 - done;
            while !reaches(part) {
                part *= 0.5;
                if part < SHORTEST_SERIES {
                    return Err((x, done));
                }
            }
            x += terms.iter().rev().fold(0.0, |sum, term| part * (sum + term));
            done += part;
            if done >= 1.0 {
                return Ok(x);
            }
        }
    }

    /// The rate of a state that is driven, over an interval, and its first four derivatives by the state.
    fn rates(self, x: f64, change: f64, turns: f64) -> [f64; 5] {
        match self {
            Self::None => [change - turns * x, -turns, 0.0, 0.0, 0.0],
            Self::Power(power, full) => {
                let factor = turns * (x / full).abs().powf(power);
                let first = -(power + 1.0) * factor;
                let along = 1.0 / x;
                let second = first * power * along;
                let third = second * (power - 1.0) * along;
                [change - factor * x, first, second, third, third * (power - 2.0) * along]
            }
            Self::Sinh(strength, full) => {
                let steep = strength / full;
                let y = steep * x;
                let first = -turns * y.cosh();
                let sinh = turns * y.sinh();
                let (second, third) = (-sinh * steep, first * steep * steep);
                [change - sinh / steep, first, second, third, second * steep * steep]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        /// Decay and drive are in balance long before a stiff interval ends: going there at once is going there in many parts.
        #[test]
        fn a_stiff_state_comes_to_its_balance(
            x in 0.0..2.0f64,
            change in 1e-3..1.0f64,
            turns in 5.0..1e3f64,
            strength in 5.0..20.0f64,
        ) {
            const PARTS: u32 = 4_000;
            let growth = Growth::Sinh(strength, 1.0);
            let balance = growth.balance(change, turns).unwrap();
            let balance = growth.settled((x, 0.0), change, &balance);
            // In so many parts a faster decay is not followed.
            if let Some(balance) = balance.filter(|balance| change / balance < 0.1 * f64::from(PARTS)) {
                prop_assert_eq!(growth.driven(x, change, turns), balance);
                let part = 1.0 / f64::from(PARTS);
                let found = (0..PARTS).fold(x, |x, _| {
                    let free = growth.alone(x, 0.5 * part * turns) + part * change;
                    growth.alone(free, 0.5 * part * turns)
                });
                prop_assert!((found - balance).abs() <= 2e-3 * balance, "{balance} or {found}");
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        /// From beyond rest, where the rate falls with the state, a drive leads through rest to the balance.
        #[test]
        fn a_state_does_not_stay_at_rest_where_it_is_driven(
            x in -0.3..-0.05f64,
            change in 0.3..0.5f64,
            turns in 40.0..60.0f64,
        ) {
            let growth = Growth::Power(-0.49, 1.0);
            let balance = growth.balance(change, turns).unwrap().at;
            let found = growth.driven(x, change, turns);
            prop_assert!((found - balance).abs() <= 1e-6 * change, "{found} for {balance}");
        }

        /// From whatever side and however stiff, with rates that grow with the state or fall: many halves of the linear law are the
        /// oracle.
        #[test]
        fn a_stiff_state_goes_where_many_parts_take_it(
            x in -1.0..3.0f64,
            change in 1e-3..1.0f64,
            turns in 0.2..60.0f64,
            power in -0.5..1.5f64,
        ) {
            const PARTS: u32 = 20_000;
            let growth = Growth::Power(power, 1.0);
            let part = 1.0 / f64::from(PARTS);
            let step = |x: f64| {
                let free = growth.alone(x, 0.5 * part * turns) + part * change;
                growth.alone(free, 0.5 * part * turns)
            };
            let expected = (0..PARTS).fold(x, |x, _| step(x));
            let found = growth.driven(x, change, turns);
            prop_assert!((found - expected).abs() <= 2e-5 * (x.abs() + change), "{found} for {expected}");
        }
    }

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

        /// Thousands of small steps of the classical Runge-Kutta method are the oracle.
        #[test]
        fn a_driven_state_goes_where_small_steps_take_it(
            x in -2.0..2.0f64,
            change in -1.0..1.0f64,
            turns in 1e-3..0.1f64,
            power in 0.0..1.2f64,
            is_power in any::<bool>(),
        ) {
            let growth =
                if is_power { Growth::Power(power, 1.0) } else { Growth::Sinh(power + 0.01, 1.0) };
            let rate = |x: f64| change - turns * growth.at(x) * x;
            let steps = 2_000;
            let h = 1.0 / f64::from(steps);
            let expected = (0..steps).fold(x, |x, _| {
                let a = rate(x);
                let b = rate(x + 0.5 * h * a);
                let c = rate(x + 0.5 * h * b);
                let d = rate(x + h * c);
                x + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
            });
            let found = growth.driven(x, change, turns);
            let size = x.abs() + change.abs();
            prop_assert!((found - expected).abs() <= 1e-5 * size, "{found} for {expected}");
            let (decay, gain) = growth.step(x, change, turns);
            prop_assert!((decay * x + gain * change - found).abs() <= 1e-12 * size);
        }

        #[test]
        fn where_a_series_reaches_it_is_exact_to_its_tolerance(
            x in 0.05..3.0f64,
            change in -0.1..0.1f64,
            turns in 1e-4..0.1f64,
            power in 0.05..2.0f64,
        ) {
            let growth = Growth::Power(power, 1.0);
            let alone = growth.alone(x, turns);
            if let Ok(found) = growth.series(x, 0.0, turns) {
                prop_assert!((found - alone).abs() <= SERIES_TOLERANCE * x, "{found} for {alone}");
            }
            // Two halves of an interval are the whole of it.
            let (whole, half) = (growth.series(x, change, turns), 0.5 * change);
            let middle = growth.series(x, half, 0.5 * turns);
            if let (Ok(whole), Ok(middle)) = (whole, middle) {
                let twice = growth.driven(middle, half, 0.5 * turns);
                prop_assert!((whole - twice).abs() <= 2.0 * SERIES_TOLERANCE * (x + change.abs()));
            }
        }
    }
}
