//! The messages, both ways: two enumerations are the table, the place of a variant in them is its type on the wire.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use super::by_ratio::{Oversampling, SettingsByRatio};
use super::capabilities::Capabilities;
use super::of_four::{BlockOfFour, SelfTestOfFour, StatusOfFour};
use super::per_gauge::{FOUR, PerGauge};
use super::record::Kept;
use super::samples::Block;
use super::settings::Settings;
use crate::adaptation::Relaxation;
use crate::calibration::Sheet;
use crate::events;
use crate::phase::Thresholds;
use crate::pipeline;

/// What the device says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum ToHost<'a> {
    /// Who it is; the answer to `Hello`, before its [`Answer`].
    #[serde(borrow)]
    Hello(Hello<'a>),
    /// What became of a command.
    Answer(Answer),
    /// Some rows of the stream, to a host of release 0.1; as [`ToHost::Samples`].
    SamplesOfFour(BlockOfFour<'a>),
    /// How it is, to a host of release 0.1; as [`ToHost::Status`].
    StatusOfFour(StatusOfFour),
    /// All settings, to a host of release 0.1; as [`ToHost::Settings`].
    SettingsByRatio {
        /// Grows by one with every change; blocks carry it.
        generation: u32,
        /// The settings.
        settings: SettingsByRatio,
    },
    /// A piece of its log.
    Log(Log<'a>),
    /// What became of the settings that were kept; after `Hello`.
    Kept(Kept),
    /// A touch, a release or a slip, as soon as it is known: before the block that its row is in.
    Event(Felt),
    /// What its converter is and can do; after `Hello`.
    Converter {
        /// The name of the part.
        part: &'a str,
        /// What it can do.
        capabilities: Capabilities,
    },
    /// All settings: after `Hello`, when asked, and after every change, before the first block that they made.
    Settings {
        /// Grows by one with every change; blocks carry it.
        generation: u32,
        /// The settings.
        settings: Settings,
    },
    /// The line that the fingers of a hand share rose: the same instant for all of them.
    Pulse {
        /// Device time of that instant, µs.
        time_us: u64,
    },
    /// Some rows of the stream.
    Samples(Block<'a>),
    /// How it is, once a second and when asked.
    Status(Status),
}

/// What the host says: commands, each answered by one [`Answer`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum ToDevice<'a> {
    /// Who the host is. Must come first.
    #[serde(borrow)]
    Hello(HelloToDevice<'a>),
    /// Begin a stream, with row 0.
    Start(Start),
    /// End the stream; rows that are waiting are sent first.
    Stop,
    /// Set the sample rate as release 0.1 does; as [`ToDevice::SetInterval`].
    SetRatio(Oversampling),
    /// Set the converter's gains as release 0.1 does; as [`ToDevice::SetGain`].
    SetGainOfFour([u8; FOUR]),
    /// Set the relaxation function, between two samples.
    SetFilter(Relaxation),
    /// Set the thresholds of the regions, between two samples.
    SetThresholds(Thresholds),
    /// Set the calibration of a gauge, between two samples; its tare is taken back.
    SetCalibration {
        /// The gauge, from 0.
        gauge: u8,
        /// Its calibration.
        sheet: Sheet,
    },
    /// Read zero from now on, on every gauge.
    Tare,
    /// Take the tare back.
    Untare,
    /// Keep the settings over a loss of power. Not while streaming: the flash stops the processor for up to two seconds.
    Save,
    /// Take the settings the device was made with; kept only after `Save`.
    LoadDefaults,
    /// Rows to be processed as if the converter had given them, in a stream from [`Source::Link`].
    Inject(Inject<'a>),
    /// Say the settings.
    Settings,
    /// Say the status.
    Status,
    /// Test converter, bridges and memory. Not while streaming.
    SelfTest,
    /// Begin again as after power-on.
    Reboot,
    /// Begin the loader in ROM, to be written anew over USB or this line.
    Bootloader,
    /// Set the time between two samples of the converter, one of [`Capabilities::intervals_ns`].
    SetInterval {
        /// The time, ns.
        ns: u32,
    },
    /// As [`ToDevice::SelfTest`], of other inputs of the converter than its gauges.
    TestInputs(Inputs),
    /// Set the converter's gains; the calibration follows, so that strain stays what it is.
    SetGain(PerGauge<u8>),
}

/// What the converter measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, Schema)]
pub enum Inputs {
    /// The gauges.
    #[default]
    Gauges,
    /// Nothing, both sides of each input joined: its own noise and offset.
    Shorted,
    /// A signal of its own, [`Capabilities::test_counts`] at any gain.
    TestSignal,
}

/// How to introduce oneself, the same in every version: both `Hello` begin with these fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub struct Introduction<'a> {
    /// Hash of all messages, [`super::SCHEMA`].
    pub schema: u64,
    /// Version of the program.
    pub version: &'a str,
}

/// Who the host is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct HelloToDevice<'a> {
    /// Hash of all messages.
    pub schema: u64,
    /// Version of the host's program.
    pub version: &'a str,
}

/// Who the device is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Hello<'a> {
    /// Hash of all messages.
    pub schema: u64,
    /// Version of the firmware.
    pub version: &'a str,
    /// Git state it was made from: a short hash, and `+` if something was not committed.
    pub git: &'a str,
    /// The board.
    pub board: &'a str,
    /// 96 bits that no other device has; 0 of a simulated one.
    pub serial: [u32; 3],
    /// Gauges.
    pub channels: u8,
    /// Clock of the converter, Hz; with an [`Oversampling`] it gives the rate.
    pub converter_clock_hz: u32,
    /// Where the processor's clock comes from.
    pub clock: ClockSource,
    /// Formats of the numbers.
    pub formats: Formats,
    /// Why it began.
    pub reset: ResetCause,
    /// What the last panic said, cut to [`Hello::PANIC`] bytes; empty without.
    pub panic: &'a str,
    /// What was lost since the reset.
    pub counters: Counters,
}

impl Hello<'_> {
    /// Most bytes of the last panic.
    pub const PANIC: usize = 80;
}

