//! The memory for settings: the last two sectors of the flash beside the chip, written by the functions of the loader in ROM.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use rp235x_hal::rom_data;
use settings_store::{Store, StoreError};
use shared::wire::{Settings, StoreFault};

/// Where the flash is seen by the processor.
const ADDRESS: u32 = 0x1000_0000;
/// That of a Pico 2.
const BYTES: u32 = 4 << 20;
const SECTOR_BYTES: u32 = 4_096;
/// What is written at once; what is written as ones stays as it is.
const PAGE: usize = 256;
/// The command that erases a sector, and a size of block that is never erased at once.
const ERASE: u8 = 0x20;
/// The two sectors, from the beginning of the flash; `memory.x` leaves them out.
const SECTORS: core::ops::Range<u32> = BYTES - 2 * SECTOR_BYTES..BYTES;
/// Where the loader keeps the program that makes the flash fast to read, and its words (RP2350 data sheet, §5.4.8).
const MAKES_FAST: *const [u32; 64] = 0x400e_0000 as *const _;

/// The memory for settings.
pub struct Memory;

impl Memory {
    /// The record that was kept.
    pub fn load<'r>(&mut self, record: &'r mut [u8; Settings::RECORD]) -> Option<&'r [u8]> {
        let mut store = Store::new(Flash, SECTORS).ok()?;
        match store.load(record) {
            Ok(length) => record.get(..length?),
            // Which is told as settings that are none.
            Err(_) => Some(&[]),
        }
    }

    /// Keeps a record. The processor stands still while the flash is written, up to 0.4 s if a sector must be erased first.
    ///
    /// # Errors
    /// What is wrong with the memory.
    pub fn save(&mut self, record: &[u8]) -> Result<(), StoreFault> {
        let saved = Store::new(Flash, SECTORS).and_then(|mut store| store.save(record));
        saved.map_err(|error| match error {
            StoreError::NotWritten => StoreFault::NotWritten,
            _ => StoreFault::Flash,
        })
    }
}

/// The flash.
struct Flash;

/// There is no such address.
#[derive(Clone, Copy, Debug)]
struct OutOfBounds;

impl NorFlashError for OutOfBounds {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::OutOfBounds
    }
}

impl ErrorType for Flash {
    type Error = OutOfBounds;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), OutOfBounds> {
        let from = within(offset, bytes.len())?;
        let from = (ADDRESS + from) as *const u8;
        // SAFETY: all of it lies within the flash, which is always readable and never where `bytes` are.
        unsafe { from.copy_to_nonoverlapping(bytes.as_mut_ptr(), bytes.len()) };
        Ok(())
    }

    fn capacity(&self) -> usize {
        BYTES as usize
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR_BYTES as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), OutOfBounds> {
        let from = within(from, to.saturating_sub(from) as usize)?;
        let bytes = to.saturating_sub(from) as usize;
        // SAFETY: whole sectors within the flash, behind the program.
        changed(|| unsafe { rom_data::flash_range_erase(from, bytes, SECTOR_BYTES, ERASE) });
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), OutOfBounds> {
        let mut at = within(offset, bytes.len())? as usize;
        let mut rest = bytes;
        while !rest.is_empty() {
            let (page, begin) = (at / PAGE * PAGE, at % PAGE);
            let (now, later) = rest.split_at(rest.len().min(PAGE - begin));
            let mut whole = [0xff; PAGE];
            for (place, byte) in whole.iter_mut().skip(begin).zip(now) {
                *place = *byte;
            }
            // SAFETY: a whole page within the flash, behind the program; the bytes are in RAM.
            changed(|| unsafe { rom_data::flash_range_program(page as u32, whole.as_ptr(), PAGE) });
            (at, rest) = (at + now.len(), later);
        }
        Ok(())
    }
}

/// Changes the flash, from which nothing can be fetched meanwhile: interrupts wait, and the function is one in ROM. The functions
/// of this chip's ROM leave the flash readable, though slowly, so that the program may go on in it.
fn changed(change: impl FnOnce()) {
    critical_section::with(|_| {
        // SAFETY: this core alone runs, from the flash, which stays readable after each of these.
        unsafe {
            rom_data::connect_internal_flash();
            rom_data::flash_exit_xip();
        }
        change();
        // SAFETY: as above.
        unsafe { rom_data::flash_flush_cache() };
        // SAFETY: the loader has left its own function there, of 256 bytes, that runs wherever it is copied to and reads the flash
        // as fast as it found that it can be read (§5.4.8).
        unsafe {
            let program = MAKES_FAST.read_volatile();
            let entry = (&raw const program as usize | 1) as *const ();
            core::mem::transmute::<*const (), extern "C" fn()>(entry)();
        }
    });
}

fn within(offset: u32, bytes: usize) -> Result<u32, OutOfBounds> {
    let end = u32::try_from(bytes).ok().and_then(|bytes| offset.checked_add(bytes));
    end.filter(|end| *end <= BYTES).map(|_| offset).ok_or(OutOfBounds)
}
