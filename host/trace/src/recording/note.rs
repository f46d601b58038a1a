//! What the host writes between the frames of the device.

use serde::{Deserialize, Serialize};
use shared::wire::{FRAME_MAX, FrameError, Head, encode, read};

/// Type in the head of a note's frame. The messages of a device count up from 0 and never come near it.
pub const NOTE: u8 = 0xf0;

/// A note of the host. The time in the head of its frame is the host's, µs since the recording was opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Note<'a> {
    /// The recording begins.
    #[serde(borrow)]
    Opened(Opened<'a>),
    /// The frame of the device that follows arrived at the time of this note. A [`super::Reader`] says so with that frame.
    Arrived,
    /// Something is missing here.
    Gap(Gap),
    /// The recording was ended in order.
    Closed,
    /// The frames and gaps that follow are of this device, one of several, counted from 0.
    Device(u8),
}

/// Who records, when and from where.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Opened<'a> {
    /// Hash of all messages, [`shared::wire::SCHEMA`] of the host.
    pub schema: u64,
    /// Version of the host's program.
    pub version: &'a str,
    /// When the recording was opened, ns since 1970 (UTC); 0 if that means nothing, as in one made from a trace.
    pub unix_ns: u64,
    /// Where the device was connected; cut to [`Opened::PORT`] bytes.
    pub port: &'a str,
}

impl<'a> Opened<'a> {
    /// Most bytes of a port's name.
    pub const PORT: usize = 160;

    /// A recording of this program that begins now.
    #[must_use]
    pub fn now(port: &'a str) -> Self {
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
        let unix_ns = now.map_or(0, |since| u64::try_from(since.as_nanos()).unwrap_or(0));
        Self { unix_ns, ..Self::timeless(port) }
    }

    /// A recording of this program that belongs to no time of day.
    #[must_use]
    pub fn timeless(port: &'a str) -> Self {
        let whole = |end: &usize| port.is_char_boundary(*end);
        let end = (0..=port.len().min(Self::PORT)).rev().find(whole).unwrap_or(0);
        let port = &port[..end];
        let version = env!("CARGO_PKG_VERSION");
        Self { schema: shared::wire::SCHEMA, version, unix_ns: 0, port }
    }
}

/// What is missing, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Gap {
    /// So many frames of the device never came or were damaged, by their sequence numbers.
    FramesLost(u32),
    /// So many rows of the stream never came, by their numbers.
    RowsLost(u64),
    /// The device began anew.
    Reset,
    /// The link to the device is gone.
    LinkLost,
    /// The link is there again.
    LinkBack,
}

/// Puts a note into `frame` and returns its bytes, the zero byte included.
pub(super) fn encode_note<'f>(
    head: Head,
    note: &Note<'_>,
    frame: &'f mut [u8; FRAME_MAX],
) -> Result<&'f [u8], FrameError> {
    encode(head, &(NOTE, note), frame)
}

/// The note in an opened frame; none if it is a frame of the device.
pub(super) fn read_note(message: &[u8]) -> Option<Result<Note<'_>, FrameError>> {
    (message.first() == Some(&NOTE)).then(|| read::<(u8, Note<'_>)>(message).map(|(_, note)| note))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use shared::wire::{ToHost, open};

    fn through_a_frame(note: &Note<'_>) {
        let head = Head { sequence: 3, time_us: u64::MAX };
        let mut frame = [0; FRAME_MAX];
        let length = encode_note(head, note, &mut frame).unwrap().len();
        let (heard, message) = open(&mut frame[..length - 1]).unwrap();
        assert_eq!((heard, read_note(message)), (head, Some(Ok(*note))));
        assert_eq!(read::<ToHost<'_>>(message), Err(FrameError::Message));
    }

    #[test]
    fn every_note_comes_back_and_is_never_taken_for_a_message_of_the_device() {
        let port = "/dev/ünplugged".repeat(40);
        through_a_frame(&Note::Opened(Opened { unix_ns: u64::MAX, ..Opened::timeless(&port) }));
        for note in
            [Note::Arrived, Note::Closed, Note::Device(7), Note::Gap(Gap::RowsLost(u64::MAX))]
        {
            through_a_frame(&note);
        }
    }

    proptest! {
        #[test]
        fn no_payload_makes_a_note_a_message_of_the_device(payload in prop::collection::vec(any::<u8>(), 0..40)) {
            let message = [&[NOTE], &payload[..]].concat();
            prop_assert!(read::<ToHost<'_>>(&message).is_err());
            prop_assert!(read_note(&message).is_some());
        }
    }
}
