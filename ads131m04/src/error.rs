//! What can go wrong, with what was read and where to look.

use core::fmt;

use crate::{CHANNELS, Register, Status};

/// Failure of a bus, a pin or the part. `SPI` and `PIN` are the errors of the bus and of the pin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Error<SPI, PIN> {
    /// The bus failed.
    Spi(SPI),
    /// The SYNC/RESET pin could not be set.
    ResetPin(PIN),
    /// Nothing drives the line from the part: all 18 bytes of a frame were `read`, 00h or FFh.
    NoChip {
        /// The byte that came 18 times.
        read: u8,
    },
    /// Something answers, but not with the acknowledgement of a reset.
    NotReset {
        /// What came instead of FF24h.
        response: u16,
    },
    /// A part of the same family with another number of channels.
    WrongChip {
        /// The acknowledgement of the reset or the identity register, whichever told.
        read: u16,
        /// The number of channels that it names.
        channels: u8,
    },
    /// The part did not acknowledge a command: it is locked, or the command was damaged on its way.
    Refused {
        /// The command word.
        command: u16,
        /// The acknowledgement owed.
        expected: u16,
        /// What came instead; most often the status register.
        response: u16,
    },
    /// A register does not hold what was written to it.
    ReadBack {
        /// The register.
        register: Register,
        /// The value written.
        written: u16,
        /// The value read back.
        read: u16,
    },
    /// The frame was damaged on its way to the host; its counts are lost.
    Crc {
        /// The checksum of the words received.
        computed: u16,
        /// The checksum received.
        received: u16,
    },
    /// The part was reset since `init`, as by a dip of its supply: gains and rate are its defaults until the next `init`.
    ConfigurationLost {
        /// The status that says so.
        status: Status,
    },
    /// The frame is whole, but some channel had no new sample: it was read too early or too often.
    NoNewData {
        /// The status with the ready bits.
        status: Status,
    },
}

impl<SPI: fmt::Debug, PIN: fmt::Debug> fmt::Display for Error<SPI, PIN> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Spi(error) => write!(f, "the SPI bus failed: {error:?}"),
            Self::ResetPin(error) => write!(f, "the SYNC/RESET pin failed: {error:?}"),
            Self::NoChip { read } => write!(
                f,
                "no converter answers, every byte read was {read:02X}h: check its supplies, CS, SCLK, the wire from DOUT, \
                 and that SYNC/RESET is high"
            ),
            Self::NotReset { response } => write!(
                f,
                "the converter answered {response:04X}h to a reset, not FF24h: check that CLKIN runs, SPI mode 1 and the \
                 speed of the bus"
            ),
            Self::WrongChip { read, channels } => write!(
                f,
                "this is a converter of {channels} channels (it answered {read:04X}h), not the ADS131M04 with {CHANNELS}"
            ),
            Self::Refused { command, expected, response } => write!(
                f,
                "the converter answered {response:04X}h to command {command:04X}h, not {expected:04X}h: it is locked, or \
                 the command was damaged on its way"
            ),
            Self::ReadBack { register, written, read } => write!(
                f,
                "register {register:?} holds {read:04X}h after {written:04X}h was written to it"
            ),
            Self::Crc { computed, received } => write!(
                f,
                "a frame was damaged on its way: its checksum is {received:04X}h, its words give {computed:04X}h"
            ),
            Self::ConfigurationLost { status: Status(bits) } => write!(
                f,
                "the converter was reset (status {bits:04X}h) and has lost gains and rate: check its supply, then `init`"
            ),
            Self::NoNewData { status: Status(bits) } => {
                write!(
                    f,
                    "a channel had no new sample (status {bits:04X}h): read once per edge of DRDY"
                )
            }
        }
    }
}

impl<SPI: fmt::Debug, PIN: fmt::Debug> core::error::Error for Error<SPI, PIN> {}
