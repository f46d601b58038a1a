//! The registers in use (§8.6) and what the status register says.

use crate::CHANNELS;

/// A register of the part; only those that the driver uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u16)]
pub enum Register {
    /// Identity: the number of channels in bits 11 to 8.
    Id = 0x00,
    /// Status, see [`Status`].
    Status = 0x01,
    /// Interface: checksums, word length, data-ready pin.
    Mode = 0x02,
    /// Enabled channels, oversampling, power mode.
    Clock = 0x03,
    /// Gains of the four channels.
    Gain1 = 0x04,
    /// Current detection, which is not used, and global chop.
    Cfg = 0x06,
    /// Inputs and phase of the first channel.
    Channel0 = 0x09,
    /// Of the second.
    Channel1 = 0x0E,
    /// Of the third.
    Channel2 = 0x13,
    /// Of the fourth.
    Channel3 = 0x18,
}

impl Register {
    /// The address where RREG, WREG and its acknowledgement have it: bits 12 to 7, the count of one register below.
    pub(crate) const fn address_bits(self) -> u16 {
        (self as u16) << 7
    }
}

/// MODE: check the host's checksum, CRC-CCITT, 24-bit words, reset flag cleared, interface timeout on; DRDY follows the
/// slowest channel, is driven both ways and stays low until the data are read.
pub(crate) const MODE: u16 = RX_CRC_EN | WORDS_OF_24_BITS | TIMEOUT;

const RX_CRC_EN: u16 = 1 << 12;
const WORDS_OF_24_BITS: u16 = 1 << 8;
const TIMEOUT: u16 = 1 << 4;

/// Channels that the identity register names.
pub(crate) const fn channels_of_id(id: u16) -> u8 {
    ((id >> 8) & 0xF) as u8
}

/// The status register, which opens every data frame (§8.6).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Status(pub u16);

impl Status {
    /// The interface obeys only NULL, RREG and UNLOCK.
    pub const fn is_locked(self) -> bool {
        self.bit(15)
    }

    /// A pulse on SYNC/RESET fell out of step with the conversions and restarted the filters.
    pub const fn was_resynchronised(self) -> bool {
        self.bit(14)
    }

    /// The part refused the frame before because of the host's checksum; it obeys a WREG all the same.
    pub const fn input_crc_error(self) -> bool {
        self.bit(12)
    }

    /// The part was reset since [`crate::Ads131m04::init`]: it runs with default gains and rate.
    pub const fn was_reset(self) -> bool {
        self.bit(10)
    }

    /// Length of the words in bits: 16, 24 or 32.
    pub const fn word_bits(self) -> u8 {
        match (self.0 >> 8) & 0b11 {
            0b00 => 16,
            0b01 => 24,
            _ => 32,
        }
    }

    /// Channel `channel` has a sample that was not read before; `false` for a channel that does not exist.
    pub const fn is_ready(self, channel: usize) -> bool {
        channel < CHANNELS && (self.0 >> channel) & 1 == 1
    }

    /// Every channel has a sample that was not read before.
    pub const fn all_ready(self) -> bool {
        self.0 & 0b1111 == 0b1111
    }

    const fn bit(self, position: u16) -> bool {
        (self.0 >> position) & 1 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_status_after_a_reset_is_what_the_datasheet_tabulates() {
        let status = Status(0x0500);
        assert!(status.was_reset());
        assert_eq!(status.word_bits(), 24);
        assert!(!status.is_locked() && !status.input_crc_error() && !status.was_resynchronised());
        assert!(!status.all_ready());
    }

    #[test]
    fn each_channel_has_its_own_ready_bit() {
        let status = Status(0x0105);
        assert_eq!(
            [0, 1, 2, 3, 4, 8, 64].map(|channel| status.is_ready(channel)),
            [true, false, true, false, false, false, false]
        );
        assert!(Status(0x010F).all_ready());
    }

    #[test]
    fn flags_and_word_lengths_are_read_from_their_bits() {
        assert!(Status(0x8000).is_locked());
        assert!(Status(0x4000).was_resynchronised());
        assert!(Status(0x1000).input_crc_error());
        assert_eq!(
            [0x0000, 0x0100, 0x0200, 0x0300].map(|bits| Status(bits).word_bits()),
            [16, 24, 32, 32]
        );
    }
}
