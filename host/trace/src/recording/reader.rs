//! Reading a recording, entry by entry.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use shared::wire::{
    FRAME_MAX, FrameError, HEAD, Head, ToHost, introduction, is_understood, open, read,
};

use super::note::{Note, read_note};
use super::{BEGINNING, BEGINNING_OF_SEVERAL, Error, VERSION};

/// What a recording holds, in the order it was written.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)] // There is one at a time, and most are the large one.
pub enum Entry<'a> {
    /// What the device said.
    Frame {
        /// Its sequence number and device time.
        head: Head,
        /// The message, in the words of this release.
        message: ToHost<'a>,
        /// When it arrived, µs since the recording was opened, if that was noted.
        arrived_us: Option<u64>,
    },
    /// What the host noted; never [`Note::Arrived`], which is told with the frame that arrived.
    Note {
        /// When, µs since the recording was opened.
        host_us: u64,
        /// The note.
        note: Note<'a>,
    },
}

/// Reads a recording of any length in constant memory.
#[derive(Debug)]
pub struct Reader<R> {
    input: R,
    /// Bytes read so far.
    read: u64,
    /// Where the last frame began.
    offset: u64,
    /// The last frame, and how many bytes it has; the bytes beyond [`FRAME_MAX`] are only counted.
    frame: [u8; FRAME_MAX],
    length: usize,
    truncated: bool,
    closed: bool,
}

impl Reader<BufReader<File>> {
    /// Opens a file.
    ///
    /// # Errors
    /// Those of [`Reader::new`], and those of the file system.
    pub fn open(path: &Path) -> Result<Self, Error> {
        Self::new(BufReader::with_capacity(1 << 16, File::open(path)?))
    }
}

impl<R: BufRead> Reader<R> {
    /// Reads the beginning. A file that ends within it is a recording cut short, without entries.
    ///
    /// # Errors
    /// [`Error::NotARecording`], [`Error::NewerVersion`], [`Error::Read`].
    pub fn new(input: R) -> Result<Self, Error> {
        let mut reader = Self {
            input,
            read: 0,
            offset: 0,
            frame: [0; FRAME_MAX],
            length: 0,
            truncated: false,
            closed: false,
        };
        let whole = reader.cut()?;
        let begun = &reader.frame[..reader.length.min(FRAME_MAX)];
        if !whole && [BEGINNING, BEGINNING_OF_SEVERAL].iter().any(|line| line.starts_with(begun)) {
            reader.truncated = true;
            return Ok(reader);
        }
        match version(begun) {
            Some(1..=VERSION) if whole => Ok(reader),
            Some(found) if found > VERSION => Err(Error::NewerVersion { found }),
            _ => Err(Error::NotARecording),
        }
    }

