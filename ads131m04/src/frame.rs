//! Frames of six 24-bit words, to and from the part (§8.5.1.7).

use crc::{CRC_16_IBM_3740, Crc, Table};

use crate::{CHANNELS, command::Command};

/// Words of a frame: response, counts, checksum.
const WORDS: usize = CHANNELS + 2;

pub(crate) type Frame = [[u8; 3]; WORDS];

/// What the datasheet calls CCITT (polynomial 1021h, seed FFFFh) is catalogued as IBM 3740.
const CRC: Crc<u16, Table<1>> = Crc::<u16, Table<1>>::new(&CRC_16_IBM_3740);

/// The frame that carries `command`. Its checksum follows the command, or the value of a WREG, at once; a part that does not
/// check it ignores that word, so it is always sent.
pub(crate) fn request(command: Command) -> Frame {
    let zero = [0; 3];
    let first = word(command.word());
    if let Command::WriteRegister(_, value) = command {
        let second = word(value);
        [first, second, word(checksum(&[first, second])), zero, zero, zero]
    } else {
        [first, word(checksum(&[first])), zero, zero, zero, zero]
    }
}

/// The frame without a command, whose response is the status register: every conversion is read with it.
pub(crate) const NULL: Frame = [[0; 3], [0xCC, 0x9C, 0], [0; 3], [0; 3], [0; 3], [0; 3]];

/// What the part sent while it received a frame.
pub(crate) struct Reply<'f>(pub(crate) &'f Frame);

impl Reply<'_> {
    /// Response to the command of the frame before.
    pub(crate) const fn response(&self) -> u16 {
        let [first, ..] = self.0;
        upper_bits(*first)
    }

    /// One sample of each channel.
    pub(crate) fn counts(&self) -> [i32; CHANNELS] {
        let [_, counts @ .., _] = *self.0;
        counts.map(|[high, middle, low]| i32::from_be_bytes([high, middle, low, 0]) >> 8)
    }

    /// The checksum computed over all words but the last, and the one received in the last.
    pub(crate) fn checksums(&self) -> (u16, u16) {
        let [words @ .., last] = self.0;
        (checksum(words), upper_bits(*last))
    }

    /// The byte that was received 18 times, when the line did not move at all. No true frame looks so: its checksum differs.
    pub(crate) fn stuck_at(&self) -> Option<u8> {
        let mut bytes = self.0.as_flattened().iter().copied();
        let first = bytes.next()?;
        (matches!(first, 0x00 | 0xFF) && bytes.all(|byte| byte == first)).then_some(first)
    }
}

fn checksum(words: &[[u8; 3]]) -> u16 {
    CRC.checksum(words.as_flattened())
}

const fn word(value: u16) -> [u8; 3] {
    let [high, low] = value.to_be_bytes();
    [high, low, 0]
}

const fn upper_bits([high, low, _]: [u8; 3]) -> u16 {
    u16::from_be_bytes([high, low])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Register;

    #[test]
    fn the_checksum_is_ccitt_seeded_with_ones() {
        assert_eq!(CRC.checksum(b"123456789"), 0x29B1);
    }

    #[test]
    fn a_line_that_does_not_move_fails_the_checksum_too() {
        for byte in [0x00, 0xFF] {
            let frame = [[byte; 3]; WORDS];
            let reply = Reply(&frame);
            let (computed, received) = reply.checksums();
            assert_ne!(computed, received);
            assert_eq!(reply.stuck_at(), Some(byte));
        }
        assert_eq!(Reply(&[[0x55; 3]; WORDS]).stuck_at(), None);
    }

    #[test]
    fn the_frame_without_a_command_has_its_checksum_too() {
        let [first, sum, ..] = NULL;
        assert_eq!(upper_bits(sum), checksum(&[first]));
    }

    #[test]
    fn counts_are_24_bit_twos_complement() {
        let words =
            [[0; 3], [0x7F, 0xFF, 0xFF], [0x80, 0, 0], [0xFF, 0xFF, 0xFF], [0, 1, 0], [0; 3]];
        assert_eq!(Reply(&words).counts(), [0x7F_FFFF, -0x80_0000, -1, 256]);
    }

    #[test]
    fn a_write_carries_its_value_before_the_checksum() {
        let [command, value, crc, ..] = request(Command::WriteRegister(Register::Gain1, 0x7531));
        assert_eq!(command, [0x62, 0x00, 0]);
        assert_eq!(value, [0x75, 0x31, 0]);
        assert_eq!(upper_bits(crc), CRC.checksum(&[0x62, 0x00, 0, 0x75, 0x31, 0]));
    }
}
