//! Spreadsheets: Excel workbooks (`.xlsx`) and OpenDocument (`.ods`), one part a sheet.

use std::fs::File;
use std::io::{self, BufReader, Write as _};
use std::path::Path;

use calamine::{Data, ExcelDateTime, ExcelDateTimeType, Ods, Reader, Xlsx, open_workbook};

use crate::error::guarded;
use crate::limits::too_much_text;
use crate::part::{put_number, put_text};
use crate::{Content, Contents, Error, Part, TEXT_LIMIT};

const EXCEL: &str = "Excel workbook";
const ODS: &str = "OpenDocument spreadsheet";
/// Most bytes that an OpenDocument spreadsheet may unpack to: its reader takes the whole into memory.
const ODS_LIMIT: u64 = 64 << 20;
/// Most bytes that an Excel workbook may unpack to; its reader goes cell by cell.
const EXCEL_LIMIT: u64 = 1 << 30;
/// Most bytes of the texts that the cells of a workbook share, which are taken into memory.
const SHARED_LIMIT: u64 = 64 << 20;
/// Seconds in a day.
const DAY: f64 = 86_400.0;
/// Steps of 10 µs in a day.
const TICKS: u64 = 8_640_000_000;

/// Reads the sheets of an Excel workbook, or the one of that name. Of formulas the values are taken that were stored.
///
/// # Errors
/// See [`Error`].
pub fn excel(path: &Path, wanted: Option<&str>) -> Result<Contents, Error> {
    check_archive(path, EXCEL, EXCEL_LIMIT)?;
    guarded(EXCEL, || {
        let damaged = |place: &str, error: &dyn ToString| {
            Error::damaged(EXCEL, place.to_owned(), error.to_string())
        };
        let mut book: Xlsx<BufReader<File>> = open_workbook(path)
            .map_err(|error: calamine::XlsxError| damaged("workbook", &error))?;
        let mut contents = Contents::default();
        for name in book.sheet_names() {
            let place = format!("sheet `{name}`");
            let mut sheet = Sheet::new(EXCEL, &place);
            let mut cells = match book.worksheet_cells_reader(&name) {
                Ok(cells) => cells,
                // A sheet of one chart has no cells.
                Err(calamine::XlsxError::NotAWorksheet(_)) => continue,
                Err(error) => return Err(damaged(&place, &error)),
            };
            while let Some(cell) = cells.next_cell().map_err(|error| damaged(&place, &error))? {
                let (row, column) = cell.get_position();
                sheet.put(row, column, &Data::from(cell.get_value().clone()))?;
            }
            sheet.finish(name, wanted, &mut contents)?;
        }
        Ok(contents)
    })
}

/// Reads the sheets of an OpenDocument spreadsheet, or the one of that name.
///
/// # Errors
/// See [`Error`].
pub fn opendocument(path: &Path, wanted: Option<&str>) -> Result<Contents, Error> {
    check_archive(path, ODS, ODS_LIMIT)?;
    guarded(ODS, || {
        let damaged =
            |place: &str, error: calamine::OdsError| Error::damaged(ODS, place.to_owned(), error);
        let mut book: Ods<BufReader<File>> =
            open_workbook(path).map_err(|error| damaged("content", error))?;
        let mut contents = Contents::default();
        for name in book.sheet_names() {
            let place = format!("sheet `{name}`");
            let mut sheet = Sheet::new(ODS, &place);
            let range = book.worksheet_range(&name).map_err(|error| damaged(&place, error))?;
            let (top, left) = range.start().unwrap_or_default();
            for (row, column, value) in range.used_cells() {
                sheet.put(top + row as u32, left + column as u32, value)?;
            }
            sheet.finish(name, wanted, &mut contents)?;
        }
        Ok(contents)
    })
}

/// Unpacks every file of the archive once: each has a checksum, and what passes it is as it was written.
fn check_archive(path: &Path, format: &'static str, limit: u64) -> Result<(), Error> {
    let file = BufReader::new(File::open(path)?);
    guarded(
        format,
        std::panic::AssertUnwindSafe(|| {
            let damaged = |place: &str, error: &dyn ToString| {
                Error::damaged(format, place.to_owned(), error.to_string())
            };
            let mut archive =
                zip::ZipArchive::new(file).map_err(|error| damaged("archive", &error))?;
            let mut left = limit;
            for index in 0..archive.len() {
                let entry = archive.by_index(index).map_err(|error| {
                    damaged(&format!("file {} of the archive", index + 1), &error)
                })?;
                let name = entry.name().map_err(|error| damaged("archive", &error))?.into_owned();
                let most =
                    if name.ends_with("sharedStrings.xml") { left.min(SHARED_LIMIT) } else { left };
                let size = io::copy(&mut io::Read::take(entry, most + 1), &mut io::sink())
                    .map_err(|error| damaged(&name, &error))?;
                if size > most {
                    let limit = format!("{} MiB when unpacked", most >> 20);
                    return Err(Error::TooLarge { format, place: name, limit });
                }
                left -= size;
            }
            Ok(())
        }),
    )
}

/// The cells of a sheet as lines of CSV.
struct Sheet<'a> {
    format: &'static str,
    place: &'a str,
    text: Vec<u8>,
    /// Where each line ends, and how many cells it has.
    lines: Vec<(usize, u32)>,
    /// Cells of the line under way.
    cells: u32,
    /// Numbers in it.
    numbers: u32,
    /// Lines with two numbers at least.
    rows: usize,
}

