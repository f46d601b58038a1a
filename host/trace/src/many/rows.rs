//! The rows of one trace after the other, without reading the file whole.

use std::path::{Path, PathBuf};

use parquet::column::reader::ColumnReader;
use parquet::file::reader::{FileReader, SerializedFileReader};

use super::super::write::check;
use super::taken::{self, Taken};
use super::{Names, one, open, refused};
use crate::declared::{self, Ending};
use crate::{Column, Error, Head, TIME, Trace};

/// Reads traces of one file. Going forward, no page is read twice.
pub struct Rows {
    path: PathBuf,
    file: SerializedFileReader<Ending>,
    head: Head,
    /// The columns of numbers.
    columns: Vec<Taken>,
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
    /// Opens a file, whose columns have these names.
    ///
    /// # Errors
    /// When it cannot be opened as Parquet, its head is not understood, a column that is called otherwise is not there, or it has
    /// no column of time.
    pub fn open(path: &Path, names: &Names) -> Result<Self, Error> {
        let file = open(path)?;
        let mut head = one::head_of(path, &file)?;
        // The order within the file is the order of recording.
        (head.setup.sequence, head.setup.start_s) = (None, None);
        let schema = file.metadata().file_metadata().schema_descr();
        let columns = taken::columns(schema, names).map_err(|what| refused(path, what))?;
        if !columns.iter().any(|column| column.names.iter().any(|name| name == TIME)) {
            return Err(refused(path, format!("there is no column `{TIME}` of numbers")));
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
        let columns: usize = self.columns.iter().map(|column| column.names.len()).sum();
        rows * columns as u64 * 8
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
        let names = self.columns.iter().flat_map(|column| &column.names).cloned();
        let mut columns: Vec<Column> =
            names.zip(values?).map(|(name, values)| Column { name, values }).collect();
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
        let empty = |column: &Taken| vec![Vec::with_capacity(rows as usize); column.names.len()];
        let mut values: Vec<Vec<Vec<f64>>> = self.columns.iter().map(empty).collect();
        let (mut at, end) = (first, first + rows);
        while at < end {
            let group = self.starts.partition_point(|&start| start <= at) - 1;
            let last = *self.starts.get(group + 1).ok_or("it ends before its rows")?;
            self.go_to(group, at)?;
            let open = self.open.as_mut().ok_or("it ends before its rows")?;
            let count = end.min(last) - at;
            for ((reader, values), column) in
                open.readers.iter_mut().zip(&mut values).zip(&self.columns)
            {
                column.take(reader, count as usize, values)?;
            }
            at += count;
            open.row = at;
        }
        Ok(values.into_iter().flatten().collect())
    }

    /// Goes to a row of a group.
    fn go_to(&mut self, group: usize, row: u64) -> Result<(), String> {
        let there = self.open.take().filter(|open| open.group == group && open.row <= row);
        let mut open = match there {
            Some(open) => open,
            None => {
                let rows = self.file.get_row_group(group).map_err(|error| error.to_string())?;
                let readers =
                    self.columns.iter().map(|column| declared::column_reader(&*rows, column.place));
                let readers =
                    readers.collect::<Result<_, _>>().map_err(|error| error.to_string())?;
                Open { group, row: self.starts[group], readers }
            }
        };
        let ahead = (row - open.row) as usize;
        for reader in open.readers.iter_mut().filter(|_| ahead > 0) {
            taken::skip(reader, ahead)?;
        }
        open.row = row;
        self.open = Some(open);
        Ok(())
    }
}
