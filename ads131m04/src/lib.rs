//! Driver of the ADS131M04, Texas Instruments' delta-sigma converter that samples four channels at the same instant with
//! 24 bits, on [`embedded_hal`] 1.0.
//!
//! "§" refers to the datasheet SBAS890 (ADS131M04).
//!
//! ```
//! # use embedded_hal_mock::eh1::{digital::Mock as Pin, spi::{Mock as Spi, Transaction}};
//! # const NULL: [u8; 18] = [0, 0, 0, 0xCC, 0x9C, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
//! # const REPLY: [u8; 18] = [
//! #     0x01, 0x0F, 0, 0x00, 0x00, 0x01, 0xFF, 0xFF, 0xFF, 0x7F, 0xFF, 0xFF, 0x80, 0x00, 0x00, 0x03, 0xDD, 0,
//! # ];
//! # let mut spi = Spi::new(&[
//! #     Transaction::transaction_start(),
//! #     Transaction::transfer_in_place(NULL.to_vec(), REPLY.to_vec()),
//! #     Transaction::transaction_end(),
//! # ]);
//! # let mut sync_reset = Pin::new(&[]);
//! use ads131m04::{Ads131m04, Error};
//!
//! let mut converter = Ads131m04::new(&mut spi, &mut sync_reset);
//! // `init` once; then, in the interrupt of the falling edge of DRDY:
//! match converter.read() {
//!     Ok(reading) => assert_eq!(reading.counts, [1, -1, 0x7F_FFFF, -0x80_0000]),
//!     Err(Error::Crc { computed, received }) => panic!("{computed:04X} is not {received:04X}"),
//!     Err(error) => panic!("{error}"),
//! }
//! # spi.done();
//! # sync_reset.done();
//! ```
//!
//! # The frame
//!
//! The part speaks in frames of six words of 24 bits, 18 bytes, one SPI transaction each (§8.5.1.7). While the host sends a
//! command, the part sends the response to the command *before*, one sample of each channel, and a checksum:
//!
//! ```text
//! DIN   command │ CRC     │ 0    │ 0    │ 0    │ 0          (WREG: command │ value │ CRC │ 0 │ 0 │ 0)
//! DOUT  response│ count 0 │ … 1  │ … 2  │ … 3  │ CRC
//! ```
//!
//! Commands, responses, register values and checksums are 16 bits, in the upper bits of their word. Both checksums are
//! CRC-16/CCITT with polynomial 1021h and seed FFFFh, over every word before it in the same frame, padding included
//! (§8.3.12). The part always sends its own; [`Ads131m04::init`] makes it check the host's too.
//!
//! Every method that succeeds leaves the part such that its next response is the status register, which is what
//! [`Ads131m04::read`] expects. Nothing here blocks but the delays of `init`; nothing allocates; nothing panics on any reply.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![cfg_attr(
    not(test),
    deny(
        clippy::arithmetic_side_effects,
        clippy::indexing_slicing,
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable
    )
)]

mod command;
mod config;
mod drdy;
mod driver;
mod error;
mod frame;
mod register;

pub use config::{Clock, ClockError, Config, Gain, Inputs, Oversampling, PowerMode};
pub use drdy::{DrdyWatch, STUCK_AFTER_INTERVALS};
pub use driver::{Ads131m04, Reading, SETTLING_SAMPLES, SPI_MODE};
pub use error::Error;
pub use register::{Register, Status};

/// Channels that are sampled at the same instant.
pub const CHANNELS: usize = 4;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
