//! `palpate fit --all`: every base law on the same traces.

use std::collections::BTreeMap;

use palpate_fit::ranking::{ParameterSpread, Place, Ranking, Setup};
use serde::Serialize;

use super::finite;
use crate::summary::unit_of;

/// Base laws, the best first.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RankingAnswer {
    /// Version of this answer.
    pub palpate_ranking: u32,
    /// The column that was fitted.
    pub signal: String,
    /// Unit of the signal, and of every error.
    pub unit: String,
    /// Standard deviation of the noise; null where the recordings do not show it without a model.
    pub noise_rms: Option<f64>,
    /// Every law, by its held-out error; for a single trace by the Bayesian information criterion.
    pub laws: Vec<RankedLaw>,
    /// The set-ups that parameters are compared between.
    pub setups: Vec<SetupAnswer>,
}

/// One law in a ranking.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct RankedLaw {
    /// Name of the law.
    pub law: &'static str,
    /// Number of exponentials or branches; 1 where the law has no choice.
    pub terms: usize,
    /// Name of the elastic response.
    pub elastic: &'static str,
    /// Name of the kernel of relaxation.
    pub relaxation: &'static str,
    /// Root mean square of the residual over all traces.
    pub residual_rms: f64,
    /// Held-out error over all traces, each left out in turn; null for a single trace.
    pub heldout_rms: Option<f64>,
    /// Median over the parameters of their relative standard deviation between set-ups; null for a single set-up.
    pub deviation_between_setups: Option<f64>,
    /// Coefficient of determination.
    pub r_squared: f64,
    /// Bayesian information criterion; the least is the best.
    pub bic: f64,
    /// Whether a minimum was reached.
    pub converged: bool,
    /// The parameters by name.
    pub parameters: BTreeMap<String, RankedParameter>,
}

/// A parameter over all traces and in each set-up.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct RankedParameter {
    /// The value over all traces, in `unit`.
    pub value: f64,
    /// Its standard error, in `unit`; null where the data do not determine it.
    pub standard_error: Option<f64>,
    /// Unit, empty for a pure number.
    pub unit: String,
    /// The value in each set-up, in their order; null for a single set-up.
    pub in_setups: Option<Vec<f64>>,
    /// Largest size in a set-up over the smallest; null for a single set-up, and where the smallest is 0.
    pub ratio: Option<f64>,
}

/// Traces that were recorded alike.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SetupAnswer {
    /// Their largest compression, mm.
    pub compression_mm: f64,
    /// Their fastest loading, mm/s.
    pub rate_mm_per_s: f64,
    /// Which traces of the set, from 0.
    pub traces: Vec<usize>,
}

impl RankingAnswer {
    /// A ranking of laws for a signal.
    #[must_use]
    pub fn of(ranking: &Ranking, signal: &str) -> Self {
        Self {
            palpate_ranking: 1,
            signal: signal.to_owned(),
            unit: unit_of(signal).to_owned(),
            noise_rms: ranking.noise.as_ref().map(|noise| noise.standard_deviation),
            laws: ranking.places.iter().map(RankedLaw::from).collect(),
            setups: ranking.setups.iter().map(SetupAnswer::from).collect(),
        }
    }
}

impl From<&Place> for RankedLaw {
    fn from(place: &Place) -> Self {
        let fit = &place.fit;
        let law = &fit.chain.base;
        let parameter = |(k, of): (usize, palpate_model::Parameter)| {
            let spread = place.spreads.get(k);
            let parameter = RankedParameter {
                value: fit.values[k],
                standard_error: fit.standard_errors[k].and_then(finite),
                unit: of.unit.to_string(),
                in_setups: spread.map(|spread| spread.values.clone()),
                ratio: spread.map(ParameterSpread::ratio).and_then(finite),
            };
            (of.name.to_string(), parameter)
        };
        Self {
            law: law.name(),
            terms: law.terms,
            elastic: law.elastic.name(),
            relaxation: law.kernel.name,
            residual_rms: fit.rms(),
            heldout_rms: place.held_out.and_then(finite),
            deviation_between_setups: place.typical_deviation(),
            r_squared: fit.r_squared,
            bic: fit.bic(),
            converged: fit.stop.converged(),
            parameters: fit.parameters().into_iter().enumerate().map(parameter).collect(),
        }
    }
}

impl From<&Setup> for SetupAnswer {
    fn from(setup: &Setup) -> Self {
        Self {
            compression_mm: setup.compression,
            rate_mm_per_s: setup.rate,
            traces: setup.traces.clone(),
        }
    }
}
