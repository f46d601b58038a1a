//! Columns of a Parquet table of rows, some of them lists.

use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};

/// The values of one column, in the order of the rows.
pub(super) enum Column {
    Whole(Vec<i64>),
    Number(Cells<f64>),
    Text(Cells<ByteArray>),
}

/// Values with how deep each is defined, and whether it goes on with a list.
pub(super) struct Cells<T> {
    values: Vec<T>,
    defined: Vec<i16>,
    goes_on: Vec<i16>,
}

impl<T> Default for Cells<T> {
    fn default() -> Self {
        Self { values: Vec::new(), defined: Vec::new(), goes_on: Vec::new() }
    }
}

impl<T> Cells<T> {
    /// One value for each row, or none.
    pub(super) fn of(cells: impl Iterator<Item = Option<T>>) -> Self {
        let mut found = Self::default();
        for cell in cells {
            found.defined.push(cell.is_some().into());
            found.values.extend(cell);
        }
        found
    }

    /// A list for each row; of lists of optional values, what is there is defined one deeper.
    pub(super) fn lists<I>(rows: impl Iterator<Item = I>, optional: bool) -> Self
    where
        I: Iterator<Item = Option<T>>,
    {
        let mut found = Self::default();
        for row in rows {
            let before = found.defined.len();
            for cell in row {
                found.goes_on.push((found.defined.len() > before).into());
                found.defined.push(1 + i16::from(optional && cell.is_some()));
                found.values.extend(cell);
            }
            if found.defined.len() == before {
                found.goes_on.push(0);
                found.defined.push(0);
            }
        }
        found
    }
}

/// A whole number in each row.
pub(super) fn whole(name: &str) -> Result<TypePtr, ParquetError> {
    primitive(name, Physical::INT64, Repetition::REQUIRED)
}

/// A number in each row, or none.
pub(super) fn number(name: &str) -> Result<TypePtr, ParquetError> {
    primitive(name, Physical::DOUBLE, Repetition::OPTIONAL)
}

/// A text in each row, or none.
pub(super) fn text(name: &str) -> Result<TypePtr, ParquetError> {
    primitive(name, Physical::BYTE_ARRAY, Repetition::OPTIONAL)
}

/// A column of one kind.
pub(super) fn primitive(
    name: &str,
    kind: Physical,
    repetition: Repetition,
) -> Result<TypePtr, ParquetError> {
    let text = (kind == Physical::BYTE_ARRAY).then_some(LogicalType::String);
    let column = Type::primitive_type_builder(name, kind);
    column.with_repetition(repetition).with_logical_type(text).build().map(Arc::new)
}

/// A list in each row, of what `element` is.
pub(super) fn list(name: &str, element: TypePtr) -> Result<TypePtr, ParquetError> {
    let repeated = Type::group_type_builder("list")
        .with_repetition(Repetition::REPEATED)
        .with_fields(vec![element])
        .build()?;
    Type::group_type_builder(name)
        .with_repetition(Repetition::REQUIRED)
        .with_logical_type(Some(LogicalType::List))
        .with_fields(vec![Arc::new(repeated)])
        .build()
        .map(Arc::new)
}

/// The bytes of a file with these columns, one for each leaf of the fields; `about` stands in its metadata.
pub(super) fn to_bytes(
    name: &str,
    fields: Vec<TypePtr>,
    columns: Vec<Column>,
    about: (&str, String),
) -> Result<Vec<u8>, ParquetError> {
    let schema = Type::group_type_builder(name).with_fields(fields).build()?;
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_created_by(concat!("palpate ", env!("CARGO_PKG_VERSION")).into())
        .set_key_value_metadata(Some(vec![KeyValue::new(about.0.to_owned(), about.1)]))
        .build();
    let mut writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    let mut columns = columns.into_iter();
    while let Some(mut leaf) = group.next_column()? {
        let column = columns.next().ok_or_else(|| too_few(name))?;
        write(&mut leaf, column)?;
        leaf.close()?;
    }
    group.close()?;
    writer.into_inner()
}

fn too_few(name: &str) -> ParquetError {
    ParquetError::General(format!("a column of {name} is missing"))
}

fn write(leaf: &mut SerializedColumnWriter, column: Column) -> Result<(), ParquetError> {
    let levels = |levels: Vec<i16>| (!levels.is_empty()).then_some(levels);
    match column {
        Column::Whole(values) => leaf.typed::<Int64Type>().write_batch(&values, None, None),
        Column::Number(Cells { values, defined, goes_on }) => {
            let (defined, goes_on) = (levels(defined), levels(goes_on));
            let writer = leaf.typed::<DoubleType>();
            writer.write_batch(&values, defined.as_deref(), goes_on.as_deref())
        }
        Column::Text(Cells { values, defined, goes_on }) => {
            let (defined, goes_on) = (levels(defined), levels(goes_on));
            let writer = leaf.typed::<ByteArrayType>();
            writer.write_batch(&values, defined.as_deref(), goes_on.as_deref())
        }
    }?;
    Ok(())
}
