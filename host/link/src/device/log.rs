//! The device's log, which only the program that wrote it can put into words.
//!
//! A message is a frame: the address of a string, then what is put into it. The strings are in the firmware's ELF file. This is
//! the format of defmt, whose own decoder brings thirty crates for what no firmware of ours says (CBOR, bit flags, calendar dates).

mod message;
mod strings;

use std::path::{Path, PathBuf};

use strings::Strings;

/// Why the log cannot be read with a file.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum LogError {
    #[error("{} cannot be read: {source}", path.display())]
    Read { path: PathBuf, source: std::io::Error },
    #[error("{} is no firmware with a log: {reason}", path.display())]
    NoLog { path: PathBuf, reason: String },
    #[error(
        "{} is not the firmware of this device, which was made from git state {git}; its log would be put into wrong \
         words. Build that state, or give --force",
        path.display()
    )]
    Another { path: PathBuf, git: String },
}

/// The words of a firmware's log.
pub struct Words {
    strings: Strings,
}

impl Words {
    /// Takes them from a firmware's ELF file. It must contain the git state of the device, where that is known.
    ///
    /// # Errors
    /// [`LogError`].
    pub fn read(elf: &Path, git: &str) -> Result<Self, LogError> {
        let path = || elf.to_owned();
        let bytes = std::fs::read(elf).map_err(|source| LogError::Read { path: path(), source })?;
        let none = |reason: String| LogError::NoLog { path: path(), reason };
        let strings = Strings::read(&bytes).map_err(none)?;
        if !git.is_empty() && !bytes.windows(git.len()).any(|part| part == git.as_bytes()) {
            return Err(LogError::Another { path: path(), git: git.into() });
        }
        Ok(Self { strings })
    }

    /// A stream that is put into words.
    #[must_use]
    pub fn stream(&self) -> Stream<'_> {
        Stream { strings: &self.strings, waiting: Vec::new() }
    }
}

/// A stream of log in pieces.
pub struct Stream<'w> {
    strings: &'w Strings,
    /// Bytes of a frame that has not ended.
    waiting: Vec<u8>,
}

/// What a piece of log completed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Line {
    /// A line of words.
    Words(String),
    /// Bytes without a meaning in these words.
    Malformed,
}

impl Stream<'_> {
    /// The lines that a piece completes.
    pub fn take(&mut self, piece: &[u8]) -> Vec<Line> {
        self.waiting.extend_from_slice(piece);
        // Zero bytes stand between frames; what is behind the last one goes on in the next piece.
        let ended = self.waiting.iter().rposition(|byte| *byte == 0).map_or(0, |end| end + 1);
        let frames = self.waiting.drain(..ended).collect::<Vec<_>>();
        let frames = frames.split(|byte| *byte == 0).filter(|frame| !frame.is_empty());
        let words = |frame| message::words(self.strings, &unpacked(frame)?);
        frames.map(|frame| words(frame).map_or(Line::Malformed, Line::Words)).collect()
    }
}

