//! Lines of a text file in any encoding, one at a time.

use std::io::Read;
use std::path::{Path, PathBuf};

use encoding_rs::{Decoder, DecoderResult, Encoding};

use super::error::Error;
use super::import_error::ImportError;
use super::read::MAX_LINE;

/// Bytes read at a time.
const CHUNK: usize = 1 << 16;

/// A file as lines; ends of line are `\n`, `\r\n` and `\r`.
pub(super) struct Lines<R = Box<dyn Read>> {
    path: PathBuf,
    input: R,
    decoder: Decoder,
    bytes: Vec<u8>,
    /// Decoded text, of which `taken` bytes are used up.
    text: String,
    taken: usize,
    at_end: bool,
    /// Number of the last line given, from 1.
    pub(super) number: usize,
}

impl<R: Read> Lines<R> {
    /// Reads from anything; `path` is what errors call it.
    pub(super) fn new(path: &Path, input: R, encoding: &'static Encoding) -> Self {
        Self {
            path: path.into(),
            input,
            decoder: encoding.new_decoder_with_bom_removal(),
            bytes: Vec::new(),
            text: String::new(),
            taken: 0,
            at_end: false,
            number: 0,
        }
    }

    /// Puts the next line into `line`, without its end; false after the last.
    pub(super) fn next(&mut self, line: &mut String) -> Result<bool, ImportError> {
        line.clear();
        loop {
            let end = self.text[self.taken..].find(['\n', '\r']).map(|end| self.taken + end);
            // A `\r` at the very end of what is decoded may be half of an end of line.
            let whole = |&end: &usize| self.at_end || end + 1 < self.text.len();
            if let Some(end) = end.filter(whole) {
                line.push_str(&self.text[self.taken..end]);
                let pair = self.text[end..].starts_with("\r\n");
                self.taken = end + 1 + usize::from(pair);
                self.number += 1;
                return Ok(true);
            }
            if self.at_end {
                line.push_str(&self.text[self.taken..]);
                self.taken = self.text.len();
                self.number += usize::from(!line.is_empty());
                return Ok(!line.is_empty());
            }
            if self.text.len() - self.taken > MAX_LINE {
                let (path, line) = (self.path.clone(), self.number + 1);
                return Err(ImportError::LongLine { path, line, limit: MAX_LINE });
            }
            self.text.drain(..self.taken);
            self.taken = 0;
            self.decode_more()?;
        }
    }

    /// Reads and decodes another chunk.
    fn decode_more(&mut self) -> Result<(), ImportError> {
        let kept = self.bytes.len();
        self.bytes.resize(kept + CHUNK, 0);
        let count = self
            .input
            .read(&mut self.bytes[kept..])
            .map_err(|source| Error::Open { path: self.path.clone(), source })?;
        self.bytes.truncate(kept + count);
        let last = count == 0;
        let space = self.decoder.max_utf8_buffer_length(self.bytes.len());
        self.text.reserve(space.unwrap_or(4 * CHUNK));
        let name = self.decoder.encoding().name();
        let mark = [self.bytes.first().copied(), self.bytes.get(1).copied()];
        let (result, used) =
            self.decoder.decode_to_string_without_replacement(&self.bytes, &mut self.text, last);
        self.bytes.drain(..used);
        self.at_end = last;
        if let DecoderResult::Malformed(..) = result {
            let hint = match mark {
                [Some(0xFF), Some(0xFE)] if self.number == 0 => Some("utf-16le"),
                [Some(0xFE), Some(0xFF)] if self.number == 0 => Some("utf-16be"),
                _ => None,
            };
            let line = self.number + 1 + self.text[self.taken..].matches('\n').count();
            return Err(ImportError::Encoding {
                path: self.path.clone(),
                line,
                encoding: name,
                hint,
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives one byte at a time, so that every boundary is hit.
    struct Trickle<'a>(&'a [u8]);

    impl Read for Trickle<'_> {
        fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
            let Some((first, rest)) = self.0.split_first() else { return Ok(0) };
            out[0] = *first;
            self.0 = rest;
            Ok(1)
        }
    }

    fn lines(bytes: &[u8], encoding: &'static Encoding) -> Result<Vec<String>, ImportError> {
        let read = |input: &mut dyn Read| {
            let mut lines = Lines::new(Path::new("f"), input, encoding);
            let (mut all, mut line) = (Vec::new(), String::new());
            while lines.next(&mut line)? {
                all.push(line.clone());
            }
            Ok(all)
        };
        let at_once = read(&mut &bytes[..]);
        let trickled = read(&mut Trickle(bytes));
        if let (Ok(a), Ok(b)) = (&at_once, &trickled) {
            assert_eq!(a, b);
        }
        at_once
    }

    #[test]
    fn every_end_of_line_ends_a_line_once() {
        let found = lines(b"a\r\nb\n\nc\rd", encoding_rs::UTF_8).unwrap();
        assert_eq!(found, ["a", "b", "", "c", "d"]);
        assert_eq!(lines(b"a\r\n\r\n", encoding_rs::UTF_8).unwrap(), ["a", ""]);
        assert!(lines(b"", encoding_rs::UTF_8).unwrap().is_empty());
    }

    #[test]
    fn utf_16_and_latin_1_are_decoded_without_their_mark() {
        let utf16: Vec<u8> = "\u{feff}µ;1\r\n2".encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(lines(&utf16, encoding_rs::UTF_16LE).unwrap(), ["µ;1", "2"]);
        assert_eq!(lines(b"\xB5\n", encoding_rs::WINDOWS_1252).unwrap(), ["µ"]);
    }

    #[test]
    fn wrong_bytes_are_an_error_that_names_the_line_and_guesses_aloud() {
        let utf16: Vec<u8> = "\u{feff}ab".encode_utf16().flat_map(u16::to_le_bytes).collect();
        let error = lines(&utf16, encoding_rs::UTF_8).unwrap_err().to_string();
        assert!(error.contains("encoding = \"utf-16le\""), "{error}");
        let error = lines(b"ok\nn\xB5\n", encoding_rs::UTF_8).unwrap_err().to_string();
        assert!(error.starts_with("f, line 2:"), "{error}");
        let long = vec![b'x'; 3 << 20];
        let mut lines = Lines::new(Path::new("f"), &long[..], encoding_rs::UTF_8);
        assert!(matches!(lines.next(&mut String::new()), Err(ImportError::LongLine { .. })));
    }
}
