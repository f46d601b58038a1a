//! One slot: a record with its sequence number and checksum, or erased flash, or neither.

use crc::{CRC_32_ISO_HDLC, Crc};

/// Longest record, bytes.
pub const MAX_RECORD_BYTES: usize = 512;

/// Distance between slots, bytes: the longest record with its frame, in whole words of flashes with words of up to 32
/// bytes.
pub const SLOT_BYTES: usize = 544;

/// Version of the layout of a slot. A slot of another version is not read.
const FORMAT: u8 = 1;
const HEADER_BYTES: usize = 1 + 4 + 2;
const ERASED: u8 = 0xFF;
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

const _: () = assert!(HEADER_BYTES + MAX_RECORD_BYTES + 4 <= SLOT_BYTES);

/// The bytes of a slot, as they are on the flash.
pub(crate) struct Slot(pub(crate) [u8; SLOT_BYTES]);

/// A record that was completely written.
#[derive(PartialEq, Eq)]
pub(crate) struct Record<'a> {
    pub(crate) sequence: u32,
    pub(crate) bytes: &'a [u8],
}

impl Record<'_> {
    /// Whether this record was saved after the other. Sequence numbers wrap; those of two sectors are close together.
    pub(crate) fn is_later_than(&self, other: &Self) -> bool {
        self.sequence.wrapping_sub(other.sequence).cast_signed() > 0
    }
}

impl Slot {
    pub(crate) const fn erased() -> Self {
        Self([ERASED; SLOT_BYTES])
    }

    pub(crate) fn is_erased(&self) -> bool {
        self.0.iter().all(|&byte| byte == ERASED)
    }

    /// Fills the slot with a record; `None` if it is too long for a slot.
    ///
    /// Format and sequence number stand first: a save that follows a torn one begins with the same bytes, so it is not
    /// harmed if a first word that was hardly programmed still looked erased.
    pub(crate) fn fill(&mut self, record: &Record<'_>) -> Option<()> {
        self.0.fill(ERASED);
        let length = u16::try_from(record.bytes.len()).ok()?;
        let (head, rest) = self.0.split_first_chunk_mut::<HEADER_BYTES>()?;
        let [s0, s1, s2, s3] = record.sequence.to_le_bytes();
        let [l0, l1] = length.to_le_bytes();
        *head = [FORMAT, s0, s1, s2, s3, l0, l1];
        let (bytes, rest) = rest.split_at_mut_checked(record.bytes.len())?;
        bytes.copy_from_slice(record.bytes);
        *rest.first_chunk_mut()? = checksum(head, bytes).to_le_bytes();
        Some(())
    }

    /// The record in this slot; `None` unless it was completely written.
    pub(crate) fn record(&self) -> Option<Record<'_>> {
        let (head, rest) = self.0.split_first_chunk::<HEADER_BYTES>()?;
        let [format, s0, s1, s2, s3, l0, l1] = *head;
        let length = usize::from(u16::from_le_bytes([l0, l1]));
        let (bytes, rest) = rest.split_at_checked(length)?;
        let whole = format == FORMAT
            && length <= MAX_RECORD_BYTES
            && u32::from_le_bytes(*rest.first_chunk()?) == checksum(head, bytes);
        whole.then_some(Record { sequence: u32::from_le_bytes([s0, s1, s2, s3]), bytes })
    }
}

fn checksum(head: &[u8; HEADER_BYTES], bytes: &[u8]) -> u32 {
    let mut digest = CRC.digest();
    digest.update(head);
    digest.update(bytes);
    digest.finalize()
}
