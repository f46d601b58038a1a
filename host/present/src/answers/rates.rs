//! `palpate rates`: one specimen at several loading rates.

use palpate_analysis::rates::{Group, Run, Study, Trend};
use serde::Serialize;

use super::finite;
use crate::summary::rates_warnings;

/// One specimen at several loading rates (chapter 5).
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct RatesAnswer {
    /// Version of this answer.
    pub palpate_rates: u32,
    /// Rate v1 of the relaxation over all runs, 1/s.
    pub v1_per_s: f64,
    /// Its standard error, 1/s; null where the runs do not determine it.
    pub v1_standard_error_per_s: Option<f64>,
    /// p value of the differences of v1 between the runs by their standard errors; null where they have none.
    pub v1_agree_p_value: Option<f64>,
    /// Specific stiffness k_s over all runs, Pa (5.6); null where a hold presses nothing in.
    #[serde(rename = "specific_stiffness_Pa")]
    pub specific_stiffness_pa: Option<f64>,
    /// Its standard error, Pa; null where the runs do not determine it.
    #[serde(rename = "specific_stiffness_standard_error_Pa")]
    pub specific_stiffness_standard_error_pa: Option<f64>,
    /// p value of the differences of k_s between the runs by their standard errors; null where they have none.
    pub specific_stiffness_agree_p_value: Option<f64>,
    /// Every loading with its hold.
    pub runs: Vec<RateRun>,
    /// The runs at each displacement.
    pub groups: Vec<RateGroup>,
    /// What to beware of.
    pub warnings: Vec<String>,
}

/// One loading and the hold after it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct RateRun {
    /// Name of the trace.
    pub trace: String,
    /// Rate of the loading, mm/s.
    pub rate_mm_per_s: f64,
    /// Displacement of the hold, mm.
    pub displacement_mm: f64,
    /// Largest force of the loading, N: mean of five samples.
    #[serde(rename = "peak_N")]
    pub peak_n: f64,
    /// Its standard error, N; null where the noise of the force cannot be estimated.
    #[serde(rename = "peak_standard_error_N")]
    pub peak_standard_error_n: Option<f64>,
    /// Asymptotic force of the hold, N (5.3).
    #[serde(rename = "asymptote_N")]
    pub asymptote_n: f64,
    /// Its standard error, N; null where the data do not determine it.
    #[serde(rename = "asymptote_standard_error_N")]
    pub asymptote_standard_error_n: Option<f64>,
    /// Rate v1 of the relaxation, 1/s.
    pub v1_per_s: f64,
    /// Its standard error, 1/s; null where the data do not determine it.
    pub v1_standard_error_per_s: Option<f64>,
    /// Nominal area of contact in the hold, mm² (5.5).
    pub area_mm2: f64,
    /// Equilibrium strain (5.8), positive in compression.
    pub equilibrium_strain: f64,
    /// Specific stiffness k_s of this run, Pa (5.6); null where the hold presses nothing in.
    #[serde(rename = "specific_stiffness_Pa")]
    pub specific_stiffness_pa: Option<f64>,
    /// Its standard error, Pa; null where the data do not determine it.
    #[serde(rename = "specific_stiffness_standard_error_Pa")]
    pub specific_stiffness_standard_error_pa: Option<f64>,
    /// Coefficient of determination of the fit of the hold.
    pub r_squared: f64,
    /// Remarks on the fit of the hold.
    pub notes: Vec<String>,
}

/// Runs at one displacement.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct RateGroup {
    /// The displacement, mm.
    pub displacement_mm: f64,
    /// Number of runs.
    pub runs: usize,
    /// Weighted mean of the asymptotic forces, N; null for a single run, or without standard errors.
    #[serde(rename = "asymptote_N")]
    pub asymptote_n: Option<f64>,
    /// Sum of their squared deviations from that mean, in standard errors; null as `asymptote_N`.
    pub asymptotes_chi_square: Option<f64>,
    /// p value of that sum if all were the same; null as `asymptote_N`.
    pub asymptotes_agree_p_value: Option<f64>,
    /// The asymptotic force over the rate; null for fewer than three different rates.
    pub asymptote_trend: Option<RateTrend>,
    /// Sum of the squared deviations of the peaks from their weighted mean, in standard errors; null for a single run, or without
    /// standard errors.
    pub peaks_chi_square: Option<f64>,
    /// p value of that sum if all were the same; null as `peaks_chi_square`.
    pub peaks_agree_p_value: Option<f64>,
    /// The peak over the rate; null for fewer than three different rates.
    pub peak_trend: Option<RateTrend>,
}

