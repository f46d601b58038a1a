//! The rows of the table in a foreign text file, as the mapping says where they are.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::error::Place;
use super::foreign::{self, Opened};
use super::import_error::ImportError;
use super::lines::Lines;
use super::mapping::{Delimiter, From, Mapping, Text};

/// A walk through the rows of a file.
pub(super) struct Rows<'m> {
    path: PathBuf,
    mapping: &'m Mapping,
    /// How cells are told, which is the mapping's to say only of text.
    text: Text,
    lines: Lines,
    /// The current line and the cells in it.
    line: String,
    cells: Vec<Range<usize>>,
    state: State,
    /// Names of the columns; empty without a header row.
    pub(super) names: Vec<String>,
    /// Line that names the columns, or of the first row.
    pub(super) header_at: usize,
    /// Cells of a row.
    width: Option<usize>,
    /// Tables met so far.
    blocks: usize,
    /// Rows met so far.
    rows: usize,
}

/// What the next line is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    /// Not of a table that is wanted.
    Outside,
    /// Above the line that names the columns.
    Above,
    /// So many lines below it are no rows.
    Skip(usize),
    /// A row.
    Inside,
}

impl<'m> Rows<'m> {
    pub(super) fn open(path: &Path, mapping: &'m Mapping) -> Result<Self, ImportError> {
        let encoding = mapping.encoding().unwrap_or(encoding_rs::UTF_8);
        let (path, lines, text) = match foreign::open(path, mapping.table.part.as_deref())? {
            Opened::Text(text) => {
                (path.into(), Lines::new(path, text, encoding), mapping.text.clone())
            }
            Opened::Part { name, text } => {
                let path = name.map_or_else(|| path.into(), |name| part_of(path, &name));
                let lines = Lines::new(&path, text, encoding_rs::UTF_8);
                let Text { comment, missing, .. } = mapping.text.clone();
                let text = Text { comment, missing, ..Text::default() };
                (path, lines, text)
            }
        };
        let mut rows = Self {
            path,
            mapping,
            text,
            lines,
            line: String::new(),
            cells: Vec::new(),
            state: State::Outside,
            names: Vec::new(),
            header_at: 0,
            width: None,
            blocks: 0,
            rows: 0,
        };
        if mapping.table.block_prefix.is_none() {
            rows.state = rows.begin();
        }
        Ok(rows)
    }

    /// What a table begins with.
    fn begin(&self) -> State {
        let table = &self.mapping.table;
        if table.header_line.is_some() || table.header_prefix.is_some() {
            State::Above
        } else {
            State::Skip(table.skip_lines)
        }
    }

    /// Goes to the next row; false after the last.
    pub(super) fn next(&mut self) -> Result<bool, ImportError> {
        let table = &self.mapping.table;
        let mut line = std::mem::take(&mut self.line);
        let found = loop {
            if table.last_row.is_some_and(|last| self.rows >= last)
                || !self.lines.next(&mut line)?
            {
                break false;
            }
            if starts(&line, table.block_prefix.as_deref()) {
                let wanted = table.blocks.as_ref().is_none_or(|list| list.contains(&self.blocks));
                self.blocks += 1;
                self.state = if wanted { self.begin() } else { State::Outside };
                if wanted && table.block_names {
                    self.read_header(&line)?;
                    self.state = State::Skip(table.skip_lines);
                }
                continue;
            }
            if self.is_row(&line)? {
                self.rows += 1;
                if table.first_row.is_none_or(|first| self.rows >= first) {
                    break true;
                }
            }
        };
        self.line = line;
        if !found {
            return self.complete().map(|()| false);
        }
        self.check_width()?;
        Ok(true)
    }

    /// Whether a line is a row of numbers; its cells are found then.
    fn is_row(&mut self, line: &str) -> Result<bool, ImportError> {
        let table = &self.mapping.table;
        match self.state {
            State::Outside => Ok(false),
            State::Above => {
                let header = match &table.header_prefix {
                    Some(prefix) => line.strip_prefix(prefix.as_str()),
                    None => table.header_line.filter(|&n| n == self.lines.number).map(|_| line),
                };
                if let Some(header) = header {
                    self.read_header(header)?;
                    self.state = State::Skip(table.skip_lines);
                }
                Ok(false)
            }
            State::Skip(left) if left > 0 => {
                self.state = State::Skip(left - 1);
                Ok(false)
            }
            State::Skip(_) | State::Inside => {
                self.state = State::Inside;
                let blank = line.trim().is_empty();
                let stop =
                    (blank && table.stop_at_blank) || starts(line, table.stop_at_prefix.as_deref());
                if stop {
                    self.state = State::Outside;
                }
                if stop || blank || starts(line, self.text.comment.as_deref()) {
                    return Ok(false);
                }
                self.split(line);
                Ok(true)
            }
        }
    }

