//! Parquet files of other programs: columns of any names, lists split into columns, and the episodes of LeRobot's data sets as
//! parts.

use std::fs::File;
use std::panic::AssertUnwindSafe;
use std::path::Path;

use parquet::basic::{LogicalType, Repetition, TimeUnit, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use crate::error::guarded;
use crate::limits::Budget;
use crate::{Column, Contents, Error, Part};

const FORMAT: &str = "Parquet";
/// What the table is called where it is one.
const TABLE: &str = "table";
/// The column by whose value a data set of LeRobot is cut into episodes.
const EPISODE: &str = "episode_index";
/// Records that are read at once.
const BATCH: usize = 1 << 12;
/// Most columns of a file, and most that one list becomes: a longer one is an image.
const COLUMNS: usize = 1 << 12;
const MEMBERS: usize = 256;
/// Times that are counted from farther than this, s, count from their first whole second instead.
const AFAR_S: i64 = 1_000_000;

/// Reads the columns of numbers of a Parquet file, whatever they are called. A list is a column for each of its places
/// (`observation.state.0`); a missing value, and a place that a shorter list does not have, is NaN. A file with the column
/// `episode_index` has a part for each of its values, else there is one.
///
/// # Errors
/// See [`Error`].
pub fn parquet(path: &Path, wanted: Option<&str>) -> Result<Contents, Error> {
    let file = File::open(path)?;
    guarded(
        FORMAT,
        AssertUnwindSafe(|| {
            let damaged = |error: ParquetError| Error::damaged(FORMAT, "file", error);
            let reader = SerializedFileReader::new(file).map_err(damaged)?;
            let schema = reader.metadata().file_metadata().schema_descr_ptr();
            if schema.num_columns() > COLUMNS {
                let limit = format!("{COLUMNS} columns");
                return Err(Error::TooLarge { format: FORMAT, place: "file".into(), limit });
            }
            let mut budget = Budget::new(FORMAT);
            let mut columns = Vec::new();
            let mut rows = None;
            for (index, descriptor) in schema.columns().iter().enumerate() {
                let Some(kind) = Kind::of(descriptor) else { continue };
                let mut leaf = Leaf::new(kind, descriptor);
                let place = format!("column `{}`", leaf.name);
                for group in 0..reader.num_row_groups() {
                    let group = reader.get_row_group(group).map_err(damaged)?;
                    let column = group.get_column_reader(index).map_err(damaged)?;
                    leaf.read(column, &mut budget, &place)?;
                }
                let count = leaf.rows;
                if *rows.get_or_insert(count) != count {
                    return Err(Error::damaged(FORMAT, place, "it is not as long as the others"));
                }
                columns.extend(leaf.finish());
            }
            Ok(parts(columns, wanted))
        }),
    )
}

/// What the numbers of a column mean.
#[derive(Clone, Copy)]
enum Kind {
    Plain,
    Unsigned,
    /// Whole numbers, so many of which are one.
    Decimal(f64),
    /// So many in a second, since 1970.
    Instant(i64),
    /// So many in a second, since midnight.
    TimeOfDay(i64),
}

impl Kind {
    /// None of what is no number, and of lists within lists.
    fn of(column: &ColumnDescriptor) -> Option<Self> {
        let number = match column.physical_type() {
            Physical::DOUBLE | Physical::FLOAT | Physical::BOOLEAN => {
                return Self::floating(column);
            }
            Physical::INT32 | Physical::INT64 => column.max_rep_level() <= 1,
            _ => false,
        };
        let in_a_second = |unit: &TimeUnit| match unit {
            TimeUnit::MILLIS => 1_000,
            TimeUnit::MICROS => 1_000_000,
            TimeUnit::NANOS => 1_000_000_000,
        };
        number.then_some(())?;
        match column.logical_type_ref() {
            None => Some(Self::Plain),
            Some(LogicalType::Integer(integer)) => {
                Some(if integer.is_signed { Self::Plain } else { Self::Unsigned })
            }
            Some(LogicalType::Decimal(decimal)) => Some(Self::Decimal(10_f64.powi(decimal.scale))),
            Some(LogicalType::Timestamp(time)) => Some(Self::Instant(in_a_second(&time.unit))),
            Some(LogicalType::Time(time)) => Some(Self::TimeOfDay(in_a_second(&time.unit))),
            _ => None,
        }
    }

    fn floating(column: &ColumnDescriptor) -> Option<Self> {
        (column.max_rep_level() <= 1 && column.logical_type_ref().is_none()).then_some(Self::Plain)
    }
}

/// A column of the file on its way to one or several columns of numbers.
struct Leaf {
    name: String,
    kind: Kind,
    list: bool,
    /// Level at which a value is there, and at which its place in the list is.
    present: i16,
    placed: i16,
    rows: usize,
    columns: Vec<Vec<f64>>,
    /// The whole second from which instants count.
    origin: Option<i64>,
    /// The list is too long for columns.
    long: bool,
}

impl Leaf {
    fn new(kind: Kind, descriptor: &ColumnDescriptor) -> Self {
        let parts = descriptor.path().parts();
        let list = descriptor.max_rep_level() > 0;
        // What stands between a list and its members has a name of its own in the file.
        let kept = match parts {
            [.., list_or_bag, _] if list && matches!(list_or_bag.as_str(), "list" | "bag") => {
                parts.len() - 2
            }
            _ => parts.len(),
        };
        let optional = descriptor.self_type().get_basic_info().repetition() == Repetition::OPTIONAL;
        let present = descriptor.max_def_level();
        Self {
            name: parts[..kept].join("."),
            kind,
            list,
            present,
            placed: present - i16::from(optional),
            rows: 0,
            columns: if list { Vec::new() } else { vec![Vec::new()] },
            origin: None,
            long: false,
        }
    }

    fn read(
        &mut self,
        column: ColumnReader,
        budget: &mut Budget,
        place: &str,
    ) -> Result<(), Error> {
        match column {
            ColumnReader::DoubleColumnReader(reader) => {
                self.read_as(reader, |_, value| *value, budget, place)
            }
            ColumnReader::FloatColumnReader(reader) => {
                self.read_as(reader, |_, value| f64::from(*value), budget, place)
            }
            ColumnReader::BoolColumnReader(reader) => {
                self.read_as(reader, |_, value| f64::from(u8::from(*value)), budget, place)
            }
            ColumnReader::Int32ColumnReader(reader) => {
                let number = |leaf: &mut Self, value: &i32| match leaf.kind {
                    Kind::Unsigned => f64::from(*value as u32),
                    _ => leaf.whole(i64::from(*value)),
                };
                self.read_as(reader, number, budget, place)
            }
            ColumnReader::Int64ColumnReader(reader) => {
                let number = |leaf: &mut Self, value: &i64| match leaf.kind {
                    Kind::Unsigned => (*value as u64) as f64,
                    _ => leaf.whole(*value),
                };
                self.read_as(reader, number, budget, place)
            }
            _ => Ok(()),
        }
    }

    fn whole(&mut self, value: i64) -> f64 {
        match self.kind {
            Kind::Plain | Kind::Unsigned => value as f64,
            Kind::Decimal(one) => value as f64 / one,
            Kind::TimeOfDay(second) => value as f64 / second as f64,
            Kind::Instant(second) => {
                let (whole, rest) = (value.div_euclid(second), value.rem_euclid(second));
                let afar = whole.abs() > AFAR_S;
                let origin = *self.origin.get_or_insert(if afar { whole } else { 0 });
                (whole - origin) as f64 + rest as f64 / second as f64
            }
        }
    }

    fn read_as<T: DataType>(
        &mut self,
        mut reader: ColumnReaderImpl<T>,
        number: impl Fn(&mut Self, &T::T) -> f64,
        budget: &mut Budget,
        place: &str,
    ) -> Result<(), Error> {
        let (mut values, mut levels, mut repeated) = (Vec::new(), Vec::new(), Vec::new());
        loop {
            values.clear();
            levels.clear();
            repeated.clear();
            let (records, present, count) = reader
                .read_records(BATCH, Some(&mut levels), Some(&mut repeated), &mut values)
                .map_err(|error| Error::damaged(FORMAT, place, error))?;
            if records == 0 {
                return Ok(());
            }
            budget.take(count, place)?;
            // Required columns have no levels.
            levels.resize(if self.present == 0 { present } else { levels.len() }, self.present);
            let mut values = values.iter();
            let mut at = 0;
            for (index, &level) in levels.iter().enumerate() {
                let first = !self.list || repeated.get(index).is_none_or(|&level| level == 0);
                if first {
                    self.rows += 1;
                    at = 0;
                }
                let value = match level == self.present {
                    true => values.next().map_or(f64::NAN, |value| number(self, value)),
                    false => f64::NAN,
                };
                if !self.list || level >= self.placed {
                    self.put(at, value);
                    at += 1;
                }
            }
        }
    }

    /// Puts a number into this row of the column of a place in the list.
    fn put(&mut self, at: usize, value: f64) {
        if at >= MEMBERS {
            self.long = true;
        }
        if self.long {
            self.columns.clear();
            return;
        }
        if at == self.columns.len() {
            self.columns.push(Vec::new());
        }
        let column = &mut self.columns[at];
        column.resize(self.rows - 1, f64::NAN);
        column.push(value);
    }

    fn finish(mut self) -> Vec<Column> {
        let unit =
            matches!(self.kind, Kind::Instant(_) | Kind::TimeOfDay(_)).then(|| "s".to_owned());
        let (name, list, rows) = (self.name, self.list, self.rows);
        let column = |(at, mut values): (usize, Vec<f64>)| {
            values.resize(rows, f64::NAN);
            let name = if list { format!("{name}.{at}") } else { name.clone() };
            Column { name, unit: unit.clone(), values }
        };
        std::mem::take(&mut self.columns).into_iter().enumerate().map(column).collect()
    }
}

/// One part, or one for each episode.
fn parts(columns: Vec<Column>, wanted: Option<&str>) -> Contents {
    let mut contents = Contents::default();
    let episodes =
        columns.iter().find(|column| column.name == EPISODE).map(|column| &column.values);
    let Some(episodes) = episodes else {
        if !columns.is_empty() {
            contents.names.push(TABLE.into());
        }
        if !columns.is_empty() && wanted.is_none_or(|wanted| wanted == TABLE) {
            contents.parts.push(Part::columns(TABLE, columns));
        }
        return contents;
    };
    let mut numbers: Vec<f64> = Vec::new();
    for &episode in episodes {
        if numbers.last() != Some(&episode) && !numbers.contains(&episode) {
            numbers.push(episode);
        }
    }
    for number in numbers {
        let name = format!("episode {number}");
        contents.names.push(name.clone());
        if wanted.is_some_and(|wanted| wanted != name) {
            continue;
        }
        let of_it = |column: &Column| Column {
            values: column
                .values
                .iter()
                .zip(episodes)
                .filter(|(_, of)| **of == number)
                .map(|(value, _)| *value)
                .collect(),
            ..Column { name: column.name.clone(), unit: column.unit.clone(), values: Vec::new() }
        };
        contents.parts.push(Part::columns(name, columns.iter().map(of_it).collect()));
    }
    contents
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use parquet::data_type::{DoubleType, Int64Type};
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::parser::parse_message_type;

    use super::*;
    use crate::Content;

    /// Three rows: a list of one or two numbers, or none, and the number of the episode.
    fn written() -> Vec<u8> {
        let schema = "message m { optional group state (LIST) { repeated group list { optional double element; } }
                      required int64 episode_index; }";
        let schema = Arc::new(parse_message_type(schema).unwrap());
        let properties = Arc::new(WriterProperties::builder().build());
        let mut writer = SerializedFileWriter::new(Vec::new(), schema, properties).unwrap();
        let mut group = writer.next_row_group().unwrap();
        let mut column = group.next_column().unwrap().unwrap();
        // [1, 2], [null, 3], no list at all.
        let (present, repeated) = ([3, 3, 2, 3, 0], [0, 1, 0, 1, 0]);
        let values = [1.0, 2.0, 3.0];
        column.typed::<DoubleType>().write_batch(&values, Some(&present), Some(&repeated)).unwrap();
        column.close().unwrap();
        let mut column = group.next_column().unwrap().unwrap();
        column.typed::<Int64Type>().write_batch(&[4, 4, 5], None, None).unwrap();
        column.close().unwrap();
        group.close().unwrap();
        writer.into_inner().unwrap()
    }

    #[test]
    fn lists_are_split_into_columns_and_rows_into_episodes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.parquet");
        std::fs::write(&path, written()).unwrap();
        let contents = parquet(&path, None).unwrap();
        assert_eq!(contents.names, ["episode 4", "episode 5"]);
        let shown = |part: &Part| match &part.content {
            Content::Columns(columns) => {
                let shown = |column: &Column| format!("{} {:?}", column.name, column.values);
                columns.iter().map(shown).collect::<Vec<_>>()
            }
            Content::Cells(_) => Vec::new(),
        };
        assert_eq!(
            shown(&contents.parts[0]),
            ["state.0 [1.0, NaN]", "state.1 [2.0, 3.0]", "episode_index [4.0, 4.0]"]
        );
        assert_eq!(
            shown(&contents.parts[1]),
            ["state.0 [NaN]", "state.1 [NaN]", "episode_index [5.0]"]
        );
    }
}
