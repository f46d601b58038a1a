//! One frame: head, payload, CRC and COBS.

use core::fmt;

use serde::{Deserialize, Serialize};

use super::check::Check;
use super::stuffing::Stuffed;
use super::{Introduction, VERSION};

/// Bytes of the head.
pub const HEAD: usize = 14;
/// Bytes of the CRC.
const CHECK: usize = 4;
/// Most bytes of head, payload and CRC: with no more than this, COBS needs a single code byte.
pub const MAX_CONTENT: usize = 254;
/// Most bytes of a frame on the line: code byte, content, zero byte.
pub const FRAME_MAX: usize = MAX_CONTENT + 2;

/// What a frame says about its message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Head {
    /// Sequence number of the sender.
    pub sequence: u32,
    /// Device time, µs since reset.
    pub time_us: u64,
}

impl Head {
    /// As it is sent, for a message of this type.
    pub(super) const fn bytes(self, kind: u8) -> [u8; HEAD] {
        let [a, b, c, d] = self.sequence.to_le_bytes();
        let [e, f, g, h, i, j, k, l] = self.time_us.to_le_bytes();
        [VERSION, kind, a, b, c, d, e, f, g, h, i, j, k, l]
    }
}

/// Why bytes are not a frame, or a message does not fit into one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// Too short for a head and a CRC, too long, or not COBS.
    Shape,
    /// The CRC does not fit.
    Check,
    /// Another version of the frame.
    Version(u8),
    /// The message is unknown, or its fields are not those of this version.
    Message,
    /// The message does not fit into a frame.
    TooLong,
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Shape => write!(f, "not a frame"),
            Self::Check => write!(f, "damaged frame: its CRC does not fit"),
            Self::Version(version) => {
                write!(f, "frame of version {version}; this side speaks version {VERSION}")
            }
            Self::Message => write!(f, "no message of this version"),
            Self::TooLong => write!(f, "message longer than a frame"),
        }
    }
}

impl core::error::Error for FrameError {}

/// Puts a message into `frame` and returns the bytes to send, the zero byte included.
///
/// # Errors
/// [`FrameError::TooLong`].
pub fn encode<'f, M: Serialize + ?Sized>(
    head: Head,
    message: &M,
    frame: &'f mut [u8; FRAME_MAX],
) -> Result<&'f [u8], FrameError> {
    let written = postcard::serialize_with_flavor(message, &mut Stuffed::new(head, frame));
    written.ok().and_then(|bytes| frame.get(..bytes)).ok_or(FrameError::TooLong)
}

/// Checks the bytes of a frame, without its zero byte, and decodes them in place: the head, and the message for [`read`].
///
/// # Errors
/// [`FrameError`] says what is wrong with them.
pub fn open(bytes: &mut [u8]) -> Result<(Head, &[u8]), FrameError> {
    let length = cobs::decode_in_place(bytes).map_err(|_| FrameError::Shape)?;
    let content = bytes.get_mut(..length).ok_or(FrameError::Shape)?;
    let (covered, check) = content.split_last_chunk_mut::<CHECK>().ok_or(FrameError::Shape)?;
    if Check::of(covered) != u32::from_le_bytes(*check) {
        return Err(FrameError::Check);
    }
    let &mut [version, kind, a, b, c, d, ref time @ ..] =
        covered.first_chunk_mut::<HEAD>().ok_or(FrameError::Shape)?;
    if version != VERSION {
        return Err(FrameError::Version(version));
    }
    let head =
        Head { sequence: u32::from_le_bytes([a, b, c, d]), time_us: u64::from_le_bytes(*time) };
    // The type in front of the payload again.
    let message = covered.get_mut(HEAD.saturating_sub(1)..).ok_or(FrameError::Shape)?;
    *message.first_mut().ok_or(FrameError::Shape)? = kind;
    Ok((head, message))
}

/// Reads the message of an opened frame.
///
/// # Errors
/// [`FrameError::Message`].
pub fn read<'f, M: Deserialize<'f>>(message: &'f [u8]) -> Result<M, FrameError> {
    match postcard::take_from_bytes(message) {
        Ok((message, [])) => Ok(message),
        _ => Err(FrameError::Message),
    }
}

/// Who speaks, if the message of an opened frame is a `Hello`, of whatever schema.
#[must_use]
pub fn introduction(message: &[u8]) -> Option<Introduction<'_>> {
    let (kind, fields) = message.split_first()?;
    let (introduction, _) = postcard::take_from_bytes(fields).ok()?;
    (*kind == 0).then_some(introduction)
}

/// [`open`] and [`read`].
///
/// # Errors
/// [`FrameError`] says what is wrong with the bytes.
pub fn decode<'f, M: Deserialize<'f>>(bytes: &'f mut [u8]) -> Result<(Head, M), FrameError> {
    let (head, message) = open(bytes)?;
    Ok((head, read(message)?))
}

/// What one more byte completed.
#[derive(Debug, PartialEq, Eq)]
pub enum Accumulated<'a> {
    /// Nothing yet.
    Nothing,
    /// A frame, for [`decode`].
    Frame(&'a mut [u8]),
    /// More bytes than a frame has came without a zero byte; they are dropped.
    TooLong,
}

