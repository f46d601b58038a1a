//! Flash that holds anything, or does not do what it is told.

mod mock;

use embedded_storage::nor_flash::NorFlashErrorKind;
use mock::{MockError, MockFlash};
use proptest::prelude::*;
use settings_store::{MAX_RECORD_BYTES, SLOT_BYTES, Store, StoreError};

const SECTOR: usize = 4 * SLOT_BYTES;

type Flash = MockFlash<1, SECTOR>;

fn store(flash: &mut Flash) -> Store<&mut Flash> {
    Store::new(flash, Flash::RANGE).unwrap()
}

fn load(flash: &mut Flash) -> Result<Option<Vec<u8>>, StoreError<MockError>> {
    let mut buffer = [0; MAX_RECORD_BYTES];
    Ok(store(flash).load(&mut buffer)?.map(|length| buffer[..length].to_vec()))
}

fn saved(records: &[&[u8]]) -> Flash {
    let mut flash = Flash::erased();
    for record in records {
        store(&mut flash).save(record).unwrap();
    }
    flash
}

#[test]
fn erased_flash_holds_no_record() {
    assert_eq!(load(&mut Flash::erased()), Ok(None));
}

#[test]
fn flash_of_zeros_holds_no_record_and_takes_the_next() {
    let mut flash = Flash::holding(vec![0; 2 * SECTOR]);
    assert_eq!(load(&mut flash), Ok(None));
    store(&mut flash).save(b"new").unwrap();
    assert_eq!(load(&mut flash), Ok(Some(b"new".to_vec())));
}

proptest! {
    #[test]
    fn any_content_is_read_in_bounded_time_and_takes_the_next_record(
        bytes in prop::collection::vec(any::<u8>(), 2 * SECTOR),
        record in prop::collection::vec(any::<u8>(), 0..=MAX_RECORD_BYTES),
    ) {
        let mut flash = Flash::holding(bytes);
        prop_assert_eq!(load(&mut flash), Ok(None));
        prop_assert!(flash.reads <= 8, "each slot is read once");
        store(&mut flash).save(&record).unwrap();
        prop_assert_eq!(load(&mut flash), Ok(Some(record)));
    }

    #[test]
    fn damage_anywhere_gives_a_record_that_was_saved_or_none_and_takes_the_next(
        saves in 1..12_u8,
        damage in prop::collection::vec((0..2 * SECTOR, any::<u8>()), 1..20),
    ) {
        let mut flash = Flash::erased();
        for number in 0..saves {
            store(&mut flash).save(&[number; 40]).unwrap();
        }
        for (address, byte) in damage {
            flash.bytes[address] = byte;
        }
        let found = load(&mut flash).unwrap();
        prop_assert!(found.is_none_or(|found| (0..saves).any(|number| found == [number; 40])));
        store(&mut flash).save(b"new").unwrap();
        prop_assert_eq!(load(&mut flash), Ok(Some(b"new".to_vec())));
    }
}

#[test]
fn a_write_that_the_flash_ignores_is_reported_and_loses_nothing() {
    let mut flash = Flash::erased();
    flash.ignores_writes = true;
    assert_eq!(store(&mut flash).save(b"new"), Err(StoreError::NotWritten));
    let mut flash = saved(&[b"old"]);
    flash.ignores_writes = true;
    assert_eq!(store(&mut flash).save(b"new"), Err(StoreError::NotWritten));
    assert_eq!(load(&mut flash), Ok(Some(b"old".to_vec())));
}

#[test]
fn a_read_error_beside_a_whole_record_does_not_hide_it() {
    let mut flash = saved(&[b"first", b"second"]);
    flash.unreadable = SLOT_BYTES as u32..SECTOR as u32;
    assert_eq!(load(&mut flash), Ok(Some(b"first".to_vec())));
    store(&mut flash).save(b"third").unwrap();
    assert_eq!(load(&mut flash), Ok(Some(b"third".to_vec())));
}

#[test]
fn a_sector_that_cannot_be_read_is_reported_and_the_other_one_takes_over() {
    let mut flash = Flash::erased();
    flash.unreadable = 0..SECTOR as u32;
    let reported = Err(StoreError::Flash(MockError::Driver(NorFlashErrorKind::Other)));
    assert_eq!(load(&mut flash), reported);
    store(&mut flash).save(b"new").unwrap();
    assert_eq!(load(&mut flash), Ok(Some(b"new".to_vec())));
}

#[test]
fn a_record_that_is_too_long_is_refused_before_anything_is_written() {
    let mut flash = saved(&[b"old"]);
    let steps = flash.steps;
    let length = MAX_RECORD_BYTES + 1;
    let refused = store(&mut flash).save(&vec![0; length]);
    assert_eq!(refused, Err(StoreError::RecordTooLong { length }));
    assert_eq!(flash.steps, steps);
}

#[test]
fn a_buffer_that_is_too_small_is_told_the_size_it_needs() {
    let mut flash = saved(&[&[7; 100]]);
    let refused = store(&mut flash).load(&mut [0; 99]);
    assert_eq!(refused, Err(StoreError::BufferTooSmall { needed: 100 }));
}

#[test]
fn a_range_that_is_not_two_sectors_of_the_flash_is_refused() {
    let sector = SECTOR as u32;
    let ranges = [0..sector, 0..3 * sector, 1..2 * sector + 1, 0..2 * sector - 2, 0..0];
    for range in ranges {
        let refused = Store::new(Flash::erased(), range.clone()).err();
        assert_eq!(refused, Some(StoreError::BadRange), "{range:?}");
    }
    let one_slot = Store::new(MockFlash::<1, SLOT_BYTES>::erased(), 0..2 * SLOT_BYTES as u32);
    assert_eq!(one_slot.err(), Some(StoreError::BadRange));
}

#[test]
fn sequence_numbers_wrap() {
    let mut flash = saved(&[b"old"]);
    // The frame of the last record before the wrap, by the documented layout.
    let mut slot = [&[1][..], &u32::MAX.to_le_bytes(), &3_u16.to_le_bytes(), b"max"].concat();
    slot.extend(crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&slot).to_le_bytes());
    flash.bytes[..slot.len()].copy_from_slice(&slot);
    assert_eq!(load(&mut flash), Ok(Some(b"max".to_vec())));
    for number in 0..10_u8 {
        store(&mut flash).save(&[number]).unwrap();
        assert_eq!(load(&mut flash), Ok(Some(vec![number])));
    }
}
