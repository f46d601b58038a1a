//! `palpate grasp watch`: the margin as it comes, one answer a line.

use palpate_contact::grasp::live::{Hold, Reading};
use serde::Serialize;

use crate::answers::finite;

/// How a grasp is at one time.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct GraspWatchAnswer {
    /// Version of this answer.
    pub palpate_grasp_reading: u32,
    /// Time, s.
    pub time_s: f64,
    /// How the grasp is, in a word.
    pub state: GraspState,
    /// Forces and margin now.
    pub now: GraspHoldAnswer,
    /// Forces and margin once settled.
    pub settled: GraspHoldAnswer,
    /// Compression of a contact that grows, mm; null for one of a fixed size.
    pub compression_mm: Option<f64>,
    /// Time until it slips if nothing moves, s; null where it does not, or where it is not known how the gauges relax.
    pub slips_in_s: Option<f64>,
    /// Normal force to add now so that it holds until it has settled, N; null where nothing need be added or it is not
    /// known.
    #[serde(rename = "tighten_N")]
    pub tighten_n: Option<f64>,
}

/// How a grasp is, in a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum GraspState {
    /// Nothing is held.
    None,
    /// It slips now.
    Slips,
    /// It holds now, and will slip once settled.
    WillSlip,
    /// It holds.
    Holds,
}

/// Forces and margin, now or once settled.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct GraspHoldAnswer {
    /// Normal force, N.
    #[serde(rename = "normal_N")]
    pub normal_n: f64,
    /// Tangential force, N.
    #[serde(rename = "force_N")]
    pub force_n: f64,
    /// Moment about the normal, N mm.
    #[serde(rename = "moment_Nmm")]
    pub moment_nmm: f64,
    /// The load could be so many times as large; null without a grasp, and without a load.
    pub margin: Option<f64>,
    /// Share of what the contact can carry that is in use, 1/margin; null without a grasp, and where nothing is carried.
    pub used: Option<f64>,
}

impl From<&Reading> for GraspWatchAnswer {
    fn from(reading: &Reading) -> Self {
        Self {
            palpate_grasp_reading: 1,
            time_s: reading.time,
            state: reading.into(),
            now: (&reading.now).into(),
            settled: (&reading.settled).into(),
            compression_mm: reading.compression,
            slips_in_s: reading.slips_in,
            tighten_n: reading.tighten,
        }
    }
}

impl From<&Reading> for GraspState {
    fn from(reading: &Reading) -> Self {
        match (reading.now.margin.is_some(), reading.slips(), reading.will_slip()) {
            (false, ..) => Self::None,
            (true, true, _) => Self::Slips,
            (true, false, true) => Self::WillSlip,
            (true, false, false) => Self::Holds,
        }
    }
}

impl From<&Hold> for GraspHoldAnswer {
    fn from(hold: &Hold) -> Self {
        Self {
            normal_n: hold.normal,
            force_n: hold.load.force[0],
            moment_nmm: hold.load.moment,
            margin: hold.margin.and_then(finite),
            used: hold.used().and_then(finite),
        }
    }
}
