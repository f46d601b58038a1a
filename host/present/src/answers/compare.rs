//! `palpate compare`: where a model fails, and what the failure depends on.

use palpate_diagnose::criticism::compare::{Cell, Comparison};
use palpate_diagnose::criticism::dependence::{Dependence, SEED};
use serde::Serialize;

use crate::summary::unit_of;

/// A model against measurements.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ComparisonAnswer {
    /// Version of this answer.
    pub palpate_comparison: u32,
    /// The column that was compared.
    pub signal: String,
    /// Unit of the signal, and of every error.
    pub unit: String,
    /// Root mean square error over all traces.
    pub rms: f64,
    /// Standard deviation of the noise; null where the recordings do not show it without a model.
    pub noise_rms: Option<f64>,
    /// Whether what the model leaves is noise alone.
    pub only_noise: bool,
    /// The error of every region of every trace.
    #[serde(rename = "where")]
    pub places: Vec<PlaceAnswer>,
    /// What the residual depends on, strongest first.
    pub depends_on: Vec<DependenceAnswer>,
    /// The findings in a sentence.
    pub in_words: String,
    /// Traces or parts that could not be compared, with the reason.
    pub left_out: Vec<String>,
    /// Seed of the circular shifts behind the p values.
    pub seed: u64,
}

/// The error in one region of one trace.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct PlaceAnswer {
    /// Name of the trace.
    pub trace: String,
    /// Name of the region, such as `loading`.
    pub phase: String,
    /// Number of samples.
    pub samples: usize,
    /// Share of all squared error beyond the noise that lies here, 0 to 1.
    pub share_of_excess: f64,
    /// Root mean square error.
    pub rms: f64,
}

/// How much of the residual a quantity explains.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct DependenceAnswer {
    /// Symbol of the quantity.
    pub covariate: String,
    /// Share of the residual's variance that it explains, 0 to 1.
    pub explained: f64,
    /// p value of explaining as much by chance.
    pub p_value: f64,
    /// Correlation of the mean residual with the quantity, −1 to 1.
    pub trend: f64,
}

impl From<&Comparison> for ComparisonAnswer {
    fn from(comparison: &Comparison) -> Self {
        let place = |cell: &Cell| PlaceAnswer {
            trace: comparison.labels[cell.trace].clone(),
            phase: cell.region.name().to_owned(),
            samples: cell.samples,
            share_of_excess: cell.share_of_excess,
            rms: cell.rms,
        };
        Self {
            palpate_comparison: 1,
            signal: comparison.signal.clone(),
            unit: unit_of(&comparison.signal).to_owned(),
            rms: comparison.rms,
            noise_rms: comparison.noise.map(|noise| noise.standard_deviation),
            only_noise: comparison.only_noise,
            places: comparison.cells.iter().map(place).collect(),
            depends_on: comparison.dependences.iter().map(DependenceAnswer::from).collect(),
            in_words: comparison.in_words(),
            left_out: comparison.left_out.clone(),
            seed: SEED,
        }
    }
}

impl From<&Dependence> for DependenceAnswer {
    fn from(found: &Dependence) -> Self {
        Self {
            covariate: found.covariate.symbol().to_owned(),
            explained: found.explained,
            p_value: found.p_value,
            trend: found.trend,
        }
    }
}
