//! A trace as Parquet: the same columns under the same names, the head as TOML in the file's metadata.

use std::fs::File;
use std::io;
use std::panic::AssertUnwindSafe;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{
    Compression, ConvertedType, Encoding, Repetition, Type as Physical, ZstdLevel,
};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{DataType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::metadata::{KeyValue, RowGroupMetaData};
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{ColumnDescriptor, Type};

use super::read::MAX_COLUMNS;
use super::write::{check, checked};
use super::{Column, Error, Head, SIZE_LIMIT, TIME, Trace, head};
use crate::caught::caught;
use crate::declared::{self, Ending};

/// Key of the head in the file's metadata.
const HEAD: &str = "palpate-trace";
/// Samples in a row group.
const GROUP: usize = 1 << 20;
/// Values read at once.
const BATCH: usize = 1 << 16;

/// The head in the metadata of a file.
pub(super) fn read_head(path: &Path) -> Result<Head, Error> {
    super::many::head_of(path)
}

/// The bytes of the file. Values that repeat are written once, others byte by byte of their eight, then compressed.
pub(super) fn to_bytes(trace: &Trace) -> io::Result<Vec<u8>> {
    checked(trace)?;
    let columns: Vec<(&str, &[f64])> = std::iter::once((TIME, &trace.time[..]))
        .chain(trace.columns.iter().map(|column| (&column.name[..], &column.values[..])))
        .collect();
    let head = head::to_toml(&trace.head).map_err(io::Error::other)?;
    encode(&columns, head).map_err(io::Error::other)
}

fn encode(columns: &[(&str, &[f64])], head: String) -> Result<Vec<u8>, ParquetError> {
    let number = |(name, _): &(&str, &[f64])| {
        let number = Type::primitive_type_builder(name, Physical::DOUBLE);
        number.with_repetition(Repetition::REQUIRED).build().map(Arc::new)
    };
    let fields = columns.iter().map(number).collect::<Result<_, _>>()?;
    let schema = Type::group_type_builder("trace").with_fields(fields).build()?;
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_encoding(Encoding::BYTE_STREAM_SPLIT)
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_created_by(concat!("palpate ", env!("CARGO_PKG_VERSION")).into())
        .set_key_value_metadata(Some(vec![KeyValue::new(HEAD.to_owned(), head)]))
        .build();
    let mut writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::new(properties))?;
    let samples = columns.first().map_or(0, |(_, values)| values.len());
    for start in (0..samples).step_by(GROUP) {
        let mut group = writer.next_row_group()?;
        for (_, values) in columns {
            let end = values.len().min(start + GROUP);
            if let Some(mut column) = group.next_column()? {
                column.typed::<DoubleType>().write_batch(&values[start..end], None, None)?;
                column.close()?;
            }
        }
        group.close()?;
    }
    writer.into_inner()
}

/// Reads one trace. Columns of floating point and integer numbers are taken, also from other programs; a missing value is an
/// error.
pub(super) fn read(path: &Path) -> Result<Trace, Error> {
    let open = |source| Error::Open { path: path.into(), source };
    let file = File::open(path).map_err(open)?;
    let bytes = file.metadata().map_err(open)?.len();
    if bytes > SIZE_LIMIT {
        return Err(Error::TooLarge { path: path.into(), bytes, limit: SIZE_LIMIT });
    }
    guarded(path, || decode(path, file))
}

/// What is read of a file; the library takes some damage for impossible.
pub(super) fn guarded<T>(path: &Path, read: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    caught(AssertUnwindSafe(read))
        .unwrap_or_else(|_| Err(Error::Parquet { path: path.into(), message: "is damaged".into() }))
}

