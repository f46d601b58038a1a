//! The memory for settings: the last two sectors of the flash.

use defmt::warn;
use settings_store::{Store, StoreError};
use shared::wire::{Settings, StoreFault};
use stm32f4xx_hal::pac::FLASH;

use crate::board::flash::{Fault, Unlocked};

/// Sectors 10 and 11 of the STM32F405RG, from the beginning of its flash; `memory.x` leaves them out.
const SECTORS: core::ops::Range<u32> = 0x000c_0000..0x0010_0000;

/// The flash, if it can be written.
pub struct Memory {
    flash: Option<FLASH>,
}

impl Memory {
    /// The flash of a real chip; on an emulated one nothing can be kept.
    pub fn new(flash: FLASH, real: bool) -> Self {
        Self { flash: real.then_some(flash) }
    }

    /// The record that was kept.
    pub fn load<'r>(&mut self, record: &'r mut [u8; Settings::RECORD]) -> Option<&'r [u8]> {
        let mut store = Store::new(Unlocked::new(self.flash.as_mut()?), SECTORS).ok()?;
        match store.load(record) {
            Ok(length) => record.get(..length?),
            Err(_) => {
                warn!("settings cannot be read");
                // Which is told as settings that are none.
                Some(&[])
            }
        }
    }

    /// Keeps a record. The processor stands still while the flash is written, seconds if a sector must be erased first.
    ///
    /// # Errors
    /// What is wrong with the memory.
    pub fn save(&mut self, record: &[u8]) -> Result<(), StoreFault> {
        let flash = self.flash.as_mut().ok_or(StoreFault::NotWritten)?;
        let saved =
            Store::new(Unlocked::new(flash), SECTORS).and_then(|mut store| store.save(record));
        saved.map_err(|error| match error {
            StoreError::NotWritten => StoreFault::NotWritten,
            StoreError::Flash(Fault::Supply) => StoreFault::Supply,
            _ => StoreFault::Flash,
        })
    }
}
