//! Friction from a slide, in words and numbers.

use super::exponent_words;
use crate::summary::estimate;
use palpate_contact::grasp::PressureLaw;
use palpate_contact::grasp::friction::Friction;
use palpate_report::number::{percent, significant};
use palpate_report::{Callout, Column, Section, Table};

/// μ, k and how much of a mix the slide had. `law` was taken where it does not determine k.
#[must_use]
pub fn friction_sections(found: &Friction, law: PressureLaw) -> Vec<Section> {
    let columns = vec![Column::text(""), Column::text("value")];
    let exponent = match found.exponent {
        Some((k, low, high)) => format!("{} ({} to {})", words(k), words(low), words(high)),
        None => "not given".into(),
    };
    let (least, most) = found.moment_share;
    let table = Table::new("Friction of the slide", columns)
        .row(["μ".to_owned(), estimate(found.coefficient.0, Some(found.coefficient.1))])
        .row(["k (95 %)".to_owned(), exponent])
        .row(["scatter of μ from sample to sample".to_owned(), significant(found.scatter, 3)])
        .row([
            "share of the moment in the load".to_owned(),
            format!("{} to {}", percent(least, 3), percent(most, 3)),
        ])
        .row(["samples".to_owned(), found.samples.to_string()])
        .note(
            "Standard error and range are for scatter that is independent from sample to sample.",
        );
    let text = match found.exponent {
        Some(_) => "Loads of different mix lie on one limit surface for this k.".to_owned(),
        None => format!(
            "The loads of this slide fit one limit surface for nearly any k: it had too little of either force or moment, or too much noise. μ is that for {}.",
            exponent_words(law.exponent())
        ),
    };
    let kind = if found.exponent.is_some() { Callout::Finding } else { Callout::Warning };
    vec![Section::new("Friction").table(table).callout(kind, "Pressure", text)]
}

fn words(exponent: f64) -> String {
    if exponent.is_infinite() { "∞".into() } else { significant(exponent, 3) }
}
