//! The mapping file: says, once and in writing, how a foreign recording becomes a trace.

use std::path::Path;

use encoding_rs::Encoding;
use serde::{Deserialize, Serialize};

use super::import_error::ImportError;
use super::units::{self, Conversion, Quantity, Unit};
use super::{Head, Stamp, TIME, read};

/// Major version of the mapping format this program reads.
pub const MAP_VERSION: i64 = 1;
/// Marks between thousands.
pub(super) const THOUSANDS: [char; 7] = [',', '.', '\'', '’', ' ', '\u{a0}', '\u{202f}'];
/// Largest mapping file that is read, bytes.
const MAP_SIZE_LIMIT: u64 = 1 << 20;

/// A mapping file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mapping {
    /// Major version of the mapping format.
    #[serde(rename = "palpate-map")]
    pub version: i64,
    /// What it is for, in free words.
    #[serde(default)]
    pub about: String,
    /// Keep every so many-th sample; all if absent.
    pub every: Option<usize>,
    /// What happens to columns that the mapping does not name.
    #[serde(default)]
    pub others: Others,
    /// How the bytes are text and numbers.
    #[serde(default)]
    pub text: Text,
    /// Where in the text the table is.
    #[serde(default)]
    pub table: Table,
    /// The clock of the recording.
    pub time: Time,
    /// The other columns.
    #[serde(default)]
    pub column: Vec<Column>,
    /// What the head of the trace will say.
    #[serde(default)]
    pub head: Head,
    /// The file it was read from.
    #[serde(skip)]
    pub name: String,
    /// Its text, kept in the head of each trace it made.
    #[serde(skip)]
    pub source: String,
}

/// What happens to columns that the mapping does not name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Others {
    /// Those that hold numbers throughout are kept under a name of letters, digits and underscores.
    #[default]
    Keep,
    /// They are left out.
    Drop,
}

/// How the bytes are text and numbers.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Text {
    /// Name of the encoding as on the web: `utf-8`, `utf-16le`, `windows-1252`, `iso-8859-15` …
    pub encoding: String,
    /// What separates cells.
    pub delimiter: Delimiter,
    /// The decimal mark, `.` or `,`.
    pub decimal: char,
    /// What stands between thousands: a comma, a point, a blank or an apostrophe; nothing if absent.
    pub thousands: Option<char>,
    /// What a cell without a value says (`NaN`, `-`, or nothing at all); a row with such a cell in a column that the mapping names is
    /// left out.
    pub missing: Vec<String>,
    /// Lines that start with this are skipped.
    pub comment: Option<String>,
}

impl Default for Text {
    fn default() -> Self {
        Self {
            encoding: "utf-8".into(),
            delimiter: Delimiter::Comma,
            decimal: '.',
            thousands: None,
            missing: Vec::new(),
            comment: None,
        }
    }
}

/// What separates cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Delimiter {
    /// `,`
    Comma,
    /// `;`
    Semicolon,
    /// One tab.
    Tab,
    /// Any run of spaces and tabs.
    Space,
}

/// Where in the text the table is.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Table {
    /// Which of several tables of the file: sheet, group, topic; the only one if absent.
    pub part: Option<String>,
    /// Line of the header row, from 1.
    pub header_line: Option<usize>,
    /// Or what the line that names the columns starts with (`# columns:`).
    pub header_prefix: Option<String>,
    /// Lines to skip below the header (a row of units), or from the top if there is none.
    pub skip_lines: usize,
    /// Whether every row ends with a delimiter, that is with an empty cell.
    pub empty_last_cell: bool,
    /// First row of numbers to take, from 1.
    pub first_row: Option<usize>,
    /// Last row of numbers to take.
    pub last_row: Option<usize>,
    /// Whether a blank line ends the table; otherwise blank lines are skipped.
    pub stop_at_blank: bool,
    /// A line that starts with this ends the table.
    pub stop_at_prefix: Option<String>,
    /// A line that starts with this begins a further table.
    pub block_prefix: Option<String>,
    /// Whether that line is also the one that names the columns.
    pub block_names: bool,
    /// Which of those tables to join, counted from 0 and increasing; all if absent.
    pub blocks: Option<Vec<usize>>,
}

/// A column of the file: by its name in the header row, or by its place from 1.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(untagged)]
pub enum From {
    /// Name in the header row.
    Name(String),
    /// Place, from 1.
    Place(usize),
}

