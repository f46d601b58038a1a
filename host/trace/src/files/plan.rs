//! What a call may write: one place decides for every command, before any work is done.
//!
//! - A result lies in a file of its own: not in one that the call reads, nor in that of another result.
//! - Its name ends as its kind does.
//! - A file that is there and that palpate did not write is written over only on demand. A recording or trace may be a
//!   measurement, unless it says that it was computed.
//!
//! What is no regular file (a device, a pipe) is written into, and may be named anywhere.

use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

use super::{folder_of, followed};
use crate as trace;

/// Bytes from the beginning of a file in which its kind is told.
const BEGINNING: u64 = 4096;

/// A kind of result.
#[derive(Debug)]
pub struct Kind {
    /// How its name may end.
    pub endings: &'static [&'static str],
    /// One of these stands near the beginning of each that palpate wrote; none where a measurement may look the same.
    pub marks: &'static [&'static str],
}

/// A model file.
pub const MODEL: Kind = Kind { endings: &["toml"], marks: &["palpate-model = "] };
/// A report.
pub const REPORT: Kind =
    Kind { endings: &["html"], marks: &["<meta name=\"generator\" content=\"palpate "] };
/// A drawing.
pub const DRAWING: Kind =
    Kind { endings: &["svg"], marks: &["<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"pl\""] };
/// A figure for a paper, as a drawing or printed.
pub const FIGURE: Kind =
    Kind { endings: &["svg", "pdf"], marks: &[DRAWING.marks[0], "/Title (palpate: "] };
/// A trace that palpate computed; only as text it can be told from a measurement.
pub const COMPUTED: Kind = Kind { endings: TRACE.endings, marks: &[COMPUTED_HEAD] };
/// The same, or a recording as a device would have made it.
pub const COMPUTED_OR_RECORDING: Kind =
    Kind { endings: TRACE_OR_RECORDING.endings, marks: &[COMPUTED_HEAD, COMPUTED_PORT] };
const COMPUTED_HEAD: &str = "\n# computed_by = \"palpate ";
const COMPUTED_PORT: &str = "computed by palpate ";
/// A trace as text or Parquet.
pub const TRACE: Kind = Kind { endings: &["csv", "parquet"], marks: &[] };
/// A trace, or a recording as a device makes it.
pub const TRACE_OR_RECORDING: Kind =
    Kind { endings: &["csv", "parquet", crate::recording::EXTENSION], marks: &[] };
/// What a trace can be converted to.
pub const CONVERTED: Kind =
    Kind { endings: &["csv", "parquet", crate::recording::EXTENSION, "mat", "mcap"], marks: &[] };
/// What a device sent.
pub const RECORDING: Kind = Kind { endings: &[crate::recording::EXTENSION], marks: &[] };
/// What a device sent, as messages for the tools of robots.
pub const MESSAGES: Kind = Kind { endings: &["mcap"], marks: &[] };
/// A table of results, by its header row.
pub const fn table(header: &'static [&'static str]) -> Kind {
    Kind { endings: &["csv"], marks: header }
}

impl Kind {
    /// Whether nothing is lost with a file: palpate wrote it as one of this kind, or there is nothing in it.
    #[must_use]
    pub fn may_replace(&self, path: &Path) -> bool {
        let mut beginning = Vec::new();
        let read =
            File::open(path).and_then(|file| file.take(BEGINNING).read_to_end(&mut beginning));
        let marked = |mark: &str| String::from_utf8_lossy(&beginning).contains(mark);
        read.is_ok() && (beginning.is_empty() || self.marks.iter().any(|mark| marked(mark)))
    }

    fn names(&self, path: &Path) -> bool {
        self.endings.iter().any(|ending| trace::has_extension(path, ending))
    }
}

/// Whether files that palpate did not write may be written over, and the option that says so.
#[derive(Clone, Copy, Debug)]
pub struct Overwrite {
    /// Whether they may.
    pub allowed: bool,
    /// What the user would have to say.
    pub option: &'static str,
}

