//! What can be wrong with a recording, each with where it is and what to do about it.

use std::fmt;
use std::io;
use std::path::PathBuf;

use crate::meant::did_you_mean;
use crate::recording;

/// One cell of a table in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub path: PathBuf,
    /// Line in the file, from 1.
    pub line: usize,
    /// Column of the table, from 1.
    pub column: usize,
    /// Name of that column in the header row.
    pub name: String,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, line {}, column {}", self.path.display(), self.line, self.column)?;
        if self.name.is_empty() { Ok(()) } else { write!(f, " ({})", shortened(&self.name)) }
    }
}

/// Why a recording cannot be read or written. The message is whole: it names the place and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file system said no.
    #[error("{}: cannot be read: {source}. Check the name and the permissions.", path.display())]
    Open {
        /// The file or folder.
        path: PathBuf,
        /// What the file system answered.
        source: io::Error,
    },
    /// The file system said no to a result.
    #[error("{}: cannot be written: {source}. Nothing was changed.", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the file system answered.
        source: io::Error,
    },
    /// More than [`super::SIZE_LIMIT`] bytes.
    #[error(
        "{}: {:.1} GB is more than the limit of {:.1} GB. Thin it with \
         `palpate import --every N` and a mapping, or split it.",
        path.display(), *bytes as f64 / 1e9, *limit as f64 / 1e9
    )]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// The largest size that is read.
        limit: u64,
    },
    /// Nothing in the file, or nothing below the head.
    #[error("{}: no header row and no samples. A trace begins with a row such as `time_s,force_N`.", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// A header row with fewer than two samples below it.
    #[error("{}: {samples} sample(s) below the header row of line {line}. A trace has at least two.", path.display())]
    TooShort {
        /// The file.
        path: PathBuf,
        /// Line of the header row.
        line: usize,
        /// How many samples there are.
        samples: usize,
    },
    /// UTF-16, or not text at all.
    #[error(
        "{}, line {line}, column {column}: this is {found}, a trace is UTF-8 text. If it is a recording, \
         bring it in with `palpate import` and a mapping that names its `encoding`.",
        path.display()
    )]
    NotText {
        /// The file.
        path: PathBuf,
        /// Line of the first such byte.
        line: usize,
        /// Column of the table, from 1.
        column: usize,
        /// What it looks like.
        found: &'static str,
    },
    /// A commented line before the header row that is not TOML or has a value that cannot be.
    #[error(
        "{}, line {line}, column {column} of the line: the head is not understood: {message}. Lines that \
         start with `#` hold TOML such as `# name = \"take 3\"`; start a free remark with `##`.",
        path.display()
    )]
    Head {
        /// The file.
        path: PathBuf,
        /// Line in the file.
        line: usize,
        /// Character within that line, from 1.
        column: usize,
        /// What the TOML reader said.
        message: String,
    },
    /// Written by a later version of this program.
    #[error(
        "{}, line {line}: palpate-trace version {found}, this program reads up to version {supported}. \
         Use a newer palpate.",
        path.display()
    )]
    NewerVersion {
        /// The file.
        path: PathBuf,
        /// Line of the key.
        line: usize,
        /// Version in the file.
        found: i64,
        /// Newest version read here.
        supported: i64,
    },
    /// More than any recording has.
    #[error("{}, line {line}: {what}. Is this a trace? `palpate import` takes a part of a foreign recording.", path.display())]
    Beyond {
        /// The file.
        path: PathBuf,
        /// Line in the file.
        line: usize,
        /// Of what there is too much.
        what: String,
    },
    /// Columns are not separated by commas.
    #[error(
        "{}, line {line}, column 1: columns seem to be separated by {found}, a trace uses commas. \
         Bring the file in with `palpate import`.",
        path.display()
    )]
    Delimiter {
        /// The file.
        path: PathBuf,
        /// Line of the header row.
        line: usize,
        /// What seems to separate columns, in words.
        found: &'static str,
    },
    /// The first row holds numbers.
    #[error(
        "{place}: the first row holds numbers, the header row is missing. Put the names of the columns \
         above it (`time_s,displacement_mm,force_N`), or use `palpate import`."
    )]
    NoHeader {
        /// The first cell.
        place: Place,
    },
    /// No column of time.
    #[error(
        "{}, line {line}: no column `time_s`; there are {}. Name the column of time `time_s` if it is in \
         seconds, else use `palpate import`.",
        path.display(), listed(columns)
    )]
    NoTime {
        /// The file.
        path: PathBuf,
        /// Line of the header row.
        line: usize,
        /// The columns there are.
        columns: Vec<String>,
    },
    /// A known quantity under another name or in another unit.
    #[error(
        "{place}: a trace has this quantity as `{expected}`. Convert the values, with `palpate import` \
         for instance; nothing is converted by its name."
    )]
    WrongUnit {
        /// The name in the header row.
        place: Place,
        /// The name a trace uses, with its unit.
        expected: &'static str,
    },
    /// Two columns of one name.
    #[error("{place}: column {first} has the same name. Rename or remove one of them.")]
    DuplicateColumn {
        /// The second of them.
        place: Place,
        /// Number of the first.
        first: usize,
    },
    /// A column without a name.
    #[error(
        "{place}: this column has no name, or one with a control character in it. Name it, or use `palpate import`."
    )]
    ColumnName {
        /// The header cell.
        place: Place,
    },
    /// A row with more or fewer cells than the header row.
    #[error(
        "{place}: the row has {found} cell(s), the header row has {expected}. {}",
        if *found == 2 * *expected { "Decimal commas? Then use `palpate import`." }
        else { "Complete the row or remove it; a cut last line means that recording or copying broke off." }
    )]
    FieldCount {
        /// The first cell that is missing or too many.
        place: Place,
        /// Cells in the header row.
        expected: usize,
        /// Cells in this row.
        found: usize,
    },
    /// Text where a number belongs.
    #[error(
        "{place}: {} is not a number. {}", quoted(text),
        if text.contains(',') { "Decimal commas come in through `palpate import`." }
        else { "Correct the cell or remove the row." }
    )]
    NotANumber {
        /// The cell.
        place: Place,
        /// What it holds.
        text: String,
    },
    /// NaN or infinity, or a number too large to hold.
    #[error(
        "{place}: {} is not a finite number. Remove the row; a gap in time is allowed.",
        quoted(text)
    )]
    NotFinite {
        /// The cell.
        place: Place,
        /// What it holds.
        text: String,
    },
    /// Time that does not increase.
    #[error(
        "{place}: time {time} s {} after {previous} s. {}",
        if time < previous { "goes backwards" } else { "is repeated" },
        "Time increases from row to row; `palpate import` can say what to do with repeated time stamps."
    )]
    TimeOrder {
        /// The later cell.
        place: Place,
        /// Its time, s.
        time: f64,
        /// Time of the row before, s.
        previous: f64,
    },
    /// A Parquet file that cannot be decoded, or does not hold a trace.
    #[error("{}: {message}. A trace in Parquet has plain columns of numbers, `time_s` among them; others come in through `palpate import`.", path.display())]
    Parquet {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
    /// A format whose reader this program was built without.
    #[error(
        "{}: {format}. This palpate was built without other programs' files. From palpate's sources: \
         `cargo install --path host --features formats`.",
        path.display()
    )]
    Unbuilt {
        /// The file.
        path: PathBuf,
        /// What it is.
        format: &'static str,
    },
    /// A format that nothing reads.
    #[error("{}: {format}, which palpate does not read. {instead}", path.display())]
    Unread {
        /// The file.
        path: PathBuf,
        /// What it is.
        format: &'static str,
        /// What to do.
        instead: &'static str,
    },
    /// A file of another program that is damaged, too large, or has no such table.
    #[error("{}: {message}.", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What is wrong, with the place.
        message: String,
    },
    /// Several tables in one file and none of them chosen, or one that is not there.
    #[error(
        "{}: {format}, {}. {}",
        path.display(),
        wanted.as_deref().map_or_else(|| counted(present), |name| format!("no table {}; there are {}", quoted(name), listed(present))),
        if present.is_empty() { "Check the file with the program that wrote it." }
        else { "Say which: `--part NAME`, or `part` under `[table]` of the mapping." }
    )]
    WhichPart {
        /// The file.
        path: PathBuf,
        /// What it is.
        format: &'static str,
        /// The table that was asked for.
        wanted: Option<String>,
        /// The tables there are.
        present: Vec<String>,
    },
    /// A table was named in a file that has only one.
    #[error("{}: a text file is one table, there is no `{wanted}` in it. Leave `part` away.", path.display())]
    NoParts {
        /// The file.
        path: PathBuf,
        /// The table that was asked for.
        wanted: String,
    },
    /// A file of another program in which no table, or more than one, is a trace as it stands.
    #[error(
        "{}: {format} with {} ({}). `palpate import` makes a trace of {}: `palpate import {} --suggest` begins its mapping.",
        path.display(),
        if *several { "several traces" } else { "no table that has a column `time_s`" },
        listed(present),
        if *several { "one of them" } else { "it" },
        path.display()
    )]
    NotOneTrace {
        /// The file.
        path: PathBuf,
        /// What it is.
        format: &'static str,
        /// Whether there are several.
        several: bool,
        /// Those several, else all tables.
        present: Vec<String>,
    },
    /// A recording of a device that cannot be read.
    #[error("{}: {source}", path.display())]
    Recording {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: recording::Error,
    },
    /// A recording of a device in which nothing was streamed.
    #[error("{}: no stream of at least two rows in this recording.", path.display())]
    NoStream {
        /// The file.
        path: PathBuf,
    },
    /// A stretch of a recording whose clock cannot be related to that of the host.
    #[error(
        "{}: the clock of the device cannot be estimated: {reason}. Convert it in the time of the device.",
        path.display()
    )]
    NoClock {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: &'static str,
    },
    /// A folder without traces.
    #[error("{}: no .csv and no .parquet file in this folder.", path.display())]
    EmptyFolder {
        /// The folder.
        path: PathBuf,
    },
    /// No file given.
    #[error("no trace given. Name at least one file or folder.")]
    EmptySet,
    /// The same file twice in one set.
    #[error("{}: given twice ({}). Name each trace once.", path.display(), first.display())]
    SameFile {
        /// The second mention.
        path: PathBuf,
        /// The first.
        first: PathBuf,
    },
    /// Two traces of a set that claim the same place in its order.
    #[error(
        "{}: `{key} = {value}` as in {}. What a specimen remembers depends on the order; give each \
         trace its own.",
        path.display(), first.display()
    )]
    SameOrder {
        /// The second of them.
        path: PathBuf,
        /// The first.
        first: PathBuf,
        /// `setup.sequence` or `setup.start_s`.
        key: &'static str,
        /// The value they share.
        value: String,
    },
}