    /// The next entry, or none at the end.
    ///
    /// # Errors
    /// [`Error::Damaged`], after which the next call gives the entry behind the damage; [`Error::Schema`], [`Error::Read`].
    pub fn next_entry(&mut self) -> Result<Option<Entry<'_>>, Error> {
        let Some((head, length, arrived_us)) = self.next_frame()? else { return Ok(None) };
        // `open` left the message behind the head, whose last byte its type takes.
        let message = &self.frame[HEAD - 1..HEAD - 1 + length];
        let damaged = |source| Error::Damaged { offset: self.offset, source };
        if let Some(note) = read_note(message) {
            let note = note.map_err(damaged)?;
            if let Note::Opened(opened) = note {
                check_schema("palpate", opened.version, opened.schema)?;
            }
            self.closed = note == Note::Closed;
            return Ok(Some(Entry::Note { host_us: head.time_us, note }));
        }
        if let Some(who) = introduction(message) {
            check_schema("a device with firmware", who.version, who.schema)?;
        }
        self.closed = false;
        let message = read::<ToHost<'_>>(message).map_err(damaged)?.in_words_of_today();
        Ok(Some(Entry::Frame { head, message, arrived_us }))
    }

    /// Head and length of the message of the next frame that is no note of arrival, and when that says it arrived.
    fn next_frame(&mut self) -> Result<Option<(Head, usize, Option<u64>)>, Error> {
        let mut arrived_us = None;
        while self.cut()? {
            let offset = self.offset;
            let damaged = |source| Error::Damaged { offset, source };
            let bytes = self.frame.get_mut(..self.length).ok_or(damaged(FrameError::Shape))?;
            if bytes.is_empty() {
                continue;
            }
            let (head, message) = open(bytes).map_err(damaged)?;
            if read_note(message) == Some(Ok(Note::Arrived)) {
                arrived_us = Some(head.time_us);
                continue;
            }
            return Ok(Some((head, message.len(), arrived_us)));
        }
        self.truncated |= self.length > 0;
        Ok(None)
    }

    /// Takes bytes up to the next zero byte into `frame`; false if the file ends before it.
    fn cut(&mut self) -> Result<bool, Error> {
        (self.offset, self.length) = (self.read, 0);
        loop {
            let bytes = self.input.fill_buf()?;
            if bytes.is_empty() {
                return Ok(false);
            }
            let zero = bytes.iter().position(|byte| *byte == 0);
            let content = &bytes[..zero.unwrap_or(bytes.len())];
            let room = self.frame.get_mut(self.length..).unwrap_or_default();
            for (place, byte) in room.iter_mut().zip(content) {
                *place = *byte;
            }
            self.length += content.len();
            let taken = content.len() + usize::from(zero.is_some());
            self.read += taken as u64;
            self.input.consume(taken);
            if zero.is_some() {
                return Ok(true);
            }
        }
    }

    /// Where in the file the last entry begins.
    #[must_use]
    pub const fn offset(&self) -> u64 {
        self.offset
    }

    /// Whether the file ends within a frame; known once [`Reader::next_entry`] gave none.
    #[must_use]
    pub const fn truncated(&self) -> bool {
        self.truncated
    }

    /// Whether the last entry read says that the recording was ended in order.
    #[must_use]
    pub const fn closed(&self) -> bool {
        self.closed
    }
}

/// The version in the first line of a recording.
fn version(begun: &[u8]) -> Option<u32> {
    let line = std::str::from_utf8(begun).ok()?.lines().next()?;
    line.strip_prefix("palpate-recording ")?.parse().ok()
}