/// Cuts a stream of bytes into frames. In step again after at most one zero byte.
#[derive(Clone, Debug)]
pub struct Accumulator {
    bytes: [u8; FRAME_MAX],
    length: usize,
}

impl Default for Accumulator {
    fn default() -> Self {
        Self::new()
    }
}

impl Accumulator {
    /// Nothing received.
    #[must_use]
    pub const fn new() -> Self {
        Self { bytes: [0; FRAME_MAX], length: 0 }
    }

    /// Takes the next byte of the line.
    pub fn push(&mut self, byte: u8) -> Accumulated<'_> {
        if byte == 0 {
            let length = core::mem::take(&mut self.length);
            return match self.bytes.get_mut(..length) {
                // Zero bytes between frames are allowed, so that a sender may clear the line.
                Some([]) => Accumulated::Nothing,
                Some(frame) => Accumulated::Frame(frame),
                None => Accumulated::TooLong,
            };
        }
        if let Some(place) = self.bytes.get_mut(self.length) {
            *place = byte;
        }
        self.length = self.length.saturating_add(1);
        Accumulated::Nothing
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    enum Message<'a> {
        Short(u8),
        #[serde(borrow)]
        Bytes(&'a [u8]),
    }

    fn sent(head: Head, message: &Message<'_>) -> Vec<u8> {
        encode(head, message, &mut [0; FRAME_MAX]).unwrap().to_vec()
    }

    #[test]
    fn the_bytes_of_a_frame_are_those_of_the_table() {
        let head = Head { sequence: 0x0403_0201, time_us: 0x1000 };
        let frame = sent(head, &Message::Short(7));
        let mut plain = frame[..frame.len() - 1].to_vec();
        let length = cobs::decode_in_place(&mut plain).unwrap();
        assert_eq!(plain[..length - 4], [1, 0, 1, 2, 3, 4, 0, 0x10, 0, 0, 0, 0, 0, 0, 7]);
        assert_eq!(plain[length - 4..length], Check::of(&plain[..length - 4]).to_le_bytes());
    }

    #[test]
    fn a_message_longer_than_a_frame_is_refused() {
        let bytes = [1; MAX_CONTENT - HEAD - CHECK - 1];
        let mut frame = [0; FRAME_MAX];
        assert!(encode(Head::default(), &Message::Bytes(&bytes[1..]), &mut frame).is_ok());
        let refused = encode(Head::default(), &Message::Bytes(&bytes), &mut frame);
        assert_eq!(refused, Err(FrameError::TooLong));
    }

    #[test]
    fn a_frame_of_another_version_is_refused_by_number() {
        let mut plain = vec![9, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 7];
        plain.extend(Check::of(&plain).to_le_bytes());
        let mut frame = vec![0; 40];
        let length = cobs::encode(&plain, &mut frame);
        assert_eq!(decode::<Message>(&mut frame[..length]), Err(FrameError::Version(9)));
    }

    fn any_head() -> impl Strategy<Value = Head> {
        any::<(u32, u64)>().prop_map(|(sequence, time_us)| Head { sequence, time_us })
    }

    proptest! {
        #[test]
        fn what_is_sent_arrives_and_is_stuffed_as_the_cobs_crate_does(
            head in any_head(), bytes in prop::collection::vec(0_u8..4, 0..=230),
        ) {
            let message = Message::Bytes(&bytes);
            let mut frame = sent(head, &message);
            prop_assert_eq!(frame.pop(), Some(0));
            prop_assert!(!frame.contains(&0));
            let mut plain = frame.clone();
            let length = cobs::decode_in_place(&mut plain).unwrap();
            let mut again = vec![0; FRAME_MAX];
            let stuffed = cobs::encode(&plain[..length], &mut again);
            prop_assert_eq!(&again[..stuffed], &frame[..]);
            prop_assert_eq!(decode::<Message>(&mut frame), Ok((head, message)));
        }

        #[test]
        fn up_to_three_wrong_bits_are_never_accepted(
            bytes in prop::collection::vec(any::<u8>(), 0..=200),
            flips in prop::collection::btree_set(0_usize..1_720, 1..=3),
        ) {
            let mut frame = sent(Head::default(), &Message::Bytes(&bytes));
            frame.pop();
            let bits = frame.len() * 8;
            let sent = frame.clone();
            for flip in flips {
                frame[flip % bits / 8] ^= 1 << (flip % 8);
            }
            if frame != sent {
                prop_assert!(decode::<Message>(&mut frame).is_err());
            }
        }

        #[test]
        fn no_bytes_panic_and_a_whole_frame_after_them_is_found(
            noise in prop::collection::vec(any::<u8>(), 0..1_000),
        ) {
            let mut accumulator = Accumulator::new();
            let mut heard = Vec::new();
            let frame = sent(Head::default(), &Message::Short(3));
            for byte in noise.iter().chain([&0]).chain(&frame) {
                if let Accumulated::Frame(bytes) = accumulator.push(*byte) {
                    heard.push(decode::<Message>(bytes).map(|(head, _)| head));
                }
            }
            prop_assert_eq!(heard.last(), Some(&Ok(Head::default())));
        }
    }
}