impl<'a> Sheet<'a> {
    fn new(format: &'static str, place: &'a str) -> Self {
        Self { format, place, text: Vec::new(), lines: Vec::new(), cells: 0, numbers: 0, rows: 0 }
    }

    /// Adds a cell, row and column from 0; they come row by row.
    fn put(&mut self, row: u32, column: u32, value: &Data) -> Result<(), Error> {
        if *value == Data::Empty {
            return Ok(());
        }
        let disorder = (row as usize) < self.lines.len()
            || (row as usize == self.lines.len() && column < self.cells);
        if disorder {
            let message = format!("row {} is out of order", row + 1);
            return Err(Error::damaged(self.format, self.place, message));
        }
        while self.lines.len() < row as usize {
            self.end_line()?;
        }
        let commas = column + 1 - self.cells - u32::from(self.cells == 0);
        self.text.resize(self.text.len() + commas as usize, b',');
        self.cells = column + 1;
        self.numbers += u32::from(put_value(&mut self.text, value));
        Ok(())
    }

    fn end_line(&mut self) -> Result<(), Error> {
        self.lines.push((self.text.len(), self.cells));
        self.rows += usize::from(self.numbers >= 2);
        (self.cells, self.numbers) = (0, 0);
        let bytes = self.text.len() + self.lines.len();
        if bytes as u64 > TEXT_LIMIT { Err(too_much_text(self.format, self.place)) } else { Ok(()) }
    }

    /// Makes all rows that are not blank of one width and adds the sheet, if it has rows of numbers and is wanted.
    fn finish(
        mut self,
        name: String,
        wanted: Option<&str>,
        contents: &mut Contents,
    ) -> Result<(), Error> {
        self.end_line()?;
        // Two numbers or fewer are remarks.
        if self.rows < 2 {
            return Ok(());
        }
        contents.names.push(name.clone());
        if wanted.is_some_and(|wanted| wanted != name) {
            return Ok(());
        }
        let width = self.lines.iter().map(|&(_, cells)| cells).max().unwrap_or(0);
        let missing = |cells: u32| if cells == 0 { 0 } else { (width - cells) as usize };
        let more: usize = self.lines.iter().map(|&(_, cells)| missing(cells) + 1).sum();
        if (self.text.len() + more) as u64 > TEXT_LIMIT {
            return Err(too_much_text(self.format, self.place));
        }
        let mut text = Vec::with_capacity(self.text.len() + more);
        let mut start = 0;
        for (end, cells) in self.lines {
            text.extend_from_slice(&self.text[start..end]);
            text.resize(text.len() + missing(cells), b',');
            text.push(b'\n');
            start = end;
        }
        contents.parts.push(Part { name, content: Content::Cells(text), setup: Vec::new() });
        Ok(())
    }
}

/// Writes a cell; true if it is a number or a time.
fn put_value(out: &mut Vec<u8>, value: &Data) -> bool {
    match value {
        Data::Empty => false,
        Data::Int(value) => write!(out, "{value}").is_ok(),
        Data::Float(value) => {
            put_number(out, Some(*value));
            true
        }
        Data::Bool(value) => write!(out, "{}", u8::from(*value)).is_ok(),
        Data::DateTime(value) => {
            put_time(out, *value);
            true
        }
        Data::DurationIso(text) => match seconds(text) {
            Some(value) => {
                put_number(out, Some(value));
                true
            }
            None => {
                put_text(out, text);
                false
            }
        },
        Data::DateTimeIso(text) => {
            put_text(out, text);
            true
        }
        Data::String(text) => {
            put_text(out, text);
            // Numbers that were typed as text are numbers to the mapping.
            text.trim().parse::<f64>().is_ok()
        }
        Data::Error(error) => {
            put_text(out, &error.to_string());
            false
        }
    }
}

/// A duration in seconds, else date and time of day. Both are told to 10 µs: a number of days has no finer digits.
fn put_time(out: &mut Vec<u8>, value: ExcelDateTime) {
    let days = value.as_f64();
    if value.is_duration() {
        return put_number(out, Some((days * DAY * 1e5).round() / 1e5));
    }
    let ticks = ((days - days.floor()) * DAY * 1e5).round() as u64;
    let (day, ticks) = (days.floor() + (ticks / TICKS) as f64, ticks % TICKS);
    let (seconds, rest) = (ticks / 100_000, ticks % 100_000);
    let (hour, minute, second) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    // Writing to a vector does not fail.
    if days >= 1.0 {
        let counted = |days, from_1904| {
            ExcelDateTime::new(days, ExcelDateTimeType::DateTime, from_1904).to_ymd_hms_milli()
        };
        let from_1904 = value.to_ymd_hms_milli() != counted(days, false);
        let (year, month, date, ..) = counted(day, from_1904);
        let _ = write!(out, "{year:04}-{month:02}-{date:02} ");
    }
    let _ = write!(out, "{hour:02}:{minute:02}:{second:02}.{rest:05}");
}

/// Seconds in a duration such as `PT01H02M03.5S`.
fn seconds(text: &str) -> Option<f64> {
    let mut rest = text.strip_prefix("PT")?;
    let mut sum = 0.0;
    for (mark, factor) in [('H', 3600.0), ('M', 60.0), ('S', 1.0)] {
        if let Some((number, after)) = rest.split_once(mark) {
            sum += number.replace(',', ".").parse::<f64>().ok()? * factor;
            rest = after;
        }
    }
    rest.is_empty().then_some(sum)
}