/// A straight line over the logarithm of the loading rate.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct RateTrend {
    /// Slope, N for ten times the rate.
    #[serde(rename = "slope_N_per_decade")]
    pub slope_n_per_decade: f64,
    /// Its standard error, N; null where the data do not determine it.
    #[serde(rename = "standard_error_N")]
    pub standard_error_n: Option<f64>,
    /// p value of so steep a slope if the rate made no difference.
    pub p_value: f64,
    /// Sum of the squared deviations from the line, in standard errors; null where the values have none.
    pub off_line_chi_square: Option<f64>,
    /// p value of that sum if the values lay on the line but for their errors; null where they have none.
    pub off_line_p_value: Option<f64>,
}

impl From<&Study> for RatesAnswer {
    fn from(study: &Study) -> Self {
        Self {
            palpate_rates: 1,
            v1_per_s: study.v1.0,
            v1_standard_error_per_s: study.v1.1,
            v1_agree_p_value: study.agreement.0.map(|test| test.p_value),
            specific_stiffness_pa: finite(study.stiffness_pa.0),
            specific_stiffness_standard_error_pa: study.stiffness_pa.1,
            specific_stiffness_agree_p_value: study.agreement.1.map(|test| test.p_value),
            runs: study.runs.iter().map(RateRun::from).collect(),
            groups: study.groups.iter().map(RateGroup::from).collect(),
            warnings: rates_warnings(study),
        }
    }
}

impl From<&Run> for RateRun {
    fn from(run: &Run) -> Self {
        Self {
            trace: run.trace.clone(),
            rate_mm_per_s: run.rate_mm_per_s,
            displacement_mm: run.displacement_mm,
            peak_n: run.peak_n.0,
            peak_standard_error_n: run.peak_n.1,
            asymptote_n: run.asymptote_n.0,
            asymptote_standard_error_n: run.asymptote_n.1,
            v1_per_s: run.v1.0,
            v1_standard_error_per_s: run.v1.1,
            area_mm2: run.area_mm2,
            equilibrium_strain: run.equilibrium_strain,
            specific_stiffness_pa: finite(run.stiffness_pa.0),
            specific_stiffness_standard_error_pa: run.stiffness_pa.1,
            r_squared: run.fit.r_squared,
            notes: run.fit.notes.iter().map(ToString::to_string).collect(),
        }
    }
}

impl From<&Group> for RateGroup {
    fn from(group: &Group) -> Self {
        Self {
            displacement_mm: group.displacement_mm,
            runs: group.runs.len(),
            asymptote_n: group.asymptotes.map(|test| test.mean),
            asymptotes_chi_square: group.asymptotes.map(|test| test.chi_square),
            asymptotes_agree_p_value: group.asymptotes.map(|test| test.p_value),
            asymptote_trend: group.asymptote_trend.as_ref().map(RateTrend::from),
            peaks_chi_square: group.peaks.map(|test| test.chi_square),
            peaks_agree_p_value: group.peaks.map(|test| test.p_value),
            peak_trend: group.peak_trend.as_ref().map(RateTrend::from),
        }
    }
}

impl From<&Trend> for RateTrend {
    fn from(trend: &Trend) -> Self {
        Self {
            slope_n_per_decade: trend.slope_n.0,
            standard_error_n: trend.slope_n.1,
            p_value: trend.p_value,
            off_line_chi_square: trend.off_line.map(|off| off.chi_square),
            off_line_p_value: trend.off_line.map(|off| off.p_value),
        }
    }
}
