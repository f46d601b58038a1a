//! Scripts of SPI frames for the mocked bus: what the host must send, and what the part sends meanwhile.

use ads131m04::{Ads131m04, Clock, Config, Gain, Oversampling, PowerMode};
use embedded_hal_mock::eh1::{
    delay::NoopDelay,
    digital::{Mock as Pin, State, Transaction as PinEvent},
    spi::{Mock as Spi, Transaction},
};

pub const NULL: &[u16] = &[0x0000];
pub const RESET: &[u16] = &[0x0011];
pub const READ_ID: &[u16] = &[0xA000];

/// A status without flags, all channels ready.
pub const READY: u16 = 0x010F;

/// The driver on a scripted bus and pin.
pub type Chip<'a> = Ads131m04<&'a mut Spi<u8>, &'a mut Pin>;

/// CRC-CCITT bit by bit, as the datasheet draws it: polynomial 1021h, seed FFFFh. Independent of the driver's.
pub fn ccitt(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xFFFF, |crc, &byte| {
        (0..8).rev().fold(crc, |crc: u16, bit| {
            let feedback = (crc >> 15) ^ u16::from((byte >> bit) & 1);
            (crc << 1) ^ (feedback * 0x1021)
        })
    })
}

/// What the host sends: 16-bit words, their checksum, zeros.
pub fn request(words: &[u16]) -> Vec<u8> {
    let mut bytes = padded(words);
    let crc = ccitt(&bytes);
    bytes.extend(padded(&[crc]));
    bytes.resize(18, 0);
    bytes
}

/// What the part sends: response, counts, checksum.
pub fn reply(response: u16, counts: [i32; 4]) -> Vec<u8> {
    let mut bytes = padded(&[response]);
    for count in counts {
        bytes.extend(&count.to_be_bytes()[1..]);
    }
    let crc = ccitt(&bytes);
    bytes.extend(padded(&[crc]));
    bytes
}

fn padded(words: &[u16]) -> Vec<u8> {
    words.iter().flat_map(|word| [(word >> 8) as u8, *word as u8, 0]).collect()
}

/// A script, built frame by frame.
#[derive(Default)]
pub struct Script(Vec<Transaction<u8>>);

impl Script {
    /// One frame: the words of the host, the bytes of the part.
    pub fn raw(mut self, host: &[u16], part: Vec<u8>) -> Self {
        self.0.push(Transaction::transaction_start());
        self.0.push(Transaction::transfer_in_place(request(host), part));
        self.0.push(Transaction::transaction_end());
        self
    }

    /// One frame with a response and no signal.
    pub fn frame(self, host: &[u16], response: u16) -> Self {
        self.raw(host, reply(response, [0; 4]))
    }

    /// A command and its response, one frame later.
    pub fn exchange(self, host: &[u16], response: u16) -> Self {
        self.frame(host, READY).frame(NULL, response)
    }

    /// A register written, acknowledged and read back as `read`.
    pub fn written(self, address: u16, value: u16, read: u16) -> Self {
        self.frame(&[0x6000 | address << 7, value], READY)
            .frame(&[0xA000 | address << 7], 0x4000 | address << 7)
            .frame(NULL, read)
    }

    /// The reset of an ADS131M04 and its identity.
    pub fn reset_and_identity(self) -> Self {
        self.frame(RESET, READY).frame(NULL, 0xFF24).exchange(READ_ID, 0x2403)
    }

    /// The two frames that empty what the part has kept.
    pub fn stale(self) -> Self {
        self.frame(NULL, READY).frame(NULL, READY)
    }

    /// Runs `act` on a driver that meets this script, the pin at rest, and checks that all of it was met.
    pub fn meet<T>(self, act: impl FnOnce(&mut Chip<'_>) -> T) -> T {
        self.meet_with_pin(&[], act)
    }

    /// As [`Script::meet`], with one pulse on SYNC/RESET.
    pub fn meet_init<T>(self, act: impl FnOnce(&mut Chip<'_>) -> T) -> T {
        let pulse = [State::High, State::Low, State::High].map(PinEvent::set);
        self.meet_with_pin(&pulse, act)
    }

    fn meet_with_pin<T>(self, pin_events: &[PinEvent], act: impl FnOnce(&mut Chip<'_>) -> T) -> T {
        let (mut spi, mut pin) = (Spi::new(&self.0), Pin::new(pin_events));
        let outcome = act(&mut Ads131m04::new(&mut spi, &mut pin));
        spi.done();
        pin.done();
        outcome
    }
}

pub fn no_delay() -> NoopDelay {
    NoopDelay::new()
}

/// 8.192 MHz, 1 kHz, gains 2, 8, 32, 128.
pub fn config() -> Config {
    Config {
        clock: Clock::new(8_192_000, PowerMode::HighResolution).unwrap(),
        oversampling: Oversampling::X4096,
        chop: false,
        gains: [Gain::X2, Gain::X8, Gain::X32, Gain::X128],
    }
}