fn decode(path: &Path, file: File) -> Result<Trace, Error> {
    let refused = |message: String| Error::Parquet { path: path.into(), message };
    let reader = declared::open(path, file)?;
    let head = head_of(path, &reader)?;
    let mut columns = columns_of(&reader).map_err(refused)?;
    let time_at = columns.iter().position(|column| column.name == TIME);
    let time_at = time_at.ok_or_else(|| refused(format!("there is no column `{TIME}`")))?;
    let time = columns.remove(time_at).values;
    let trace = Trace { path: Some(path.into()), head, time, columns };
    check(&trace).map_err(refused)?;
    Ok(trace)
}

/// The head in the metadata; an empty one in a file of another program.
pub(super) fn head_of(path: &Path, reader: &SerializedFileReader<Ending>) -> Result<Head, Error> {
    let pairs = reader.metadata().file_metadata().key_value_metadata();
    let head = pairs.into_iter().flatten().find(|pair| pair.key == HEAD);
    match head.and_then(|pair| pair.value.as_deref()) {
        Some(toml) => head::from_toml(path, toml),
        None => Ok(Head::default()),
    }
}

fn columns_of(reader: &SerializedFileReader<Ending>) -> Result<Vec<Column>, String> {
    let schema = reader.metadata().file_metadata().schema_descr();
    if schema.num_columns() > MAX_COLUMNS {
        return Err(format!("it has {} columns, more than {MAX_COLUMNS}", schema.num_columns()));
    }
    let mut columns = Vec::new();
    for descriptor in schema.columns() {
        let name = descriptor.path().string();
        if !is_number(descriptor) {
            return Err(format!("column `{name}` does not hold plain numbers"));
        }
        columns.push(Column { name, values: Vec::new() });
    }
    let groups = reader.metadata().row_groups().iter().map(RowGroupMetaData::num_rows);
    for (group, rows) in declared::rows(groups, columns.len())?.into_iter().enumerate() {
        let group = reader.get_row_group(group).map_err(|error| error.to_string())?;
        for (index, column) in columns.iter_mut().enumerate() {
            let wrong = |what: String| format!("column `{}`: {what}", column.name);
            let reader = declared::column_reader(&*group, index)
                .map_err(|error| wrong(error.to_string()))?;
            let most = column.values.len() + rows as usize;
            append(reader, most, &mut column.values).map_err(wrong)?;
        }
    }
    Ok(columns)
}

/// One number in each row that means itself: no date, no decimal fraction, no list.
pub(super) fn is_number(column: &ColumnDescriptor) -> bool {
    column.max_rep_level() == 0 && is_plain(column)
}

/// A list of such numbers in each row.
pub(super) fn is_list(column: &ColumnDescriptor) -> bool {
    column.max_rep_level() == 1 && column.path().parts().len() == 3 && is_plain(column)
}

fn is_plain(column: &ColumnDescriptor) -> bool {
    use ConvertedType::{INT_8, INT_16, INT_32, INT_64, NONE};
    let plain = matches!(column.converted_type(), NONE | INT_8 | INT_16 | INT_32 | INT_64);
    let whole = column.converted_type() != NONE;
    plain && (whole || column.logical_type_ref().is_none())
}

fn append(reader: ColumnReader, most: usize, values: &mut Vec<f64>) -> Result<(), String> {
    match reader {
        ColumnReader::DoubleColumnReader(reader) => append_as(reader, |value| value, most, values),
        ColumnReader::FloatColumnReader(reader) => append_as(reader, f64::from, most, values),
        ColumnReader::Int32ColumnReader(reader) => append_as(reader, f64::from, most, values),
        ColumnReader::Int64ColumnReader(reader) => {
            append_as(reader, |value| value as f64, most, values)
        }
        _ => Err("does not hold plain numbers".into()),
    }
}

