//! The quantities that a term may depend on, and how far they reach in a data set.

use std::f64::consts::TAU;

use palpate_fit::data::Data;
use palpate_model::Expression;

/// Something known at every sample.
#[derive(Debug, PartialEq, Eq)]
pub struct Quantity {
    /// How an expression says it.
    pub symbol: &'static str,
    /// Name in words.
    pub name: &'static str,
    /// Unit; none for that of the signal.
    pub unit: Option<&'static str>,
    /// What shapes it is tried in.
    pub kind: Kind,
}

/// What shapes a quantity is tried in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// All: it passes through its range within a trace.
    Fast,
    /// All but those with a memory, which time itself has.
    Clock,
    /// Few: it changes from trace to trace more than within one.
    Slow,
    /// Those without a place or a period: it has the few values at which the rig was run.
    Rate,
    /// A straight line, or behind a delay: it is a product or a sign.
    Plain,
}

const fn quantity(
    symbol: &'static str,
    name: &'static str,
    unit: &'static str,
    kind: Kind,
) -> Quantity {
    Quantity { symbol, name, unit: Some(unit), kind }
}

/// Every quantity.
pub const QUANTITIES: [Quantity; 22] = [
    quantity("x", "displacement", "mm", Kind::Fast),
    quantity("v", "velocity", "mm/s", Kind::Rate),
    Quantity { symbol: "F", name: "force", unit: None, kind: Kind::Fast },
    quantity("t", "time in the trace", "s", Kind::Clock),
    quantity("since(x)", "time since the touch", "s", Kind::Clock),
    quantity(
        "since((0.5 - abs(sign(v))) * total(abs(v)))",
        "time since the motion stopped",
        "s",
        Kind::Clock,
    ),
    quantity("total(abs(v))", "way travelled", "mm", Kind::Clock),
    quantity("t_set", "time in the data set", "s", Kind::Slow),
    quantity("T", "temperature", "K", Kind::Slow),
    quantity("n", "loadings before", "", Kind::Slow),
    quantity("x_max", "largest displacement", "mm", Kind::Slow),
    quantity("sign(v)", "direction of the motion", "", Kind::Plain),
    quantity("abs(v)", "speed", "mm/s", Kind::Rate),
    quantity("a", "acceleration", "mm/s²", Kind::Plain),
    quantity("F * v", "power", "N mm/s", Kind::Plain),
    quantity("x * v", "displacement times velocity", "mm²/s", Kind::Plain),
    quantity("x * sign(v)", "displacement times direction", "mm", Kind::Plain),
    quantity("x * T", "displacement times temperature", "mm K", Kind::Plain),
    quantity("x * n", "displacement times loadings before", "mm", Kind::Plain),
    quantity("x * t_set", "displacement times time in the data set", "mm s", Kind::Plain),
    quantity("v * T", "velocity times temperature", "mm K/s", Kind::Plain),
    quantity("v * n", "velocity times loadings before", "mm/s", Kind::Plain),
];

/// The quantity with this symbol.
#[must_use]
pub fn find(symbol: &str) -> Option<&'static Quantity> {
    QUANTITIES.iter().find(|quantity| quantity.symbol == symbol)
}

/// How far a quantity reaches in a data set.
#[derive(Clone, Debug, PartialEq)]
pub struct Reach {
    /// Its smallest value.
    pub least: f64,
    /// Its largest value.
    pub most: f64,
    /// Periods at which the residual repeats most over it.
    pub periods: Vec<f64>,
    /// Places at which something may be: some evenly over the range, and those where most of the residual is.
    pub places: Vec<f64>,
    /// Sizes at which it mostly is where it is a velocity: the speeds at which the rig was run, rising.
    pub speeds: Vec<f64>,
    /// Time constants from a few samples to a trace, s.
    pub times: [f64; 4],
    /// Size of the signal.
    pub force: f64,
    /// Largest compression, mm.
    pub compression: f64,
    /// Fastest motion, mm/s.
    pub fastest: f64,
}

