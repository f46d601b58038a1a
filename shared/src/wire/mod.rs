//! Everything that passes between fingertip and host: the frame, the messages, the coding of samples.
//!
//! # Frame
//! All numbers little-endian; the whole in COBS (consistent overhead byte stuffing), then one zero byte:
//!
//! | bytes | what |
//! |-|-|
//! | 1 | version of this frame, [`VERSION`] |
//! | 1 | type: the place of the message in [`ToHost`] or [`ToDevice`] |
//! | 4 | sequence number of the sender; grows by one with every frame, also with those that were dropped |
//! | 8 | device time of the message, µs since reset; of a block, that of its first sample. From the host: 0 |
//! | n | payload, postcard |
//! | 4 | CRC-32 (ISO-HDLC) of all before it |
//!
//! A frame holds at most [`MAX_CONTENT`] bytes, so COBS costs one byte.
//!
//! # Conversation
//! The device only answers until it is told to start; then it streams samples and, once a second, its status. Its log comes
//! at any time after `Hello`. The first command is `Hello` with the schema, a hash
//! of every message's type ([`SCHEMA`]). Both sides understand the schemas of all earlier releases ([`EARLIER`]) and speak the
//! older of the two; a device to which the host's is foreign refuses all that follows but the core ([`is_of_core`]) and says so,
//! and the host sees the device's schema and version in its `Hello`. The frame, the first fields of both `Hello`, those of
//! [`Introduction`], and the core never change, so that this works between any two versions.
//!
//! Every command is answered by one [`Answer`] that carries the sequence number of the command. A command that comes again
//! with the same number is not carried out again, only its answer is repeated: a host that hears nothing asks again safely.

mod by_ratio;
mod capabilities;
mod check;
mod differences;
mod frame;
mod message;
mod of_four;
mod per_gauge;
mod record;
mod releases;
mod rows;
mod samples;
mod settings;
mod stuffing;

pub use by_ratio::{Oversampling, SettingsByRatio};
pub use capabilities::{Capabilities, RATES};
pub use differences::{CodingError, Gauges, pack, unpack};
pub use frame::{
    Accumulated, Accumulator, FRAME_MAX, FrameError, HEAD, Head, MAX_CONTENT, decode, encode,
    introduction, open, read,
};
pub use message::{
    Answer, ClockSource, Columns, ConverterFault, Counters, Done, Felt, Formats, Hello,
    HelloToDevice, INJECT_ROWS, Inject, Inputs, Introduction, Log, Refusal, ResetCause, SelfTest,
    Source, Start, Status, StoreFault, ToDevice, ToHost,
};
pub use of_four::{BlockOfFour, SelfTestOfFour, StatusOfFour};
pub use per_gauge::PerGauge;
pub use record::Kept;
pub use releases::{EARLIER, is_of_core, is_understood};
pub use samples::{Block, Made, REFERENCE_TEMPERATURE, Row, RowState, Rows};
pub use settings::{Settings, SettingsError};

/// Speed of a serial line, bits per second, 8N1: exact with either clock of the device.
pub const BAUD: u32 = 1_000_000;

/// How the device introduces itself on USB: numbers that pid.codes keeps for trying things out in private. Whoever gives boards to
/// others takes a product number of their own there, and writes it here and into the rules for Linux.
pub const USB_VENDOR: u16 = 0x1209;
/// The first of those that are for tests.
pub const USB_PRODUCT: u16 = 0x0001;
/// Who made it, as it says on USB.
pub const USB_MAKER: &str = "palpate";
/// What it is, as it says on USB.
pub const USB_NAME: &str = "palpate fingertip";

/// Version of the frame; a frame of another version is refused.
pub const VERSION: u8 = 1;

/// Hash of the types of all messages in both directions: equal schemas mean equal messages. How rows are packed is no type:
/// the number behind `rows` must grow with it.
pub const SCHEMA: u64 = {
    use postcard_schema::key::Key;
    let to_host = u64::from_le_bytes(Key::for_path::<ToHost<'_>>("to host, rows 2").to_bytes());
    let to_device =
        u64::from_le_bytes(Key::for_path::<ToDevice<'_>>("to device, rows 2").to_bytes());
    to_host.rotate_left(1) ^ to_device
};
