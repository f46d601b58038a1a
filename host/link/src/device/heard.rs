//! What was heard from a device, owned.

use std::time::Instant;

use shared::wire::{
    Answer, Capabilities, ClockSource, Counters, Felt, FrameError, Head, Hello, Introduction, Kept,
    ResetCause, Rows, Settings, Status, ToHost, introduction, is_understood, open, read,
};

use super::line::Arrival;

/// A frame, and what it says.
#[derive(Clone, Debug)]
pub struct Heard {
    /// When its last byte was read.
    pub at: Instant,
    /// The frame as it was on the line, without its zero byte; empty if it was longer than a frame can be.
    pub frame: Vec<u8>,
    /// What it says, or what is wrong with it.
    pub said: Result<(Head, Said), FrameError>,
}

/// A message of a device.
#[derive(Clone, Debug, PartialEq)]
pub enum Said {
    /// Who it is.
    Hello(Box<Identity>),
    /// Who it is, in a schema that is not ours.
    Foreign {
        /// Hash of its messages.
        schema: u64,
        /// Version of its firmware.
        version: String,
    },
    /// What became of a command.
    Answer(Answer),
    /// Rows of the stream.
    Rows(Box<Rows>),
    /// How it is.
    Status(Box<Status>),
    /// Its settings.
    Settings(u32, Box<Settings>),
    /// A piece of its log.
    Log(Vec<u8>),
    /// What became of the settings that it had kept.
    Kept(Kept),
    /// A touch, a release or a slip.
    Event(Felt),
    /// The line that the fingers of a hand share rose.
    Pulse {
        /// Device time of that instant, µs.
        time_us: u64,
    },
    /// Its converter, by the name of the part, and what that can do.
    Converter(String, Box<Capabilities>),
}

/// Who a device is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Hash of the messages that it speaks.
    pub schema: u64,
    /// Version of the firmware.
    pub version: String,
    /// Git state it was made from: a short hash, and `+` if something was not committed.
    pub git: String,
    /// The board.
    pub board: String,
    /// 96 bits that no other device has; 0 of a simulated one.
    pub serial: [u32; 3],
    /// Gauges.
    pub channels: u8,
    /// Clock of the converter, Hz.
    pub converter_clock_hz: u32,
    /// The converter, by the name of its part.
    pub converter: String,
    /// What the converter can do.
    pub capabilities: Capabilities,
    /// Where the processor's clock comes from.
    pub clock: ClockSource,
    /// Why it began.
    pub reset: ResetCause,
    /// What the last panic said; empty without.
    pub panic: String,
    /// What was lost since the reset.
    pub counters: Counters,
    /// What became of the settings that it had kept; none of firmware that does not say.
    pub kept: Option<Kept>,
}

impl Identity {
    /// Of a device of which only the core is understood.
    pub(crate) fn unknown() -> Self {
        Self {
            schema: 0,
            version: String::new(),
            git: String::new(),
            board: String::new(),
            serial: [0; 3],
            channels: 0,
            converter_clock_hz: 0,
            converter: String::new(),
            capabilities: Capabilities::ads131m04(0),
            clock: ClockSource::Internal,
            reset: ResetCause::PowerOn,
            panic: String::new(),
            counters: Counters::default(),
            kept: None,
        }
    }

    /// The serial number as 24 hexadecimal digits.
    #[must_use]
    pub fn serial_number(&self) -> String {
        self.serial.iter().map(|word| format!("{word:08x}")).collect()
    }
}

impl From<Hello<'_>> for Identity {
    fn from(hello: Hello<'_>) -> Self {
        Self {
            schema: hello.schema,
            version: hello.version.into(),
            git: hello.git.into(),
            board: hello.board.into(),
            serial: hello.serial,
            channels: hello.channels,
            converter_clock_hz: hello.converter_clock_hz,
            // Firmware that has another says so.
            converter: "ADS131M04".into(),
            capabilities: Capabilities::ads131m04(hello.converter_clock_hz),
            clock: hello.clock,
            reset: hello.reset,
            panic: hello.panic.into(),
            counters: hello.counters,
            kept: None,
        }
    }
}

impl Heard {
    /// What an arrival says; none for the end of the line.
    #[must_use]
    pub fn of(arrival: Arrival) -> Option<Self> {
        match arrival {
            Arrival::Frame(at, frame) => {
                let said = understand(&mut frame.clone());
                Some(Self { at, frame, said })
            }
            Arrival::TooLong(at) => {
                Some(Self { at, frame: Vec::new(), said: Err(FrameError::TooLong) })
            }
            Arrival::Gone(_) => None,
        }
    }
}

fn understand(frame: &mut [u8]) -> Result<(Head, Said), FrameError> {
    let (head, message) = open(frame)?;
    if let Some(Introduction { schema, version }) = introduction(message)
        && !is_understood(schema)
    {
        return Ok((head, Said::Foreign { schema, version: version.into() }));
    }
    let said = match read::<ToHost<'_>>(message)?.in_words_of_today() {
        ToHost::Hello(hello) => Said::Hello(Box::new(hello.into())),
        ToHost::Answer(answer) => Said::Answer(answer),
        ToHost::Samples(block) => {
            // The frame is whole, so a block that contradicts itself was made so.
            Said::Rows(Box::new(Rows::decode(head, &block).map_err(|_| FrameError::Message)?))
        }
        ToHost::Status(status) => Said::Status(Box::new(status)),
        ToHost::Settings { generation, settings } => Said::Settings(generation, Box::new(settings)),
        // Nothing is left in the words of release 0.1.
        ToHost::SettingsByRatio { .. } | ToHost::StatusOfFour(_) | ToHost::SamplesOfFour(_) => {
            return Err(FrameError::Message);
        }
        ToHost::Converter { part, capabilities } => {
            Said::Converter(part.into(), Box::new(capabilities))
        }
        ToHost::Log(log) => Said::Log(log.bytes.into()),
        ToHost::Kept(kept) => Said::Kept(kept),
        ToHost::Event(felt) => Said::Event(felt),
        ToHost::Pulse { time_us } => Said::Pulse { time_us },
    };
    Ok((head, said))
}
