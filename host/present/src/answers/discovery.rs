//! `palpate discover`: formulas for what no effect of the library explains.

use std::collections::BTreeMap;

use palpate_diagnose::criticism::covariate::Covariate;
use palpate_diagnose::criticism::dependence::Dependence;
use palpate_diagnose::discover::Outcome;
use palpate_diagnose::discover::causes::cause_of;
use palpate_diagnose::discover::formula::{Alternative, Formula, Shares};
use palpate_diagnose::discover::grammar::Term;
use palpate_diagnose::discover::surface::Surface;
use palpate_model::{Rung, StoredEffect, StoredParameter};
use serde::Serialize;

use super::{StageAnswer, VerdictAnswer, finite};
use crate::summary::DiscoverySummary;

/// Formulas for what a model lacks.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct DiscoveryAnswer {
    /// Version of this answer.
    pub palpate_discovery: u32,
    /// What came of it.
    pub outcome: OutcomeAnswer,
    /// The column that was looked at.
    pub signal: String,
    /// Unit of the signal, and of every error.
    pub unit: String,
    /// Standard deviation of the noise.
    pub noise_rms: f64,
    /// The verdict of the diagnosis, which knows the library alone.
    pub verdict_of_the_library: VerdictAnswer,
    /// The effects of the library that the diagnosis found, each with those that the traces do not tell from it.
    pub effects_of_the_library: Vec<Vec<String>>,
    /// Number of terms of the grammar that these traces can show.
    pub terms: usize,
    /// The formulas, in the order in which they were found.
    pub formulas: Vec<FormulaAnswer>,
    /// The error of the model without formula, and with each.
    pub ladder: Vec<FormulaRung>,
    /// What the residual of the model without formula depends on, strongest first.
    pub dependences: Vec<QuantityAnswer>,
    /// What it depends on by pairs of quantities, those with the least held-out error first.
    pub surfaces: Vec<SurfaceAnswer>,
}

/// What came of a search for formulas.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum OutcomeAnswer {
    /// Only noise is left.
    Adequate,
    /// The library explains what is missing.
    Library,
    /// There are formulas.
    Formula,
    /// No term of the grammar lowers the held-out error.
    Nothing,
}

/// A formula as a law of one's own, and what is known of it.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct FormulaAnswer {
    /// The law.
    #[serde(flatten)]
    pub law: FoundLaw,
    /// p value over the whole grammar.
    pub p_value: f64,
    /// How much of it there is in parts of the data.
    pub shares: SharesAnswer,
    /// Effects of the library whose mark on these traces looks alike.
    pub resembles: Vec<Resemblance>,
    /// Other laws that these traces do not tell from it.
    pub alternatives: Vec<AlternativeAnswer>,
    /// What it can come from.
    pub cause: String,
    /// The experiment that would confirm that.
    pub experiment: String,
}

/// A term of the grammar as a law.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct FoundLaw {
    /// Name under which it is added.
    pub name: String,
    /// Where in the chain it acts; null where that is not said.
    pub stage: Option<StageAnswer>,
    /// Its expression; null where it has none.
    pub expression: Option<String>,
    /// How it depends on its quantity.
    pub shape: String,
    /// Symbol of the quantity.
    pub quantity: String,
    /// Its parameters by name.
    pub parameters: BTreeMap<String, LawParameter>,
}

/// A parameter as a model file has it.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct LawParameter {
    /// Its value, in `unit`.
    pub value: f64,
    /// Its standard error, in `unit`; absent where the data do not determine it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standard_error: Option<f64>,
    /// Its unit; absent for a pure number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Smallest value that a fit may give it; absent where there is no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lower: Option<f64>,
    /// Largest value that a fit may give it; absent where there is no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub upper: Option<f64>,
}

/// Another law in the place of a formula.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct AlternativeAnswer {
    /// The law.
    #[serde(flatten)]
    pub law: FoundLaw,
    /// By how much its Bayesian information criterion is larger.
    pub delta_bic: f64,
}

/// How much of a formula there is in parts of the data: the factor by which least squares would multiply it there.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SharesAnswer {
    /// While pressing.
    pub pressing: ShareAnswer,
    /// While not pressing.
    pub releasing: ShareAnswer,
    /// In each trace; null where it does nothing.
    pub traces: Vec<Option<f64>>,
}

/// A share with its uncertainty.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct ShareAnswer {
    /// The share, 1 being all; null where the formula does nothing there.
    pub value: Option<f64>,
    /// Its standard error over the traces; null where they do not determine it.
    pub standard_error: Option<f64>,
}

/// An effect of the library that looks alike.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct Resemblance {
    /// Name of the effect.
    pub effect: String,
    /// Cosine between its mark on these traces and that of the formula.
    pub cosine: f64,
}

/// The error with one formula more.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct FormulaRung {
    /// The model or formula that was added.
    pub add: String,
    /// Root mean square error on the traces fitted.
    pub fitted_rms: f64,
    /// Held-out error; null where it was not found.
    pub heldout_rms: Option<f64>,
}

/// How much of the residual a quantity explains.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct QuantityAnswer {
    /// Symbol of the quantity.
    pub quantity: String,
    /// Share of the residual's mean square that it explains, 0 to 1.
    pub explained: f64,
    /// p value of explaining as much by chance.
    pub p_value: f64,
}

