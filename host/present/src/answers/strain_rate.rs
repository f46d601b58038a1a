//! `palpate strain-rate`: strain, strain rate and the power law of every hold.

use palpate_analysis::derivative::Derivative;
use palpate_analysis::regions::type_name;
use palpate_analysis::segment_run::SegmentRun;
use palpate_analysis::strain_rate::{Hold, Study};
use serde::Serialize;

use super::finite;

/// The power law ε̇ = −ν sgn(ε − ε_e) |ε − ε_e|^n of every hold (7.2).
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct StrainRateAnswer {
    /// Version of this answer.
    pub palpate_strain_rate: u32,
    /// Young's modulus E of the strain, Pa.
    #[serde(rename = "modulus_Pa")]
    pub modulus_pa: f64,
    /// The order n of all holds; null where each has its own.
    pub order: Option<f64>,
    /// Sign of every strain.
    pub strain: String,
    /// The holds, in order.
    pub holds: Vec<StrainRateHold>,
    /// The motion of each trace through segments (7.11); absent where it was not asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub simulated: Option<Vec<SimulatedRun>>,
}

/// The power law of one hold.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct StrainRateHold {
    /// Name of the trace.
    pub trace: String,
    /// Time at which the hold began, s.
    pub from_s: f64,
    /// How long it lasted, s.
    pub duration_s: f64,
    /// Displacement of the hold, mm.
    pub displacement_mm: f64,
    /// Area of contact, mm².
    pub area_mm2: f64,
    /// `Type I` after loading, `Type II` after unloading.
    #[serde(rename = "type")]
    pub kind: String,
    /// The order n.
    pub order: f64,
    /// Its standard error; null where the order was given.
    pub order_standard_error: Option<f64>,
    /// The rate ν, 1/s; null where it is beyond all numbers.
    pub rate_per_s: Option<f64>,
    /// Standard error of ln ν; null where the data do not determine it.
    pub rate_logarithm_standard_error: Option<f64>,
    /// Equilibrium strain ε_e.
    pub equilibrium_strain: f64,
    /// Its standard error; null where the data do not determine it.
    pub equilibrium_strain_standard_error: Option<f64>,
    /// First strain of the hold less the equilibrium strain.
    pub gap: f64,
    /// Its standard error; null where the data do not determine it.
    pub gap_standard_error: Option<f64>,
    /// Correlation of the estimates of ln ν and n, −1 to 1; null where the order was given.
    pub correlation_of_log_rate_and_order: Option<f64>,
    /// Share of that gap that is left at the end of the hold, 0 to 1.
    pub gap_left_at_the_end: f64,
    /// Standard deviation of the residuals of the strain; null where it is beyond all numbers.
    pub residual_rms: Option<f64>,
    /// Coefficient of determination; null where the strain does not vary.
    pub r_squared: Option<f64>,
    /// Lowest and highest odd order that fit as well as the best.
    pub odd_orders_that_fit: [f64; 2],
    /// What the hold does not identify, in sentences.
    pub not_identified: Vec<String>,
    /// The strain rate that figures show; null for too few samples.
    pub derivative: Option<DerivativeAnswer>,
}

/// What a derivative can show.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct DerivativeAnswer {
    /// Samples within so much time on each side are used, s.
    pub half_width_s: f64,
    /// Frequency at which the slope of a sine comes out 3 dB too small, Hz; null where the samples are too few.
    #[serde(rename = "bandwidth_Hz")]
    pub bandwidth_hz: Option<f64>,
    /// Standard deviation of the derivative for noise of standard deviation 1, 1/s.
    pub noise_gain_per_s: f64,
}

/// The motion of a trace through segments that relax one after the other (7.4), beside the measured force.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SimulatedRun {
    /// Name of the trace.
    pub trace: String,
    /// Number of segments from the face to what does not move.
    pub segments: usize,
    /// The order n.
    pub order: f64,
    /// The rate ν, 1/s; null where it is beyond all numbers.
    pub rate_per_s: Option<f64>,
    /// Whether the rate was fitted to the measured force.
    pub rate_fitted: bool,
    /// Young's modulus E, Pa.
    #[serde(rename = "modulus_Pa")]
    pub modulus_pa: f64,
    /// Root mean square difference of the forces, N; null where it is beyond all numbers.
    #[serde(rename = "rms_N")]
    pub rms_n: Option<f64>,
    /// The modulus that fits best with this rate, Pa; null where the simulated force is zero.
    #[serde(rename = "best_modulus_Pa")]
    pub best_modulus_pa: Option<f64>,
}

impl StrainRateAnswer {
    /// The holds of a study, and its simulations where they were asked for.
    #[must_use]
    pub fn of(study: &Study, simulated: Option<&[SegmentRun]>) -> Self {
        Self {
            palpate_strain_rate: 1,
            modulus_pa: study.modulus_pa,
            order: study.order,
            strain: "positive in compression".to_owned(),
            holds: study.holds.iter().map(StrainRateHold::from).collect(),
            simulated: simulated.map(|runs| runs.iter().map(SimulatedRun::from).collect()),
        }
    }
}

impl From<&Hold> for StrainRateHold {
    fn from(hold: &Hold) -> Self {
        let fit = &hold.fit;
        Self {
            trace: hold.trace.clone(),
            from_s: hold.from_s,
            duration_s: hold.duration_s,
            displacement_mm: hold.displacement_mm,
            area_mm2: hold.area_mm2,
            kind: type_name(hold.relaxation),
            order: fit.order.0,
            order_standard_error: fit.order.1,
            rate_per_s: finite(fit.rate.0),
            rate_logarithm_standard_error: fit.rate.1,
            equilibrium_strain: fit.equilibrium.0,
            equilibrium_strain_standard_error: fit.equilibrium.1,
            gap: fit.gap.0,
            gap_standard_error: fit.gap.1,
            correlation_of_log_rate_and_order: fit.trade_off,
            gap_left_at_the_end: fit.left,
            residual_rms: finite(fit.noise),
            r_squared: finite(fit.r_squared),
            odd_orders_that_fit: hold.odd_orders.into(),
            not_identified: fit.doubts.clone(),
            derivative: hold.measured.as_ref().map(DerivativeAnswer::from),
        }
    }
}

impl From<&Derivative> for DerivativeAnswer {
    fn from(found: &Derivative) -> Self {
        Self {
            half_width_s: found.half_width_s,
            bandwidth_hz: found.bandwidth_hz,
            noise_gain_per_s: found.noise_gain,
        }
    }
}

impl From<&SegmentRun> for SimulatedRun {
    fn from(run: &SegmentRun) -> Self {
        let setting = &run.setting;
        Self {
            trace: run.trace.clone(),
            segments: setting.segments,
            order: setting.order,
            rate_per_s: finite(setting.rate),
            rate_fitted: run.fitted,
            modulus_pa: setting.modulus_pa,
            rms_n: finite(run.rms_n),
            best_modulus_pa: finite(run.best_modulus_pa),
        }
    }
}