impl std::fmt::Display for From {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Name(name) => write!(f, "`{name}`"),
            Self::Place(place) => write!(f, "number {place}"),
        }
    }
}

/// What is subtracted from a column in the end.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Reference {
    /// A value in the unit of the trace.
    Value(f64),
    /// A sample that is found.
    Word(Word),
}

/// Which sample of a column is subtracted from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Word {
    /// The first.
    First,
    /// The one at which contact begins, by `force_N`.
    Contact,
}

/// What to do where a time stamp is the same as the one before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Repeated {
    /// Stop and name the line.
    #[default]
    Error,
    /// Keep the first of the rows.
    KeepFirst,
    /// Keep the last of the rows.
    KeepLast,
    /// One row with the mean of each column.
    Mean,
}

/// What to do where the clock begins anew: it falls by at least half of what it has counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Restarts {
    /// Stop and name the line.
    #[default]
    Error,
    /// What follows is another test: a trace of its own.
    Split,
}

/// The clock of the recording: a column, or a first time and a step.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Time {
    /// The column it is in.
    pub from: Option<From>,
    /// Its unit, `s` if absent.
    pub unit: Option<String>,
    /// How it is written, where it is no plain number.
    pub stamp: Option<Stamp>,
    /// What is subtracted in the end, s.
    pub reference: Option<Reference>,
    /// Without a column: time of the first row, s.
    pub start_s: Option<f64>,
    /// Without a column: time from row to row, s.
    pub step_s: Option<f64>,
    /// What to do with repeated time stamps.
    #[serde(default)]
    pub repeated: Repeated,
    /// What to do where the clock begins anew.
    #[serde(default)]
    pub restarts: Restarts,
}

/// One column of the trace.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// The column of the file.
    pub from: From,
    /// Its name in the trace, which ends in the unit it will have.
    pub name: String,
    /// The unit in the file; the values are left alone if absent.
    pub unit: Option<String>,
    /// First step: factor on the number in the file.
    pub scale: Option<f64>,
    /// First step: what is added after the factor, in the unit of the file.
    pub offset: Option<f64>,
    /// Stress becomes force over this area, mm².
    pub area_mm2: Option<f64>,
    /// Strain becomes displacement over this length, mm.
    pub gauge_length_mm: Option<f64>,
    /// Whether the sign is turned.
    #[serde(default)]
    pub negate: bool,
    /// What is subtracted in the end, in the unit of the trace.
    pub reference: Option<Reference>,
    /// The column's own clock; its values are interpolated onto the clock of the recording.
    pub clock: Option<Clock>,
}

/// The clock of one column.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Clock {
    /// The column it is in.
    pub from: From,
    /// Its unit, `s` if absent.
    pub unit: Option<String>,
    /// What is subtracted in the end, s: where this clock's zero lies on the clock of the recording.
    pub reference: Option<f64>,
}

/// From a number in the file to a number in the trace, but for the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Change {
    scale: f64,
    offset: f64,
    unit: Conversion,
    measure: f64,
    last: Conversion,
}

const SAME: Conversion = Conversion { multiply: 1.0, divide: 1.0, add: 0.0 };

impl Change {
    /// Nothing changes.
    pub(super) const NONE: Self =
        Self { scale: 1.0, offset: 0.0, unit: SAME, measure: 1.0, last: SAME };

    pub(super) fn apply(&self, value: f64) -> f64 {
        self.last.apply(self.unit.apply(value * self.scale + self.offset) * self.measure)
    }

    /// Of a clock in a named unit.
    pub(super) fn clock(unit: Option<&str>) -> Result<Self, String> {
        let from = known(unit.unwrap_or("s"))?;
        Ok(Self { unit: convert(from, known("s")?)?, ..Self::NONE })
    }
}

impl Column {
    /// How its numbers change.
    pub(super) fn change(&self) -> Result<Change, String> {
        let sign = if self.negate { -1.0 } else { 1.0 };
        let mut change = Change {
            scale: self.scale.unwrap_or(1.0),
            offset: self.offset.unwrap_or(0.0),
            measure: sign,
            ..Change::NONE
        };
        let Some(unit) = &self.unit else {
            return if self.area_mm2.or(self.gauge_length_mm).is_some() {
                Err("`area_mm2` and `gauge_length_mm` need the `unit` of the column".into())
            } else {
                Ok(change)
            };
        };
        let from = known(unit)?;
        let to = units::of_column(&self.name).ok_or_else(|| {
            format!(
                "the name `{}` does not end in a unit known here; use `scale` instead",
                self.name
            )
        })?;
        // 1 MPa over 1 mm² is 1 N; a strain of 1 over 1 mm is 1 mm.
        let (through, made, measure) = match (self.area_mm2, self.gauge_length_mm) {
            (None, None) => (to, to, 1.0),
            (Some(area), None) => (known("MPa")?, known("N")?, area),
            (None, Some(length)) => (known("1")?, known("mm")?, length),
            _ => return Err("`area_mm2` and `gauge_length_mm` exclude each other".into()),
        };
        change.unit = convert(from, through)?;
        change.last = convert(made, to)?;
        change.measure = sign * measure;
        Ok(change)
    }
}

