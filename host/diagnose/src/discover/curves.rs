//! Free curves: terms of any shape over one quantity, told by their values at some knots and straight between them. They come where
//! no law of the grammar has the shape, and name the quantity all the same.

use super::grammar::{Made, Term};
use super::reach::{Kind, Quantity, Reach};
use super::shape::CURVE;
use crate::criticism::leftover_curve::rounded;
use palpate_model::{Expression, Parameter, StoredEffect, StoredParameter};

/// Knots over a quantity that passes through its range within a trace.
const FAST: usize = 10;
/// Knots over one that changes from trace to trace.
const SLOW: usize = 6;
/// Knots over a velocity where a rig is run at no few speeds, in parts of the fastest.
const RATES: [f64; 7] = [-1.0, -0.3, -0.08, 0.0, 0.08, 0.3, 1.0];

/// Relative difference of distances between knots that is rounding.
const EVEN: f64 = 0.01;

/// A free curve of a quantity.
#[derive(Clone, Debug)]
pub(super) struct Knots {
    /// Where its value is told, rising.
    pub(super) at: Vec<f64>,
    symbol: &'static str,
    /// What it is multiplied by.
    factor: String,
}

/// The free curve over a quantity.
pub(super) fn curve(made: &Made) -> Option<Term> {
    if made.quantity.kind == Kind::Plain {
        return None;
    }
    // Digits beyond those that matter only make the law long.
    let at: Vec<f64> = knots(made.quantity, made.reach).into_iter().map(rounded).collect();
    if at.windows(2).any(|pair| pair[1] <= pair[0]) {
        return None;
    }
    let factor = format!("{}{}", made.place.factor, made.factor.text);
    let knots = Knots { at, symbol: made.quantity.symbol, factor };
    let names: Vec<String> = (1..=knots.at.len()).map(|k| format!("size{k}")).collect();
    let expression = knots.expression("", &names)?;
    let strengths: Vec<Parameter> = names.iter().map(|name| made.strength(name, &CURVE)).collect();
    let count = strengths.len();
    Some(made.of(&CURVE, (strengths, count), expression, vec![Vec::new()], Some(knots)))
}

fn knots(quantity: &Quantity, reach: &Reach) -> Vec<f64> {
    let even = |count: usize| -> Vec<f64> {
        let parts: Vec<f64> = (0..count).map(|k| k as f64 / (count - 1) as f64).collect();
        reach.at(&parts)
    };
    match quantity.kind {
        Kind::Rate => {
            let both_ways: Vec<f64> = if reach.speeds.is_empty() {
                RATES.iter().map(|part| part * reach.size()).collect()
            } else {
                let back = reach.speeds.iter().rev().map(|speed| -speed);
                back.chain([0.0]).chain(reach.speeds.iter().copied()).collect()
            };
            both_ways.into_iter().filter(|speed| *speed >= 0.0 || reach.least < 0.0).collect()
        }
        Kind::Slow => even(SLOW),
        _ => even(FAST),
    }
}

impl Knots {
    /// The curve with these values at its knots, each a name or a number, multiplied by `before`.
    fn text(&self, before: &str, values: &[String]) -> String {
        let hats: Vec<String> = values
            .iter()
            .enumerate()
            .map(|(k, value)| format!("{value} * {}", self.hat(k)))
            .collect();
        format!("{before}{}({})", self.factor, hats.join(" + "))
    }

    /// 1 at a knot, 0 at its neighbours and beyond, straight between. Where knots lie evenly the shorter of two ways to say it: an
    /// expression is evaluated at every sample.
    fn hat(&self, k: usize) -> String {
        let (at, symbol) = (&self.at, self.symbol);
        let width = |k: usize| at.get(k).zip(at.get(k + 1)).map(|(from, to)| rounded(to - from));
        let (before, after) = (k.checked_sub(1).and_then(width), width(k));
        let place = at[k];
        let inner = match (before, after) {
            (Some(left), Some(right)) if (left / right - 1.0).abs() > EVEN => {
                format!("1 - max(({place} - {symbol}) / {left}, ({symbol} - {place}) / {right})")
            }
            (Some(width), _) | (None, Some(width)) => {
                format!("1 - abs({symbol} - {place}) / {width}")
            }
            (None, None) => "1".into(),
        };
        format!("max(0, {inner})").replace("- -", "+ ")
    }

