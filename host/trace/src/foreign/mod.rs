//! Files of other programs that are not plain text: packed text, and files of one or several tables (parts).
//!
//! Their readers are in the crate `palpate-formats`, which the feature `formats` takes in. A table comes out of it as text, one
//! line a row, so that a mapping speaks of it as of any other text. Some of them are written, too.

mod kind;
#[cfg(feature = "formats")]
mod parts;

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use super::error::Error;
use super::{Trace, has_extension, head, read, write};
use crate::files::write_whole;
use kind::{Format, Reader};

/// A file as text.
pub(super) enum Opened {
    /// The text as it is in the file, or was before it was packed.
    Text(Box<dyn Read>),
    /// A table that was made text: UTF-8 with commas and points.
    #[cfg_attr(not(feature = "formats"), expect(dead_code, reason = "only the readers make it"))]
    Part {
        /// Its name, where there are several.
        name: Option<String>,
        /// The text.
        text: Box<dyn Read>,
    },
}

/// Opens a file as text; `part` names one of its tables.
///
/// # Errors
/// Those of the file system, [`Error::Unread`] and the others that speak of formats and parts.
pub(super) fn open(path: &Path, part: Option<&str>) -> Result<Opened, Error> {
    let Some(format) = Format::of(path) else { return plain(path, part) };
    match format.reader {
        Reader::None(instead) => Err(unread(path, format, instead)),
        Reader::Gzip | Reader::Zstandard => {
            no_part(path, part)?;
            unpacked(path, format).map(Opened::Text)
        }
        _ => open_part(path, format, part),
    }
}

/// The trace in a file that is not plain text; none if the file is.
pub(super) fn trace(path: &Path) -> Result<Option<Trace>, Error> {
    let Some(format) = Format::of(path) else { return Ok(None) };
    match format.reader {
        Reader::None(_) | Reader::Gzip | Reader::Zstandard => packed_trace(path, format).map(Some),
        _ => only_trace(path, format).map(Some),
    }
}

/// All traces in a file that is not plain text, such as the curves of a map; none if the file is.
pub(super) fn traces(path: &Path) -> Result<Option<Vec<Trace>>, Error> {
    let Some(format) = Format::of(path) else { return Ok(None) };
    match format.reader {
        Reader::None(_) | Reader::Gzip | Reader::Zstandard => {
            packed_trace(path, format).map(|trace| Some(vec![trace]))
        }
        _ => all_traces(path, format).map(Some),
    }
}

/// The trace in a packed text.
fn packed_trace(path: &Path, format: Format) -> Result<Trace, Error> {
    match format.reader {
        Reader::None(instead) => Err(unread(path, format, instead)),
        _ => {
            let limit = read::UNPACKED_LIMIT;
            let mut bytes = Vec::new();
            let unpacked = unpacked(path, format)?.take(limit + 1).read_to_end(&mut bytes);
            unpacked.map_err(|source| Error::Open { path: path.into(), source })?;
            if bytes.len() as u64 > limit {
                return Err(Error::TooLarge {
                    path: path.into(),
                    bytes: bytes.len() as u64,
                    limit,
                });
            }
            read::parse(path, &bytes)
        }
    }
}

/// A file of another program that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Export {
    /// MATLAB 7.3: a vector for each column.
    Matlab,
    /// MCAP: a message of JSON for each row.
    Mcap,
}

impl Export {
    /// What a file of this name would be.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        let is = |ending| has_extension(path, ending);
        if is("mat") { Some(Self::Matlab) } else { is("mcap").then_some(Self::Mcap) }
    }

    /// Writes a trace whole or not at all, with its head as a text that is not read back.
    ///
    /// # Errors
    /// As [`super::write()`]; [`Error::Foreign`] where the format allows no column of a name, and [`Error::Unbuilt`] where this
    /// program was built without formats of others.
    pub fn write(self, path: &Path, trace: &Trace) -> Result<(), Error> {
        let refused = |source| Error::Write { path: path.into(), source };
        write::checked(trace).map_err(refused)?;
        let head = head::to_toml(&trace.head).map_err(|error| refused(io::Error::other(error)))?;
        let bytes = exported(path, trace, &head, self)?;
        write_whole(path, |file| file.write_all(&bytes)).map_err(refused)
    }
}

fn plain(path: &Path, part: Option<&str>) -> Result<Opened, Error> {
    let open = |source| Error::Open { path: path.into(), source };
    let file = File::open(path).map_err(open)?;
    if file.metadata().map_err(open)?.is_dir() {
        return Err(open(io::Error::from(io::ErrorKind::IsADirectory)));
    }
    no_part(path, part)?;
    Ok(Opened::Text(Box::new(file)))
}

fn no_part(path: &Path, part: Option<&str>) -> Result<(), Error> {
    let none = |part: &str| Error::NoParts { path: path.into(), wanted: part.into() };
    part.map_or(Ok(()), |part| Err(none(part)))
}

fn unread(path: &Path, format: Format, instead: &'static str) -> Error {
    Error::Unread { path: path.into(), format: format.name, instead }
}

#[cfg(feature = "formats")]
use parts::{all_traces, exported, only_trace, open_part, unpacked};

#[cfg(not(feature = "formats"))]
fn unbuilt<T>(path: &Path, format: Format) -> Result<T, Error> {
    Err(Error::Unbuilt { path: path.into(), format: format.name })
}

#[cfg(not(feature = "formats"))]
fn exported(path: &Path, _: &Trace, _: &str, export: Export) -> Result<Vec<u8>, Error> {
    let name = if export == Export::Matlab { "a MATLAB file (7.3)" } else { "an MCAP file" };
    unbuilt(path, Format { name, reader: Reader::None("") })
}

#[cfg(not(feature = "formats"))]
fn unpacked(path: &Path, format: Format) -> Result<Box<dyn Read>, Error> {
    unbuilt(path, format)
}

#[cfg(not(feature = "formats"))]
fn open_part(path: &Path, format: Format, _part: Option<&str>) -> Result<Opened, Error> {
    unbuilt(path, format)
}

#[cfg(not(feature = "formats"))]
fn only_trace(path: &Path, format: Format) -> Result<Trace, Error> {
    unbuilt(path, format)
}

#[cfg(not(feature = "formats"))]
fn all_traces(path: &Path, format: Format) -> Result<Vec<Trace>, Error> {
    unbuilt(path, format)
}
