//! `palpate add` and `palpate drop`: an effect more in a model, or one less.

use std::collections::BTreeMap;

use palpate_diagnose::criticism::change::{Change, Tried};
use palpate_model::Rung;
use serde::Serialize;

use super::Estimate;
use crate::summary::{changed_parameters, unit_of};

/// A model before and after a change.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct ChangeAnswer {
    /// Version of this answer.
    pub palpate_change: u32,
    /// The effect that was added or taken out.
    pub effect: String,
    /// Whether it was added.
    pub added: bool,
    /// The law of the effect that was taken; null where it was taken out.
    pub law: Option<String>,
    /// The column that was fitted.
    pub signal: String,
    /// Unit of the signal, and of every error.
    pub unit: String,
    /// Root mean square error before the change.
    pub rms_before: f64,
    /// Root mean square error after it.
    pub rms_after: f64,
    /// Held-out error before; null for a single trace.
    pub heldout_rms_before: Option<f64>,
    /// Held-out error after; null for a single trace.
    pub heldout_rms_after: Option<f64>,
    /// Standard deviation of the noise; null where the recordings do not show it without a model.
    pub noise_rms: Option<f64>,
    /// The parameters after, by the base law or effect that they are of, then by name.
    pub parameters: BTreeMap<String, BTreeMap<String, Estimate>>,
    /// The error from the base law to the model after the change.
    pub ladder: Vec<RungAnswer>,
    /// The laws of the effect that were tried, best first; empty where it was taken out.
    pub laws: Vec<TriedLaw>,
    /// Whether the fit of the model after reached a minimum.
    pub converged: bool,
    /// What was done besides.
    pub notes: Vec<String>,
    /// What a reader should beware of.
    pub warnings: Vec<String>,
}

/// One rung of the ladder of errors.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct RungAnswer {
    /// The law or effect that was added.
    pub add: String,
    /// Root mean square error on the traces fitted.
    pub rms: f64,
    /// Held-out error; null for a single trace.
    pub heldout_rms: Option<f64>,
}

/// A law that was tried.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct TriedLaw {
    /// Name of the law.
    pub law: String,
    /// Its Bayesian information criterion over that of the best.
    pub bic_over_best: f64,
}

impl From<&Change> for ChangeAnswer {
    fn from(change: &Change) -> Self {
        let fit = &change.fit;
        let mut parameters: BTreeMap<String, BTreeMap<String, Estimate>> = BTreeMap::new();
        for (k, (of, parameter)) in changed_parameters(change).into_iter().enumerate() {
            let estimate = Estimate::of(&parameter, fit.values[k], fit.standard_errors[k]);
            parameters.entry(of).or_default().insert(parameter.name.to_string(), estimate);
        }
        Self {
            palpate_change: 1,
            effect: change.effect.clone(),
            added: change.added,
            law: change.laws.first().map(|tried| tried.law.clone()),
            signal: change.model.base.signal.clone(),
            unit: unit_of(&change.model.base.signal).to_owned(),
            rms_before: change.before.fitted_rms,
            rms_after: change.after.fitted_rms,
            heldout_rms_before: change.before.heldout_rms,
            heldout_rms_after: change.after.heldout_rms,
            noise_rms: change.noise.map(|noise| noise.standard_deviation),
            parameters,
            ladder: change.model.ladder.iter().map(RungAnswer::from).collect(),
            laws: change.laws.iter().map(TriedLaw::from).collect(),
            converged: fit.stop.converged(),
            notes: change.notes.clone(),
            warnings: change.warnings.clone(),
        }
    }
}

impl From<&Rung> for RungAnswer {
    fn from(rung: &Rung) -> Self {
        Self { add: rung.add.clone(), rms: rung.fitted_rms, heldout_rms: rung.heldout_rms }
    }
}

impl From<&Tried> for TriedLaw {
    fn from(tried: &Tried) -> Self {
        Self { law: tried.law.clone(), bic_over_best: tried.over_best }
    }
}