    fn expression(&self, before: &str, names: &[String]) -> Option<Expression> {
        let known: Vec<&str> = names.iter().map(String::as_str).collect();
        Expression::parse(&self.text(before, names), &known).ok()
    }

    /// The law as a file holds it: its largest value as the strength, the others as parts of it.
    pub(super) fn law(&self, fitted: &StoredEffect) -> StoredEffect {
        let sizes: Vec<&StoredParameter> = fitted.parameters.values().collect();
        let size_of = |k: &usize| sizes[*k].value.abs();
        let largest = (0..sizes.len()).max_by(|a, b| size_of(a).total_cmp(&size_of(b)));
        let largest = largest.unwrap_or(0);
        let size = sizes[largest];
        let mut parameters = vec![("size".to_owned(), size.clone())];
        let mut values = Vec::with_capacity(sizes.len());
        for (k, own) in sizes.iter().enumerate() {
            if k == largest {
                values.push("1".to_owned());
                continue;
            }
            let name = format!("part{}", k + 1);
            let part = StoredParameter {
                value: own.value / size.value,
                standard_error: None,
                unit: String::new(),
                lower: None,
                upper: None,
            };
            values.push(name.clone());
            parameters.push((name, part));
        }
        StoredEffect {
            expression: Some(self.text("size * ", &values)),
            parameters: parameters.into_iter().collect(),
            ..fitted.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_model::Stage;

    fn knots(at: &[f64]) -> Knots {
        Knots { at: at.to_vec(), symbol: "x", factor: "F * ".into() }
    }

    #[test]
    fn a_curve_is_a_sum_of_hats() {
        let names = ["s1".to_owned(), "s2".to_owned(), "s3".to_owned()];
        let even = knots(&[-1.0, 1.0, 3.0]);
        assert_eq!(
            even.text("size * ", &names),
            "size * F * (s1 * max(0, 1 - abs(x + 1) / 2) + s2 * max(0, 1 - abs(x - 1) / 2) + s3 * max(0, 1 - abs(x - 3) / 2))"
        );
        let uneven = knots(&[-2.0, 0.0, 0.5]);
        assert_eq!(uneven.hat(1), "max(0, 1 - max((0 - x) / 2, (x - 0) / 0.5))");
        assert!(even.expression("", &names).is_some() && uneven.expression("", &names).is_some());
    }

    #[test]
    fn in_a_file_the_largest_height_is_the_strength() {
        let size = |value: f64| StoredParameter {
            value,
            standard_error: Some(0.1),
            unit: "N".into(),
            lower: None,
            upper: None,
        };
        let heights = [("size1", 0.5), ("size2", -2.0), ("size3", 1.0)];
        let fitted = StoredEffect {
            name: "found-1".into(),
            law: None,
            stage: Some(Stage::Sensor),
            expression: None,
            meaning: None,
            parameters: heights
                .map(|(name, value)| (name.to_owned(), size(value)))
                .into_iter()
                .collect(),
        };
        let law = knots(&[0.0, 1.0, 2.0]).law(&fitted);
        let told: Vec<(&str, f64)> =
            law.parameters.iter().map(|(name, it)| (name.as_str(), it.value)).collect();
        assert_eq!(told, [("size", -2.0), ("part1", -0.25), ("part3", -0.5)]);
        let text = law.expression.unwrap();
        assert!(
            text.starts_with("size * F * (part1 * max(0,") && text.contains("+ 1 * max("),
            "{text}"
        );
        let names: Vec<&str> = told.iter().map(|(name, _)| *name).collect();
        assert!(Expression::parse(&text, &names).is_ok());
    }
}