fn append_as<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    number: fn(T::T) -> f64,
    most: usize,
    values: &mut Vec<f64>,
) -> Result<(), String> {
    let (mut batch, mut levels) = (Vec::new(), Vec::new());
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
        values.extend(batch.drain(..).map(number));
        if values.len() > most {
            return Err("has more values than the file declares rows".into());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn press() -> Trace {
        let mut trace = Trace { time: vec![0.0, 0.1, 0.30000000000000004], ..Trace::default() };
        trace.head.version = Some(1);
        trace.head.name = Some("take 3".into());
        trace.head.specimen.height_mm = Some(30.0);
        trace.head.other.insert("remark".into(), "ä \"quoted\" line\nand another".into());
        trace.set_column("force_N", vec![-0.0, f64::MIN_POSITIVE, f64::MAX]);
        trace.set_column("own.name, with \"marks\"", vec![1.0 / 3.0, 5e-324, -1e300]);
        trace
    }

    fn through_a_file(bytes: &[u8]) -> Result<Trace, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("press.parquet");
        std::fs::write(&path, bytes).unwrap();
        super::super::read(&path).map(|trace| Trace { path: None, ..trace })
    }

    #[test]
    fn a_compression_is_read_or_named_with_what_reads_it() {
        let read = through_a_file(include_bytes!("../../../tests/foreign/gzip.parquet"));
        if cfg!(feature = "formats") {
            assert_eq!(read.unwrap().column("force_N"), Some(&[0.0, 0.5, 1.25][..]));
        } else {
            let refused = read.unwrap_err().to_string();
            assert!(refused.contains("Parquet compressed with gzip. This palpate"), "{refused}");
            assert!(refused.contains("--features formats"), "{refused}");
        }
    }

    #[test]
    fn a_trace_comes_back_to_the_last_bit_with_its_head() {
        let trace = press();
        let back = through_a_file(&to_bytes(&trace).unwrap()).unwrap();
        assert_eq!(back, trace);
        assert!(back.columns[0].values[0].is_sign_negative());
    }

    #[test]
    fn more_samples_than_a_row_group_has_come_back() {
        let time = (0..GROUP as u32 + 10).map(|i| f64::from(i) / 1000.0).collect();
        let trace =
            Trace { time, head: Head { version: Some(1), ..Head::default() }, ..Trace::default() };
        assert_eq!(through_a_file(&to_bytes(&trace).unwrap()).unwrap(), trace);
    }

    #[test]
    fn what_no_reader_would_take_is_not_written() {
        let mut trace = press();
        trace.columns[0].values[1] = f64::NAN;
        let error = to_bytes(&trace).unwrap_err().to_string();
        assert!(error.contains("force_N is not finite in sample 2"), "{error}");
    }

    #[test]
    fn other_files_and_tables_that_are_no_trace_are_refused_in_words() {
        let error = |bytes: &[u8]| through_a_file(bytes).unwrap_err().to_string();
        assert!(error(b"time_s,force_N\n0,1\n1,2\n").contains("press.parquet"));
        let table = |columns: &[(&str, &[f64])]| encode(columns, "name = 1".into()).unwrap();
        assert!(error(&table(&[("time_s", &[0.0, 1.0])])).contains("head is not understood"));
        let table = |columns: &[(&str, &[f64])]| encode(columns, String::new()).unwrap();
        assert!(error(&table(&[("t", &[0.0, 1.0])])).contains("no column `time_s`"));
        assert!(error(&table(&[("time_s", &[1.0, 0.0])])).contains("does not increase"));
        assert!(error(&table(&[("time_s", &[1.0])])).contains("at least two"));
        assert!(
            error(&table(&[("time_s", &[0.0, 1.0]), ("force_mN", &[0.0, 1.0])]))
                .contains("force_N")
        );
    }

    proptest! {
        #[test]
        fn a_damaged_file_is_refused_or_read_and_never_panics(
            damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6), cut: Option<prop::sample::Index>,
        ) {
            let mut bytes = to_bytes(&press()).unwrap();
            for (at, byte) in damage {
                let at = at.index(bytes.len());
                bytes[at] = byte;
            }
            if let Some(cut) = cut {
                bytes.truncate(cut.index(bytes.len()));
            }
            let _ = through_a_file(&bytes);
        }
    }
}
