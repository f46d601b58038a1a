//! `palpate survey population`: what the specimens of a survey have in common, and how much they differ.

use palpate_survey::population::{Between, Correlations, EffectInAll, InAll, Population, Spread};
use palpate_survey::results::About;
use serde::Serialize;

use super::{CorrelationAnswer, SurveyQuestion, finite};

/// What the specimens of a survey have in common, and how much they differ.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct PopulationAnswer {
    /// Version of this answer.
    pub palpate_population: u32,
    /// The command that was asked of every group.
    pub asked: SurveyQuestion,
    /// Folder of the results.
    pub results: String,
    /// How the population was estimated.
    pub method: String,
    /// Number of specimens with an answer.
    pub specimens: usize,
    /// Number of groups with an answer.
    pub groups: usize,
    /// The key that distinguishes occasions of one specimen; null where each specimen was asked once.
    pub occasions: Option<String>,
    /// Every number with standard errors in at least three specimens.
    pub parameters: Vec<PopulationParameter>,
    /// Correlations over the specimens between the numbers that vary, the errors of the fits taken off; null where the survey does
    /// not determine them.
    pub correlation: Option<CorrelationAnswer>,
    /// Effects that are missing, most frequent first; empty unless the question was `diagnose`.
    pub effects: Vec<PopulationEffect>,
    /// What was left out.
    pub left_out: Vec<LeftOutOfPopulation>,
}

/// One number over the population.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct PopulationParameter {
    /// Its name, with the effect that it is of.
    pub name: String,
    /// Its unit; empty for a pure number.
    pub unit: String,
    /// Number of specimens that have it with a standard error.
    pub specimens: usize,
    /// Number of groups.
    pub groups: usize,
    /// Whether the specimens differ in it, at 5 % over all numbers (Holm).
    pub varies: bool,
    /// The value of a typical specimen, in `unit`.
    pub typical: ValueInterval,
    /// Whether the logarithm of the values is modelled: then the spreads and `error` are parts of the value, else in `unit`.
    pub relative: bool,
    /// Standard deviation from specimen to specimen.
    pub between_specimens: SpreadInPopulation,
    /// Standard deviation from one occasion to another of a specimen; null where each specimen was asked once.
    pub between_occasions: Option<SpreadInPopulation>,
    /// Root mean square of the standard errors of single groups.
    pub error: f64,
}

/// A number with its 95 % interval.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct ValueInterval {
    /// The number.
    pub value: f64,
    /// The 95 % interval; null at an end where there is none.
    pub interval_95: [Option<f64>; 2],
}

/// A standard deviation beyond the errors of the fits.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SpreadInPopulation {
    /// The standard deviation.
    pub value: f64,
    /// Its 95 % interval, by the profile of the restricted likelihood.
    pub interval_95: [Option<f64>; 2],
    /// p value of as much where there is none.
    pub p_value: f64,
}

/// An effect over the population.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct PopulationEffect {
    /// Name of the effect.
    pub effect: String,
    /// Number of groups in which it is missing.
    pub groups: usize,
    /// Number of specimens in which it is missing.
    pub specimens: usize,
    /// Part of all specimens (interval of Clopper and Pearson), 0 to 1.
    pub share: ValueInterval,
    /// p value of as many groups where each is a false alarm of one in a hundred.
    pub p_value: f64,
    /// Whether some specimens lack it, at 5 % over all effects (Holm).
    pub is_there: bool,
}

/// A number that was left out.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct LeftOutOfPopulation {
    /// Its name.
    pub name: String,
    /// Why.
    pub reason: String,
}

/// How the population is estimated, in words.
pub const METHOD: &str = "two stages: each group by itself, then restricted maximum likelihood over its estimates with their standard errors";

impl PopulationAnswer {
    /// The population of the survey in this folder.
    #[must_use]
    pub fn of(about: &About, population: &Population, folder: &str) -> Self {
        let left_out = |(name, reason): &(String, &str)| LeftOutOfPopulation {
            name: name.clone(),
            reason: (*reason).to_owned(),
        };
        Self {
            palpate_population: 1,
            asked: about.asked.into(),
            results: folder.to_owned(),
            method: METHOD.to_owned(),
            specimens: population.specimens,
            groups: population.groups,
            occasions: population.occasions.clone(),
            parameters: population.parameters.iter().map(PopulationParameter::from).collect(),
            correlation: population.correlations.as_ref().map(CorrelationAnswer::from),
            effects: population.effects.iter().map(PopulationEffect::from).collect(),
            left_out: population.left_out.iter().map(left_out).collect(),
        }
    }
}

impl From<&InAll> for PopulationParameter {
    fn from(found: &InAll) -> Self {
        Self {
            name: found.name.clone(),
            unit: found.unit.clone(),
            specimens: found.specimens,
            groups: found.groups,
            varies: found.varies,
            typical: found.typical.into(),
            relative: found.relative,
            between_specimens: found.spread.into(),
            between_occasions: found.occasions.map(SpreadInPopulation::from),
            error: found.error,
        }
    }
}

impl From<Between> for ValueInterval {
    fn from(found: Between) -> Self {
        Self { value: found.value, interval_95: [finite(found.lower), finite(found.upper)] }
    }
}

impl From<Spread> for SpreadInPopulation {
    fn from(found: Spread) -> Self {
        let ValueInterval { value, interval_95 } = found.deviation.into();
        Self { value, interval_95, p_value: found.p_value }
    }
}

impl From<&EffectInAll> for PopulationEffect {
    fn from(found: &EffectInAll) -> Self {
        Self {
            effect: found.effect.clone(),
            groups: found.groups,
            specimens: found.specimens.len(),
            share: found.share.into(),
            p_value: found.p_value,
            is_there: found.is_there,
        }
    }
}

impl From<&Correlations> for CorrelationAnswer {
    fn from(found: &Correlations) -> Self {
        let rows = found.matrix.row_iter();
        Self {
            order: found.order.clone(),
            matrix: rows.map(|row| row.iter().copied().map(finite).collect()).collect(),
        }
    }
}