/// Formats of the numbers in a block; [`crate::fixed`] tells more.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Formats {
    /// Bits of a raw count.
    pub count_bits: u8,
    /// Fractional bits of a strain, µε.
    pub strain_fraction_bits: u8,
    /// Fractional bits of a temperature, °C.
    pub temperature_fraction_bits: u8,
}

impl Formats {
    /// Those of this version.
    pub const OURS: Self = Self {
        count_bits: 24,
        strain_fraction_bits: crate::fixed::STRAIN_FRACTION_BITS as u8,
        temperature_fraction_bits: crate::fixed::TEMPERATURE_FRACTION_BITS as u8,
    };
}

/// Where the processor's clock comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum ClockSource {
    /// The crystal, through the PLL.
    Crystal,
    /// The oscillator on the chip, 1 %: the crystal or the PLL did not start.
    Internal,
    /// A simulated device.
    Simulated,
}

/// Why the device began.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum ResetCause {
    /// Power came, or is not known to have been there.
    PowerOn,
    /// Power was low.
    BrownOut,
    /// The reset pin.
    Pin,
    /// It was told to, or panicked.
    Software,
    /// A stage made no progress.
    Watchdog,
}

/// What was lost, stage by stage, since the reset. Each stops at the largest `u32`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, Schema)]
pub struct Counters {
    /// Conversions whose data-ready edge was not seen or came while one was read.
    pub conversions_missed: u32,
    /// Conversions with a wrong CRC or a wrong status.
    pub conversions_damaged: u32,
    /// Rows that found the queue from interrupt to filter full.
    pub queue_full: u32,
    /// Rows that found the queue to the link full.
    pub link_full: u32,
    /// Bytes of log that found no room.
    pub log_full: u32,
    /// Bytes from the host that were lost on the line or found no room.
    pub bytes_lost: u32,
    /// Frames from the host that were damaged or unknown.
    pub frames_damaged: u32,
    /// Frames from the host that never came, by their sequence numbers.
    pub frames_missed: u32,
}

/// An event of the stream, with [`events::Settings::DEFAULT`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Felt {
    /// Events since the start of the stream, from 0; a number that is left out was lost.
    pub number: u32,
    /// Row at which it became known.
    pub row: u64,
    /// Time of that row, µs.
    pub time_us: u64,
    /// What happened, and how many rows before that it began.
    pub event: events::Event,
}