    fn read_header(&mut self, line: &str) -> Result<(), ImportError> {
        self.split(line);
        let name = |cell: &Range<usize>| line[cell.clone()].replace("\"\"", "\"").trim().to_owned();
        let names: Vec<String> = self.cells.iter().map(name).collect();
        if self.names.is_empty() || self.names == names {
            self.width = Some(names.len());
            self.names = names;
            self.header_at = self.lines.number;
            return Ok(());
        }
        Err(ImportError::BlocksDiffer { path: self.path.clone(), line: self.lines.number })
    }

    /// Finds the cells of a line.
    fn split(&mut self, line: &str) {
        split(line, self.text.delimiter, &mut self.cells);
        let empty = |cell: &Range<usize>| line[cell.clone()].trim().is_empty();
        if self.mapping.table.empty_last_cell && self.cells.last().is_some_and(empty) {
            self.cells.pop();
        }
    }

    /// Refuses a row that is shorter or longer than the others.
    fn check_width(&mut self) -> Result<(), ImportError> {
        let found = self.cells.len();
        if self.width.is_none() {
            self.header_at = self.lines.number;
        }
        let expected = *self.width.get_or_insert(found);
        if found == expected {
            return Ok(());
        }
        Err(ImportError::CellCount { place: self.place(found.min(expected)), expected, found })
    }

    /// Refuses a file in which the table was never met.
    fn complete(&self) -> Result<(), ImportError> {
        let table = &self.mapping.table;
        let missing = |what: String| Err(ImportError::NoTable { path: self.path.clone(), what });
        if let Some(prefix) = &table.block_prefix {
            let wanted = table.blocks.as_ref().and_then(|list| list.last()).copied().unwrap_or(0);
            if self.blocks <= wanted {
                return missing(format!("table {wanted} (from 0) that starts with `{prefix}`"));
            }
        }
        match (&table.header_prefix, table.header_line) {
            (Some(prefix), _) if self.header_at == 0 => {
                missing(format!("the line of column names that starts with `{prefix}`"))
            }
            (_, Some(line)) if self.header_at == 0 => missing(format!("header line {line}")),
            _ => Ok(()),
        }
    }

    /// The text of a cell, from 0.
    pub(super) fn cell(&self, index: usize) -> &str {
        self.line[self.cells[index].clone()].trim()
    }

    /// Number of columns.
    pub(super) fn width(&self) -> usize {
        self.width.unwrap_or(0)
    }

    /// Line of the current row.
    pub(super) fn line_number(&self) -> usize {
        self.lines.number
    }

    /// Where a cell of the current row is.
    pub(super) fn place(&self, index: usize) -> Place {
        Place {
            path: self.path.clone(),
            line: self.lines.number,
            column: index + 1,
            name: self.names.get(index).cloned().unwrap_or_default(),
        }
    }

    /// Which column the mapping means, from 0.
    pub(super) fn find(&self, from: &From) -> Result<usize, ImportError> {
        let (path, line) = (self.path.clone(), self.header_at);
        let found = match from {
            From::Place(place) => (*place <= self.width()).then(|| place - 1),
            From::Name(name) => {
                let count = self.names.iter().filter(|present| *present == name).count();
                if count > 1 {
                    let wanted = from.to_string();
                    return Err(ImportError::AmbiguousColumn { path, line, wanted, count });
                }
                self.names.iter().position(|present| present == name)
            }
        };
        found.ok_or_else(|| {
            let present = if self.names.is_empty() {
                vec![format!("{} columns without names", self.width())]
            } else {
                self.names.clone()
            };
            ImportError::NoColumn { path, line, wanted: from.to_string(), present }
        })
    }

    /// Whether a cell says that it has no value.
    pub(super) fn is_missing(&self, index: usize) -> bool {
        self.text.missing.iter().any(|word| word == self.cell(index))
    }

    /// The number in a cell.
    pub(super) fn number(&self, index: usize) -> Result<f64, ImportError> {
        let text = self.cell(index);
        let decimal = self.text.decimal;
        match number(text, decimal, self.text.thousands) {
            Some(value) if value.is_finite() => Ok(value),
            Some(_) => Err(ImportError::NotFinite { place: self.place(index), text: text.into() }),
            None => {
                let (place, text) = (self.place(index), text.into());
                Err(ImportError::NotANumber { place, text, decimal })
            }
        }
    }
}

