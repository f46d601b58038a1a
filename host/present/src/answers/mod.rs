//! What the commands found, as types: `--json` prints them, the page and other programs get them, `docs/schema/` describes them.
//!
//! One file an answer: its type, and how it follows from what was computed. Nothing is computed here; what an answer states, its
//! result has found. Sections for people are in [`summary`](crate::summary).

mod afm;
mod change;
mod compare;
mod conversion;
mod creep;
mod decomposition;
mod diagnosis;
mod discovery;
mod dissertation;
mod effects;
mod events;
mod grasp;
mod holds;
mod markers;
mod next_motion;
pub(crate) mod population;
mod practice;
mod preparation;
mod pull_off;
mod ranking;
mod rates;
mod recording_plan;
mod relaxation;
mod segment;
mod sensor;
mod strain_rate;
mod survey;
mod terms;
mod uncertain;
mod whole_motion;

pub use afm::{
    AfmAnswer, AfmCurveAnswer, AfmExponentialAnswer, AfmFitAnswer, AfmHoldAnswer, AfmLatencyAnswer,
    AfmRefusedAnswer, AfmRefusedHoldAnswer, AfmRelaxedAnswer, AfmRetreatAnswer, AfmRoughAnswer,
    AfmSpreadAnswer, AfmTermAnswer,
};
pub use change::{ChangeAnswer, RungAnswer, TriedLaw};
pub use compare::{ComparisonAnswer, DependenceAnswer, PlaceAnswer};
pub use conversion::{ConversionAnswer, WrittenAnswer};
pub use creep::{ConditioningAnswer, CreepAnswer, CreepHold};
pub use decomposition::{
    DecomposedChannel, DecomposedTrace, DecompositionAnswer, FilterRelaxation, GraspRegion,
};
pub use diagnosis::{
    AdequacyAnswer, AdequacyPair, CandidateAnswer, DiagnosisAnswer, ErrorBasis, ExplorationAnswer,
    IncidentAnswer, IncidentChange, IncidentUntil, LeftoverPlace, NoiseAnswer, PValueBasis,
    RefusedAnswer, RivalAnswer, Seeds, StepAnswer, SwingAnswer, UntestableAnswer, VerdictAnswer,
};
pub use discovery::{
    AlternativeAnswer, DiscoveryAnswer, FormulaAnswer, FormulaRung, FoundLaw, LawParameter,
    OutcomeAnswer, QuantityAnswer, Resemblance, ShareAnswer, SharesAnswer, SurfaceAnswer,
};
pub use dissertation::{
    DissertationAnswer, DrawnFigure, EvidenceKind, EvidenceTally, PrintedComparison, PrintedFigure,
    PrintedNumber,
};
pub use effects::{
    ContractAnswer, EffectAnswer, KeptAnswer, LawAnswer, LibraryAnswer, PromiseAnswer, ShapeAnswer,
    SignAnswer, StageAnswer, StrengthAnswer,
};
pub use events::{
    EventAnswer, EventKind, EventSettings, EventsAnswer, HappenedAnswer, TraceEvents,
};
pub use grasp::{
    BalanceAnswer, BalancedAnswer, ContactAnswer, ContactShapeAnswer, FingerAnswer,
    GraspForecastAnswer, GraspFrictionAnswer, GraspGrowthAnswer, GraspHoldAnswer, GraspLoadAnswer,
    GraspMarginAnswer, GraspPlanAnswer, GraspState, GraspSurfaceAnswer, GraspWatchAnswer,
    GrownAnswer, InstantAnswer, LeastAnswer, MarginHistoryAnswer, SlipAnswer, SurfacePointAnswer,
    UnbalancedAnswer,
};
pub use holds::{CorrelationAnswer, HoldFitAnswer, HoldParameter, HoldsAnswer, SpreadAnswer};
pub use markers::{GapAnswer, MarkersAnswer};
pub use next_motion::{InformedParameter, NextMotionAnswer, RigAnswer};
pub use population::{
    LeftOutOfPopulation, PopulationAnswer, PopulationEffect, PopulationParameter,
    SpreadInPopulation, ValueInterval,
};
pub use practice::{HiddenEffect, HiddenValue, PracticeAnswer, PracticeRecording, TruthAnswer};
pub use preparation::{
    MotionNoiseAnswer, PreparationAnswer, Prepared, RepeatsAnswer, RobustAnswer, RobustParameter,
    StairsAnswer, StairsCause,
};
pub use pull_off::{PullOffAnswer, PullOffGrowthAnswer, PullOffLaw, PullOffsAtSpeed};
pub use ranking::{RankedLaw, RankedParameter, RankingAnswer, SetupAnswer};
pub use rates::{RateGroup, RateRun, RateTrend, RatesAnswer};
pub use recording_plan::{PlannedRecordingAnswer, RecordingPlanAnswer};
pub use relaxation::{
    FormAnswer, FormsAnswer, LatencyAnswer, RelaxationAnswer, RelaxationHold, StrainReference,
};
pub use segment::{
    ControlSource, ControlledQuantity, CycleAnswer, CyclePoint, CycleRegion, ForceLimit,
    InertiaAnswer, LoopDirection, SegmentationAnswer, SegmentedTraceAnswer,
};
pub use sensor::{
    SensorFrequencyAnswer, SensorGaugeAnswer, SensorPressAnswer, SensorRelaxationAnswer,
    SensorResponseAnswer, SensorShakeAnswer, SensorSlideAnswer, SensorSlipAnswer,
    SensorSpecimenAnswer, SensorStimulus, SensorToneAnswer,
};
pub use strain_rate::{DerivativeAnswer, SimulatedRun, StrainRateAnswer, StrainRateHold};
pub use survey::{
    EstimateDistribution, FarOutAnswer, GroupFailure, GroupStatus, MedianAt, MissingEffect,
    MissingSince, SurveyAnswer, SurveyQuestion,
};
pub use terms::{NumberAnswer, TermsAnswer};
pub use uncertain::Uncertain;
pub use whole_motion::{FitAnswer, FitErrorBasis, FittedParameter, TraceError};

