//! What can go wrong when a foreign recording is brought in.

use std::path::PathBuf;

use super::error::{Error, Place, listed, quoted};

/// Why a foreign recording cannot be brought in. The message is whole: it names place and remedy.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] Error),
    /// The mapping is not understood.
    #[error("{}, line {line}, column {column}: the mapping is not understood: {message}.", path.display())]
    Map {
        /// The mapping file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Character within the line, from 1.
        column: usize,
        /// What is wrong.
        message: String,
    },
    /// A mapping of a later version of this program.
    #[error(
        "{}, line {line}: palpate-map version {found}, this program reads up to version {supported}. \
         Use a newer palpate.",
        path.display()
    )]
    NewerMap {
        /// The mapping file.
        path: PathBuf,
        /// Line of the key.
        line: usize,
        /// Version in the file.
        found: i64,
        /// Newest version read here.
        supported: i64,
    },
    /// Bytes that the encoding does not have.
    #[error(
        "{}, line {line}: these bytes are not {encoding}. {}",
        path.display(),
        hint.map_or_else(|| "Correct `encoding` in the mapping.".into(), |name| format!("The file seems to be {name}: set `encoding = \"{name}\"` in the mapping."))
    )]
    Encoding {
        /// The recording.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// The encoding in the mapping.
        encoding: &'static str,
        /// What it seems to be instead.
        hint: Option<&'static str>,
    },
    /// A line too long to be a row.
    #[error("{}, line {line}: longer than {limit} characters, so not a table of numbers in this encoding.", path.display())]
    LongLine {
        /// The recording.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// The longest line that is read.
        limit: usize,
    },
    /// The line that names the columns was not met.
    #[error("{}: {what} not found. Correct `[table]` in the mapping.", path.display())]
    NoTable {
        /// The recording.
        path: PathBuf,
        /// The line or table that was looked for.
        what: String,
    },
    /// A column that the mapping names is not in the file.
    #[error("{}, line {line}: no column {wanted}; there are {}. Correct `from` in the mapping.", path.display(), listed(present))]
    NoColumn {
        /// The recording.
        path: PathBuf,
        /// Line of the header row, or of the first row.
        line: usize,
        /// The column asked for.
        wanted: String,
        /// The columns there are.
        present: Vec<String>,
    },
    /// Two columns of one name where the mapping goes by name.
    #[error("{}, line {line}: {count} columns are named {wanted}. Say which by its place: `from = 3`.", path.display())]
    AmbiguousColumn {
        /// The recording.
        path: PathBuf,
        /// Line of the header row.
        line: usize,
        /// The name.
        wanted: String,
        /// How many there are.
        count: usize,
    },
    /// Tables with different columns cannot be joined.
    #[error("{}, line {line}: this table has other columns than the one before. Choose one with `blocks` and import the others by themselves.", path.display())]
    BlocksDiffer {
        /// The recording.
        path: PathBuf,
        /// Line that names the columns.
        line: usize,
    },
    /// A row with more or fewer cells than the others.
    #[error(
        "{place}: the row has {found} cell(s), {expected} expected. Correct the row, or `delimiter`, `empty_last_cell`, `stop_at_blank` or `last_row` in the mapping."
    )]
    CellCount {
        /// The first cell that is missing or too many.
        place: Place,
        /// Cells expected.
        expected: usize,
        /// Cells found.
        found: usize,
    },
    /// Text where a number belongs.
    #[error(
        "{place}: {} is not a number with decimal mark `{decimal}`. Correct the cell, or `decimal`, `skip_lines`, `comment` or `last_row` in the mapping.{}",
        quoted(text),
        without_value(text)
    )]
    NotANumber {
        /// The cell.
        place: Place,
        /// What it holds.
        text: String,
        /// Decimal mark of the mapping.
        decimal: char,
    },
    /// Text where a written time belongs.
    #[error(
        "{place}: {} is not a time written `{stamp}`. Correct the cell, or `stamp` or `last_row` in the mapping.",
        quoted(text)
    )]
    NotATime {
        /// The cell.
        place: Place,
        /// What it holds.
        text: String,
        /// How the mapping says times are written.
        stamp: &'static str,
    },
    /// No contact from which to count a displacement.
    #[error("{}: `{column}` is to count from contact, and `force_N` does not show where that begins: it is missing, never leaves its noise, or does so from the start. Give a number as `reference`.", path.display())]
    NoContact {
        /// The recording.
        path: PathBuf,
        /// The column.
        column: String,
    },
    /// NaN, infinity, or out of range after conversion.
    #[error(
        "{place}: {} is not a finite number. Remove the row; a gap in time is allowed.{}",
        quoted(text),
        without_value(text)
    )]
    NotFinite {
        /// The cell.
        place: Place,
        /// What it holds.
        text: String,
    },
    /// Time that repeats or goes back.
    #[error(
        "{place}: time {time} s {} after {previous} s. {}",
        if time < previous { "goes backwards" } else { "is repeated" },
        if time < previous { "Take part of the rows (`first_row`, `last_row`), give an even clock (`start_s`, `step_s`) if the rate is known, or where another test begins there, say `restarts = \"split\"` in `[time]`." }
        else { "Say in `[time]` what to do: `repeated = \"keep-first\"`, `\"keep-last\"` or `\"mean\"`." }
    )]
    TimeOrder {
        /// The later cell.
        place: Place,
        /// Its time, s.
        time: f64,
        /// Time before, s.
        previous: f64,
    },
    /// A file of several tests where one is wanted.
    #[error(
        "{}: {tests} tests follow one another, the clock begins anew at each. `palpate import` makes a trace of each.",
        path.display()
    )]
    SeveralTests {
        /// The recording.
        path: PathBuf,
        /// How many.
        tests: usize,
    },
    /// A name that no trace may have.
    #[error("{}: column `{name}` {fault}. Name or drop it in the mapping.", path.display())]
    Name {
        /// The recording.
        path: PathBuf,
        /// The name.
        name: String,
        /// What is wrong with it.
        fault: String,
    },
    /// Fewer than two samples.
    #[error("{}: {samples} sample(s) after the mapping, a trace has at least two. Correct `[table]` in the mapping.", path.display())]
    TooShort {
        /// The recording.
        path: PathBuf,
        /// How many samples there are.
        samples: usize,
    },
    /// A column whose clock shares no time with the recording's.
    #[error("{}: the clock of `{column}` ({from_s} to {to_s} s) shares fewer than two samples with the clock of the recording. Correct `clock` (`unit`, `reference`) in the mapping.", path.display())]
    NoOverlap {
        /// The recording.
        path: PathBuf,
        /// The column.
        column: String,
        /// Its clock's first time, s.
        from_s: f64,
        /// Its clock's last time, s.
        to_s: f64,
    },
    /// Files of one recording with different columns.
    #[error("{}: has other columns than {}. Import them one by one.", path.display(), other.display())]
    PartsDiffer {
        /// The later file.
        path: PathBuf,
        /// The file before.
        other: PathBuf,
    },
    /// Files of one recording that share time.
    #[error("{}: begins at {start} s, before {} ends at {end} s. Files of one recording follow each other; import others one by one.", path.display(), other.display())]
    PartsOverlap {
        /// The later file.
        path: PathBuf,
        /// The file before.
        other: PathBuf,
        /// First time of the later, s.
        start: f64,
        /// Last time of the one before, s.
        end: f64,
    },
    /// Several files and no clock to put them in order.
    #[error(
        "several files are put in order by their time, and the mapping has no column for it. Name one in `[time]` (`from`), or import the files one by one."
    )]
    PartsWithoutClock,
}

/// What to do where a cell without a digit says that it has no value.
fn without_value(text: &str) -> String {
    if text.contains(|c: char| c.is_ascii_digit()) {
        return String::new();
    }
    let words = toml::Value::from(vec![text]);
    format!(
        " If it says that there is no value, `missing = {words}` in `[text]` leaves its row out."
    )
}
