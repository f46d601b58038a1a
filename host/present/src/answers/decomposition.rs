//! `palpate decompose`: signals in fast and slow adapting parts, and their regions.

use palpate_analysis::decomposition::Channel;
use palpate_analysis::regions::{Regions, Stretch, name, type_code};
use palpate_trace::Trace;
use serde::Serialize;
use shared::adaptation::Relaxation;

/// Recordings in fast and slow adapting parts.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct DecompositionAnswer {
    /// Version of this answer.
    pub palpate_decomposition: u32,
    /// The relaxation function of the filter.
    pub relaxation: FilterRelaxation,
    /// Each recording.
    pub traces: Vec<DecomposedTrace>,
}

/// The relaxation function of the filter, c0 + c1 e^(−v1 t) + c2 e^(−v2 t).
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct FilterRelaxation {
    /// Share that never relaxes, 0 to 1.
    pub c0: f64,
    /// Share of the fast term, 0 to 1.
    pub c1: f64,
    /// Rate of the fast term, 1/s.
    pub v1: f64,
    /// Share of the slow term, 0 to 1.
    pub c2: f64,
    /// Rate of the slow term, 1/s; at most `v1`.
    pub v2: f64,
}

/// One recording in its parts.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct DecomposedTrace {
    /// Name of the trace.
    pub trace: String,
    /// Each signal that was decomposed.
    pub channels: Vec<DecomposedChannel>,
}

/// One signal that was decomposed.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct DecomposedChannel {
    /// Its column.
    pub signal: String,
    /// Least significant bit of the 24-bit numbers of the filter, in the unit of the signal.
    pub lsb: f64,
    /// Number of samples beyond full scale.
    pub saturated: u32,
    /// The regions of the grasp, in order.
    pub regions: Vec<GraspRegion>,
}

/// A stretch of one region of the grasp.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct GraspRegion {
    /// Its name: `rest`, `preloading`, `loading`, `transition`, `relaxation`, `unloading` or `recovery`.
    pub region: String,
    /// The points of Fig. 3.10 between which it lies, such as `AB`; empty at rest.
    pub points: String,
    /// Time at which it begins, s.
    pub from_s: f64,
    /// Time at which it ends, s.
    pub to_s: f64,
    /// The type of relaxation that most of its samples show: 0 settled, 1 Type I, 2 Type II.
    pub relaxation: f64,
}

impl DecompositionAnswer {
    /// The channels of each recording with their regions, and the relaxation function of the filter.
    #[must_use]
    pub fn of(parts: &[(&Trace, &[(Channel, Regions)])], relaxation: &Relaxation) -> Self {
        let trace = |(trace, channels): &(&Trace, &[(Channel, Regions)])| DecomposedTrace {
            trace: trace.label(),
            channels: channels
                .iter()
                .map(|(channel, regions)| DecomposedChannel::of(trace, channel, regions))
                .collect(),
        };
        Self {
            palpate_decomposition: 1,
            relaxation: relaxation.into(),
            traces: parts.iter().map(trace).collect(),
        }
    }
}

impl DecomposedChannel {
    fn of(trace: &Trace, channel: &Channel, regions: &Regions) -> Self {
        let region = |stretch: &Stretch| {
            let (points, region) = name(stretch.region);
            GraspRegion {
                region: region.to_owned(),
                points: points.to_owned(),
                from_s: trace.time[stretch.range.start],
                to_s: trace.time[stretch.range.end.min(trace.len() - 1)],
                relaxation: type_code(stretch.relaxation),
            }
        };
        Self {
            signal: channel.signal.clone(),
            lsb: channel.lsb,
            saturated: channel.saturated,
            regions: regions.stretches().iter().map(region).collect(),
        }
    }
}

impl From<&Relaxation> for FilterRelaxation {
    fn from(relaxation: &Relaxation) -> Self {
        let Relaxation { c1, v1, c2, v2 } = *relaxation;
        Self { c0: relaxation.c0(), c1, v1, c2, v2 }
    }
}
