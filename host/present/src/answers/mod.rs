//! What the commands found, as types: `--json` prints them, the page and other programs get them, `docs/schema/` describes them.
//!
//! One file an answer: its type, and how it follows from what was computed. Nothing is computed here; what an answer states, its
//! result has found. Sections for people are in [`summary`](crate::summary).

mod compare;
mod holds;
mod preparation;
mod terms;

pub use compare::{ComparisonAnswer, DependenceAnswer, PlaceAnswer};
pub use holds::{CorrelationAnswer, HoldFitAnswer, HoldParameter, HoldsAnswer, SpreadAnswer};
pub use preparation::{PreparationAnswer, Prepared};
pub use terms::{NumberAnswer, TermsAnswer};

use schemars::{JsonSchema, Schema, SchemaGenerator, generate::SchemaSettings};
use serde::Serialize;
use serde_json::Value;

/// An estimated number with its uncertainty.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Estimate {
    /// The value, in `unit`.
    pub value: f64,
    /// Its standard error, in `unit`; null where the data do not determine it.
    pub standard_error: Option<f64>,
    /// Unit, empty for a pure number.
    pub unit: String,
}

/// An answer as one JSON value.
///
/// # Panics
/// Never: the keys of every answer are names.
#[must_use]
pub fn json(answer: &impl Serialize) -> Value {
    serde_json::to_value(answer).expect("the keys of an answer are names")
}

/// A number that JSON can say; none for what is not finite.
#[must_use]
pub fn finite(number: f64) -> Option<f64> {
    number.is_finite().then_some(number)
}

/// The JSON schema of every answer, by the name of its file in `docs/schema/`.
#[must_use]
pub fn schemas() -> Vec<(&'static str, Schema)> {
    vec![
        ("compare", schema::<Prepared<ComparisonAnswer>>()),
        ("fit-holds", schema::<Prepared<HoldsAnswer>>()),
    ]
}

/// What a program that reads an answer may rely on: the schema of what is written, not of what would be read.
fn schema<A: JsonSchema>() -> Schema {
    SchemaGenerator::new(SchemaSettings::draft2020_12().for_serialize()).into_root_schema_for::<A>()
}
