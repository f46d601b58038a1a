//! What a file holds: named parts, each a table.

use std::io::{self, Cursor, Read, Write};

/// What was read of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contents {
    /// Names of all parts with numbers in them, in the order of the file.
    pub names: Vec<String>,
    /// The parts that were asked for, read.
    pub parts: Vec<Part>,
}

/// A table in a file: a sheet, a group, a topic.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its name in the file.
    pub name: String,
    /// Its numbers.
    pub content: Content,
    /// What the file says of the set-up, by the key in the table `[setup]` of a trace's head.
    pub setup: Vec<(&'static str, f64)>,
}

/// The numbers of a part.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// Cells in which numbers, names and remarks stand anywhere, as CSV: one line a row, from the first row of the sheet.
    Cells(Vec<u8>),
    /// Columns of one length.
    Columns(Vec<Column>),
}

/// A named column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Column {
    /// Its name in the file.
    pub name: String,
    /// Its unit as the file writes it, where it has one beside the name.
    pub unit: Option<String>,
    /// Its numbers; NaN where one is missing.
    pub values: Vec<f64>,
}

impl Part {
    pub(crate) fn columns(name: impl Into<String>, columns: Vec<Column>) -> Self {
        Self { name: name.into(), content: Content::Columns(columns), setup: Vec::new() }
    }

    /// The part as CSV in UTF-8: of columns the names, then a row of units if any has one, then the numbers with all their
    /// digits. A missing number is an empty cell.
    #[must_use]
    pub fn into_text(self) -> Box<dyn Read> {
        match self.content {
            Content::Cells(text) => Box::new(Cursor::new(text)),
            Content::Columns(columns) => Box::new(Rows::new(columns)),
        }
    }
}

/// Columns as CSV, made row by row as it is read.
struct Rows {
    columns: Vec<Column>,
    rows: usize,
    /// The row to make next.
    next: usize,
    made: Cursor<Vec<u8>>,
}

/// Bytes that are made at a time, about.
const STRETCH: usize = 1 << 16;

impl Rows {
    fn new(columns: Vec<Column>) -> Self {
        let rows = columns.iter().map(|column| column.values.len()).max().unwrap_or(0);
        let mut made = Vec::new();
        line(&mut made, columns.iter().map(|column| column.name.as_str()));
        if columns.iter().any(|column| column.unit.is_some()) {
            line(&mut made, columns.iter().map(|column| column.unit.as_deref().unwrap_or("")));
        }
        Self { columns, rows, next: 0, made: Cursor::new(made) }
    }
}

impl Read for Rows {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let used_up = self.made.position() == self.made.get_ref().len() as u64;
        if used_up && self.next < self.rows {
            let mut made = std::mem::take(self.made.get_mut());
            made.clear();
            while self.next < self.rows && made.len() < STRETCH {
                for (index, column) in self.columns.iter().enumerate() {
                    if index > 0 {
                        made.push(b',');
                    }
                    put_number(&mut made, column.values.get(self.next).copied());
                }
                made.push(b'\n');
                self.next += 1;
            }
            self.made = Cursor::new(made);
        }
        self.made.read(out)
    }
}

fn line<'a>(out: &mut Vec<u8>, cells: impl Iterator<Item = &'a str>) {
    for (index, cell) in cells.enumerate() {
        if index > 0 {
            out.push(b',');
        }
        put_text(out, cell);
    }
    out.push(b'\n');
}

/// A number that reads back as the same; nothing for one that is missing.
pub(crate) fn put_number(out: &mut Vec<u8>, value: Option<f64>) {
    let Some(value) = value.filter(|value| !value.is_nan()) else { return };
    let size = value.abs();
    // Writing to a vector does not fail.
    let _ = if size == 0.0 || (1e-5..1e16).contains(&size) {
        write!(out, "{value}")
    } else {
        write!(out, "{value:e}")
    };
}

/// A text in one line and one cell.
pub(crate) fn put_text(out: &mut Vec<u8>, text: &str) {
    let plain = text.trim().replace(char::is_control, " ");
    if plain.contains([',', '"']) {
        out.push(b'"');
        out.extend(plain.replace('"', "\"\"").bytes());
        out.push(b'"');
    } else {
        out.extend(plain.bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(columns: Vec<Column>) -> String {
        let mut text = String::new();
        Part::columns("p", columns).into_text().read_to_string(&mut text).unwrap();
        text
    }

    fn column(name: &str, unit: Option<&str>, values: &[f64]) -> Column {
        Column { name: name.into(), unit: unit.map(Into::into), values: values.into() }
    }

    #[test]
    fn columns_are_written_with_their_units_and_missing_numbers_left_empty() {
        let time = column("t, \"s\"", Some("s"), &[0.0, 0.1]);
        let force = column("F", None, &[1e-300, f64::NAN]);
        assert_eq!(text(vec![time, force]), "\"t, \"\"s\"\"\",F\ns,\n0,1e-300\n0.1,\n");
        assert_eq!(text(vec![column("F", None, &[2.5])]), "F\n2.5\n");
    }

    #[test]
    fn numbers_keep_every_bit_over_many_stretches() {
        let values: Vec<f64> = (0..50_000).map(|i| (f64::from(i) * 0.7).sin() * 1e-7).collect();
        let text = text(vec![column("x", None, &values)]);
        let back: Vec<f64> = text.lines().skip(1).map(|line| line.parse().unwrap()).collect();
        assert_eq!(back, values);
    }
}
