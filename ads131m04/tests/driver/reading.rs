//! Reading samples: whole, damaged, stale, absent.

use crate::script::{NULL, READY, Script, config, no_delay, reply};
use ads131m04::{Ads131m04, Error, Reading, Status};
use core::convert::Infallible;
use embedded_hal::{digital, spi};
use embedded_hal_mock::eh1::MockError;
use proptest::prelude::*;

fn read(part: Vec<u8>) -> Result<Reading, Error<spi::ErrorKind, MockError>> {
    #[expect(clippy::redundant_closure_for_method_calls, reason = "not general over lifetimes")]
    Script::default().raw(NULL, part).meet(|chip| chip.read())
}

#[test]
fn a_whole_frame_gives_the_four_counts() {
    let counts = [0, -1, 0x7F_FFFF, -0x80_0000];
    let reading = read(reply(READY, counts)).unwrap();
    assert_eq!(reading, Reading { status: Status(READY), counts });
}

#[test]
fn a_wrong_checksum_is_reported_with_both_values() {
    let whole = reply(READY, [1, 2, 3, 4]);
    let sent = u16::from_be_bytes([whole[15], whole[16]]);
    let mut damaged = whole;
    damaged[7] ^= 0x20;
    let computed = crate::script::ccitt(&damaged[..15]);
    let error = read(damaged).unwrap_err();
    assert!(matches!(error, Error::Crc { computed: c, received: r } if c == computed && r == sent));
    let message = error.to_string();
    assert!(
        message.contains(&format!("{computed:04X}h")) && message.contains(&format!("{sent:04X}h"))
    );
}

#[test]
fn a_channel_without_a_new_sample_is_not_passed_off_as_one() {
    for missing in 0..4 {
        let status = READY & !(1 << missing);
        let error = read(reply(status, [5; 4])).unwrap_err();
        assert!(matches!(error, Error::NoNewData { status: s } if s == Status(status)));
    }
}

#[test]
fn a_chip_that_lost_its_settings_is_noticed_at_the_next_reading() {
    let error = read(reply(0x050F, [5; 4])).unwrap_err();
    assert!(matches!(error, Error::ConfigurationLost { status: Status(0x050F) }));
}

#[test]
fn a_line_that_went_dead_is_told_from_a_damaged_frame() {
    for byte in [0x00, 0xFF] {
        assert!(matches!(read(vec![byte; 18]), Err(Error::NoChip { read }) if read == byte));
    }
}

#[test]
fn an_error_does_not_spoil_the_next_reading() {
    let mut damaged = reply(READY, [9; 4]);
    damaged[3] ^= 1;
    let script = Script::default().raw(NULL, damaged).raw(NULL, reply(READY, [7; 4]));
    script.meet(|chip| {
        assert!(chip.read().is_err());
        assert_eq!(chip.read().unwrap().counts, [7; 4]);
    });
}

#[test]
fn after_a_pause_two_frames_empty_what_the_chip_has_kept() {
    let script = Script::default()
        .raw(NULL, reply(READY, [1; 4]))
        .raw(NULL, reply(READY, [2; 4]))
        .raw(NULL, reply(READY, [3; 4]));
    script.meet(|chip| {
        chip.discard_stale().unwrap();
        assert_eq!(chip.read().unwrap().counts, [3; 4]);
    });
}

#[test]
fn an_input_checksum_error_shows_in_the_status_of_a_good_reading() {
    let reading = read(reply(READY | 0x1000, [1; 4])).unwrap();
    assert!(reading.status.input_crc_error());
    assert_eq!(reading.status.word_bits(), 24);
}

proptest! {
    #[test]
    fn every_frame_survives_the_way_from_the_chip(
        counts in prop::array::uniform4(-0x80_0000..=0x7F_FFFF)
    ) {
        prop_assert_eq!(read(reply(READY, counts)).unwrap().counts, counts);
    }

    /// Bits 0 to 135: words and checksum. The last byte of the frame is padding that carries nothing.
    #[test]
    fn any_single_wrong_bit_is_caught(
        counts in prop::array::uniform4(-0x80_0000..=0x7F_FFFF),
        bit in 0_usize..136,
    ) {
        let mut damaged = reply(READY, counts);
        damaged[bit / 8] ^= 0x80 >> (bit % 8);
        let caught = matches!(read(damaged), Err(Error::Crc { .. }));
        prop_assert!(caught);
    }

    #[test]
    fn no_reply_makes_the_driver_panic(frames in prop::collection::vec(any_frame(), 1..24)) {
        let mut chip = Ads131m04::new(Babble(frames.into_iter().cycle()), Pin);
        let _ = chip.init(&mut no_delay(), &config());
        let _ = chip.configure(&config());
        let _ = chip.lock();
        if let Err(error) = chip.read() {
            prop_assert!(!error.to_string().is_empty());
        }
    }
}

/// Noise, or a whole frame with any response, often one that leads the driver on.
fn any_frame() -> impl Strategy<Value = Vec<u8>> {
    let leading_on = [0xFF24, 0x2400, 0x4100, 0x1110, 0x4180, 0x0F16, 0x4200, 0x7531, READY];
    let response = prop_oneof![any::<u16>(), prop::sample::select(leading_on.to_vec())];
    prop_oneof![
        prop::collection::vec(any::<u8>(), 18),
        (response, prop::array::uniform4(any::<i32>()))
            .prop_map(|(word, counts)| reply(word, counts)),
    ]
}

/// A bus on which the same frames come back for ever, whatever is sent.
struct Babble(core::iter::Cycle<std::vec::IntoIter<Vec<u8>>>);

impl spi::ErrorType for Babble {
    type Error = Infallible;
}

impl spi::SpiDevice for Babble {
    fn transaction(&mut self, operations: &mut [spi::Operation<'_, u8>]) -> Result<(), Infallible> {
        for operation in operations {
            let spi::Operation::TransferInPlace(buffer) = operation else {
                panic!("the driver only transfers in place");
            };
            buffer.copy_from_slice(&self.0.next().unwrap());
        }
        Ok(())
    }
}

/// A pin that does nothing.
struct Pin;

impl digital::ErrorType for Pin {
    type Error = Infallible;
}

impl digital::OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}
