//! Text that was packed: `.gz` and `.zst`.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

use crate::Error;

/// The largest window that a zstd file may ask for, as a power of two: 128 MiB, what `zstd --long` writes.
const WINDOW: u32 = 27;

/// Opens a file of gzip, one stream or several in a row, as the bytes that were packed.
///
/// # Errors
/// [`Error::Open`]. A damaged stream is an error of the reader, at the place of the damage.
pub fn gzip(path: &Path) -> Result<impl Read + use<>, Error> {
    let file = BufReader::new(File::open(path)?);
    Ok(Named { inner: flate2::bufread::MultiGzDecoder::new(file), format: "gzip", bytes: 0 })
}

/// Opens a file of Zstandard as the bytes that were packed.
///
/// # Errors
/// As [`gzip`].
pub fn zstandard(path: &Path) -> Result<impl Read + use<>, Error> {
    let mut inner = zstd::Decoder::new(File::open(path)?)?;
    inner.window_log_max(WINDOW)?;
    Ok(Named { inner, format: "Zstandard", bytes: 0 })
}

/// Says in each error what was being unpacked, and how far.
struct Named<R> {
    inner: R,
    format: &'static str,
    bytes: u64,
}

impl<R: Read> Read for Named<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(out).map_err(|error| {
            let (format, place) = (self.format, format!("after {} unpacked bytes", self.bytes));
            io::Error::new(error.kind(), Error::damaged(format, place, error))
        })?;
        self.bytes += count as u64;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    const TEXT: &str = "time_s,force_N\n0,1\n0.5,2\n";

    fn gzipped() -> Vec<u8> {
        let mut writer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        writer.write_all(TEXT.as_bytes()).unwrap();
        writer.finish().unwrap()
    }

    fn unpacked(
        bytes: &[u8],
        open: impl Fn(&Path) -> Result<Box<dyn Read>, Error>,
    ) -> io::Result<String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x");
        std::fs::write(&path, bytes).unwrap();
        let mut text = String::new();
        open(&path).unwrap().read_to_string(&mut text).map(|_| text)
    }

    #[test]
    fn several_streams_in_a_row_are_one_text() {
        let read = |bytes: &[u8]| unpacked(bytes, |path| Ok(Box::new(gzip(path)?)));
        let twice = [gzipped(), gzipped()].concat();
        assert_eq!(read(&twice).unwrap(), TEXT.repeat(2));
        let zst = zstd::encode_all(TEXT.as_bytes(), 3).unwrap();
        let read = |bytes: &[u8]| unpacked(bytes, |path| Ok(Box::new(zstandard(path)?)));
        assert_eq!(read(&[zst.clone(), zst].concat()).unwrap(), TEXT.repeat(2));
    }

    #[test]
    fn every_cut_is_an_error_that_names_the_format() {
        let read = |bytes: &[u8]| unpacked(bytes, |path| Ok(Box::new(gzip(path)?)));
        let whole = gzipped();
        for end in 1..whole.len() {
            let error = read(&whole[..end]).unwrap_err().to_string();
            assert!(error.starts_with("gzip, after "), "{end}: {error}");
        }
        let read = |bytes: &[u8]| unpacked(bytes, |path| Ok(Box::new(zstandard(path)?)));
        let whole = zstd::encode_all(TEXT.as_bytes(), 3).unwrap();
        for end in 1..whole.len() {
            let error = read(&whole[..end]).unwrap_err().to_string();
            assert!(error.starts_with("Zstandard, after "), "{end}: {error}");
        }
    }
}
