//! `palpate relaxation`: what the holds of a displacement show.

use palpate_analysis::relaxation::{Hold, Latency, OVER, StrainScale};
use palpate_fit::exponentials::Parameter;
use palpate_fit::hold::{HoldError, HoldFit, spreads};
use palpate_fit::relaxation_form::{Broad, FormFit, Forms};
use serde::Serialize;

use super::{HoldFitAnswer, SpreadAnswer, TermsAnswer, Uncertain, finite};
use crate::summary::{hold_warnings, unit_of};

/// Holds of a displacement: their relaxation functions, the form of the relaxation, and the linear latency model.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct RelaxationAnswer {
    /// Version of this answer.
    pub palpate_relaxation: u32,
    /// The column that was fitted.
    pub signal: String,
    /// Unit of the signal.
    pub unit: String,
    /// Every hold that could be fitted.
    pub holds: Vec<RelaxationHold>,
    /// Each coefficient over holds of one type at one displacement.
    pub spread: Vec<SpreadAnswer>,
    /// Why other holds could not be fitted, a sentence each.
    pub left_out: Vec<String>,
    /// What to beware of, each remark with its hold.
    pub warnings: Vec<String>,
}

/// One hold of a displacement.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct RelaxationHold {
    /// Its relaxation function (eq. 3.4).
    #[serde(flatten)]
    pub fit: HoldFitAnswer,
    /// One to four exponentials beside each other.
    pub terms: TermsAnswer,
    /// Sums of exponentials beside a power law and a stretched exponential; null where the samples are too few.
    pub forms: Option<FormsAnswer>,
    /// The linear latency model; null where the hold does not show where it settles.
    pub latency: Option<LatencyAnswer>,
}

/// Forms of a relaxation function, and which one is used.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct FormsAnswer {
    /// Name of the form of fewest numbers whose held-out error is no worse than the best by two standard errors.
    pub chosen: String,
    /// Every form, the least held-out error first.
    pub rows: Vec<FormAnswer>,
}

/// One form fitted to a hold.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct FormAnswer {
    /// Its name: `1 exponential` to `4 exponentials`, `power law` or `stretched exponential`.
    pub form: String,
    /// Number of parameters.
    pub numbers: usize,
    /// Root mean square of the residual, in the unit of the signal.
    pub residual_rms: f64,
    /// Held-out error, in the unit of the signal: each half decade of time predicted from all others, the geometric mean over
    /// them; null where the samples are too few.
    pub held_out_rms: Option<f64>,
    /// Shortest time constant of a sum of exponentials, s; null for other forms.
    pub time_constants_from_s: Option<f64>,
    /// Longest time constant of a sum of exponentials, s; null for other forms.
    pub time_constants_to_s: Option<f64>,
    /// A, where A + B (1 + t/τ)^(−β) or A + B e^(−(t/τ)^β) settles, in the unit of the signal; null for a sum of exponentials.
    pub settles_at: Option<Uncertain>,
    /// B, what relaxes, in the unit of the signal; null for a sum of exponentials.
    pub relaxes: Option<Uncertain>,
    /// Time τ, s; null for a sum of exponentials.
    pub tau_s: Option<Uncertain>,
    /// Order β; null for a sum of exponentials.
    pub beta: Option<Uncertain>,
}

/// The linear latency model, strain rate = −v1 (ε − ε_e), of a hold (4.4–4.10).
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct LatencyAnswer {
    /// Rate v1, 1/s.
    pub v1_per_s: f64,
    /// Its standard error, 1/s; null where the data do not determine it.
    pub v1_standard_error_per_s: Option<f64>,
    /// Share c0 of the signal at first that never relaxes.
    pub c0: f64,
    /// Where the signal settles, in its unit.
    pub settles_at: f64,
    /// Its standard error; null where the data do not determine it.
    pub settles_at_standard_error: Option<f64>,
    /// What every strain here is a share of.
    pub strain_of: StrainReference,
    /// Equilibrium strain ε_e, negative in compression.
    pub equilibrium_strain: f64,
    /// Slope of the strain rate over the strain, 1/s (4.7).
    pub strain_rate_slope_per_s: f64,
    /// Strain rate at no strain, 1/s (4.7).
    pub strain_rate_intercept_per_s: f64,
    /// Time to half of the way to equilibrium, s; null where it is never reached.
    pub half_time_s: Option<f64>,
    /// Time to 99 % of that way, s; null where it is never reached.
    pub time_to_99_percent_s: Option<f64>,
    /// Coefficient of determination of one exponential.
    pub r_squared: f64,
}

