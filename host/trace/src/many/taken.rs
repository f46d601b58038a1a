//! Columns of numbers on their way from a Parquet file: one a row, or places of the list that a row has.

use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::schema::types::{ColumnDescriptor, SchemaDescriptor};

use super::super::parquet::{is_list, is_number};
use super::Names;

/// A column of the file, and what is taken from it.
pub(super) struct Taken {
    /// Which column of the file.
    pub(super) place: usize,
    /// What the columns of a trace are called that come from it.
    pub(super) names: Vec<String>,
    /// Which places of the list each is; none where it is no list.
    list: Option<Vec<usize>>,
}

/// The columns of numbers of a file: all that are none of the names that traces are grouped by, of lists the places that are
/// called otherwise.
pub(super) fn columns(schema: &SchemaDescriptor, names: &Names) -> Result<Vec<Taken>, String> {
    let mut found = Vec::new();
    let mut called: Vec<&str> = Vec::new();
    for (place, column) in schema.columns().iter().enumerate() {
        if is_number(column) {
            let own = column.path().string();
            let other = names.called.iter().find(|(from, _)| *from == own);
            called.extend(other.map(|(from, _)| &from[..]));
            if other.is_some() || !names.beside.contains(&own) {
                let name = other.map_or(own, |(_, to)| to.clone());
                found.push(Taken { place, names: vec![name], list: None });
            }
        } else if let Some(list) = list_of(column) {
            let (mut places, mut taken) = (Vec::new(), Vec::new());
            for (from, to) in &names.called {
                let place = from.strip_prefix(list).and_then(|rest| rest.strip_prefix('.'));
                if let Some(place) = place.and_then(|place| place.parse().ok()) {
                    called.push(from);
                    places.push(place);
                    taken.push(to.clone());
                }
            }
            if !places.is_empty() {
                found.push(Taken { place, names: taken, list: Some(places) });
            }
        }
    }
    match names.called.iter().find(|(from, _)| !called.contains(&&from[..])) {
        Some((from, _)) => Err(format!("there is no column `{from}` of numbers")),
        None => Ok(found),
    }
}

/// What a list of numbers is called.
fn list_of(column: &ColumnDescriptor) -> Option<&str> {
    is_list(column).then(|| column.path().parts().first().map(String::as_str)).flatten()
}

impl Taken {
    /// Takes so many rows.
    pub(super) fn take(
        &self,
        reader: &mut ColumnReader,
        rows: usize,
        values: &mut [Vec<f64>],
    ) -> Result<(), String> {
        let taken = match reader {
            ColumnReader::DoubleColumnReader(reader) => self.take_as(reader, rows, |v| v, values),
            ColumnReader::FloatColumnReader(reader) => {
                self.take_as(reader, rows, f64::from, values)
            }
            ColumnReader::Int32ColumnReader(reader) => {
                self.take_as(reader, rows, f64::from, values)
            }
            ColumnReader::Int64ColumnReader(reader) => {
                self.take_as(reader, rows, |value| value as f64, values)
            }
            _ => Err("does not hold plain numbers".into()),
        };
        taken.map_err(|what| format!("column `{}`: {what}", self.names[0]))
    }

    fn take_as<T: DataType>(
        &self,
        reader: &mut ColumnReaderImpl<T>,
        rows: usize,
        number: fn(T::T) -> f64,
        values: &mut [Vec<f64>],
    ) -> Result<(), String> {
        let (mut batch, mut levels, mut goes_on) = (Vec::new(), Vec::new(), Vec::new());
        let mut left = rows;
        while left > 0 {
            levels.clear();
            goes_on.clear();
            let lists = self.list.as_ref().map(|_| &mut goes_on);
            let read = reader.read_records(left, Some(&mut levels), lists, &mut batch);
            let (read, present, known) = read.map_err(|error| error.to_string())?;
            let wanted = if self.list.is_some() { known } else { read };
            if present < wanted {
                return Err("a value is missing".into());
            }
            if read == 0 {
                return Err("it ends before its rows".into());
            }
            left -= read;
            match &self.list {
                None => values[0].extend(batch.drain(..).map(number)),
                Some(places) => {
                    let before = values[0].len();
                    let mut at = 0;
                    for (value, goes_on) in batch.drain(..).map(number).zip(&goes_on) {
                        at = if *goes_on == 0 { 0 } else { at + 1 };
                        for (place, values) in places.iter().zip(&mut *values) {
                            if *place == at {
                                values.push(value);
                            }
                        }
                    }
                    if values.iter().any(|values| values.len() != before + read) {
                        return Err("a list is too short".into());
                    }
                }
            }
        }
        Ok(())
    }
}

/// Goes over so many rows.
pub(super) fn skip(reader: &mut ColumnReader, rows: usize) -> Result<(), String> {
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