/// Text from a file, short and printable.
pub(super) fn quoted(text: &str) -> String {
    if text.is_empty() { "an empty cell".into() } else { format!("`{}`", shortened(text)) }
}

/// The beginning of a text from a file, printable.
fn shortened(text: &str) -> String {
    const MAX_CHARS: usize = 40;
    let mut shown: String = text.chars().take(MAX_CHARS).flat_map(char::escape_debug).collect();
    if text.chars().nth(MAX_CHARS).is_some() {
        shown.push('…');
    }
    shown
}

/// The first names of a file.
pub(super) fn listed(names: &[String]) -> String {
    const MAX_NAMES: usize = 20;
    let shown: Vec<String> = names.iter().take(MAX_NAMES).map(|name| shortened(name)).collect();
    let more = names.len().saturating_sub(MAX_NAMES);
    shown.join(", ") + &if more > 0 { format!(" and {more} more") } else { String::new() }
}

/// How many tables a file has, and which.
fn counted(parts: &[String]) -> String {
    match parts {
        [] => "no table of numbers in it".into(),
        several => format!("{} tables: {}", several.len(), listed(several)),
    }
}

/// Why a signal cannot be cut into segments or judged for its noise.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SignalError {
    /// The trace has no such column.
    #[error(
        "{trace}: no column `{column}`{}; there are {}.",
        did_you_mean(column, present.iter().map(String::as_str)),
        listed(present)
    )]
    NoColumn {
        /// The trace's label.
        trace: String,
        /// The column asked for.
        column: String,
        /// The columns there are.
        present: Vec<String>,
    },
    /// No part of the trace in which the controlled quantity rests.
    #[error(
        "{trace}: no hold found: {controlled} never rests on the specimen. Fit the whole motion instead."
    )]
    NoHold {
        /// The trace's label.
        trace: String,
        /// The column whose rest was looked for.
        controlled: String,
    },
    /// A hold with fewer samples than the question needs.
    #[error(
        "{trace}: the hold from {from_s} s has {samples} sample(s), {needed} are needed. Record longer or faster."
    )]
    EmptyHold {
        /// The trace's label.
        trace: String,
        /// Time at which the hold begins, s.
        from_s: f64,
        /// Samples in it.
        samples: usize,
        /// Samples needed.
        needed: usize,
    },
    /// The same value in every sample.
    #[error(
        "{trace}: `{column}` is {value} in every sample: there is nothing to fit. Is the channel connected?"
    )]
    Constant {
        /// The trace's label.
        trace: String,
        /// The column.
        column: String,
        /// Its one value.
        value: f64,
    },
}