#[cfg(feature = "schemas")]
use palpate_link::device::answers as device;
use palpate_model::Parameter;
#[cfg(feature = "schemas")]
use schemars::{JsonSchema, Schema, SchemaGenerator, generate::SchemaSettings};
use serde::Serialize;
use serde_json::Value;

/// An estimated number with its uncertainty.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
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
#[cfg(feature = "schemas")]
#[must_use]
pub fn schemas() -> Vec<(&'static str, Schema)> {
    vec![
        ("add", schema::<ChangeAnswer>()),
        ("afm", schema::<AfmAnswer>()),
        ("afm-rough", schema::<AfmRoughAnswer>()),
        ("compare", schema::<Prepared<ComparisonAnswer>>()),
        ("convert", schema::<ConversionAnswer>()),
        ("creep", schema::<CreepAnswer>()),
        ("decompose", schema::<DecompositionAnswer>()),
        ("device-calibrate", schema::<device::CalibrationAnswer>()),
        ("device-info", schema::<device::DeviceAnswer>()),
        ("device-list", schema::<device::PortsAnswer>()),
        ("device-self-test", schema::<device::SelfTestAnswer>()),
        ("device-set", schema::<device::SetAnswer>()),
        ("device-tare", schema::<device::TareAnswer>()),
        ("diagnose", schema::<Prepared<DiagnosisAnswer>>()),
        ("discover", schema::<Prepared<DiscoveryAnswer>>()),
        ("dissertation", schema::<DissertationAnswer>()),
        ("drop", schema::<ChangeAnswer>()),
        ("effects-check", schema::<Vec<ContractAnswer>>()),
        ("effects-list", schema::<LibraryAnswer>()),
        ("effects-one", schema::<EffectAnswer>()),
        ("events", schema::<EventsAnswer>()),
        ("explore", schema::<Prepared<ExplorationAnswer>>()),
        ("fit", schema::<Prepared<FitAnswer>>()),
        ("fit-holds", schema::<Prepared<HoldsAnswer>>()),
        ("fit-rank", schema::<Prepared<RankingAnswer>>()),
        ("grasp-friction", schema::<GraspFrictionAnswer>()),
        ("grasp-growth", schema::<GraspGrowthAnswer>()),
        ("grasp-margin", schema::<GraspMarginAnswer>()),
        ("grasp-plan", schema::<GraspPlanAnswer>()),
        ("grasp-surface", schema::<GraspSurfaceAnswer>()),
        ("grasp-watch", schema::<GraspWatchAnswer>()),
        ("hide", schema::<PracticeAnswer>()),
        ("hide-open", schema::<TruthAnswer>()),
        ("hide-record", schema::<PracticeRecording>()),
        ("markers", schema::<MarkersAnswer>()),
        ("plan", schema::<RecordingPlanAnswer>()),
        ("rates", schema::<RatesAnswer>()),
        ("record", schema::<device::RecordedAnswer>()),
        ("record-second", schema::<device::SecondAnswer>()),
        ("relaxation", schema::<RelaxationAnswer>()),
        ("segment", schema::<SegmentationAnswer>()),
        ("sensor-frequency", schema::<SensorFrequencyAnswer>()),
        ("sensor-press", schema::<SensorPressAnswer>()),
        ("sensor-shake", schema::<SensorShakeAnswer>()),
        ("sensor-slide", schema::<SensorSlideAnswer>()),
        ("sensor-slip", schema::<SensorSlipAnswer>()),
        ("strain-rate", schema::<StrainRateAnswer>()),
        ("survey-population", schema::<PopulationAnswer>()),
        ("survey-report", schema::<SurveyAnswer>()),
    ]
}

/// What a program that reads an answer may rely on: the schema of what is written, not of what would be read.
#[cfg(feature = "schemas")]
fn schema<A: JsonSchema>() -> Schema {
    SchemaGenerator::new(SchemaSettings::draft2020_12().for_serialize()).into_root_schema_for::<A>()
}
