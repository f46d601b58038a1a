//! `palpate record`: how a recording goes, and how it went.

use std::path::Path;

use palpate_analysis::events::name;
use palpate_trace::recording::parts;
use serde::Serialize;
use shared::pipeline::GAUGES;
use shared::wire::Felt;

use crate::device::record::View;

/// How a recording goes, once a second, of several devices one of each.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct SecondAnswer {
    /// Which device it is of, from 1; absent where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub device: Option<u32>,
    /// How it goes.
    #[serde(flatten)]
    pub view: ViewAnswer,
    /// What the device felt since the object before.
    pub events: Vec<EventAnswer>,
}

/// How a recording went: the last object, of several devices one of each.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct RecordedAnswer {
    /// Which device it is of, from 1; absent where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub device: Option<u32>,
    /// The recording.
    pub file: String,
    /// How it was at its end.
    pub summary: ViewAnswer,
    /// The file of topics of ROS 2; absent where none was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mcap: Option<String>,
}

/// What came of a stream and what did not, so far.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ViewAnswer {
    /// Time since the recording began, s.
    pub time_s: f64,
    /// Whether the device is there.
    pub linked: bool,
    /// Rows in a second of the device, over about the last half second, Hz; 0 where none came.
    pub rate_hz: f64,
    /// Rows that came.
    pub rows: u64,
    /// Rows that did not come, or were lost by the device.
    pub rows_lost: u64,
    /// Frames that did not come.
    pub frames_lost: u64,
    /// Frames that came damaged.
    pub frames_damaged: u64,
    /// Bytes on the line.
    pub bytes: u64,
    /// Times that something was missing.
    pub gaps: u64,
    /// Conversions and rows that the device itself lost since the recording began.
    pub drops: u64,
    /// Frames that wait for the disk now.
    pub backlog_frames: usize,
    /// Most frames that ever waited for the disk.
    pub backlog_frames_most: usize,
    /// Parts of the strain of each gauge in the last row; null before the first row.
    pub gauges: Option<[PartsAnswer; GAUGES]>,
}

/// Parts of the strain of one gauge.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct PartsAnswer {
    /// Fast-adapting part FA, µε.
    pub fa_ustrain: f64,
    /// Slowly adapting part SA, µε.
    pub sa_ustrain: f64,
}

/// An event that the device felt.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct EventAnswer {
    /// What happened: `touch`, `release` or `slip`.
    pub event: &'static str,
    /// Number of the event in its stream, from 0; a number that is left out was lost.
    pub number: u32,
    /// Row at which it became known.
    pub row: u64,
    /// Time of that row by the device's clock, s.
    pub device_time_s: f64,
    /// How many rows before that it began.
    pub began_rows_before: u32,
    /// The gauge that showed it, 1 to 4.
    pub gauge: u32,
}

impl RecordedAnswer {
    /// Of a recording that has ended, in these files.
    #[must_use]
    pub fn of(file: &Path, mcap: Option<&Path>, view: &View) -> Self {
        let named = |file: &Path| file.display().to_string();
        Self { device: None, file: named(file), summary: view.into(), mcap: mcap.map(named) }
    }
}

impl From<&View> for ViewAnswer {
    fn from(view: &View) -> Self {
        let gauge = |(fa_ustrain, sa_ustrain)| PartsAnswer { fa_ustrain, sa_ustrain };
        Self {
            time_s: view.passed.as_secs_f64(),
            linked: view.linked,
            rate_hz: view.rate_hz,
            rows: view.tally.rows,
            rows_lost: view.tally.rows_lost,
            frames_lost: view.tally.frames_lost,
            frames_damaged: view.tally.damaged,
            bytes: view.tally.bytes,
            gaps: view.gaps,
            drops: view.drops,
            backlog_frames: view.backlog.0,
            backlog_frames_most: view.backlog.1,
            gauges: view.row.as_ref().map(|row| parts(row).map(gauge)),
        }
    }
}

impl From<&Felt> for EventAnswer {
    fn from(felt: &Felt) -> Self {
        Self {
            event: name(felt.event.kind),
            number: felt.number,
            row: felt.row,
            device_time_s: felt.time_us as f64 * 1e-6,
            began_rows_before: felt.event.began_samples_ago,
            gauge: u32::from(felt.event.channel) + 1,
        }
    }
}