fn known(unit: &str) -> Result<&'static Unit, String> {
    units::named(unit).ok_or_else(|| {
        let names: Vec<_> = units::UNITS.iter().map(|unit| unit.name).collect();
        format!("unit `{unit}` is not known; there are {}. Or use `scale`", names.join(" "))
    })
}

fn convert(from: &Unit, to: &Unit) -> Result<Conversion, String> {
    from.conversion(to).ok_or_else(|| {
        let hint = match (from.quantity, to.quantity) {
            (Quantity::Stress, Quantity::Force) => " (give `area_mm2`)",
            (Quantity::Ratio, Quantity::Length) => " (give `gauge_length_mm`)",
            _ => "",
        };
        format!("`{}` does not convert to `{}`{hint}", from.name, to.name)
    })
}

impl Mapping {
    /// Reads a mapping file.
    ///
    /// # Errors
    /// [`ImportError::Map`] with line and column, [`ImportError::NewerMap`], or that the file cannot
    /// be read.
    pub fn read(path: &Path) -> Result<Self, ImportError> {
        let bytes = read::load(path, MAP_SIZE_LIMIT)?;
        let text = String::from_utf8(bytes).map_err(|error| ImportError::Map {
            path: path.into(),
            line: read::line_of(error.as_bytes(), error.utf8_error().valid_up_to()),
            column: 1,
            message: "not UTF-8 text".into(),
        })?;
        Self::parse(path, &text)
    }

