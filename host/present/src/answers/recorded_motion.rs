//! `palpate hide --record`: one more recording of the specimen of a practice set.

use std::path::Path;

use palpate_trace::Trace;
use schemars::JsonSchema;
use serde::Serialize;

/// The recording that was added to a practice set.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct RecordedMotionAnswer {
    /// File of the recording.
    pub recorded: String,
    /// Time from its first sample to its last, s.
    pub duration_s: f64,
}

impl RecordedMotionAnswer {
    /// Of a trace that was written to a file.
    #[must_use]
    pub fn of(trace: &Trace, file: &Path) -> Self {
        Self { recorded: file.display().to_string(), duration_s: trace.duration() }
    }
}