/// How the device is; by default as one that has done nothing yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, Schema)]
pub struct Status {
    /// What was lost.
    pub counters: Counters,
    /// What happened to the gauges since the start of the stream.
    pub gauges: PerGauge<pipeline::Counters>,
    /// Rows since the start of the stream, those lost too.
    pub rows: u64,
    /// Whether a stream is on.
    pub streaming: Option<Source>,
    /// Temperature, 2^-8 °C; none without a sensor.
    pub temperature: Option<i16>,
    /// What is wrong with the converter.
    pub converter: Option<ConverterFault>,
    /// Most bytes of stack that were ever used.
    pub stack_used: u32,
    /// Most rows that ever waited between interrupt and filter.
    pub queue_most: u8,
}

/// What became of the command with this sequence number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Answer {
    /// Sequence number of the command.
    pub to: u32,
    /// What was done, or why not.
    pub outcome: Result<Done, Refusal>,
}

/// What was done.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum Done {
    /// The command.
    Carried,
    /// Rows were taken; those that found no room are counted in [`Counters::queue_full`].
    Injected {
        /// Rows taken.
        taken: u8,
        /// Rows that found no room.
        lost: u8,
        /// Rows that would find room now.
        room: u8,
    },
    /// Results of the test, to a host of release 0.1; as [`Done::Tested`].
    TestedOfFour(SelfTestOfFour),
    /// Results of the test.
    Tested(SelfTest),
}

/// Why a command was not carried out; nothing was changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Refusal {
    /// `Hello` must come first.
    NoHello,
    /// The schemas differ; this is the device's.
    Schema(u64),
    /// Not while streaming.
    Streaming,
    /// Only while streaming.
    NotStreaming,
    /// Rows are injected only into a stream from [`Source::Link`].
    NotFromLink,
    /// There is no gauge of this number.
    Gauge(u8),
    /// The interval of injected rows must be positive.
    Interval,
    /// A gain is no power of two from 1 to 128, or the converter does not have it.
    Gain,
    /// The relaxation function is out of range, or does not suit the rate.
    Filter,
    /// The thresholds are out of range.
    Thresholds,
    /// The calibration is out of range.
    Calibration,
    /// The injected rows cannot be read.
    Rows,
    /// There is no sample yet that could read zero.
    NoSample,
    /// The converter.
    Converter(ConverterFault),
    /// The memory for settings.
    Store(StoreFault),
    /// This device cannot do that.
    NotHere,
    /// The converter has no such rate.
    Rate,
}

/// What is wrong with the converter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum ConverterFault {
    /// Nothing answers.
    Missing,
    /// Something else answers, with this identity.
    Wrong(u16),
    /// A register did not keep what was written.
    Register,
    /// A reply was damaged.
    Damaged,
    /// The data-ready line stands still.
    Stuck,
    /// The bus failed.
    Bus,
}

/// What is wrong with the memory for settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum StoreFault {
    /// The flash did not keep what was written.
    NotWritten,
    /// The flash reported an error.
    Flash,
    /// The supply is too low to write the flash.
    Supply,
}

/// What a self-test found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct SelfTest {
    /// Converter, or what is wrong with it.
    pub converter: Result<(), ConverterFault>,
    /// Standard deviation of the raw counts over the test, gauge by gauge.
    pub noise_counts: PerGauge<f32>,
    /// Mean of the raw counts over the test, gauge by gauge; near a rail a bridge is open or shorted.
    pub mean_counts: PerGauge<i32>,
    /// Samples the test took.
    pub samples: u16,
    /// Rate that was seen over the rate that was set; 0 if none came.
    pub rate_ratio: f32,
}

/// Where samples come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Source {
    /// The converter.
    Converter,
    /// [`ToDevice::Inject`]; row times are multiples of the interval.
    Link {
        /// Time between two rows, ns.
        interval_ns: u32,
    },
}

/// What a block holds besides regions and warnings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Columns {
    /// Raw counts, FA and SA.
    Parts,
    /// Also elastic input and equilibrium.
    All,
}

/// How to stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Start {
    /// Where samples come from.
    pub source: Source,
    /// What to send.
    pub columns: Columns,
}

/// Most rows that are injected at once.
pub const INJECT_ROWS: usize = 16;