/// What errors call one of several tables of a file.
pub(super) fn part_of(path: &Path, name: &str) -> PathBuf {
    format!("{}, `{name}`", path.display()).into()
}

fn starts(line: &str, prefix: Option<&str>) -> bool {
    prefix.is_some_and(|prefix| line.starts_with(prefix))
}

/// A number with that decimal mark, in groups of three digits where they are told by a mark.
pub(super) fn number(text: &str, decimal: char, thousands: Option<char>) -> Option<f64> {
    if let Some(mark) = thousands.filter(|&mark| text.contains(mark)) {
        let (whole, part) = text.split_once(decimal).unwrap_or((text, ""));
        let mut groups = whole.trim_start_matches(['-', '+']).split(mark);
        let digits = |group: &str| group.bytes().all(|c| c.is_ascii_digit());
        let first =
            groups.next().is_some_and(|group| (1..=3).contains(&group.len()) && digits(group));
        let others = groups.all(|group| group.len() == 3 && digits(group));
        let fits = first && others && !part.contains(mark);
        return fits.then(|| number(&text.replace(mark, ""), decimal, None))?;
    }
    if decimal == '.' {
        return text.parse().ok();
    }
    if text.contains('.') {
        return None;
    }
    text.replacen(decimal, ".", 1).parse().ok()
}

/// Finds the cells of a line; quotes around a cell are left out of it.
pub(super) fn split(line: &str, delimiter: Delimiter, cells: &mut Vec<Range<usize>>) {
    cells.clear();
    let mark = match delimiter {
        Delimiter::Comma => b',',
        Delimiter::Semicolon => b';',
        Delimiter::Tab => b'\t',
        Delimiter::Space => {
            let start_of = |word: &str| word.as_ptr() as usize - line.as_ptr() as usize;
            cells.extend(line.split_whitespace().map(|word| {
                let start = start_of(word);
                start..start + word.len()
            }));
            return;
        }
    };
    let bytes = line.as_bytes();
    let mut start = 0;
    let mut quoted = false;
    for at in 0..=bytes.len() {
        if at < bytes.len() && (quoted || bytes[at] != mark) {
            quoted ^= bytes[at] == b'"';
            continue;
        }
        let text = &line[start..at];
        let inner = text.trim();
        let cell = if inner.len() >= 2 && inner.starts_with('"') && inner.ends_with('"') {
            let from = start + text.len() - text.trim_start().len() + 1;
            from..from + inner.len() - 2
        } else {
            start..at
        };
        cells.push(cell);
        start = at + 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(line: &str, delimiter: Delimiter) -> Vec<&str> {
        let mut found = Vec::new();
        split(line, delimiter, &mut found);
        found.into_iter().map(|cell| &line[cell]).collect()
    }

    #[test]
    fn cells_are_found_with_quotes_and_empty_ones() {
        assert_eq!(cells("1,\"a,b\", \"c\" ,", Delimiter::Comma), ["1", "a,b", "c", ""]);
        assert_eq!(cells("  1 \t 2.5  3", Delimiter::Space), ["1", "2.5", "3"]);
        assert_eq!(cells("1;;3", Delimiter::Semicolon), ["1", "", "3"]);
        assert_eq!(cells("\"open,1", Delimiter::Comma), ["\"open,1"]);
    }

    #[test]
    fn a_number_has_the_one_decimal_mark() {
        let number = |text, decimal| number(text, decimal, None);
        assert_eq!(number("1,5", ','), Some(1.5));
        assert_eq!(number("1,0543E+05", ','), Some(105_430.0));
        assert_eq!(number("1.5", ','), None);
        assert_eq!(number("1,5", '.'), None);
        assert_eq!(number("1.000,5", ','), None);
    }

    #[test]
    fn thousands_stand_in_groups_of_three() {
        for (text, decimal, mark, expected) in [
            ("-1,047.75", '.', ',', Some(-1047.75)),
            ("1.234.567,5", ',', '.', Some(1_234_567.5)),
            ("12\u{a0}000", ',', '\u{a0}', Some(12_000.0)),
            ("7.5", '.', ',', Some(7.5)),
            ("10,47.7", '.', ',', None),
            ("1047,200.7", '.', ',', None),
            (",047", '.', ',', None),
            ("1.234,5", '.', ',', None),
        ] {
            assert_eq!(number(text, decimal, Some(mark)), expected, "{text}");
        }
    }
}