    /// Reads a mapping from its text; `path` is what errors call it.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(path: &Path, text: &str) -> Result<Self, ImportError> {
        let place = |at: usize| {
            let before = &text[..at.min(text.len())];
            let within = before.chars().rev().take_while(|&c| c != '\n').count();
            (1 + before.matches('\n').count(), within + 1)
        };
        let fault = |error: &toml::de::Error| {
            let (line, column) = place(error.span().map_or(0, |span| span.start));
            let message = error.message().trim().replace('\n', ", ");
            ImportError::Map { path: path.into(), line, column, message }
        };
        let table: toml::Table = text.parse().map_err(|error| fault(&error))?;
        if let Some(found) = table.get("palpate-map").and_then(toml::Value::as_integer)
            && found > MAP_VERSION
        {
            let (line, _) = place(text.find("palpate-map").unwrap_or(0));
            let path = path.into();
            return Err(ImportError::NewerMap { path, line, found, supported: MAP_VERSION });
        }
        let mut mapping: Self = toml::from_str(text).map_err(|error| fault(&error))?;
        mapping.name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        mapping.source = text.into();
        mapping.check().map_err(|(about, message)| {
            let (line, column) = place(text.find(&about).unwrap_or(0));
            ImportError::Map { path: path.into(), line, column, message }
        })?;
        Ok(mapping)
    }

    /// What TOML cannot check: a word of the file near which the fault is, and the fault.
    fn check(&self) -> Result<(), (String, String)> {
        let fault = |about: &str, message: &str| Err((about.to_owned(), message.to_owned()));
        if self.version < 1 {
            return fault("palpate-map", "palpate-map is a version, from 1");
        }
        if self.every == Some(0) {
            return fault("every", "`every` counts from 1");
        }
        if self.encoding().is_none() {
            return fault("encoding", "no such encoding; try `utf-8`, `utf-16le`, `windows-1252`");
        }
        if !matches!(self.text.decimal, '.' | ',') {
            return fault("decimal", "the decimal mark is `.` or `,`");
        }
        if self
            .text
            .thousands
            .is_some_and(|mark| mark == self.text.decimal || !THOUSANDS.contains(&mark))
        {
            return fault(
                "thousands",
                "thousands are told by `,` `.` `'` or a blank, and not by the decimal mark",
            );
        }
        if self.text.decimal == ',' && self.text.delimiter == Delimiter::Comma {
            return fault("decimal", "a comma cannot separate both cells and decimals");
        }
        self.check_table()?;
        self.check_columns()?;
        self.head.check().map_err(|message| ("[head".to_owned(), message))
    }

    fn check_table(&self) -> Result<(), (String, String)> {
        let fault = |about: &str, message: &str| Err((about.to_owned(), message.to_owned()));
        let table = &self.table;
        if table.header_line.is_some() && table.header_prefix.is_some() {
            return fault("header_prefix", "`header_line` and `header_prefix` exclude each other");
        }
        if table.header_line == Some(0) || table.first_row == Some(0) || table.last_row == Some(0) {
            return fault("[table", "lines and rows count from 1");
        }
        if table.block_prefix.is_some() && table.header_line.is_some() {
            return fault(
                "header_line",
                "with `block_prefix` each table is named by `header_prefix`",
            );
        }
        if table.blocks.is_some() && table.block_prefix.is_none() {
            return fault("blocks", "`blocks` needs `block_prefix`");
        }
        if table.block_names && (table.block_prefix.is_none() || table.header_prefix.is_some()) {
            return fault(
                "block_names",
                "`block_names` needs `block_prefix` and no `header_prefix`",
            );
        }
        let increasing = |blocks: &Vec<usize>| blocks.windows(2).all(|pair| pair[0] < pair[1]);
        if table.blocks.as_ref().is_some_and(|blocks| blocks.is_empty() || !increasing(blocks)) {
            return fault("blocks", "`blocks` lists at least one table, in increasing order");
        }
        Ok(())
    }

    fn check_columns(&self) -> Result<(), (String, String)> {
        let fault = |about: &str, message: &str| Err((about.to_owned(), message.to_owned()));
        let time = &self.time;
        let even = time.start_s.is_some() || time.step_s.is_some();
        if time.from.is_some() == even {
            return fault("[time", "time is either `from` a column or `start_s` with `step_s`");
        }
        if even && (time.unit.is_some() || time.reference.is_some()) {
            return fault("[time", "`unit` and `reference` belong to a time that is in a column");
        }
        if time.stamp.is_some() && (even || time.unit.is_some()) {
            return fault("[time", "`stamp` is of a time in a column, and has no `unit`");
        }
        let splits = time.restarts == Restarts::Split;
        if splits && (time.from.is_none() || time.stamp.is_some()) {
            return fault("restarts", "`restarts` is of a time in a column that counts");
        }
        if splits && self.column.iter().any(|column| column.clock.is_some()) {
            return fault("restarts", "`restarts` is of a recording with one clock");
        }
        if time.reference == Some(Reference::Word(Word::Contact)) {
            return fault("[time", "`reference = \"contact\"` is of other columns than time");
        }
        let step = time.step_s.zip(time.start_s);
        if even && !step.is_some_and(|(step, start)| step > 0.0 && (step + start).is_finite()) {
            return fault("[time", "both `start_s` and a `step_s` above 0 are needed");
        }
        Change::clock(time.unit.as_deref()).map_err(|message| ("[time".to_owned(), message))?;
        for column in &self.column {
            let near = |message: String| (format!("\"{}\"", column.name), message);
            if column.name == TIME {
                return fault(TIME, "time has a section of its own, `[time]`");
            }
            column.change().map_err(near)?;
            let sizes = [column.area_mm2, column.gauge_length_mm, column.scale.map(f64::abs)];
            if sizes.into_iter().flatten().any(|size| !(size > 0.0 && size.is_finite())) {
                return Err(near("an area, a length or a scale is a number other than 0".into()));
            }
            if let Some(clock) = &column.clock {
                Change::clock(clock.unit.as_deref()).map_err(near)?;
            }
        }
        let sources = self.column.iter().map(|column| &column.from).chain(&time.from);
        if self.table.header_line.is_none()
            && self.table.header_prefix.is_none()
            && !self.table.block_names
            && let Some(From::Name(name)) =
                sources.clone().find(|from| matches!(from, From::Name(_)))
        {
            return fault(
                &format!("\"{name}\""),
                "without a header row columns go by their place: `from = 2`",
            );
        }
        if sources.clone().any(|from| *from == From::Place(0)) {
            return fault("from", "places count from 1");
        }
        Ok(())
    }

    /// The encoding by its name.
    pub(super) fn encoding(&self) -> Option<&'static Encoding> {
        Encoding::for_label(self.text.encoding.as_bytes())
    }
}
