//! `palpate convert`: what was written, and what was missing from the recordings that were read.

use std::path::{Path, PathBuf};

use palpate_trace::recorded::Recorded;
use palpate_trace::{Trace, gaps};
use serde::Serialize;

/// The files that were written, and what the recordings lacked.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct ConversionAnswer {
    /// Version of this answer.
    pub palpate_conversion: u32,
    /// The files that were written, in order.
    pub written: Vec<WrittenAnswer>,
    /// Rows that were lost while recording.
    pub rows_lost: u64,
    /// Rows that were left out because the settings that made them are not in the recording.
    pub rows_without_settings: u64,
    /// Damaged frames that were left out.
    pub damaged_frames: u64,
    /// Whether every recording was ended in order; if not, something may be missing at its end.
    pub ended_in_order: bool,
}

/// A file that was written, and its trace.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct WrittenAnswer {
    /// The file.
    pub file: String,
    /// Name of the trace.
    pub trace: String,
    /// Number of samples.
    pub samples: usize,
    /// Time from the first sample to the last, s.
    pub duration_s: f64,
    /// Number of gaps in time.
    pub gaps: usize,
    /// Number of pulses of a line that several devices share from which its time was taken; absent where it was not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pulses: Option<i64>,
}

impl ConversionAnswer {
    /// Of what was read, and of the file of each of its traces.
    #[must_use]
    pub fn of(read: &Recorded, files: &[PathBuf]) -> Self {
        let written = read.traces.iter().zip(files);
        Self {
            palpate_conversion: 1,
            written: written.map(|(trace, file)| WrittenAnswer::of(trace, file)).collect(),
            rows_lost: read.rows_lost,
            rows_without_settings: read.rows_unknown,
            damaged_frames: read.damaged,
            ended_in_order: read.closed,
        }
    }
}

impl WrittenAnswer {
    fn of(trace: &Trace, file: &Path) -> Self {
        Self {
            file: file.display().to_string(),
            trace: trace.label(),
            samples: trace.len(),
            duration_s: trace.duration(),
            gaps: gaps(&trace.time).len(),
            pulses: trace.pulses(),
        }
    }
}
