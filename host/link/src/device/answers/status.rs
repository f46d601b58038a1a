//! How a device is, and what it lost.

use serde::Serialize;
use shared::fixed::celsius;
use shared::wire::{Counters, Source, Status};

use crate::device::refusal::Fault;

/// How a device is.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct StatusAnswer {
    /// What was lost since the reset.
    pub counters: CountersAnswer,
    /// Rows since the start of the stream, those lost included.
    pub rows: u64,
    /// Where the rows of the stream come from; null where none is on.
    pub streaming: Option<SourceAnswer>,
    /// Temperature, °C; null without a sensor.
    pub temperature_celsius: Option<f64>,
    /// What is wrong with the converter, and where to look; null where nothing is.
    pub converter: Option<String>,
    /// Most bytes of stack that were ever used.
    pub stack_used_bytes: u32,
}

/// Where the rows of a stream come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum SourceAnswer {
    /// The converter.
    Converter,
    /// The line: rows are put in as if the converter had given them.
    Link,
}

/// What was lost, stage by stage, since the reset. Each count stops at the largest number of 32 bits.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct CountersAnswer {
    /// Conversions whose data-ready edge was not seen, or came while one was read.
    pub conversions_missed: u32,
    /// Conversions with a wrong checksum or a wrong status.
    pub conversions_damaged: u32,
    /// Rows that found the queue from interrupt to filter full.
    pub queue_full: u32,
    /// Rows that found the queue to the line full.
    pub link_full: u32,
    /// Bytes of the log that found no room.
    pub log_full: u32,
    /// Bytes from the host that were lost on the line or found no room.
    pub bytes_lost: u32,
    /// Frames from the host that were damaged or unknown.
    pub frames_damaged: u32,
    /// Frames from the host that never came, by their sequence numbers.
    pub frames_missed: u32,
}

impl From<&Status> for StatusAnswer {
    fn from(status: &Status) -> Self {
        Self {
            counters: status.counters.into(),
            rows: status.rows,
            streaming: status.streaming.map(SourceAnswer::from),
            temperature_celsius: status.temperature.map(celsius),
            converter: status.converter.map(|fault| Fault(fault).to_string()),
            stack_used_bytes: status.stack_used,
        }
    }
}

impl From<Source> for SourceAnswer {
    fn from(source: Source) -> Self {
        match source {
            Source::Converter => Self::Converter,
            Source::Link { .. } => Self::Link,
        }
    }
}

impl From<Counters> for CountersAnswer {
    fn from(counters: Counters) -> Self {
        Self {
            conversions_missed: counters.conversions_missed,
            conversions_damaged: counters.conversions_damaged,
            queue_full: counters.queue_full,
            link_full: counters.link_full,
            log_full: counters.log_full,
            bytes_lost: counters.bytes_lost,
            frames_damaged: counters.frames_damaged,
            frames_missed: counters.frames_missed,
        }
    }
}
