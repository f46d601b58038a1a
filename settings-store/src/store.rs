//! Two sectors that take turns.

use core::ops::Range;

use embedded_storage::nor_flash::NorFlash;

use crate::slot::{Record, SLOT_BYTES, Slot};
use crate::{MAX_RECORD_BYTES, StoreError};

const SLOT: u32 = SLOT_BYTES as u32;

/// One record on two sectors of a flash. Nothing is remembered between calls: it may be made anew for each.
pub struct Store<F> {
    flash: F,
    start: u32,
    sector_bytes: u32,
}

#[derive(Clone, Copy)]
enum Sector {
    First,
    Second,
}

impl Sector {
    fn other(self) -> Self {
        match self {
            Self::First => Self::Second,
            Self::Second => Self::First,
        }
    }
}

/// What a look through one sector found, beside its last whole record.
struct Contents<E> {
    /// Number of slots up to the last one that is not erased.
    used: u32,
    /// An error met on the way.
    fault: Option<E>,
}

/// Room for the last whole record of each sector: all the memory that the store works in.
type Slots = [Slot; 2];

impl<F: NorFlash> Store<F> {
    /// A store on the two halves of `range`, addresses as the flash driver counts them.
    ///
    /// # Errors
    ///
    /// [`StoreError::BadRange`] unless each half is made of whole erasable sectors of the flash and holds two slots of
    /// [`SLOT_BYTES`].
    pub fn new(flash: F, range: Range<u32>) -> Result<Self, StoreError<F::Error>> {
        const {
            assert!(SLOT_BYTES.is_multiple_of(F::READ_SIZE), "slots are not whole words");
            assert!(SLOT_BYTES.is_multiple_of(F::WRITE_SIZE), "slots are not whole words");
        }
        let sector_bytes = range.end.saturating_sub(range.start) / 2;
        let erasable = |bytes: u32| (bytes as usize).is_multiple_of(F::ERASE_SIZE);
        let fits = erasable(range.start)
            && erasable(sector_bytes)
            && sector_bytes as usize >= 2 * SLOT_BYTES
            && range.end as usize <= flash.capacity()
            && range.start.saturating_add(sector_bytes.saturating_mul(2)) == range.end;
        fits.then_some(Self { flash, start: range.start, sector_bytes }).ok_or(StoreError::BadRange)
    }

    /// Copies the newest record that was completely written to the start of `buffer` and gives its length in bytes;
    /// `None` if there is none: nothing was ever saved, or what is on the flash is not a record.
    ///
    /// # Errors
    ///
    /// [`StoreError::BufferTooSmall`], and [`StoreError::Flash`] if no record was found and the flash could not be read
    /// everywhere. Neither prevents a later [`save`](Self::save).
    pub fn load(&mut self, buffer: &mut [u8]) -> Result<Option<usize>, StoreError<F::Error>> {
        let mut slots = [const { Slot::erased() }; 2];
        let Some((_, record)) = self.newest(&mut slots)? else {
            return Ok(None);
        };
        let needed = record.bytes.len();
        let place = buffer.get_mut(..needed).ok_or(StoreError::BufferTooSmall { needed })?;
        place.copy_from_slice(record.bytes);
        Ok(Some(needed))
    }

    /// Saves a record; on return it has been read back from the flash, and [`load`](Self::load) gives it.
    ///
    /// Until then the record before stays. If neither sector holds a whole record, the store starts again on an erased
    /// sector.
    ///
    /// # Errors
    ///
    /// [`StoreError::RecordTooLong`]; [`StoreError::Flash`] or [`StoreError::NotWritten`] if neither sector takes it.
    pub fn save(&mut self, record: &[u8]) -> Result<(), StoreError<F::Error>> {
        if record.len() > MAX_RECORD_BYTES {
            return Err(StoreError::RecordTooLong { length: record.len() });
        }
        let mut slots = [const { Slot::erased() }; 2];
        let (sector, sequence) = match self.newest(&mut slots) {
            Ok(Some((sector, newest))) => (sector, newest.sequence),
            _ => {
                // If this fails, the sector does not take the record either, and the other one has its turn.
                let _ = self.erase(Sector::First);
                (Sector::First, 0)
            }
        };
        let next = Record { sequence: sequence.wrapping_add(1), bytes: record };
        if self.append(sector, &next, &mut slots).is_ok() {
            return Ok(());
        }
        // Later than what the failed attempt may have left.
        let later = Record { sequence: sequence.wrapping_add(2), bytes: record };
        self.erase(sector.other())?;
        self.append(sector.other(), &later, &mut slots)
    }

    /// Writes the record after the last slot of a sector and reads the store back.
    fn append(
        &mut self,
        sector: Sector,
        record: &Record<'_>,
        slots: &mut Slots,
    ) -> Result<(), StoreError<F::Error>> {
        let [slot, _] = slots;
        let used = self.contents(sector, slot).used;
        if used >= self.slots_per_sector() {
            return Err(StoreError::NotWritten);
        }
        slot.fill(record).ok_or(StoreError::RecordTooLong { length: record.bytes.len() })?;
        self.flash.write(self.address(sector, used), &slot.0).map_err(StoreError::Flash)?;
        match self.newest(slots)? {
            Some((_, newest)) if newest == *record => Ok(()),
            _ => Err(StoreError::NotWritten),
        }
    }

    fn erase(&mut self, sector: Sector) -> Result<(), StoreError<F::Error>> {
        let from = self.address(sector, 0);
        let to = from.saturating_add(self.sector_bytes);
        self.flash.erase(from, to).map_err(StoreError::Flash)
    }

    /// The newest whole record; an error only if there is none and something could not be read.
    fn newest<'a>(
        &mut self,
        slots: &'a mut Slots,
    ) -> Result<Option<(Sector, Record<'a>)>, StoreError<F::Error>> {
        let [first, second] = slots;
        let fault_in_first = self.contents(Sector::First, first).fault;
        let fault_in_second = self.contents(Sector::Second, second).fault;
        match (first.record(), second.record()) {
            (Some(a), Some(b)) if b.is_later_than(&a) => Ok(Some((Sector::Second, b))),
            (Some(a), _) => Ok(Some((Sector::First, a))),
            (None, Some(b)) => Ok(Some((Sector::Second, b))),
            (None, None) => match fault_in_first.or(fault_in_second) {
                Some(fault) => Err(StoreError::Flash(fault)),
                None => Ok(None),
            },
        }
    }

    /// Looks through a sector from its end until it meets a whole record, and leaves that in `slot`; if there is none,
    /// what it leaves is not a record.
    fn contents(&mut self, sector: Sector, slot: &mut Slot) -> Contents<F::Error> {
        let mut contents = Contents { used: 0, fault: None };
        for index in (0..self.slots_per_sector()).rev() {
            match self.flash.read(self.address(sector, index), &mut slot.0) {
                Ok(()) if slot.is_erased() => continue,
                Ok(()) => {}
                Err(fault) => {
                    contents.fault = Some(fault);
                    *slot = Slot::erased();
                }
            }
            contents.used = contents.used.max(index.saturating_add(1));
            if slot.record().is_some() {
                break;
            }
        }
        contents
    }

    fn slots_per_sector(&self) -> u32 {
        self.sector_bytes / SLOT
    }

    fn address(&self, sector: Sector, slot: u32) -> u32 {
        let start = match sector {
            Sector::First => self.start,
            Sector::Second => self.start.saturating_add(self.sector_bytes),
        };
        start.saturating_add(slot.saturating_mul(SLOT))
    }
}