/// How much of the residual a pair of quantities explains.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SurfaceAnswer {
    /// Symbols of both quantities.
    pub quantities: [&'static str; 2],
    /// Share of the residual's mean square that the surface explains, 0 to 1.
    pub explained: f64,
    /// Share that the sum of one curve over each explains, 0 to 1.
    pub additive: f64,
    /// Share that only both together explain, 0 to 1.
    pub interaction: f64,
    /// Share that a surface of the other traces explains of a trace left out; below 0 where it does harm.
    pub held_out: f64,
    /// p value of explaining as much by chance.
    pub p_value: f64,
    /// Middles of the classes of each quantity, in its unit.
    pub at: [Vec<f64>; 2],
    /// Mean residual in each class of the first quantity, by class of the second; null where there is no sample.
    pub means: Vec<Vec<Option<f64>>>,
}

impl From<&DiscoverySummary<'_>> for DiscoveryAnswer {
    fn from(summary: &DiscoverySummary) -> Self {
        let discovery = summary.discovery;
        let diagnosis = &discovery.diagnosis;
        let steps = diagnosis.found.steps.iter();
        Self {
            palpate_discovery: 1,
            outcome: OutcomeAnswer::from(&discovery.outcome),
            signal: diagnosis.signal.clone(),
            unit: summary.unit().to_owned(),
            noise_rms: diagnosis.noise.level,
            verdict_of_the_library: diagnosis.verdict.into(),
            effects_of_the_library: steps.map(|step| step.credible.clone()).collect(),
            terms: discovery.terms,
            formulas: summary.formulas().iter().map(FormulaAnswer::from).collect(),
            ladder: discovery.ladder.iter().map(FormulaRung::from).collect(),
            dependences: discovery.dependences.iter().map(QuantityAnswer::from).collect(),
            surfaces: discovery.surfaces.iter().map(SurfaceAnswer::from).collect(),
        }
    }
}

impl From<&Outcome> for OutcomeAnswer {
    fn from(outcome: &Outcome) -> Self {
        match outcome {
            Outcome::Adequate => Self::Adequate,
            Outcome::Library => Self::Library,
            Outcome::Formulas(_) => Self::Formula,
            Outcome::Nothing => Self::Nothing,
        }
    }
}

impl From<&Formula> for FormulaAnswer {
    fn from(formula: &Formula) -> Self {
        let cause = cause_of(&formula.term);
        let resemblance = |(effect, cosine): &(String, f64)| Resemblance {
            effect: effect.clone(),
            cosine: *cosine,
        };
        Self {
            law: FoundLaw::of(&formula.law, &formula.term),
            p_value: formula.p_value,
            shares: SharesAnswer::from(&formula.shares),
            resembles: formula.resembles.iter().map(resemblance).collect(),
            alternatives: formula.alternatives.iter().map(AlternativeAnswer::from).collect(),
            cause: cause.cause.to_owned(),
            experiment: cause.experiment.to_owned(),
        }
    }
}

impl FoundLaw {
    fn of(law: &StoredEffect, term: &Term) -> Self {
        let parameters = law.parameters.iter();
        Self {
            name: law.name.clone(),
            stage: law.stage.map(StageAnswer::from),
            expression: law.expression.clone(),
            shape: format!("{}{}", term.shape.name, term.factor.name),
            quantity: term.quantity.symbol.to_owned(),
            parameters: parameters.map(|(name, it)| (name.clone(), it.into())).collect(),
        }
    }
}

impl From<&StoredParameter> for LawParameter {
    fn from(stored: &StoredParameter) -> Self {
        Self {
            value: stored.value,
            standard_error: stored.standard_error,
            unit: Some(stored.unit.clone()).filter(|unit| !unit.is_empty()),
            lower: stored.lower,
            upper: stored.upper,
        }
    }
}

impl From<&Alternative> for AlternativeAnswer {
    fn from(found: &Alternative) -> Self {
        Self { law: FoundLaw::of(&found.law, &found.term), delta_bic: found.delta_bic }
    }
}

impl From<&Shares> for SharesAnswer {
    fn from(shares: &Shares) -> Self {
        let share = |(value, error): (f64, f64)| ShareAnswer {
            value: finite(value),
            standard_error: finite(error),
        };
        Self {
            pressing: share(shares.pressing),
            releasing: share(shares.releasing),
            traces: shares.traces.iter().copied().map(finite).collect(),
        }
    }
}

impl From<&Rung> for FormulaRung {
    fn from(rung: &Rung) -> Self {
        Self { add: rung.add.clone(), fitted_rms: rung.fitted_rms, heldout_rms: rung.heldout_rms }
    }
}

impl From<&Dependence> for QuantityAnswer {
    fn from(found: &Dependence) -> Self {
        Self {
            quantity: found.covariate.symbol().to_owned(),
            explained: found.explained,
            p_value: found.p_value,
        }
    }
}

impl From<&Surface> for SurfaceAnswer {
    fn from(surface: &Surface) -> Self {
        Self {
            quantities: surface.of.map(Covariate::symbol),
            explained: surface.explained,
            additive: surface.additive,
            interaction: surface.interaction(),
            held_out: surface.held_out,
            p_value: surface.p_value,
            at: surface.at.clone(),
            means: surface.means.clone(),
        }
    }
}