/// A frame as it was before the reverse-zero-compressing COBS of defmt took the zeros out; none where it cannot be one.
///
/// It is read from its end: a byte below 128 says which of the seven before it were zero, a larger one how many follow before a
/// zero.
fn unpacked(frame: &[u8]) -> Option<Vec<u8>> {
    let mut packed = frame.iter().rev().copied();
    let mut bytes = Vec::new();
    while let Some(code) = packed.next() {
        match code {
            0 => return None,
            1..0x80 => {
                for k in (0..7).rev() {
                    bytes.push(if code >> k & 1 == 0 { packed.next()? } else { 0 });
                }
            }
            _ => {
                if code < 0xff {
                    bytes.push(0);
                }
                for _ in 0..code & 0x7f {
                    bytes.push(packed.next()?);
                }
                for _ in 0..7 {
                    bytes.push(packed.next()?);
                }
            }
        }
    }
    bytes.reverse();
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, RngExt, SeedableRng};

    #[test]
    fn a_file_that_is_no_firmware_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("text.elf");
        std::fs::write(&path, "not an executable").unwrap();
        let refused = Words::read(&path, "").map(drop).unwrap_err().to_string();
        assert!(refused.contains("text.elf is no firmware with a log"), "{refused}");
        // This test is an executable, but of another kind.
        let test = std::env::current_exe().unwrap();
        let refused = Words::read(&test, "").map(drop).unwrap_err().to_string();
        assert!(refused.contains(".defmt"), "{refused}");
    }

    /// What a firmware could say, beside a timestamp; the first three are parts of others.
    const FORMATS: [(&str, &str); 35] = [
        ("defmt_str", "interned"),
        ("defmt_derived", "Off|On({=u8})|Level { at: {=i16}, of: {=?} }"),
        ("defmt_prim", "{=u8}"),
        ("defmt_info", "palpate {=str} on {=istr}, {=u32} MHz"),
        ("defmt_warn", "converter: {=__internal_Debug}"),
        ("defmt_error", "{=bool} {=char} {=u8} {=u16} {=u64} {=u128} {=usize}"),
        ("defmt_debug", "{=i8} {=i16} {=i32} {=i64} {=i128} {=isize}"),
        ("defmt_trace", "{=f32} and {=f64}"),
        ("defmt_println", "{=?:x}"),
        ("defmt_println", "{=?:?}"),
        ("defmt_info", "{=[?]}"),
        ("defmt_info", "{=[?]:?} {=[?;3]:#04x}"),
        ("defmt_info", "{=[u8]} {=[u8;4]}"),
        ("defmt_info", "{=[u8]:a} {=[u8]:x} {=[u8;2]:#010b}"),
        ("defmt_info", "{=__internal_FormatSequence}"),
        ("defmt_info", "{0=0..3} {0=4..9} {0=13..17:b} {1=u8}"),
        ("defmt_info", "{0=8..24:a} {0=8..24}"),
        ("defmt_info", "{1=u8} {0=u16} {1=u8:X}"),
        ("defmt_info", "{=u32:08} {=i32:06} {=u8:02x} {=u16:#06X}"),
        ("defmt_info", "{=i8:x} {=i16:#x} {=i32:X} {=i64:#X} {=i128:x}"),
        ("defmt_info", "{=i8:b} {=i16:#o} {=u8:o} {=u16:#b}"),
        ("defmt_info", "{=u32:us} {=u64:ms} {=u64:us}"),
        ("defmt_info", "{=u64:tus} {=u64:tms} {=u64:ts}"),
        ("defmt_info", "{=str:?} {=istr:?} {=__internal_Display:?}"),
        ("defmt_info", "{{ {=u8:?} }}"),
        ("defmt_info", ""),
        ("defmt_write", "{=u16:x}"),
        ("defmt_info", "{=u8:unheard}"),
        ("another_tool", "{=u8}"),
        ("defmt_info", "{=u8"),
        ("defmt_info", "{=f32:?} {=bool:x} {=char:?}"),
        ("defmt_info", "{=?:a}"),
        ("defmt_info", "{=?:us}"),
        ("defmt_derived", "Wrapped({=?})"),
        ("defmt_info", "{=[u8;64]}"),
    ];

    /// An ELF file for a 32-bit processor with these symbols in a section `.defmt`.
    fn elf(timestamp: &str) -> Vec<u8> {
        let name = |tag: &str, data: &str, k: usize| {
            let data = data.replace('"', "\\\"");
            format!(
                r#"{{"package":"p","tag":"{tag}","data":"{data}","disambiguator":"{k}","crate_name":"c"}}"#
            )
        };
        let logged = FORMATS.iter().enumerate();
        let mut symbols: Vec<(u32, u16, String)> =
            logged.map(|(k, (tag, data))| (k as u32 + 1, 1, name(tag, data, k))).collect();
        symbols.push((99, 1, name("defmt_timestamp", timestamp, 99)));
        symbols.push((0, 0xfff1, "\"_defmt_version_ = 4\"".into()));
        symbols.push((0, 0xfff1, "_defmt_encoding_ = rzcobs".into()));
        let (mut names, mut table) = (vec![0], vec![0; 16]);
        for (address, section, name) in symbols {
            table.extend((names.len() as u32).to_le_bytes());
            table.extend([address, 1].map(u32::to_le_bytes).concat());
            table.extend([0x11, 0]);
            table.extend(section.to_le_bytes());
            names.extend(name.as_bytes());
            names.push(0);
        }
        let titles = b"\0.defmt\0.symtab\0.strtab\0.shstrtab\0".to_vec();
        let bodies = [vec![0; 128], table, names, titles];
        // Name, kind, link, size of an entry.
        let heads = [(1, 1, 0, 0), (8, 2, 3, 16), (16, 3, 0, 0), (24, 3, 0, 0)];
        let mut file = b"\x7fELF\x01\x01\x01".to_vec();
        file.resize(52, 0);
        let mut sections = vec![0; 40];
        for ((name, kind, link, entry), body) in heads.into_iter().zip(bodies) {
            let fields =
                [name, kind, 0, 0, file.len() as u32, body.len() as u32, link, 1, 1, entry];
            sections.extend(fields.map(u32::to_le_bytes).concat());
            file.extend(body);
            file.resize(file.len().next_multiple_of(4), 0);
        }
        let table = (file.len() as u32).to_le_bytes();
        file[16..24].copy_from_slice(&[2, 0, 40, 0, 1, 0, 0, 0]);
        file[32..36].copy_from_slice(&table);
        file[40..52].copy_from_slice(&[52, 0, 0, 0, 0, 0, 40, 0, 5, 0, 4, 0]);
        file.extend(sections);
        file
    }

    #[test]
    fn every_message_reads_as_defmt_reads_it() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        for timestamp in ["{=u64:us}", "{=u32:tms}"] {
            let file = elf(timestamp);
            let theirs = defmt_decoder::Table::parse(&file).unwrap().unwrap();
            let ours = Strings::read(&file).unwrap();
            let mut read = [0; FORMATS.len()];
            for k in 0..200 * FORMATS.len() {
                let address = k % FORMATS.len();
                // With or without an exponent is not the same, see below.
                if FORMATS[address].1.contains("{=f") {
                    continue;
                }
                let mut frame = vec![address as u8 + 1, 0];
                // A list that is said to be very long lets their decoder end the program.
                let list = FORMATS[address].1.contains("[?]");
                for _ in 0..random.random_range(0..40) {
                    match random.random_range(0..8) {
                        _ if list => frame.extend([random.random_range(0..6), 0, 0, 0]),
                        0..3 => frame.extend([random.random_range(0..6), 0, 0, 0]),
                        3 | 4 => frame.extend([random.random_range(0..4), 0]),
                        5 => frame.push(random.random_range(0..40)),
                        6 => frame.push(0xff),
                        _ => frame.push(random.next_u32() as u8),
                    }
                }
                let expected =
                    theirs.decode(&frame).ok().map(|(frame, _)| frame.display(false).to_string());
                let found = message::words(&ours, &frame);
                assert_eq!(found, expected, "{:?} {frame:?}", FORMATS[address]);
                read[address] += usize::from(found.is_some());
            }
            // What neither reads: a tag of another tool, a format that is cut off; or seldom: a part of others by itself.
            let never = |k: usize| {
                let (tag, format) = FORMATS[k];
                matches!(tag, "another_tool" | "defmt_derived")
                    || format == "{=u8"
                    || format.contains("{=f")
            };
            let rarely: Vec<_> = (0..FORMATS.len())
                .filter(|k| read[*k] == 0 && !never(*k))
                .map(|k| FORMATS[k])
                .collect();
            assert!(rarely.is_empty(), "{rarely:?}");
        }
    }

    #[test]
    fn a_number_with_a_point_has_the_fewest_digits_that_give_it_back() {
        let ours = Strings::read(&elf("{=u32:ms}")).unwrap();
        let floats = FORMATS.iter().position(|(_, format)| *format == "{=f32} and {=f64}").unwrap();
        for (a, b, printed) in [
            (0.1, -2.5, "0.1 and -2.5"),
            (f32::MAX, 1e-300, "3.4028235e38 and 1e-300"),
            (f32::NAN, f64::NEG_INFINITY, "NaN and -inf"),
        ] {
            let frame =
                [&[floats as u8 + 1, 0, 1, 0, 0, 0], &a.to_le_bytes()[..], &b.to_le_bytes()];
            let expected = format!("0.001 TRACE {printed}");
            assert_eq!(message::words(&ours, &frame.concat()), Some(expected));
        }
    }

    #[test]
    fn a_length_that_was_damaged_is_no_message() {
        let ours = Strings::read(&elf("{=u32:ms}")).unwrap();
        for list in ["{=[?]}", "{=[u8]} {=[u8;4]}"] {
            let address = FORMATS.iter().position(|(_, format)| *format == list).unwrap() as u8 + 1;
            let frame = [address, 0, 1, 0, 0, 0, 0xff, 0xff, 0xff, 0xff, 26, 0];
            assert_eq!(message::words(&ours, &frame), None);
        }
    }

    #[test]
    fn a_stream_in_pieces_gives_the_lines_of_defmt() {
        let file = elf("{=u64:us}");
        let theirs = defmt_decoder::Table::parse(&file).unwrap().unwrap();
        let words = Words { strings: Strings::read(&file).unwrap() };
        // Frames of packed groups in any order, the first with the address of the last format; some are cut short.
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let mut bytes = vec![0, 0];
        for frame in 0..300 {
            bytes.extend([FORMATS.len() as u8, 0b111_1110]);
            for _ in 0..random.random_range(3..12) {
                let (taken, code) = match random.random_range(0..4) {
                    0 => (134, 0xff),
                    1 => {
                        let more = random.random_range(0..127);
                        (usize::from(more) + 7, 0x80 | more)
                    }
                    _ => {
                        let zeros: u8 = random.random_range(1..128);
                        (7 - zeros.count_ones() as usize, zeros)
                    }
                };
                bytes.extend((0..taken).map(|_| random.random_range(1..=255_u8)));
                bytes.push(code);
            }
            if frame % 7 == 0 {
                bytes.truncate(bytes.len() - 3);
            }
            bytes.extend([0, 0]);
        }
        let mut expected = Vec::new();
        let mut decoder = theirs.new_stream_decoder();
        decoder.received(&bytes);
        loop {
            expected.push(match decoder.decode() {
                Ok(frame) => Line::Words(frame.display(false).to_string()),
                Err(defmt_decoder::DecodeError::Malformed) => Line::Malformed,
                Err(defmt_decoder::DecodeError::UnexpectedEof) => break,
            });
        }
        let read = expected.iter().filter(|line| **line != Line::Malformed).count();
        assert!((200..300).contains(&read), "{read}");
        for piece in [1, 3, 64, bytes.len()] {
            let mut stream = words.stream();
            let lines: Vec<Line> =
                bytes.chunks(piece).flat_map(|piece| stream.take(piece)).collect();
            assert!(lines == expected, "pieces of {piece} bytes");
        }
    }
}