/// Periods that are tried.
const PERIODS: usize = 4;
/// Periods of a wave over a session, in parts of it, and fewest traces in which it is looked for.
const SLOW_PERIODS: [f64; 3] = [2.0, 1.0, 0.6];
const SESSION: usize = 6;
/// Places that are tried of every range, in parts of it.
const EVEN_PLACES: [f64; 6] = [0.1, 0.25, 0.4, 0.55, 0.7, 0.85];
/// Classes of a range in which the residual is summed up to see where most of it is, and those that are taken together.
const CLASSES: usize = 60;
const TOGETHER: usize = 3;
/// Most places that are tried because most of the residual is there.
const PLACES: usize = 2;
/// Part of the moving samples from which on a speed is one at which the rig was run, and most such speeds.
const RUN: f64 = 0.04;
const MOST_SPEEDS: usize = 5;
/// Half periods over the range, least and most.
const HALVES: std::ops::RangeInclusive<usize> = 3..=160;

impl Reach {
    /// The reach of a quantity over a data set of which a model predicts this and leaves that, stretch by stretch; none where the
    /// quantity does not vary.
    #[must_use]
    pub fn of(
        quantity: &Quantity,
        data: &Data,
        predicted: &[Vec<f64>],
        left: &[Vec<f64>],
    ) -> Option<Self> {
        let mut values = values(quantity, data, predicted)?;
        if quantity.symbol == "x" {
            let farthest = data.farthest_off();
            values.iter_mut().flatten().for_each(|x| *x = x.max(farthest));
        }
        let all = || values.iter().flatten().copied();
        let (least, most) =
            (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
        if !(most - least).is_finite() || most - least <= 1e-9 * most.abs().max(least.abs()) {
            return None;
        }
        let scales = data.scales();
        let (short, long) = (3.0 * scales.interval, 0.5 * scales.duration);
        let ratio = (long / short).max(1.0).powf(1.0 / 3.0);
        let wavy = matches!(quantity.kind, Kind::Fast | Kind::Clock);
        let session = quantity.symbol == "t_set" && data.labels.len() >= SESSION;
        let periods = match wavy {
            true => periods(&values, left, (least, most - least)),
            false if session => SLOW_PERIODS.map(|part| part * (most - least)).to_vec(),
            false => Vec::new(),
        };
        let even = EVEN_PLACES.map(|part| least + part * (most - least));
        let mut places = even.to_vec();
        if wavy {
            places.extend(places_of(&values, left, (least, most), |_| 1.0));
            let velocities: Vec<Vec<f64>> =
                data.pieces.iter().map(|piece| data.scene(piece).velocity.to_vec()).collect();
            let way = |(piece, k): (usize, usize)| velocities[piece][k].signum();
            places.extend(places_of(&values, left, (least, most), way));
        }
        let speeds = if quantity.kind == Kind::Rate { speeds(&values) } else { Vec::new() };
        Some(Self {
            least,
            most,
            periods,
            places,
            speeds,
            times: [0, 1, 2, 3].map(|k| short * ratio.powi(k)),
            force: scales.force,
            compression: scales.compression,
            fastest: scales.speed,
        })
    }

    /// Largest less smallest value.
    #[must_use]
    pub fn span(&self) -> f64 {
        self.most - self.least
    }

    /// Largest size.
    #[must_use]
    pub fn size(&self) -> f64 {
        self.most.abs().max(self.least.abs())
    }

    /// Places at these parts of the range.
    #[must_use]
    pub fn at(&self, parts: &[f64]) -> Vec<f64> {
        parts.iter().map(|part| self.least + part * self.span()).collect()
    }
}

/// The values of a quantity, stretch by stretch; none where it has none.
#[must_use]
pub fn values(quantity: &Quantity, data: &Data, predicted: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let expression = Expression::parse(quantity.symbol, &[]).ok()?;
    let of = |(piece, predicted): (&palpate_fit::data::Piece, &Vec<f64>)| {
        let mut sum = predicted.clone();
        expression.add_to_force(&data.scene(piece), &[], &mut sum);
        sum.iter().zip(predicted).map(|(sum, predicted)| sum - predicted).collect()
    };
    Some(data.pieces.iter().zip(predicted).map(of).collect())
}

/// The periods at which waves over a quantity take most out of a residual: the highest peaks of the periodogram of its means over
/// narrow classes, in which a long hold counts no more than a passage.
fn periods(values: &[Vec<f64>], left: &[Vec<f64>], (least, span): (f64, f64)) -> Vec<f64> {
    const CLASSES: usize = 4 * *HALVES.end();
    let mut classes = vec![(0.0, 0.0); CLASSES];
    for (value, left) in values.iter().flatten().zip(left.iter().flatten()) {
        let class = ((value - least) / span * CLASSES as f64) as usize;
        let (sum, count) = &mut classes[class.min(CLASSES - 1)];
        (*sum, *count) = (*sum + left, *count + 1.0);
    }
    let means: Vec<(f64, f64)> = (0..CLASSES)
        .filter(|&k| classes[k].1 > 0.0)
        .map(|k| ((k as f64 + 0.5) / CLASSES as f64 * span, classes[k].0 / classes[k].1))
        .collect();
    let middle = means.iter().map(|(_, mean)| mean).sum::<f64>() / means.len().max(1) as f64;
    let power = |halves: usize| {
        let turns = TAU * halves as f64 / (2.0 * span);
        let (mut cosine, mut sine) = (0.0, 0.0);
        for (value, mean) in &means {
            let (s, c) = (turns * value).sin_cos();
            (cosine, sine) = (cosine + c * (mean - middle), sine + s * (mean - middle));
        }
        cosine * cosine + sine * sine
    };
    let powers: Vec<f64> = HALVES.map(power).collect();
    let is_peak = |&k: &usize| {
        let beside = |other: Option<&f64>| other.is_none_or(|other| *other <= powers[k]);
        beside(k.checked_sub(1).map(|k| &powers[k])) && beside(powers.get(k + 1))
    };
    let mut peaks: Vec<usize> = (0..powers.len()).filter(is_peak).collect();
    peaks.sort_by(|&a, &b| powers[b].total_cmp(&powers[a]));
    peaks.truncate(PERIODS);
    peaks.iter().map(|&k| 2.0 * span / (HALVES.start() + k) as f64).collect()
}

/// Where in its range the residual, multiplied by a factor of every sample (by stretch and place in it), has the largest means beside
/// their uncertainty.
fn places_of(
    values: &[Vec<f64>],
    left: &[Vec<f64>],
    (least, most): (f64, f64),
    factor: impl Fn((usize, usize)) -> f64,
) -> Vec<f64> {
    let mut sums = [[0.0; 2]; CLASSES];
    let class = |value: f64| {
        let part = CLASSES as f64 * (value - least) / (most - least);
        (part as usize).min(CLASSES - 1)
    };
    for (piece, (values, left)) in values.iter().zip(left).enumerate() {
        for (k, (value, left)) in values.iter().zip(left).enumerate() {
            let sum = &mut sums[class(*value)];
            *sum = [sum[0] + factor((piece, k)) * left, sum[1] + 1.0];
        }
    }
    let clear = |at: &[[f64; 2]]| {
        let [sum, count] = at.iter().fold([0.0; 2], |sum, own| [sum[0] + own[0], sum[1] + own[1]]);
        if count > 0.0 { sum.abs() / count.sqrt() } else { 0.0 }
    };
    let clear: Vec<f64> = sums.windows(TOGETHER).map(clear).collect();
    let is_peak = |&k: &usize| {
        let near = &clear[k.saturating_sub(TOGETHER)..(k + TOGETHER + 1).min(clear.len())];
        clear[k] > 0.0 && near.iter().all(|other| *other <= clear[k])
    };
    let mut peaks: Vec<usize> = (0..clear.len()).filter(is_peak).collect();
    peaks.sort_by(|&a, &b| clear[b].total_cmp(&clear[a]));
    peaks.truncate(PLACES);
    let middle = |k: usize| (k as f64 + 0.5 * TOGETHER as f64) / CLASSES as f64;
    peaks.into_iter().map(|k| least + middle(k) * (most - least)).collect()
}

/// The speeds at which the rig was run, rising: neighbours in the order of their sizes that are many within a tenth of each other.
fn speeds(velocities: &[Vec<f64>]) -> Vec<f64> {
    let mut sizes: Vec<f64> = velocities.iter().flatten().map(|v| v.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let fastest = sizes.last().copied().unwrap_or(0.0);
    let moving = &sizes[sizes.partition_point(|size| *size < 2e-3 * fastest)..];
    let enough = RUN * moving.len() as f64;
    let mut found: Vec<(f64, f64)> = Vec::new();
    let mut begin = 0;
    while begin < moving.len() {
        let end = begin + moving[begin..].partition_point(|size| *size <= 1.1 * moving[begin]);
        let count = (end - begin) as f64;
        let mean = moving[begin..end].iter().sum::<f64>() / count;
        match found.last_mut() {
            // A speed that lies across the border of two classes is one.
            Some((speed, of)) if mean < 1.1 * *speed => {
                *speed = (*speed * *of + mean * count) / (*of + count);
                *of += count;
            }
            _ => found.push((mean, count)),
        }
        begin = end;
    }
    found.retain(|(_, count)| *count >= enough);
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    found.truncate(MOST_SPEEDS);
    let mut speeds: Vec<f64> = found.into_iter().map(|(speed, _)| speed).collect();
    speeds.sort_by(f64::total_cmp);
    speeds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_speeds_of_a_rig_are_those_at_which_it_mostly_moves() {
        let ramp = |speed: f64| {
            let rise = (1..20).map(move |k| speed * f64::from(k) / 20.0);
            rise.chain((0..400).map(move |k| speed * (1.0 + 0.01 * f64::from(k % 5) - 0.02)))
        };
        let velocities: Vec<f64> =
            ramp(5.0).chain(ramp(20.0).map(|v| -v)).chain([0.0; 900]).collect();
        let found = speeds(&[velocities]);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!((found[0] - 5.0).abs() < 0.1 && (found[1] - 20.0).abs() < 0.4, "{found:?}");
    }

    #[test]
    fn a_period_is_found_beside_long_holds() {
        let wave = |x: f64| (TAU * x / 0.9).sin();
        let ramp = (0..300).map(|k| f64::from(k) / 25.0);
        // Holds at places that have another period in common.
        let holds = [4.0, 8.0, 12.0].iter().flat_map(|x| std::iter::repeat_n(*x, 2000));
        let at: Vec<f64> = ramp.chain(holds).collect();
        let left: Vec<f64> = at.iter().map(|x| wave(*x)).collect();
        let found = periods(&[at], &[left], (0.0, 12.0));
        assert!((found[0] - 0.9).abs() < 0.03, "{found:?}");
    }

    #[test]
    fn places_are_where_the_residual_is() {
        let at: Vec<f64> = (0..1000).map(|k| f64::from(k) / 100.0).collect();
        let bump = |x: &f64| (-((x - 3.1) / 0.2).powi(2)).exp();
        let left: Vec<f64> = at.iter().map(bump).collect();
        let found = places_of(&[at], &[left], (0.0, 10.0), |_| 1.0);
        assert!((found[0] - 3.1).abs() < 0.15, "{found:?}");
    }
}