/// Rows of raw counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Inject<'a> {
    /// Their temperature, 2^-8 °C.
    pub temperature: Option<i16>,
    /// Counts of at most [`INJECT_ROWS`] rows, as [`super::pack`] packs them.
    #[serde(borrow, with = "serde_bytes")]
    pub counts: &'a [u8],
}

/// A piece of the device's log, in the encoding of defmt.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Log<'a> {
    /// Bytes of a defmt stream of rzCOBS frames; they go on in the next piece.
    #[serde(borrow, with = "serde_bytes")]
    pub bytes: &'a [u8],
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::GAUGES;
    use crate::wire::{FRAME_MAX, Head, RATES, SCHEMA, decode, encode, introduction, open};

    const LONGEST: Counters = Counters {
        conversions_missed: u32::MAX,
        conversions_damaged: u32::MAX,
        queue_full: u32::MAX,
        link_full: u32::MAX,
        log_full: u32::MAX,
        bytes_lost: u32::MAX,
        frames_damaged: u32::MAX,
        frames_missed: u32::MAX,
    };

    fn fits(message: &ToHost<'_>) {
        let mut frame = [0; FRAME_MAX];
        let sent = encode(Head::default(), message, &mut frame).unwrap().len();
        let (_, heard) = decode::<ToHost<'_>>(&mut frame[..sent - 1]).unwrap();
        assert_eq!(heard, *message);
    }

    #[test]
    fn the_longest_of_every_message_fits_into_a_frame() {
        let panic = "x".repeat(Hello::PANIC);
        fits(&ToHost::Hello(Hello {
            schema: u64::MAX,
            version: "100.100.100-alpha.10",
            git: "0123456789abcdef+",
            board: "adafruit-feather-stm32f405",
            serial: [u32::MAX; 3],
            channels: 4,
            converter_clock_hz: u32::MAX,
            clock: ClockSource::Internal,
            formats: Formats::OURS,
            reset: ResetCause::Watchdog,
            panic: &panic,
            counters: LONGEST,
        }));
        let gauge = pipeline::Counters {
            converter_at_rail: u32::MAX,
            strain_saturated: u32::MAX,
            filter_saturated: u32::MAX,
        };
        fits(&ToHost::Status(Status {
            counters: LONGEST,
            gauges: PerGauge([gauge; GAUGES]),
            rows: u64::MAX,
            streaming: Some(Source::Link { interval_ns: u32::MAX }),
            temperature: Some(i16::MIN),
            converter: Some(ConverterFault::Wrong(u16::MAX)),
            stack_used: u32::MAX,
            queue_most: u8::MAX,
        }));
        let mut settings = Settings { tare: [i32::MIN; GAUGES], ..Settings::DEFAULT };
        settings.thresholds.touch = i32::MIN;
        settings.thresholds.release = i32::MIN;
        settings.thresholds.peak_drop = i32::MIN;
        settings.thresholds.motion_step = i32::MIN;
        settings.thresholds.latent_dead_band = i32::MIN;
        settings.calibration =
            settings.calibration.map(|sheet| Sheet { offset: i32::MIN, ..sheet });
        fits(&ToHost::Settings { generation: u32::MAX, settings });
        let capabilities =
            Capabilities { intervals_ns: [u32::MAX; RATES], ..Capabilities::ads131m04(1) };
        fits(&ToHost::Converter { part: "a part with a long name", capabilities });
    }

    #[test]
    fn a_hello_of_another_schema_still_says_who_speaks() {
        let mut frame = [0; FRAME_MAX];
        let hello = HelloToDevice { schema: 12, version: "9.9.9" };
        let sent = encode(Head::default(), &ToDevice::Hello(hello), &mut frame).unwrap().len();
        let (_, message) = open(&mut frame[..sent - 1]).unwrap();
        assert_eq!(introduction(message).unwrap(), Introduction { schema: 12, version: "9.9.9" });
    }

    #[test]
    fn the_schema_changes_with_the_messages_and_with_nothing_else() {
        // A change of any message must change this number, and this number must not change without one.
        assert_eq!(SCHEMA, 0xbcf8_bf7b_80c4_ffdc, "{SCHEMA:#018x}");
    }
}
