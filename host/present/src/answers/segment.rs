//! `palpate segment`: cycles and regions of recordings, their points, forces and work.

use palpate_analysis::cycles::{Cycle, Inertia, Piece, Point, Segmentation, Turn};
use palpate_analysis::pull_off_growth::Growth;
use palpate_trace::{Control, Trace};
use serde::Serialize;

use super::{PullOffAnswer, PullOffGrowthAnswer};
use crate::summary::{region_of, segment_warnings, type_of};

/// Recordings cut into cycles and regions.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SegmentationAnswer {
    /// Version of this answer.
    pub palpate_segment: u32,
    /// Each recording.
    pub traces: Vec<SegmentedTraceAnswer>,
    /// How pull-offs grow with the speed of the retreat; null for fewer than two speeds.
    pub pull_off_growth: Option<PullOffGrowthAnswer>,
}

/// One recording cut into cycles and regions.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SegmentedTraceAnswer {
    /// Name of the trace.
    pub trace: String,
    /// The quantity that was controlled.
    pub control: ControlledQuantity,
    /// What says so.
    pub control_from: ControlSource,
    /// Standard deviation of the noise of the force, N; 0 where it cannot be estimated.
    #[serde(rename = "force_noise_N")]
    pub force_noise_n: f64,
    /// The cycles, in order.
    pub cycles: Vec<CycleAnswer>,
    /// What moving the sensor's own mass adds to the force; null where the head gives no mass.
    pub inertia: Option<InertiaAnswer>,
    /// What to beware of.
    pub warnings: Vec<String>,
}

/// The quantity that was controlled in a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ControlledQuantity {
    /// The displacement: holds relax.
    Displacement,
    /// The force: holds creep.
    Force,
}

/// What says which quantity was controlled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ControlSource {
    /// The head of the trace.
    Head,
    /// The data.
    Data,
}

/// One way in and back.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct CycleAnswer {
    /// Number of the cycle, from 1.
    pub number: usize,
    /// Its points (Fig. 3.10), in order.
    pub points: Vec<CyclePoint>,
    /// Its regions, in order.
    pub regions: Vec<CycleRegion>,
    /// Work of the regions that put work into the specimen, mJ.
    #[serde(rename = "work_in_mJ")]
    pub work_in_mj: f64,
    /// Work of the regions that gave it back, mJ, positive.
    #[serde(rename = "work_out_mJ")]
    pub work_out_mj: f64,
    /// Work in less work out, mJ; an open loop also stores some of it.
    #[serde(rename = "dissipated_mJ")]
    pub dissipated_mj: f64,
    /// Its standard error from the noise of the force, mJ.
    #[serde(rename = "dissipated_standard_error_mJ")]
    pub dissipated_standard_error_mj: f64,
    /// Which way the loop runs in the plane of force over displacement.
    pub direction: LoopDirection,
    /// Whether it ends where it began, within 2 % of its stroke.
    pub closed: bool,
    /// Largest force by size, with its sign, N.
    #[serde(rename = "peak_force_N")]
    pub peak_force_n: f64,
    /// Time of the largest force, s.
    pub peak_time_s: f64,
    /// How the contact came off; null where the specimen does not adhere.
    pub pull_off: Option<PullOffAnswer>,
}

/// A point of a cycle (Fig. 3.10).
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct CyclePoint {
    /// `O`, `A` to `F`; from the second hold of a cycle on with its number, as `C2`. Where the specimen adheres, `Z` is where
    /// the force passes zero and `P` the largest pull.
    pub point: String,
    /// Time, s.
    pub time_s: f64,
    /// Displacement, mm.
    pub displacement_mm: f64,
    /// Force, N.
    #[serde(rename = "force_N")]
    pub force_n: f64,
}

/// A region of a cycle.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct CycleRegion {
    /// The points between which it lies, such as `AB`.
    pub points: String,
    /// Its name: `preloading`, `loading`, `transition`, `relaxation`, `creep`, `unloading`, `pull-off` or `recovery`.
    pub region: String,
    /// `Type I` or `Type II` for a hold after loading or after unloading; null for other regions.
    #[serde(rename = "type")]
    pub kind: Option<String>,
    /// Time at which it begins, s.
    pub from_s: f64,
    /// Time at which it ends, s.
    pub to_s: f64,
    /// ∫F dx over it, mJ; positive where work goes into the specimen.
    #[serde(rename = "work_mJ")]
    pub work_mj: f64,
}

/// Which way a loop runs in the plane of force over displacement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum LoopDirection {
    /// The force is higher on the way in: energy is dissipated.
    Clockwise,
    /// The force is higher on the way out.
    Counterclockwise,
    /// The two ways differ by no more than noise.
    #[serde(rename = "none beyond noise")]
    Neither,
}

