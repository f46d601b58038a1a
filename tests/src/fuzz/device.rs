//! A device on a desk: its program with made-up hardware.

use device::{Board, Device, Identity, Lost, Restart, Room, Setting, begin_with};
use shared::wire::{Capabilities, ClockSource, ConverterFault, ResetCause, StoreFault};

/// Clock of its converter, Hz.
pub const CONVERTER_CLOCK_HZ: u32 = 8_000_000;

const IDENTITY: Identity<'static> = Identity {
    version: "1.2.3",
    git: "abcdef0",
    board: "desk",
    serial: [1, 2, 3],
    converter_clock_hz: CONVERTER_CLOCK_HZ,
    converter: "ADS131M04",
    capabilities: Capabilities::ads131m04(CONVERTER_CLOCK_HZ),
    clock: ClockSource::Simulated,
    reset: ResetCause::PowerOn,
    panic: "",
};

/// Hardware that does what it is told.
#[derive(Debug, Default)]
pub struct Desk {
    /// Whether samples of the converter are let through.
    pub listening: bool,
}

impl Board for Desk {
    fn configure(&mut self, _: Setting) -> Result<(), ConverterFault> {
        Ok(())
    }

    fn listen(&mut self, to_converter: bool) -> Lost {
        self.listening = to_converter;
        Lost::default()
    }

    fn store(&mut self, _: &[u8]) -> Result<(), StoreFault> {
        Ok(())
    }

    fn can_restart(&self, _: Restart) -> bool {
        true
    }
}

/// Does something with a device that was just switched on.
pub fn desk<T>(with: impl FnOnce(&mut Device<'_>, &mut Desk) -> T) -> T {
    let begun = begin_with(None, &IDENTITY.capabilities).expect("the defaults are in range");
    let mut room = Room::new();
    let mut device = Device::new(IDENTITY, &begun, &mut room);
    with(&mut device, &mut Desk::default())
}