fn check_schema(who: &str, version: &str, schema: u64) -> Result<(), Error> {
    if is_understood(schema) {
        Ok(())
    } else {
        Err(Error::Schema { by: format!("{who} {version}"), schema })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Gap, Opened, Writer};
    use proptest::prelude::*;
    use shared::wire::{Answer, Done, SCHEMA, encode};

    fn answer(to: u32) -> Vec<u8> {
        let answer = ToHost::Answer(Answer { to, outcome: Ok(Done::Carried) });
        let head = Head { sequence: to, time_us: 10 * u64::from(to) };
        let mut frame = [0; FRAME_MAX];
        let bytes = encode(head, &answer, &mut frame).unwrap();
        bytes[..bytes.len() - 1].to_vec()
    }

    fn recorded(write: impl FnOnce(&mut Writer<&mut Vec<u8>>)) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut writer = Writer::new(&mut bytes, &Opened::timeless("tty")).unwrap();
        write(&mut writer);
        drop(writer);
        bytes
    }

    /// Sequence numbers of the frames, whether it was cut, and the damage met.
    fn answers(bytes: &[u8]) -> (Vec<u32>, bool, Vec<u64>) {
        let mut reader = Reader::new(bytes).unwrap();
        let (mut heard, mut damage) = (Vec::new(), Vec::new());
        loop {
            match reader.next_entry() {
                Ok(Some(Entry::Frame { head, .. })) => heard.push(head.sequence),
                Ok(Some(_)) => {}
                Ok(None) => return (heard, reader.truncated(), damage),
                Err(Error::Damaged { offset, .. }) => damage.push(offset),
                Err(error) => panic!("{error}"),
            }
        }
    }

    #[test]
    fn what_was_written_is_read_with_the_time_of_arrival_where_it_was_noted() {
        let bytes = recorded(|writer| {
            for (arrived_us, to) in [(100, 1), (200, 2), (20_100, 3)] {
                writer.frame(arrived_us, &answer(to)).unwrap();
            }
            writer.note(20_200, &Note::Gap(Gap::LinkLost)).unwrap();
        });
        let mut reader = Reader::new(&bytes[..]).unwrap();
        let mut seen = Vec::new();
        while let Some(entry) = reader.next_entry().unwrap() {
            seen.push(match entry {
                Entry::Frame { head, arrived_us, .. } => (u64::from(head.sequence), arrived_us),
                Entry::Note { host_us, .. } => (host_us, None),
            });
        }
        let expected = [(0, None), (1, Some(100)), (2, None), (3, Some(20_100)), (20_200, None)];
        assert_eq!(seen, expected);
        assert!(!reader.truncated() && !reader.closed());
    }

    #[test]
    fn a_recording_ended_in_order_says_so() {
        let mut bytes = Vec::new();
        Writer::new(&mut bytes, &Opened::timeless("tty")).unwrap().close(5).unwrap();
        let mut reader = Reader::new(&bytes[..]).unwrap();
        while reader.next_entry().unwrap().is_some() {}
        assert!(reader.closed());
    }

    #[test]
    fn damage_is_named_by_its_byte_and_what_follows_is_read() {
        let mut bytes = recorded(|writer| {
            (1..=3).for_each(|to| writer.frame(0, &answer(to)).unwrap());
        });
        let frame = answer(2);
        let at = bytes.windows(frame.len()).position(|window| window == frame).unwrap();
        bytes[at + 9] ^= 0x40;
        assert_eq!(answers(&bytes), (vec![1, 3], false, vec![at as u64]));
    }

    #[test]
    fn other_files_and_newer_recordings_are_refused_by_name() {
        let refused = |bytes: &[u8]| Reader::new(bytes).map(drop).unwrap_err().to_string();
        for bytes in
            [&b"time_s,force_N\n0,1\n"[..], &[0; 100], &[7; 1_000], b"palpate-recording x\n\0"]
        {
            assert!(refused(bytes).starts_with("is not a recording"), "{bytes:?}");
        }
        let newer = refused(b"palpate-recording 23\n\0rest");
        assert!(newer.contains("version 23") && newer.contains("version 2"), "{newer}");
    }

    #[test]
    fn a_recording_of_other_messages_is_refused_with_both_versions() {
        let mut bytes = Vec::new();
        let opened = Opened { schema: 12, version: "9.8.7", ..Opened::timeless("") };
        drop(Writer::new(&mut bytes, &opened).unwrap());
        let error = Reader::new(&bytes[..]).unwrap().next_entry().map(drop).unwrap_err();
        let said = error.to_string();
        assert!(
            said.contains("palpate 9.8.7") && said.contains(env!("CARGO_PKG_VERSION")),
            "{said}"
        );
        assert!(said.contains("000000000000000c") && said.contains(&format!("{SCHEMA:016x}")));
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_or_refused(
            noise in prop::collection::vec(any::<u8>(), 0..2_000), begun: bool,
        ) {
            let begin = if begun { BEGINNING } else { &[] };
            let bytes = [begin, &noise].concat();
            if let Ok(mut reader) = Reader::new(&bytes[..]) {
                while !matches!(reader.next_entry(), Ok(None)) {}
            }
        }

        #[test]
        fn a_recording_cut_anywhere_gives_its_whole_frames(cut: prop::sample::Index) {
            let bytes = recorded(|writer| {
                (1..=20).for_each(|to| writer.frame(u64::from(to) * 9_000, &answer(to)).unwrap());
            });
            let cut = &bytes[..cut.index(bytes.len() + 1)];
            let whole = (1..=20).filter(|to| {
                let frame = [answer(*to), vec![0]].concat();
                cut.windows(frame.len()).any(|window| window == frame)
            });
            let (heard, truncated, damage) = answers(cut);
            prop_assert_eq!(heard, whole.collect::<Vec<_>>());
            prop_assert!(damage.is_empty(), "{damage:?}");
            prop_assert_eq!(truncated, cut.last() != Some(&0));
        }
    }
}
