//! From a law to one near it that depends on one thing more: it changes with a power of a second quantity, or a wave has a jump in each
//! period. Each holds the law itself, with a power of 0, or comes near it: a refit begins there.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use super::grammar::{Grammar, Term};
use super::reach::{Kind, Quantity, Reach, find};
use super::shape::Family;
use crate::criticism::leftover_curve::rounded;
use palpate_model::effects::{Candidate, Form};
use palpate_model::{Act, Applied, Expression, Parameter};

/// A quantity with a power of which a term may change, and on which none depends alone.
static FASTEST: Quantity = Quantity {
    symbol: "peak(abs(v))",
    name: "largest speed so far",
    unit: Some("mm/s"),
    kind: Kind::Plain,
};
/// The same of those that a term may depend on.
const POWERS: [&str; 8] = ["since(x)", "abs(v)", "x", "F", "x_max", "t", "t_set", "n"];
/// Part of its largest value below which a quantity counts as that: a power of nothing is nothing, or infinite.
const FLOOR: f64 = 1e-3;
/// Largest power.
const STEEPEST: f64 = 4.0;
/// Sharpness of the corners with which a sawtooth begins.
const SHARP: f64 = 0.95;

/// A term near another, with the values of its parameters from which its refit begins.
pub(super) struct Varied {
    pub term: Term,
    pub start: Vec<f64>,
}

/// The terms near a law whose parameters have these values.
pub(super) fn near(
    term: &Term,
    values: &[f64],
    grammar: &Grammar,
    reaches: &[(&'static Quantity, Reach)],
) -> Vec<Varied> {
    let powers = reaches.iter().filter_map(|(by, reach)| {
        let term = by_a_power(term, by, reach)?;
        Some(Varied { term, start: [values, &[0.0]].concat() })
    });
    powers.chain(sawtooths(term, values, grammar)).collect()
}

/// The quantities with a power of which a term may change that vary in a data set.
pub(super) fn quantities(
    of: impl Fn(&'static Quantity) -> Option<Reach>,
) -> Vec<(&'static Quantity, Reach)> {
    let powers = POWERS.iter().filter_map(|symbol| find(symbol));
    let all = std::iter::once(&FASTEST).chain(powers);
    all.filter_map(|quantity| Some((quantity, of(quantity)?))).collect()
}

/// A law multiplied by a power of a quantity.
fn by_a_power(term: &Term, by: &'static Quantity, reach: &Reach) -> Option<Term> {
    if term.varies.is_some() || term.shape.is_free() {
        return None;
    }
    let form = term.candidate.forms.first()?;
    let Act::Own(expression) = &form.applied.act else { return None };
    let (least, most) = (rounded(FLOOR * reach.most), rounded(reach.most));
    let text = format!("{} * (max({}, {least}) / {most})^power", expression.text(), by.symbol);
    let power = Parameter {
        name: "power".into(),
        unit: "".into(),
        meaning: "".into(),
        lower: -STEEPEST,
        upper: STEEPEST,
        bounded: false,
    };
    let mut parameters = form.applied.parameters.clone();
    parameters.push(power);
    let names: Vec<&str> = parameters.iter().map(|parameter| &parameter.name[..]).collect();
    let expression = Expression::parse(&text, &names).ok()?;
    let mut varied = Term { varies: Some(by), ..term.clone() };
    let name = varied.full_name();
    let act = Act::Own(Arc::new(expression));
    let applied = Applied { name: name.clone(), parameters, act, ..form.applied.clone() };
    let forms = vec![Form { applied, ..form.clone() }];
    varied.candidate = Candidate { name, forms, missing: None };
    Some(varied)
}

/// The sawtooths, rising and falling, whose first harmonic is a wave.
fn sawtooths(term: &Term, values: &[f64], grammar: &Grammar) -> Vec<Varied> {
    let wave = term.shape.family == Family::Wave && term.varies.is_none();
    let like = |other: &&Term| other.shape.family == Family::Sawtooth && other.beside(term);
    let sawtooth = grammar.terms.iter().find(like).filter(|_| wave);
    let (Some(sawtooth), &[size, period, phase]) = (sawtooth, values) else { return Vec::new() };
    let size = 0.5 * PI * size / SHARP;
    let turned = (phase + TAU).rem_euclid(TAU) - PI;
    [(size, phase), (-size, turned)]
        .map(|(size, phase)| Varied {
            term: sawtooth.clone(),
            start: vec![size, period, phase, SHARP],
        })
        .into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discover::shape::SHAPES;

    #[test]
    fn a_sawtooth_begins_with_the_wave_as_its_first_harmonic() {
        let value =
            SHAPES.iter().find(|shape| shape.family == Family::Sawtooth).unwrap().value.unwrap();
        const COUNT: u32 = 4_000;
        let harmonic = |phase: f64| {
            let part = |k: u32| {
                let c = f64::from(k) / f64::from(COUNT);
                value(c, &[1.0, phase, SHARP]) * (TAU * c + phase).sin()
            };
            2.0 * (0..COUNT).map(part).sum::<f64>() / f64::from(COUNT)
        };
        for phase in [0.0, 1.0, -2.0] {
            assert!((0.5 * PI / SHARP * harmonic(phase) - 1.0).abs() < 1e-6, "{phase}");
        }
    }
}
