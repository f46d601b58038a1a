//! The memory for settings: the last two sectors of the flash.

use defmt::warn;
use settings_store::{Store, StoreError};
use shared::wire::{Settings, StoreFault};
use stm32f4xx_hal::flash::FlashExt;
use stm32f4xx_hal::pac::FLASH;

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

    /// Whether there is one.
    pub fn is_real(&self) -> bool {
        self.flash.is_some()
    }

    /// The settings that were kept, if they were made by this firmware.
    pub fn load(&mut self) -> Option<Settings> {
        let mut record = [0; Settings::RECORD];
        let mut store = Store::new(self.flash.as_mut()?.unlocked(), SECTORS).ok()?;
        match store.load(&mut record) {
            Ok(length) => Settings::from_record(record.get(..length?)?),
            Err(_) => {
                warn!("settings cannot be read");
                None
            }
        }
    }

    /// Keeps a record. The processor stands still while the flash is written, seconds if a sector must be erased first.
    ///
    /// # Errors
    /// What is wrong with the memory.
    pub fn save(&mut self, record: &[u8]) -> Result<(), StoreFault> {
        let flash = self.flash.as_mut().ok_or(StoreFault::NotWritten)?;
        // Errors of earlier operations stay until they are cleared (RM0090 §3.9.4).
        flash.sr().write(|w| {
            let w = w.pgserr().clear_bit_by_one().pgperr().clear_bit_by_one();
            w.pgaerr().clear_bit_by_one().wrperr().clear_bit_by_one().operr().clear_bit_by_one()
        });
        // The data cache would go on giving what was there before an erasure (RM0090 §3.5.2).
        flash.acr().modify(|_, w| w.dcen().clear_bit());
        let saved = Store::new(flash.unlocked(), SECTORS).and_then(|mut store| store.save(record));
        flash.acr().modify(|_, w| w.dcrst().set_bit());
        flash.acr().modify(|_, w| w.dcrst().clear_bit());
        flash.acr().modify(|_, w| w.dcen().set_bit());
        saved.map_err(|error| match error {
            StoreError::NotWritten => StoreFault::NotWritten,
            _ => StoreFault::Flash,
        })
    }
}
