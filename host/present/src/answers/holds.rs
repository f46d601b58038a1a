//! `palpate fit --hold-only`: a sum of exponentials for each hold, and its spread over repeats.

use std::collections::BTreeMap;

use palpate_analysis::regions::type_name;
use palpate_fit::exponentials::{Fit, Parameter, Stop};
use palpate_fit::hold::{HoldError, HoldFit, Spread, spreads};
use serde::Serialize;

use super::finite;
use crate::summary::{NO_BETTER, hold_warnings, unit_of};

/// The relaxation function of every hold.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct HoldsAnswer {
    /// Version of this answer.
    pub palpate_fit: u32,
    /// The law that was fitted: always `relaxation`.
    pub law: &'static str,
    /// The column that was fitted.
    pub signal: String,
    /// Unit of the signal.
    pub unit: String,
    /// Every hold that could be fitted.
    pub holds: Vec<HoldFitAnswer>,
    /// Each coefficient over holds of one type at one displacement.
    pub spread: Vec<SpreadAnswer>,
    /// Why other holds could not be fitted, a sentence each.
    pub left_out: Vec<String>,
    /// What a reader should beware of, each remark with its hold.
    pub warnings: Vec<String>,
}

/// The fit of one hold.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct HoldFitAnswer {
    /// Name of the trace.
    pub trace: String,
    /// When the hold began, s.
    pub from_s: f64,
    /// How long it lasted, s.
    pub duration_s: f64,
    /// Displacement during the hold, mm; null where it was not recorded.
    pub displacement_mm: Option<f64>,
    /// Which way the signal went: `Type I` relaxes down or creeps up towards its equilibrium, `Type II` the other way.
    #[serde(rename = "type")]
    pub relaxation: String,
    /// The parameters by name: `N`, `c0` to `cn`, `v1` to `vn`.
    pub parameters: BTreeMap<String, HoldParameter>,
    /// Correlations between them.
    pub correlation: CorrelationAnswer,
    /// Number of samples fitted.
    pub samples: usize,
    /// Coefficient of determination.
    pub r_squared: f64,
    /// Root mean square of the residual, in the unit of the signal.
    pub residual_rms: f64,
    /// Correlation between a residual and the next; null where the standard errors are those of white noise.
    pub residual_autocorrelation: Option<f64>,
    /// Correlation time of the residual, s; null where the standard errors are those of white noise.
    pub correlation_time_s: Option<f64>,
    /// How many times those of white noise the standard errors are, at most; null where they are those of white noise.
    pub error_over_white_noise: Option<f64>,
    /// Whether the fit converged and is better than a constant.
    pub converged: bool,
    /// Why the iteration ended.
    pub stop: String,
    /// What is held at a bound or not identifiable.
    pub notes: Vec<String>,
}

/// A parameter of a hold.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct HoldParameter {
    /// Its value: of `N` in the unit of the signal, of a coefficient a pure number, of a rate 1/s.
    pub value: f64,
    /// Its standard error, in the same unit; null where the data do not determine it.
    pub standard_error: Option<f64>,
    /// Its 95 % interval; null where the data do not determine it, a null end where no number can hold it.
    pub interval_95: Option<[Option<f64>; 2]>,
}

/// Correlations between parameters.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct CorrelationAnswer {
    /// Names of the parameters, in the order of rows and columns.
    pub order: Vec<String>,
    /// The correlations, row by row, −1 to 1; null where the data do not determine one of the two.
    pub matrix: Vec<Vec<Option<f64>>>,
}

/// One coefficient over repeats.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SpreadAnswer {
    /// Type of the holds: `Type I` or `Type II`.
    #[serde(rename = "type")]
    pub relaxation: String,
    /// Name of the coefficient.
    pub parameter: String,
    /// Number of holds.
    pub holds: usize,
    /// Mean over the holds.
    pub mean: f64,
    /// Sample standard deviation over the holds.
    pub standard_deviation: f64,
    /// Standard deviation that the standard errors of the holds explain; null where one has none.
    pub expected_from_noise: Option<f64>,
    /// Mean weighted by the standard errors; null where one has none.
    pub weighted_mean: Option<f64>,
    /// Its standard error; null where there is no weighted mean.
    pub weighted_mean_standard_error: Option<f64>,
    /// χ² of the holds about the weighted mean; null where there is none.
    pub chi_square: Option<f64>,
    /// Its degrees of freedom; null where there is no χ².
    pub degrees_of_freedom: Option<usize>,
    /// p value of as much scatter from the standard errors alone; null where there is no χ².
    pub p_value: Option<f64>,
    /// The displacement held, mm; null where it was not recorded, absent where a force was held.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement_mm: Option<Option<f64>>,
    /// The force held, N; null where it was not recorded, absent where a displacement was held.
    #[serde(rename = "force_N", skip_serializing_if = "Option::is_none")]
    pub force_n: Option<Option<f64>>,
}

