//! `palpate fit`: a law fitted to whole motions.

use std::collections::BTreeMap;

use palpate_fit::whole_motion::{Basis, MotionFit};
use serde::Serialize;

use super::{CorrelationAnswer, finite};
use crate::summary::{FitSummary, unit_of};

/// A law fitted to whole motions.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct FitAnswer {
    /// Version of this answer.
    pub palpate_fit: u32,
    /// Name of the law.
    pub law: &'static str,
    /// Number of exponentials or branches; 1 where the law has no choice.
    pub terms: usize,
    /// What happens where contact breaks: `clamp`, `free` or `bonded`.
    pub separation: &'static str,
    /// Number of segments of a latency model; null where c0 is a parameter, and for other laws.
    pub segments: Option<u32>,
    /// Exponent n of the nonlinear latency model; null where it is a parameter, and for other laws.
    pub exponent: Option<f64>,
    /// Name of the elastic response.
    pub elastic: &'static str,
    /// Name of the kernel of relaxation.
    pub relaxation: &'static str,
    /// The column that was fitted.
    pub signal: String,
    /// Unit of the signal, and of every error.
    pub unit: String,
    /// The parameters by name.
    pub parameters: BTreeMap<String, FittedParameter>,
    /// Correlations between them.
    pub correlation: CorrelationAnswer,
    /// Number of samples fitted.
    pub samples: usize,
    /// Coefficient of determination over all samples.
    pub r_squared: f64,
    /// Root mean square of the residual.
    pub residual_rms: f64,
    /// Standard deviation of the noise; null where the recordings do not show it without a model.
    pub noise_rms: Option<f64>,
    /// Held-out error over all traces, each left out in turn; null for a single trace.
    pub heldout_rms: Option<f64>,
    /// Correlation between a residual and the next, which the standard errors allow for.
    pub residual_autocorrelation: f64,
    /// What standard errors and correlations rest on.
    pub standard_errors: FitErrorBasis,
    /// Whether a minimum was reached.
    pub converged: bool,
    /// Why the search stopped.
    pub stop: String,
    /// Number of steps tried.
    pub iterations: usize,
    /// The error of each trace.
    pub traces: Vec<TraceError>,
    /// What a reader should beware of.
    pub warnings: Vec<String>,
}

/// What standard errors of a fit rest on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub enum FitErrorBasis {
    /// The residual and how its neighbours correlate.
    #[serde(rename = "residual")]
    Residual,
    /// The scatter of refits without each trace: the law leaves more than noise.
    #[serde(rename = "jackknife over traces")]
    Jackknife,
}

impl From<Basis> for FitErrorBasis {
    fn from(basis: Basis) -> Self {
        match basis {
            Basis::Samples => Self::Residual,
            Basis::Traces => Self::Jackknife,
        }
    }
}

/// A fitted parameter.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct FittedParameter {
    /// The value, in `unit`.
    pub value: f64,
    /// Its standard error, in `unit`; null where the data do not determine it.
    pub standard_error: Option<f64>,
    /// Unit, empty for a pure number.
    pub unit: String,
    /// Whether it ended on a bound of what physics or the sampling allows.
    pub at_bound: bool,
}

/// The error of one trace.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct TraceError {
    /// Name of the trace.
    pub trace: String,
    /// Root mean square of the residual.
    pub rms: f64,
    /// Root mean square error when it is left out of the fit; null for a single trace.
    pub heldout_rms: Option<f64>,
}

impl From<&FitSummary<'_>> for FitAnswer {
    fn from(summary: &FitSummary) -> Self {
        let fit = summary.fit;
        let law = &fit.chain.base;
        let trace = |(k, label): (usize, &String)| TraceError {
            trace: label.clone(),
            rms: fit.trace_rms[k],
            heldout_rms: summary.held_out.get(k).copied().and_then(finite),
        };
        Self {
            palpate_fit: 1,
            law: law.name(),
            terms: law.terms,
            separation: law.separation.name(),
            segments: law.segments,
            exponent: law.exponent,
            elastic: law.elastic.name(),
            relaxation: law.kernel.name,
            signal: summary.signal.to_owned(),
            unit: unit_of(summary.signal).to_owned(),
            parameters: parameters(fit),
            correlation: CorrelationAnswer::from(fit),
            samples: fit.samples,
            r_squared: fit.r_squared,
            residual_rms: fit.rms(),
            noise_rms: summary.noise.map(|noise| noise.standard_deviation),
            heldout_rms: summary.held_out_rms().and_then(finite),
            residual_autocorrelation: fit.autocorrelation,
            standard_errors: fit.basis.into(),
            converged: fit.stop.converged(),
            stop: fit.stop.to_string(),
            iterations: fit.iterations,
            traces: summary.data.labels.iter().enumerate().map(trace).collect(),
            warnings: summary.warnings(),
        }
    }
}

/// The parameters by name.
fn parameters(fit: &MotionFit) -> BTreeMap<String, FittedParameter> {
    let declared = fit.parameters().into_iter().enumerate();
    let one = |(k, parameter): (usize, palpate_model::Parameter)| {
        let fitted = FittedParameter {
            value: fit.values[k],
            standard_error: fit.standard_errors[k].and_then(finite),
            unit: parameter.unit.to_string(),
            at_bound: fit.at_bound[k],
        };
        (parameter.name.to_string(), fitted)
    };
    declared.map(one).collect()
}

impl From<&MotionFit> for CorrelationAnswer {
    fn from(fit: &MotionFit) -> Self {
        let parameters = fit.parameters();
        Self {
            order: parameters.iter().map(|parameter| parameter.name.to_string()).collect(),
            matrix: fit
                .correlation
                .row_iter()
                .map(|row| row.iter().copied().map(finite).collect())
                .collect(),
        }
    }
}
