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
pub const QUANTITIES: [Quantity; 20] = [
    quantity("x", "displacement", "mm", Kind::Fast),
    quantity("v", "velocity", "mm/s", Kind::Rate),
    Quantity { symbol: "F", name: "force", unit: None, kind: Kind::Fast },
    quantity("t", "time in the trace", "s", Kind::Clock),
    quantity("since(x)", "time since the touch", "s", Kind::Clock),
    quantity("total(abs(v))", "way travelled", "mm", Kind::Clock),
    quantity("t_set", "time in the data set", "s", Kind::Slow),
    quantity("T", "temperature", "K", Kind::Slow),
    quantity("n", "loadings before", "", Kind::Slow),
    quantity("x_max", "largest displacement", "mm", Kind::Slow),
    quantity("sign(v)", "direction of the motion", "", Kind::Plain),
    quantity("abs(v)", "speed", "mm/s", Kind::Plain),
    quantity("a", "acceleration", "mm/s²", Kind::Plain),
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
        let values = values(quantity, data, predicted)?;
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
        let periods = if wavy { periods(&values, left, most - least) } else { Vec::new() };
        Some(Self {
            least,
            most,
            periods,
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

/// The periods at which waves over a quantity take most out of a residual: the highest peaks of its periodogram.
fn periods(values: &[Vec<f64>], left: &[Vec<f64>], span: f64) -> Vec<f64> {
    let power = |halves: usize| {
        let turns = TAU * halves as f64 / (2.0 * span);
        let (mut cosine, mut sine) = (0.0, 0.0);
        for (value, left) in values.iter().flatten().zip(left.iter().flatten()) {
            let (s, c) = (turns * value).sin_cos();
            (cosine, sine) = (cosine + c * left, sine + s * left);
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
