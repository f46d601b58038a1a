//! The power fails at every instant of every save: what was saved before, or what is being saved, is there afterwards.

mod mock;

use mock::{MockFlash, Tear};
use proptest::prelude::*;
use settings_store::{MAX_RECORD_BYTES, SLOT_BYTES, Store};

const SECTOR: usize = 4 * SLOT_BYTES;

type Bytewise = MockFlash<1, SECTOR>;
type Wordwise = MockFlash<4, SECTOR>;

fn load<const WORD: usize>(flash: &mut MockFlash<WORD, SECTOR>) -> Option<Vec<u8>> {
    let mut buffer = [0; MAX_RECORD_BYTES];
    let mut store = Store::new(flash, MockFlash::<WORD, SECTOR>::RANGE).unwrap();
    store.load(&mut buffer).unwrap().map(|length| buffer[..length].to_vec())
}

fn save<const WORD: usize>(flash: &mut MockFlash<WORD, SECTOR>, record: &[u8]) -> bool {
    Store::new(flash, MockFlash::<WORD, SECTOR>::RANGE).unwrap().save(record).is_ok()
}

/// Records of many sizes, from none to the longest, with bytes that look erased among them.
fn records() -> Vec<Vec<u8>> {
    let lengths = [60, 0, 1, 200, 3, 120, 120, 7, MAX_RECORD_BYTES, 90, 33, 64];
    let byte = |save: usize, index: usize| match (save + index) % 7 {
        0 => 0xFF,
        1 => 0x00,
        _ => (31 * save + 7 * index) as u8,
    };
    let record = |(save, &length): (usize, &usize)| (0..length).map(|i| byte(save, i)).collect();
    lengths.iter().enumerate().map(record).collect()
}

/// Cuts each save of the series at every step, and looks what is there after the power is back.
fn cut_everywhere<const WORD: usize>(tear: Tear) {
    let mut flash = MockFlash::<WORD, SECTOR>::erased();
    let mut before: Option<Vec<u8>> = None;
    for record in records() {
        let mut whole = flash.clone();
        assert!(save(&mut whole, &record));
        let steps = whole.steps - flash.steps;
        assert!(steps >= SLOT_BYTES / WORD);
        for cut in 0..steps {
            let mut flash = flash.clone();
            flash.cut_after(cut, tear);
            assert!(!save(&mut flash, &record), "the power fails in step {cut} of {steps}");
            flash.restart();
            let found = load(&mut flash);
            assert!(
                found == before || found.as_ref() == Some(&record),
                "{tear:?} after {cut} of {steps} steps: {before:?}, {record:?}, found {found:?}"
            );
            assert!(save(&mut flash, b"the next"), "{tear:?} after {cut} of {steps} steps");
            for _ in 0..3 {
                assert_eq!(load(&mut flash).as_deref(), Some(&b"the next"[..]), "{tear:?} {cut}");
            }
        }
        flash = whole;
        assert_eq!(load(&mut flash).as_ref(), Some(&record));
        before = Some(record);
    }
    assert!(flash.erases >= 3, "the series goes through each sector");
}

#[test]
fn a_cut_between_two_bytes_loses_nothing() {
    cut_everywhere::<1>(Tear::Clean);
}

#[test]
fn a_cut_within_a_byte_loses_nothing() {
    cut_everywhere::<1>(Tear::Torn);
}

#[test]
fn bytes_that_read_differently_every_time_are_not_believed() {
    cut_everywhere::<1>(Tear::Unstable);
}

#[test]
fn a_cut_while_the_sector_is_zeroed_before_its_erase_loses_nothing() {
    cut_everywhere::<1>(Tear::Zeroed);
}

#[test]
fn the_order_within_a_write_or_an_erase_does_not_matter() {
    cut_everywhere::<1>(Tear::Backwards);
}

#[test]
fn flash_with_wider_words_loses_nothing() {
    for tear in Tear::ALL {
        cut_everywhere::<4>(tear);
    }
}

/// A record to save, and when the power fails meanwhile.
type Save = (Vec<u8>, Option<(usize, Tear)>);

fn saves() -> impl Strategy<Value = Vec<Save>> {
    let record = prop::collection::vec(any::<u8>(), 0..=80);
    let cut = (0..SECTOR + SLOT_BYTES, prop::sample::select(Tear::ALL.to_vec()));
    prop::collection::vec((record, prop::option::weighted(0.6, cut)), 1..40)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn after_any_series_of_cuts_one_of_the_records_since_the_last_whole_save_is_there(
        saves in saves()
    ) {
        let mut flash = Bytewise::erased();
        let mut expected = vec![None];
        for (record, cut) in saves {
            // As many cuts in a row as a sector has slots are beyond what is promised for unstable bits.
            if let Some((steps, tear)) = cut.filter(|_| expected.len() < 4) {
                flash.cut_after(steps, tear);
            }
            let saved = save(&mut flash, &record);
            flash.restart();
            if saved {
                expected.clear();
            }
            expected.push(Some(record));
            let found = load(&mut flash);
            prop_assert!(expected.contains(&found), "{expected:?}, found {found:?}");
        }
    }
}

#[test]
fn a_sector_is_erased_once_for_as_many_saves_as_it_has_slots() {
    let mut flash = Wordwise::erased();
    for save_number in 0..40_u8 {
        assert!(save(&mut flash, &[save_number]));
    }
    assert_eq!(flash.erases, 10);
}

#[test]
fn a_torn_slot_that_reads_as_whole_later_does_not_come_before_a_later_save() {
    // Not after 4 or 8 saves: a torn first slot is erased with its sector.
    for saves in [1, 2, 3, 5, 6, 7, 9_u8] {
        let mut flash = Bytewise::erased();
        for number in 0..saves {
            assert!(save(&mut flash, &[number]));
        }
        let before = flash.clone();
        assert!(save(&mut flash, b"torn"));
        // The last byte of the new slot that is programmed: the end of its checksum.
        let changed = |&at: &usize| flash.bytes[at] != 0xFF && before.bytes[at] == 0xFF;
        let last = (0..2 * SECTOR).rfind(changed).unwrap();
        let whole = core::mem::replace(&mut flash.bytes[last], 0xFF);
        assert_eq!(load(&mut flash), Some(vec![saves - 1]));
        assert!(save(&mut flash, b"later"));
        flash.bytes[last] = whole;
        assert_eq!(load(&mut flash).as_deref(), Some(&b"later"[..]), "after {saves} saves");
    }
}
