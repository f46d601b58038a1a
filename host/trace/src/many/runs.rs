//! Which rows of the file are which trace.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use parquet::column::reader::ColumnReader;
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::FileReader;
use parquet::record::Field;
use parquet::schema::types::ColumnDescPtr;

use super::{is_name, one, open, refused};
use crate::Error;
use crate::declared;

/// Values read at once.
const BATCH: usize = 1 << 14;

/// The rows of one trace.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Run {
    /// What the trace is called.
    pub id: Arc<str>,
    /// The value of each column that it is grouped by.
    pub keys: Vec<Arc<str>>,
    /// Its first row in the file, from 0.
    pub first: u64,
    /// Number of its rows.
    pub rows: u64,
}

/// The traces of a file in the order in which they lie, by the column `id` and those of `by`.
///
/// # Errors
/// When a column is missing or cannot name anything, a name is missing in a row, or the rows of a trace lie apart.
pub fn runs(path: &Path, id: &str, by: &[&str]) -> Result<Vec<Run>, Error> {
    one::guarded(path, || find(path, id, by))
}

fn find(path: &Path, id: &str, by: &[&str]) -> Result<Vec<Run>, Error> {
    let reader = open(path)?;
    let schema = reader.metadata().file_metadata().schema_descr();
    let mut places = Vec::new();
    for &name in [id].iter().chain(by) {
        let place = schema.columns().iter().position(|column| column.path().string() == name);
        let place = place.ok_or_else(|| refused(path, format!("there is no column `{name}`")))?;
        if !is_name(&schema.column(place)) {
            let what = format!("column `{name}` holds neither text nor whole numbers nor dates");
            return Err(refused(path, what));
        }
        places.push(place);
    }
    let mut found = Found::default();
    for group in 0..reader.num_row_groups() {
        let group =
            reader.get_row_group(group).map_err(|error| refused(path, error.to_string()))?;
        let rows = group.metadata().num_rows() as u64;
        let mut columns = Vec::new();
        for &place in &places {
            let reader = declared::column_reader(&*group, place);
            let reader = reader.map_err(|error| refused(path, error.to_string()))?;
            let names = names(reader, &schema.column(place));
            let what =
                |what| refused(path, format!("column `{}`: {what}", schema.column(place).name()));
            columns.push(names.map_err(what)?);
        }
        found.add(&columns, rows).map_err(|what| refused(path, what))?;
    }
    Ok(found.runs)
}

/// Stretches of equal values: the value, and the row after its last.
type Stretches = Vec<(Arc<str>, u64)>;

#[derive(Default)]
struct Found {
    runs: Vec<Run>,
    seen: HashSet<(Arc<str>, Vec<Arc<str>>)>,
    rows: u64,
}

impl Found {
    /// Takes one more group of rows, given by the stretches of each column.
    fn add(&mut self, columns: &[Stretches], rows: u64) -> Result<(), String> {
        let mut at = vec![0; columns.len()];
        let mut from = 0;
        while from < rows {
            let here = |column: usize| &columns[column][at[column]];
            let to = (0..columns.len()).map(|column| here(column).1).min().unwrap_or(rows);
            let keys = (1..columns.len()).map(|column| here(column).0.clone()).collect();
            self.stretch(here(0).0.clone(), keys, to - from)?;
            for (column, at) in at.iter_mut().enumerate() {
                if columns[column][*at].1 == to {
                    *at += 1;
                }
            }
            from = to;
        }
        Ok(())
    }

    fn stretch(&mut self, id: Arc<str>, keys: Vec<Arc<str>>, rows: u64) -> Result<(), String> {
        let first = self.rows;
        self.rows += rows;
        if let Some(last) = self.runs.last_mut()
            && (&last.id, &last.keys) == (&id, &keys)
        {
            last.rows += rows;
            return Ok(());
        }
        if !self.seen.insert((id.clone(), keys.clone())) {
            return Err(format!(
                "the rows of trace `{id}` do not lie together (again from row {}); sort the file by its traces",
                first + 1
            ));
        }
        self.runs.push(Run { id, keys, first, rows });
        Ok(())
    }
}

/// The values of a column as text, where they change.
fn names(reader: ColumnReader, about: &ColumnDescPtr) -> Result<Stretches, String> {
    let text = |field: Field| match field {
        Field::Str(text) => text,
        other => other.to_string(),
    };
    let mut found = Stretches::new();
    let words = |error: ParquetError| error.to_string();
    match reader {
        ColumnReader::ByteArrayColumnReader(mut reader) => {
            stretches(&mut reader, &mut found, |value| {
                Field::convert_byte_array(about, value.clone()).map(text).map_err(words)
            })
        }
        ColumnReader::Int32ColumnReader(mut reader) => {
            stretches(&mut reader, &mut found, |value| {
                Ok(text(Field::convert_int32(about, *value)))
            })
        }
        ColumnReader::Int64ColumnReader(mut reader) => {
            stretches(&mut reader, &mut found, |value| {
                Ok(text(Field::convert_int64(about, *value)))
            })
        }
        ColumnReader::BoolColumnReader(mut reader) => {
            stretches(&mut reader, &mut found, |value| Ok(value.to_string()))
        }
        _ => Err("holds neither text nor whole numbers nor dates".into()),
    }?;
    Ok(found)
}

fn stretches<T: DataType>(
    reader: &mut parquet::column::reader::ColumnReaderImpl<T>,
    found: &mut Stretches,
    text: impl Fn(&T::T) -> Result<String, String>,
) -> Result<(), String> {
    let (mut batch, mut levels) = (Vec::<T::T>::new(), Vec::new());
    let mut last: Option<T::T> = None;
    let mut row = 0;
    loop {
        batch.clear();
        levels.clear();
        let read = reader.read_records(BATCH, Some(&mut levels), None, &mut batch);
        let (rows, present, _) = read.map_err(|error| error.to_string())?;
        if present < rows {
            return Err("a value is missing".into());
        }
        if rows == 0 {
            return Ok(());
        }
        for value in batch.drain(..) {
            row += 1;
            match found.last_mut() {
                Some(stretch) if last.as_ref() == Some(&value) => stretch.1 = row,
                _ => {
                    found.push((text(&value)?.into(), row));
                    last = Some(value);
                }
            }
        }
    }
}
