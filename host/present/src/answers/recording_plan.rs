//! `palpate plan`: what a recording of a hold would determine, and the recording that a wanted precision needs.

use std::collections::BTreeMap;

use palpate_fit::exponentials::plan::{Experiment, Plan, Recording};
use palpate_fit::exponentials::{Bound, Parameter};
use serde::Serialize;

/// The Cramér–Rao bound of a recording of a hold, and the recordings that a wanted precision needs.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct RecordingPlanAnswer {
    /// Version of this answer.
    pub palpate_plan: u32,
    /// Standard deviation of the noise of one sample, in the unit of the signal.
    pub noise: f64,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Length of the hold, s.
    pub duration_s: f64,
    /// Least standard error of each parameter, by name: rates in 1/s, `N` in the unit of the signal; null where undetermined.
    pub standard_errors: BTreeMap<String, Option<f64>>,
    /// The shortest recording at this sample rate that reaches the wanted precision; null where none was asked for.
    pub longer: Option<PlannedRecordingAnswer>,
    /// The slowest sampling of a hold of this length that reaches the wanted precision; null where none was asked for.
    pub faster: Option<PlannedRecordingAnswer>,
}

/// A recording that reaches the wanted precision, or the largest one allowed where none does.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct PlannedRecordingAnswer {
    /// Whether it reaches every precision that is wanted.
    pub enough: bool,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Length of the hold, s.
    pub duration_s: f64,
    /// The parameter that falls short most; absent where the recording is enough.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parameter: Option<String>,
    /// Standard error of it over its size; null where it is not determined at all, absent where the recording is enough.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative_standard_error: Option<Option<f64>>,
}

impl RecordingPlanAnswer {
    /// Of an experiment, a recording and its bound; `plans` are the longer recording and the faster one, where asked for.
    #[must_use]
    pub fn of(
        experiment: &Experiment,
        recording: &Recording,
        bound: &Bound,
        plans: &[Plan],
    ) -> Self {
        let error = |parameter: Parameter| (parameter.to_string(), bound.standard_error(parameter));
        Self {
            palpate_plan: 1,
            noise: experiment.noise,
            rate_hz: recording.rate,
            duration_s: recording.duration(),
            standard_errors: Parameter::all(experiment.sum.terms.len()).map(error).collect(),
            longer: plans.first().map(PlannedRecordingAnswer::from),
            faster: plans.get(1).map(PlannedRecordingAnswer::from),
        }
    }
}

impl From<&Plan> for PlannedRecordingAnswer {
    fn from(plan: &Plan) -> Self {
        let (recording, missed) = match plan {
            Plan::Enough { recording, .. } => (recording, None),
            Plan::OutOfReach { recording, parameter, relative } => {
                (recording, Some((parameter, relative)))
            }
        };
        Self {
            enough: missed.is_none(),
            rate_hz: recording.rate,
            duration_s: recording.duration(),
            parameter: missed.map(|(parameter, _)| parameter.to_string()),
            relative_standard_error: missed.map(|(_, relative)| *relative),
        }
    }
}
