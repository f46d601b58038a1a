//! `palpate creep`: what the holds of a force show.

use palpate_analysis::creep::{Hold, spreads};
use palpate_fit::hold::HoldError;
use serde::Serialize;

use super::{HoldFitAnswer, SpreadAnswer, TermsAnswer};
use crate::summary::{Conditioning, unit_of};

/// Holds of a force and their creep functions.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct CreepAnswer {
    /// Version of this answer.
    pub palpate_creep: u32,
    /// The column that was fitted.
    pub signal: String,
    /// Unit of the signal.
    pub unit: String,
    /// The filter of the force; null where it was not filtered.
    pub conditioning: Option<ConditioningAnswer>,
    /// Every hold that could be fitted.
    pub holds: Vec<CreepHold>,
    /// Why other holds could not be fitted, a sentence each.
    pub left_out: Vec<String>,
    /// Each coefficient over holds of one type at one force.
    pub spread: Vec<SpreadAnswer>,
}

/// A low-pass filter of the force.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct ConditioningAnswer {
    /// Kind of the filter: always `Butterworth`.
    pub filter: &'static str,
    /// Cutoff frequency of one pass, Hz.
    #[serde(rename = "cutoff_Hz")]
    pub cutoff_hz: f64,
    /// Order of one pass.
    pub order: usize,
    /// Whether it runs forward and backward, so without delay.
    pub zero_phase: bool,
    /// Frequency at which all passes together take 3 dB off, Hz.
    #[serde(rename = "minus_3_dB_Hz")]
    pub minus_3_db_hz: f64,
}

/// One hold of a force.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct CreepHold {
    /// Its creep function (eq. 6.2); `N` is D, the signal after infinite time, and `c0` is 1.
    #[serde(flatten)]
    pub fit: HoldFitAnswer,
    /// Mean of the force that was held, N; null where it was not recorded.
    #[serde(rename = "force_N")]
    pub force_n: Option<f64>,
    /// Standard deviation of that force, N; null where it was not recorded.
    #[serde(rename = "force_scatter_N")]
    pub force_scatter_n: Option<f64>,
    /// One to four exponentials beside each other.
    pub terms: TermsAnswer,
    /// What the hold does not identify, in sentences.
    pub not_identified: Vec<String>,
}

impl CreepAnswer {
    /// The holds of a signal.
    #[must_use]
    pub fn of(
        holds: &[Hold],
        left_out: &[HoldError],
        signal: &str,
        conditioning: Option<Conditioning>,
    ) -> Self {
        Self {
            palpate_creep: 1,
            signal: signal.to_owned(),
            unit: unit_of(signal).to_owned(),
            conditioning: conditioning.map(ConditioningAnswer::from),
            holds: holds.iter().map(CreepHold::from).collect(),
            left_out: left_out.iter().map(ToString::to_string).collect(),
            spread: spreads(holds).iter().map(SpreadAnswer::at_force).collect(),
        }
    }
}

impl From<Conditioning> for ConditioningAnswer {
    fn from((filter, rate): Conditioning) -> Self {
        Self {
            filter: "Butterworth",
            cutoff_hz: filter.cutoff_hz,
            order: filter.order,
            zero_phase: filter.zero_phase,
            minus_3_db_hz: filter.three_db_hz(rate),
        }
    }
}

impl From<&Hold> for CreepHold {
    fn from(hold: &Hold) -> Self {
        Self {
            fit: (&hold.fit).into(),
            force_n: hold.force.map(|force| force.0),
            force_scatter_n: hold.force.map(|force| force.1),
            terms: (&hold.terms).into(),
            not_identified: hold.doubts.clone(),
        }
    }
}
