//! `palpate markers`: the law of the gaps between markers.

use palpate_analysis::markers::{Gap, Study};
use serde::Serialize;

use super::finite;

/// The latency model of the gaps between markers, e' = −ν sgn e |e|^n, e the distance of the gap from its equilibrium.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct MarkersAnswer {
    /// Version of this answer.
    pub palpate_markers: u32,
    /// The order n of all gaps; null where each has its own.
    pub order: Option<f64>,
    /// Hold by hold, gap by gap.
    pub gaps: Vec<GapAnswer>,
}

/// One gap in one hold.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct GapAnswer {
    /// Name of the trace.
    pub trace: String,
    /// The two columns; one where the trace has a single marker.
    pub between: Vec<String>,
    /// Time at which the hold began, s.
    pub from_s: f64,
    /// How long it lasted, s; null for a hold without samples.
    pub duration_s: Option<f64>,
    /// The order n.
    pub order: f64,
    /// Its standard error; null where the order was given.
    pub order_standard_error: Option<f64>,
    /// The rate ν, 1/s, at a distance of 1 mm; null where it is beyond all numbers.
    pub rate_per_s: Option<f64>,
    /// Standard error of ln ν; null where the data do not determine it.
    pub rate_logarithm_standard_error: Option<f64>,
    /// The gap at first, mm.
    pub initial_mm: f64,
    /// Its standard error, mm; null where the data do not determine it.
    pub initial_mm_standard_error: Option<f64>,
    /// The equilibrium of the gap, mm.
    pub equilibrium_mm: f64,
    /// Its standard error, mm; null where the data do not determine it.
    pub equilibrium_mm_standard_error: Option<f64>,
    /// Share of the distance from equilibrium that is left at the end of the hold, 0 to 1.
    pub gap_left_at_the_end: f64,
    /// Standard deviation of the residuals, mm; null where it is beyond all numbers.
    pub residual_rms_mm: Option<f64>,
    /// Lowest and highest odd order that fit as well as the best.
    pub odd_orders_that_fit: [f64; 2],
    /// What the hold does not identify, in sentences.
    pub not_identified: Vec<String>,
}

impl From<&Study> for MarkersAnswer {
    fn from(study: &Study) -> Self {
        Self {
            palpate_markers: 1,
            order: study.order,
            gaps: study.gaps.iter().map(GapAnswer::from).collect(),
        }
    }
}

impl From<&Gap> for GapAnswer {
    fn from(gap: &Gap) -> Self {
        let fit = &gap.fit;
        Self {
            trace: gap.trace.clone(),
            between: gap.between.clone(),
            from_s: gap.from_s,
            duration_s: gap.time.last().copied(),
            order: fit.order.0,
            order_standard_error: fit.order.1,
            rate_per_s: finite(fit.rate.0),
            rate_logarithm_standard_error: fit.rate.1,
            initial_mm: fit.initial.0,
            initial_mm_standard_error: fit.initial.1,
            equilibrium_mm: fit.equilibrium.0,
            equilibrium_mm_standard_error: fit.equilibrium.1,
            gap_left_at_the_end: fit.left,
            residual_rms_mm: finite(fit.noise),
            odd_orders_that_fit: gap.odd_orders.into(),
            not_identified: fit.doubts.clone(),
        }
    }
}