/// What a strain is a share of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum StrainReference {
    /// The height of the specimen, from the head of the trace.
    Height,
    /// The equilibrium strain itself, which is −1.
    Equilibrium,
}

impl RelaxationAnswer {
    /// The holds of a signal.
    #[must_use]
    pub fn of(holds: &[Hold], left_out: &[HoldError], signal: &str) -> Self {
        let fits: Vec<HoldFit> = holds.iter().map(|hold| hold.fit.clone()).collect();
        Self {
            palpate_relaxation: 1,
            signal: signal.to_owned(),
            unit: unit_of(signal).to_owned(),
            holds: holds.iter().map(RelaxationHold::from).collect(),
            spread: spreads(&fits).iter().map(SpreadAnswer::at_displacement).collect(),
            left_out: left_out.iter().map(ToString::to_string).collect(),
            warnings: hold_warnings(&fits),
        }
    }
}

impl From<&Hold> for RelaxationHold {
    fn from(hold: &Hold) -> Self {
        Self {
            fit: (&hold.fit).into(),
            terms: (&hold.terms).into(),
            forms: hold.forms.as_ref().map(FormsAnswer::from),
            latency: hold.latency.as_ref().map(LatencyAnswer::from),
        }
    }
}

impl From<&Forms> for FormsAnswer {
    fn from(forms: &Forms) -> Self {
        Self {
            chosen: forms.chosen.name(),
            rows: forms.rows.iter().map(FormAnswer::from).collect(),
        }
    }
}

impl From<&FormFit> for FormAnswer {
    fn from(fit: &FormFit) -> Self {
        let own = |of: fn(Broad) -> (f64, Option<f64>)| {
            fit.parameters.map(|parameters| of(parameters).into())
        };
        Self {
            form: fit.form.name(),
            numbers: fit.numbers,
            residual_rms: fit.residual_rms,
            held_out_rms: fit.held_out_rms,
            time_constants_from_s: fit.span.map(|span| span.0),
            time_constants_to_s: fit.span.map(|span| span.1),
            settles_at: own(|parameters| parameters.settles),
            relaxes: own(|parameters| parameters.relaxes),
            tau_s: own(|parameters| parameters.tau),
            beta: own(|parameters| parameters.beta),
        }
    }
}

impl From<&Latency> for LatencyAnswer {
    fn from(latency: &Latency) -> Self {
        let (slope, intercept) = latency.law.line();
        Self {
            v1_per_s: latency.law.rate,
            v1_standard_error_per_s: latency.fit.standard_error(Parameter::Rate(1)),
            c0: latency.law.constant,
            settles_at: latency.settles.0,
            settles_at_standard_error: latency.settles.1,
            strain_of: latency.scale.into(),
            equilibrium_strain: latency.law.equilibrium(),
            strain_rate_slope_per_s: slope,
            strain_rate_intercept_per_s: intercept,
            half_time_s: latency.time_with_left(0.5).and_then(finite),
            time_to_99_percent_s: latency.time_with_left(1.0 - OVER).and_then(finite),
            r_squared: latency.fit.r_squared,
        }
    }
}

impl From<StrainScale> for StrainReference {
    fn from(scale: StrainScale) -> Self {
        match scale {
            StrainScale::OfHeight => Self::Height,
            StrainScale::OfEquilibrium => Self::Equilibrium,
        }
    }
}