/// What moving the sensor's own mass adds to the force (3.3.4).
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct InertiaAnswer {
    /// Moving mass, g.
    pub mass_g: f64,
    /// Largest acceleration by size that the samples show, mm/s².
    pub acceleration_mm_per_s2: f64,
    /// Acceleration that the scatter of the displacement alone would show, mm/s².
    pub acceleration_scatter_mm_per_s2: f64,
    /// Mass times acceleration, N.
    #[serde(rename = "force_N")]
    pub force_n: f64,
    /// What it is compared with, N.
    #[serde(rename = "compared_with_N")]
    pub compared_with_n: f64,
    /// What that is.
    pub compared_with: ForceLimit,
    /// That force as a share of the largest force.
    pub share_of_peak_force: f64,
}

/// What limits the force that a channel can show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ForceLimit {
    /// The resolution of the force channel, from the head of the trace.
    Resolution,
    /// The noise of the force.
    Noise,
}

impl SegmentationAnswer {
    /// Each recording as it was cut, and the growth of their pull-offs.
    #[must_use]
    pub fn of<'a>(
        each: impl Iterator<Item = (&'a Trace, &'a Segmentation)>,
        growth: Option<&Growth>,
    ) -> Self {
        Self {
            palpate_segment: 1,
            traces: each.map(|(trace, found)| SegmentedTraceAnswer::of(trace, found)).collect(),
            pull_off_growth: growth.map(PullOffGrowthAnswer::from),
        }
    }
}

impl SegmentedTraceAnswer {
    /// A recording as it was cut.
    #[must_use]
    pub fn of(trace: &Trace, found: &Segmentation) -> Self {
        let cycle = |cycle: &Cycle| CycleAnswer::of(trace, cycle, found.control);
        Self {
            trace: trace.label(),
            control: found.control.into(),
            control_from: if found.control_told {
                ControlSource::Head
            } else {
                ControlSource::Data
            },
            force_noise_n: found.force_noise_n,
            cycles: found.cycles.iter().map(cycle).collect(),
            inertia: found.inertia.as_ref().map(InertiaAnswer::from),
            warnings: segment_warnings(found),
        }
    }
}

impl CycleAnswer {
    fn of(trace: &Trace, cycle: &Cycle, control: Control) -> Self {
        let region = |piece: &Piece| {
            let (points, region) = region_of(piece, cycle, control);
            CycleRegion {
                points: points.to_owned(),
                region: region.to_owned(),
                kind: type_of(piece.relaxation),
                from_s: trace.time[*piece.samples.start()],
                to_s: trace.time[*piece.samples.end()],
                work_mj: piece.work_mj,
            }
        };
        Self {
            number: cycle.number,
            points: cycle.points.iter().map(CyclePoint::from).collect(),
            regions: cycle.pieces.iter().map(region).collect(),
            work_in_mj: cycle.work_in_mj,
            work_out_mj: cycle.work_out_mj,
            dissipated_mj: cycle.dissipated_mj(),
            dissipated_standard_error_mj: cycle.work_error_mj,
            direction: cycle.turn().into(),
            closed: cycle.closed,
            peak_force_n: cycle.peak_force_n,
            peak_time_s: trace.time[cycle.peak],
            pull_off: cycle.pull_off.as_ref().map(|pull| PullOffAnswer::of(trace, pull)),
        }
    }
}

impl From<&Point> for CyclePoint {
    fn from(point: &Point) -> Self {
        Self {
            point: point.name.clone(),
            time_s: point.time_s,
            displacement_mm: point.displacement_mm,
            force_n: point.force_n,
        }
    }
}

impl From<&Inertia> for InertiaAnswer {
    fn from(inertia: &Inertia) -> Self {
        Self {
            mass_g: inertia.mass_g,
            acceleration_mm_per_s2: inertia.acceleration_mm_per_s2,
            acceleration_scatter_mm_per_s2: inertia.scatter_mm_per_s2,
            force_n: inertia.force_n,
            compared_with_n: inertia.resolution_n,
            compared_with: match inertia.resolution_told {
                true => ForceLimit::Resolution,
                false => ForceLimit::Noise,
            },
            share_of_peak_force: inertia.share_of_peak,
        }
    }
}

impl From<Control> for ControlledQuantity {
    fn from(control: Control) -> Self {
        match control {
            Control::Displacement => Self::Displacement,
            Control::Force => Self::Force,
        }
    }
}

impl From<Turn> for LoopDirection {
    fn from(turn: Turn) -> Self {
        match turn {
            Turn::Clockwise => Self::Clockwise,
            Turn::Counterclockwise => Self::Counterclockwise,
            Turn::Neither => Self::Neither,
        }
    }
}
