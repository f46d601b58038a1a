//! The flash as the store of settings takes it: words of 32 bits, which the 3.3 V of the board allow, so that a sector is erased
//! in half the time that bytes take.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use stm32f4xx_hal::pac::{FLASH, flash::cr::PSIZE};

use super::{supply, watchdog};

const ADDRESS: u32 = 0x0800_0000;
const BYTES: u32 = 1 << 20;
/// Of the sectors from 5 on (RM0090 table 5).
const SECTOR_BYTES: u32 = 128 * 1024;
const FIRST_LARGE: u32 = 4;
const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];

/// The flash, unlocked for as long as this lives.
pub struct Unlocked<'f>(&'f mut FLASH);

/// Why it failed.
#[derive(Clone, Copy, Debug)]
pub enum Fault {
    /// It says so.
    Flash,
    /// The supply is too low to write it.
    Supply,
    /// There is no such address.
    Bounds,
}

impl NorFlashError for Fault {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Bounds => NorFlashErrorKind::OutOfBounds,
            Self::Flash | Self::Supply => NorFlashErrorKind::Other,
        }
    }
}

impl<'f> Unlocked<'f> {
    /// Unlocks it, and takes its data cache out of use, which would go on giving what was there before (RM0090 §3.5.2).
    pub fn new(flash: &'f mut FLASH) -> Self {
        // Errors of earlier operations stay until they are cleared (RM0090 §3.9.4).
        flash.sr().write(|w| {
            let w = w.pgserr().clear_bit_by_one().pgperr().clear_bit_by_one();
            w.pgaerr().clear_bit_by_one().wrperr().clear_bit_by_one().operr().clear_bit_by_one()
        });
        flash.acr().modify(|_, w| w.dcen().clear_bit());
        for key in KEYS {
            // SAFETY: the register takes any value; a wrong one leaves the flash locked, which the first write then says.
            flash.keyr().write(|w| unsafe { w.key().bits(key) });
        }
        flash.cr().modify(|_, w| w.psize().variant(PSIZE::Psize32));
        Self(flash)
    }

    /// Waits until the operation has ended.
    fn done(&self) -> Result<(), Fault> {
        while self.0.sr().read().bsy().bit_is_set() {}
        let status = self.0.sr().read();
        let wrong = status.pgserr().bit() || status.pgperr().bit() || status.pgaerr().bit();
        if wrong || status.wrperr().bit() || status.operr().bit() {
            Err(Fault::Flash)
        } else {
            Ok(())
        }
    }
}

impl Drop for Unlocked<'_> {
    fn drop(&mut self) {
        self.0.cr().modify(|_, w| w.lock().set_bit());
        self.0.acr().modify(|_, w| w.dcrst().set_bit());
        self.0.acr().modify(|_, w| w.dcrst().clear_bit());
        self.0.acr().modify(|_, w| w.dcen().set_bit());
    }
}

impl ErrorType for Unlocked<'_> {
    type Error = Fault;
}

impl ReadNorFlash for Unlocked<'_> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Fault> {
        let from = at(offset, bytes.len())? as *const u8;
        // SAFETY: `at` has found all of it within the flash, which is always readable and never where `bytes` are.
        unsafe { from.copy_to_nonoverlapping(bytes.as_mut_ptr(), bytes.len()) };
        Ok(())
    }

    fn capacity(&self) -> usize {
        BYTES as usize
    }
}

impl NorFlash for Unlocked<'_> {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR_BYTES as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Fault> {
        at(from, to.saturating_sub(from) as usize)?;
        for sector in from / SECTOR_BYTES..to / SECTOR_BYTES {
            // The watchdog's patience is for one erasure.
            watchdog::feed_now();
            if supply::is_low() {
                return Err(Fault::Supply);
            }
            let number = (sector + FIRST_LARGE) as u8;
            // SAFETY: a field of four bits; the part has sectors up to 11, and `at` has found this one.
            self.0.cr().modify(|_, w| unsafe { w.ser().set_bit().snb().bits(number) });
            self.0.cr().modify(|_, w| w.strt().set_bit());
            let done = self.done();
            self.0.cr().modify(|_, w| w.ser().clear_bit());
            done?;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Fault> {
        let to = at(offset, bytes.len())? as *mut u32;
        let (words, []) = bytes.as_chunks::<4>() else { return Err(Fault::Bounds) };
        self.0.cr().modify(|_, w| w.pg().set_bit());
        let mut done = Ok(());
        for (index, word) in words.iter().enumerate() {
            if supply::is_low() {
                done = Err(Fault::Supply);
                break;
            }
            // SAFETY: `at` has found all of it within the flash, aligned; the controller takes a word at a time.
            unsafe { to.wrapping_add(index).write_volatile(u32::from_le_bytes(*word)) };
            done = self.done();
            if done.is_err() {
                break;
            }
        }
        self.0.cr().modify(|_, w| w.pg().clear_bit());
        done
    }
}

/// The address of so many bytes, from an offset that is a multiple of four.
fn at(offset: u32, bytes: usize) -> Result<u32, Fault> {
    let end = u32::try_from(bytes).ok().and_then(|bytes| offset.checked_add(bytes));
    let fits = end.is_some_and(|end| end <= BYTES) && offset.is_multiple_of(4);
    if fits { Ok(ADDRESS + offset) } else { Err(Fault::Bounds) }
}