/// Why a file is not written.
#[derive(Debug, thiserror::Error)]
pub enum Refused {
    /// A result where an input lies.
    #[error("{}: is read by this call. Choose another name for the result.", .0.display())]
    Input(PathBuf),
    /// A table of numbers in a folder that stands for its traces.
    #[error(
        "{}: lies in a folder that this call reads, and would be read as a trace by the next. Choose another folder.",
        .0.display()
    )]
    AmongInputs(PathBuf),
    /// Two results in one file.
    #[error("{}: is named for two results of this call. Give each a name of its own.", .0.display())]
    Twice(PathBuf),
    /// A name of another kind.
    #[error("{}: the name must end in {}", path.display(), listed(endings))]
    Ending {
        /// The name.
        path: PathBuf,
        /// How it may end.
        endings: &'static [&'static str],
    },
    /// A file that may be precious.
    #[error("{}: exists already. Choose another name, or write over it with {option}.", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
        /// The option that allows it.
        option: &'static str,
    },
}

fn listed(endings: &[&str]) -> String {
    let endings: Vec<String> = endings.iter().map(|ending| format!(".{ending}")).collect();
    match endings.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, rest)) => format!("{} or {last}", rest.join(", ")),
        None => String::new(),
    }
}

/// The files of one call.
#[derive(Debug)]
pub struct Plan {
    overwrite: Overwrite,
    read: Vec<PathBuf>,
    written: Vec<PathBuf>,
}

impl Plan {
    /// A call that reads these files and folders.
    pub fn reading<P: AsRef<Path>>(
        read: impl IntoIterator<Item = P>,
        overwrite: Overwrite,
    ) -> Self {
        let read = read.into_iter().map(|path| real(path.as_ref())).collect();
        Self { overwrite, read, written: Vec::new() }
    }

    /// Whether a result of this kind may be written there.
    ///
    /// # Errors
    /// See [`Refused`].
    pub fn writes(&mut self, path: &Path, kind: &Kind) -> Result<(), Refused> {
        let there = fs::metadata(path);
        if there.as_ref().is_ok_and(|about| !about.is_file() && !about.is_dir()) {
            return Ok(());
        }
        if !kind.names(path) {
            return Err(Refused::Ending { path: path.into(), endings: kind.endings });
        }
        let place = real(path);
        if self.read.contains(&place) {
            return Err(Refused::Input(path.into()));
        }
        let among_inputs = self.read.iter().any(|read| read.is_dir() && folder_of(&place) == read);
        if among_inputs && (TRACE.names(path)) {
            return Err(Refused::AmongInputs(path.into()));
        }
        if self.written.contains(&place) {
            return Err(Refused::Twice(path.into()));
        }
        if there.is_ok() && !self.overwrite.allowed && !kind.may_replace(path) {
            return Err(Refused::Exists { path: path.into(), option: self.overwrite.option });
        }
        self.written.push(place);
        Ok(())
    }
}

/// The one name of a file by which it is known from others, also of one that is not there yet.
fn real(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| {
        let path = followed(path).unwrap_or_else(|_| path.into());
        let folder = folder_of(&path);
        let folder = folder.canonicalize().unwrap_or_else(|_| folder.into());
        path.file_name().map_or(folder.clone(), |name| folder.join(name))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAREFUL: Overwrite = Overwrite { allowed: false, option: "--force" };

    #[test]
    fn a_file_that_is_not_there_yet_is_known_by_its_folder_and_name() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("sub")).unwrap();
        let mut plan = Plan::reading([""; 0], CAREFUL);
        plan.writes(&folder.path().join("a.csv"), &TRACE).unwrap();
        let again = folder.path().join("sub/../a.csv");
        assert!(matches!(plan.writes(&again, &TRACE), Err(Refused::Twice(_))));
        plan.writes(&folder.path().join("b.csv"), &TRACE).unwrap();
    }
}
