//! What commands ask of the hardware.

use device::{Board, Lost, Restart, Setting};
use embedded_hal::delay::DelayNs;
use rp235x_hal::Timer;
use rp235x_hal::timer::CopyableTimer0;
use shared::wire::{ConverterFault, StoreFault};

use crate::flash::Memory;
use crate::{EDGE, Edge};

/// Device time, µs since reset.
#[derive(Clone, Copy)]
pub struct Time(pub Timer<CopyableTimer0>);

impl Time {
    /// Now.
    pub fn now_us(self) -> u64 {
        self.0.get_counter().ticks()
    }
}

impl DelayNs for Time {
    fn delay_ns(&mut self, ns: u32) {
        // One more, because the present one may be over at once.
        let until = self.now_us() + u64::from(ns.div_ceil(1_000)) + 1;
        while self.now_us() < until {}
    }
}

/// Does something with the converter while its interrupt waits.
pub fn with_edge<T>(change: impl FnOnce(&mut Edge) -> T) -> Option<T> {
    critical_section::with(|section| EDGE.borrow_ref_mut(section).as_mut().map(change))
}

/// The hardware as a command finds it.
pub struct Hardware<'m> {
    /// The clock.
    pub time: Time,
    /// The memory for settings.
    pub memory: &'m mut Memory,
}

impl Board for Hardware<'_> {
    fn configure(&mut self, setting: Setting) -> Result<(), ConverterFault> {
        let missing = Err(ConverterFault::Missing);
        // In two steps, so that the cable waits for neither for long.
        with_edge(|edge| edge.front_end.prepare(setting)).unwrap_or(missing)?;
        let now_us = self.time.now_us();
        with_edge(|edge| edge.front_end.configure(now_us, setting)).unwrap_or(missing)
    }

    fn listen(&mut self, to_converter: bool) -> Lost {
        let now_us = self.time.now_us();
        with_edge(|edge| edge.front_end.listen(now_us, to_converter)).unwrap_or_default()
    }

    fn store(&mut self, record: &[u8]) -> Result<(), StoreFault> {
        self.memory.save(record)
    }

    fn can_restart(&self, _: Restart) -> bool {
        true
    }
}
