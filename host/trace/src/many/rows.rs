//! The rows of one trace after the other, without reading the file whole.

use std::fs::File;
use std::path::{Path, PathBuf};

use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::file::reader::{FileReader, SerializedFileReader};

use super::super::parquet::is_number;
use super::super::write::check;
use super::{one, open, refused};
use crate::{Column, Error, Head, TIME, Trace};

/// Reads traces of one file. Going forward, no page is read twice.
pub struct Rows {
    path: PathBuf,
    file: SerializedFileReader<File>,
    head: Head,
    /// Place and name of each column of numbers.
    columns: Vec<(usize, String)>,
    /// First row of each group of rows, and the number of all.
    starts: Vec<u64>,
    open: Option<Open>,
}

/// A group of rows under way.
struct Open {
    group: usize,
    /// The next row in the file.
    row: u64,
    readers: Vec<ColumnReader>,
}

impl Rows {
    /// Opens a file; columns named in `names` are no part of the traces, nor are those that hold no numbers.
    ///
    /// # Errors
    /// When it cannot be opened as Parquet, its head is not understood, or it has no column of time.
    pub fn open(path: &Path, names: &[&str]) -> Result<Self, Error> {
        let file = open(path)?;
        let mut head = one::head_of(path, &file)?;
        // The order within the file is the order of recording.
        (head.setup.sequence, head.setup.start_s) = (None, None);
        let schema = file.metadata().file_metadata().schema_descr();
        let number = |(place, column): (usize, &std::sync::Arc<_>)| {
            let column: &parquet::schema::types::ColumnDescriptor = column;
            let name = column.path().string();
            (is_number(column) && !names.contains(&&*name)).then_some((place, name))
        };
        let columns: Vec<_> = schema.columns().iter().enumerate().filter_map(number).collect();
        if !columns.iter().any(|(_, name)| name == TIME) {
            return Err(refused(path, format!("there is no column `{TIME}`")));
        }
        let mut starts = vec![0];
        for group in file.metadata().row_groups() {
            starts.push(starts[starts.len() - 1] + group.num_rows() as u64);
        }
        Ok(Self { path: path.into(), file, head, columns, starts, open: None })
    }

    /// Bytes that the numbers of so many rows take in memory.
    #[must_use]
    pub fn bytes_of(&self, rows: u64) -> u64 {
        rows * self.columns.len() as u64 * 8
    }

    /// Reads one trace: so many rows from `first` on.
    ///
    /// # Errors
    /// When the file is damaged, a value is missing, or the rows are no trace.
    pub fn trace(&mut self, id: &str, first: u64, rows: u64) -> Result<Trace, Error> {
        let path = self.path.clone();
        let values =
            one::guarded(&path, || self.read(first, rows).map_err(|what| refused(&path, what)));
        if values.is_err() {
            self.open = None;
        }
        let mut columns: Vec<Column> = self
            .columns
            .iter()
            .zip(values?)
            .map(|((_, name), values)| Column { name: name.clone(), values })
            .collect();
        let time = columns.iter().position(|column| column.name == TIME);
        let time = time.map(|at| columns.remove(at).values).unwrap_or_default();
        let mut head = self.head.clone();
        head.name = Some(id.to_owned());
        let trace = Trace { path: None, head, time, columns };
        check(&trace).map_err(|what| refused(&path, format!("trace `{id}`: {what}")))?;
        Ok(trace)
    }

    /// The values of every column.
    fn read(&mut self, first: u64, rows: u64) -> Result<Vec<Vec<f64>>, String> {
        let mut values: Vec<Vec<f64>> =
            self.columns.iter().map(|_| Vec::with_capacity(rows as usize)).collect();
        let (mut at, end) = (first, first + rows);
        while at < end {
            let group = self.starts.partition_point(|&start| start <= at) - 1;
            let last = *self.starts.get(group + 1).ok_or("it ends before its rows")?;
            self.go_to(group, at)?;
            let open = self.open.as_mut().ok_or("it ends before its rows")?;
            let count = end.min(last) - at;
            for ((reader, values), (_, name)) in
                open.readers.iter_mut().zip(&mut values).zip(&self.columns)
            {
                take(reader, count as usize, values)
                    .map_err(|what| format!("column `{name}`: {what}"))?;
            }
            at += count;
            open.row = at;
        }
        Ok(values)
    }

    /// Goes to a row of a group.
    fn go_to(&mut self, group: usize, row: u64) -> Result<(), String> {
        let there = self.open.take().filter(|open| open.group == group && open.row <= row);
        let mut open = match there {
            Some(open) => open,
            None => {
                let rows = self.file.get_row_group(group).map_err(|error| error.to_string())?;
                let readers = self.columns.iter().map(|(place, _)| rows.get_column_reader(*place));
                let readers =
                    readers.collect::<Result<_, _>>().map_err(|error| error.to_string())?;
                Open { group, row: self.starts[group], readers }
            }
        };
        let ahead = (row - open.row) as usize;
        for reader in open.readers.iter_mut().filter(|_| ahead > 0) {
            skip(reader, ahead)?;
        }
        open.row = row;
        self.open = Some(open);
        Ok(())
    }
}

fn skip(reader: &mut ColumnReader, rows: usize) -> Result<(), String> {
    let skipped = match reader {
        ColumnReader::DoubleColumnReader(reader) => reader.skip_records(rows),
        ColumnReader::FloatColumnReader(reader) => reader.skip_records(rows),
        ColumnReader::Int32ColumnReader(reader) => reader.skip_records(rows),
        ColumnReader::Int64ColumnReader(reader) => reader.skip_records(rows),
        _ => return Err("does not hold plain numbers".into()),
    };
    match skipped {
        Ok(skipped) if skipped == rows => Ok(()),
        Ok(_) => Err("it ends before its rows".into()),
        Err(error) => Err(error.to_string()),
    }
}

fn take(reader: &mut ColumnReader, rows: usize, values: &mut Vec<f64>) -> Result<(), String> {
    match reader {
        ColumnReader::DoubleColumnReader(reader) => take_as(reader, rows, |value| value, values),
        ColumnReader::FloatColumnReader(reader) => take_as(reader, rows, f64::from, values),
        ColumnReader::Int32ColumnReader(reader) => take_as(reader, rows, f64::from, values),
        ColumnReader::Int64ColumnReader(reader) => {
            take_as(reader, rows, |value| value as f64, values)
        }
        _ => Err("does not hold plain numbers".into()),
    }
}

fn take_as<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    rows: usize,
    number: fn(T::T) -> f64,
    values: &mut Vec<f64>,
) -> Result<(), String> {
    let (mut batch, mut levels) = (Vec::new(), Vec::new());
    let mut left = rows;
    while left > 0 {
        levels.clear();
        let read = reader.read_records(left, Some(&mut levels), None, &mut batch);
        let (read, present, _) = read.map_err(|error| error.to_string())?;
        if present < read {
            return Err("a value is missing".into());
        }
        if read == 0 {
            return Err("it ends before its rows".into());
        }
        left -= read;
        values.extend(batch.drain(..).map(number));
    }
    Ok(())
}
