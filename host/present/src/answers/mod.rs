//! What the commands found, as types: `--json` prints them, the page and other programs get them, `docs/schema/` describes them.
//!
//! One file an answer: its type, and how it follows from what was computed. Nothing is computed here; what an answer states, its
//! result has found. Sections for people are in [`summary`](crate::summary).

mod change;
mod compare;
mod diagnosis;
mod discovery;
mod effects;
mod holds;
mod next_motion;
mod practice;
mod preparation;
mod ranking;
mod terms;
mod whole_motion;

pub use change::{ChangeAnswer, RungAnswer, TriedLaw};
pub use compare::{ComparisonAnswer, DependenceAnswer, PlaceAnswer};
pub use diagnosis::{
    AdequacyAnswer, AdequacyPair, CandidateAnswer, DiagnosisAnswer, ErrorBasis, ExplorationAnswer,
    LeftoverPlace, NoiseAnswer, PValueBasis, RefusedAnswer, RivalAnswer, Seeds, StepAnswer,
    UntestableAnswer, VerdictAnswer,
};
pub use discovery::{
    AlternativeAnswer, DiscoveryAnswer, FormulaAnswer, FormulaRung, FoundLaw, LawParameter,
    OutcomeAnswer, QuantityAnswer, Resemblance, ShareAnswer, SharesAnswer, SurfaceAnswer,
};
pub use effects::{
    ContractAnswer, EffectAnswer, KeptAnswer, LawAnswer, LibraryAnswer, PromiseAnswer, ShapeAnswer,
    SignAnswer, StageAnswer, StrengthAnswer,
};
pub use holds::{CorrelationAnswer, HoldFitAnswer, HoldParameter, HoldsAnswer, SpreadAnswer};
pub use next_motion::{NextMotionAnswer, RigAnswer};
pub use practice::{HiddenEffect, HiddenValue, PracticeAnswer, PracticeRecording, TruthAnswer};
pub use preparation::{PreparationAnswer, Prepared};
pub use ranking::{RankedLaw, RankedParameter, RankingAnswer, SetupAnswer};
pub use terms::{NumberAnswer, TermsAnswer};
pub use whole_motion::{FitAnswer, FittedParameter, TraceError};

use palpate_model::Parameter;
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

impl Estimate {
    /// A value of a parameter and its standard error.
    #[must_use]
    pub fn of(parameter: &Parameter, value: f64, standard_error: Option<f64>) -> Self {
        let unit = parameter.unit.to_string();
        Self { value, standard_error: standard_error.and_then(finite), unit }
    }
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
        ("add", schema::<ChangeAnswer>()),
        ("compare", schema::<Prepared<ComparisonAnswer>>()),
        ("diagnose", schema::<Prepared<DiagnosisAnswer>>()),
        ("discover", schema::<Prepared<DiscoveryAnswer>>()),
        ("drop", schema::<ChangeAnswer>()),
        ("effects-check", schema::<Vec<ContractAnswer>>()),
        ("effects-list", schema::<LibraryAnswer>()),
        ("effects-one", schema::<EffectAnswer>()),
        ("explore", schema::<Prepared<ExplorationAnswer>>()),
        ("fit", schema::<Prepared<FitAnswer>>()),
        ("fit-holds", schema::<Prepared<HoldsAnswer>>()),
        ("fit-rank", schema::<Prepared<RankingAnswer>>()),
        ("hide", schema::<PracticeAnswer>()),
        ("hide-open", schema::<TruthAnswer>()),
        ("hide-record", schema::<PracticeRecording>()),
    ]
}

/// What a program that reads an answer may rely on: the schema of what is written, not of what would be read.
fn schema<A: JsonSchema>() -> Schema {
    SchemaGenerator::new(SchemaSettings::draft2020_12().for_serialize()).into_root_schema_for::<A>()
}
