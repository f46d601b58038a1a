//! `palpate grasp margin`: the margin over recordings.

use palpate_contact::grasp::{History, Slip};
use palpate_trace::Trace;
use serde::Serialize;

use crate::answers::finite;

/// The margin until slip over recordings.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct GraspMarginAnswer {
    /// Version of this answer.
    pub palpate_grasp_margin: u32,
    /// The traces, in the order given.
    pub traces: Vec<MarginHistoryAnswer>,
}

/// The margin over one trace: the factor by which the load could grow until the contact slips.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct MarginHistoryAnswer {
    /// Name of the trace.
    pub trace: String,
    /// When a grasp that held first slips, s; null where it never does.
    pub first_slip_s: Option<f64>,
    /// Every slip, in order.
    pub slips: Vec<SlipAnswer>,
    /// Smallest margin; null where it is infinite, without a load.
    pub smallest_margin: Option<f64>,
    /// When the margin is smallest, s.
    pub smallest_margin_at_s: f64,
    /// Share of the time in contact in which it slips, 0 to 1.
    pub slipping_share: f64,
    /// Normal force above which there is contact, N.
    #[serde(rename = "contact_above_N")]
    pub contact_above_n: f64,
    /// Time of each sample, s.
    pub time_s: Vec<f64>,
    /// Share of what the contact can carry that is in use, 1/margin, at each sample; null without contact or where it is
    /// infinite.
    pub used: Vec<Option<f64>>,
    /// The same once the normal force has settled; null where no model was given.
    pub used_once_settled: Option<Vec<Option<f64>>>,
}

/// A stretch of time over which the contact slips.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SlipAnswer {
    /// When it begins, s.
    pub from_s: f64,
    /// When it ends, by holding again or by losing contact, s.
    pub to_s: f64,
    /// Whether the contact had not held before: the load was there at the touch.
    pub from_touch: bool,
}

impl From<&[(&Trace, &History)]> for GraspMarginAnswer {
    fn from(histories: &[(&Trace, &History)]) -> Self {
        let traces =
            histories.iter().map(|(trace, history)| MarginHistoryAnswer::of(trace, history));
        Self { palpate_grasp_margin: 1, traces: traces.collect() }
    }
}

impl MarginHistoryAnswer {
    fn of(trace: &Trace, history: &History) -> Self {
        let shares = |used: &[f64]| used.iter().copied().map(finite).collect::<Vec<_>>();
        Self {
            trace: trace.label(),
            first_slip_s: history.first_slip(),
            slips: history.slips.iter().map(SlipAnswer::from).collect(),
            smallest_margin: finite(history.smallest_margin()),
            smallest_margin_at_s: history.most_used.1,
            slipping_share: history.slipping,
            contact_above_n: history.threshold,
            time_s: trace.time.clone(),
            used: shares(&history.used),
            used_once_settled: history.settled.as_deref().map(shares),
        }
    }
}

impl From<&Slip> for SlipAnswer {
    fn from(slip: &Slip) -> Self {
        Self { from_s: slip.from, to_s: slip.to, from_touch: slip.from_touch }
    }
}
