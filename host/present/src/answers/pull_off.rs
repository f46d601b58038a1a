//! Pull-offs of adhesive contacts, and how they grow with the speed of the retreat.

use palpate_analysis::pull_off::PullOff;
use palpate_analysis::pull_off_growth::{AtSpeed, Growth, Law};
use palpate_trace::Trace;
use serde::Serialize;

use super::Uncertain;

/// A contact that came off. Forces count from the force after the separation; a pull is positive.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct PullOffAnswer {
    /// Mean speed of the indenter while the specimen pulls, mm/s.
    pub speed_mm_per_s: f64,
    /// Largest pull, N.
    #[serde(rename = "force_N")]
    pub force_n: f64,
    /// Its standard error from the noise of the force, N.
    #[serde(rename = "force_standard_error_N")]
    pub force_standard_error_n: f64,
    /// Time of the largest pull, s.
    pub time_s: f64,
    /// Displacement at the largest pull, mm.
    pub displacement_mm: f64,
    /// Displacement at which the pull is gone, mm; negative above the first touch.
    pub separation_mm: f64,
    /// Work of adhesion, mJ: the area under the pull over displacement.
    #[serde(rename = "work_of_adhesion_mJ")]
    pub work_of_adhesion_mj: f64,
    /// Its standard error from the noise of the force, mJ.
    #[serde(rename = "work_of_adhesion_standard_error_mJ")]
    pub work_of_adhesion_standard_error_mj: f64,
    /// Recorded force after the separation, N.
    #[serde(rename = "zero_N")]
    pub zero_n: f64,
}

/// How pull-offs grow with the speed of the retreat.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct PullOffGrowthAnswer {
    /// Means at each speed, the slowest first.
    pub speeds: Vec<PullOffsAtSpeed>,
    /// Slope of the logarithm of the force over that of the speed; null for fewer than three speeds.
    pub exponent_of_a_power: Option<Uncertain>,
    /// The law F = F0 (1 + (v/v0)^n); null where it is not identifiable.
    pub law: Option<PullOffLaw>,
    /// Why the law is not identifiable; null where it is.
    pub not_identifiable: Option<String>,
}

/// Pull-offs at one speed. Standard errors are from the scatter, that of a single pull-off from the noise.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct PullOffsAtSpeed {
    /// Mean speed of the indenter while the specimen pulls, mm/s.
    pub speed_mm_per_s: f64,
    /// Number of pull-offs.
    pub pull_offs: usize,
    /// Mean pull-off force, N.
    #[serde(rename = "force_N")]
    pub force_n: Uncertain,
    /// Mean work of adhesion, mJ.
    #[serde(rename = "work_of_adhesion_mJ")]
    pub work_of_adhesion_mj: Uncertain,
    /// Mean displacement at which the pull is gone, mm.
    pub separation_mm: Uncertain,
}

/// The law F = F0 (1 + (v/v0)^n).
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct PullOffLaw {
    /// Force at rest F0, N.
    #[serde(rename = "F0_N")]
    pub force_n: Uncertain,
    /// Speed v0 at which the force has doubled, mm/s.
    #[serde(rename = "v0_mm_per_s")]
    pub speed_mm_per_s: Uncertain,
    /// Exponent n.
    #[serde(rename = "n")]
    pub exponent: Uncertain,
}

impl PullOffAnswer {
    /// A pull-off of this trace.
    #[must_use]
    pub fn of(trace: &Trace, pull: &PullOff) -> Self {
        Self {
            speed_mm_per_s: pull.speed_mm_per_s,
            force_n: pull.force_n,
            force_standard_error_n: pull.force_error_n,
            time_s: trace.time[pull.sample],
            displacement_mm: pull.displacement_mm,
            separation_mm: pull.separation_mm,
            work_of_adhesion_mj: pull.work_mj,
            work_of_adhesion_standard_error_mj: pull.work_error_mj,
            zero_n: pull.zero_n,
        }
    }
}

impl From<&Growth> for PullOffGrowthAnswer {
    fn from(growth: &Growth) -> Self {
        Self {
            speeds: growth.speeds.iter().map(PullOffsAtSpeed::from).collect(),
            exponent_of_a_power: growth.slope.map(Uncertain::from),
            law: growth.law.as_ref().ok().map(PullOffLaw::from),
            not_identifiable: growth.law.as_ref().err().cloned(),
        }
    }
}

impl From<&AtSpeed> for PullOffsAtSpeed {
    fn from(speed: &AtSpeed) -> Self {
        Self {
            speed_mm_per_s: speed.speed_mm_per_s,
            pull_offs: speed.count,
            force_n: speed.force_n.into(),
            work_of_adhesion_mj: speed.work_mj.into(),
            separation_mm: speed.separation_mm.into(),
        }
    }
}

impl From<&Law> for PullOffLaw {
    fn from(law: &Law) -> Self {
        Self {
            force_n: law.force_n.into(),
            speed_mm_per_s: law.speed_mm_per_s.into(),
            exponent: law.exponent.into(),
        }
    }
}