impl HoldsAnswer {
    /// The holds of a signal.
    #[must_use]
    pub fn of(fits: &[HoldFit], left_out: &[HoldError], signal: &str) -> Self {
        Self {
            palpate_fit: 1,
            law: "relaxation",
            signal: signal.to_owned(),
            unit: unit_of(signal).to_owned(),
            holds: fits.iter().map(HoldFitAnswer::from).collect(),
            spread: spreads(fits).iter().map(SpreadAnswer::at_displacement).collect(),
            left_out: left_out.iter().map(ToString::to_string).collect(),
            warnings: hold_warnings(fits),
        }
    }
}

impl SpreadAnswer {
    /// Over holds of one displacement.
    #[must_use]
    pub fn at_displacement(spread: &Spread) -> Self {
        Self { displacement_mm: Some(spread.level), ..Self::of(spread) }
    }

    /// Over holds of one force.
    #[must_use]
    pub fn at_force(spread: &Spread) -> Self {
        Self { force_n: Some(spread.level), ..Self::of(spread) }
    }

    fn of(spread: &Spread) -> Self {
        let consistency = spread.consistency;
        Self {
            relaxation: type_name(spread.relaxation),
            parameter: spread.parameter.to_string(),
            holds: spread.holds,
            mean: spread.mean,
            standard_deviation: spread.deviation,
            expected_from_noise: spread.expected,
            weighted_mean: consistency.map(|found| found.mean),
            weighted_mean_standard_error: consistency.map(|found| found.standard_error),
            chi_square: consistency.map(|found| found.chi_square),
            degrees_of_freedom: consistency.map(|found| found.degrees_of_freedom),
            p_value: consistency.map(|found| found.p_value),
            displacement_mm: None,
            force_n: None,
        }
    }
}

impl From<&HoldFit> for HoldFitAnswer {
    fn from(hold: &HoldFit) -> Self {
        let fit = &hold.fit;
        let correlated = fit.correlated.as_ref();
        let (converged, stop) = if fit.explains() {
            (fit.stop != Stop::Iterations, fit.stop.to_string())
        } else {
            (false, NO_BETTER.to_owned())
        };
        Self {
            trace: hold.trace.clone(),
            from_s: hold.from_s,
            duration_s: hold.duration_s,
            displacement_mm: hold.displacement,
            relaxation: type_name(hold.relaxation),
            parameters: parameters(fit),
            correlation: CorrelationAnswer::from(fit),
            samples: fit.samples,
            r_squared: fit.r_squared,
            residual_rms: fit.residual_rms,
            residual_autocorrelation: correlated.map(|found| found.neighbours),
            correlation_time_s: correlated.map(|found| found.time),
            error_over_white_noise: correlated.map(|found| found.inflation),
            converged,
            stop,
            notes: fit.notes.iter().map(ToString::to_string).collect(),
        }
    }
}

/// The parameters of a hold by name.
fn parameters(fit: &Fit) -> BTreeMap<String, HoldParameter> {
    let one = |parameter: Parameter| {
        let interval = fit.interval(parameter, 0.95);
        let value = HoldParameter {
            value: fit.value(parameter)?,
            standard_error: fit.standard_error(parameter).and_then(finite),
            interval_95: interval.map(|(from, to)| [finite(from), finite(to)]),
        };
        Some((parameter.to_string(), value))
    };
    fit.parameters().filter_map(one).collect()
}

impl From<&Fit> for CorrelationAnswer {
    fn from(fit: &Fit) -> Self {
        let row = |a| fit.parameters().map(|b| fit.correlation(a, b).and_then(finite)).collect();
        Self {
            order: fit.parameters().map(|parameter| parameter.to_string()).collect(),
            matrix: fit.parameters().map(row).collect(),
        }
    }
}
