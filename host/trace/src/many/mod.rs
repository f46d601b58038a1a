//! Many traces in one Parquet file: long format, a column that says of which trace a row is, and columns to group traces by.
//!
//! The rows of one trace lie together, in order of time. The file is never read whole: [`runs`] looks at the columns of names
//! alone, and [`Rows`] reads the traces in the order of the file, page by page.

mod rows;
mod runs;
mod taken;

pub use rows::Rows;
pub use runs::{Run, runs};

use std::fs::File;
use std::path::Path;

use parquet::basic::{ConvertedType, Type as Physical};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use super::{Error, Head, parquet as one};
use crate::declared::{self, Ending};

/// What the columns of a file with many traces are.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Names {
    /// Those that are no part of a trace, but say which it is.
    pub beside: Vec<String>,
    /// Those that a trace calls otherwise: their names in the file and in the trace. `observation.state.0` is the first place of the
    /// lists in `observation.state`.
    pub called: Vec<(String, String)>,
}

/// The names of the columns.
///
/// # Errors
/// When it cannot be opened as Parquet.
pub fn columns(path: &Path) -> Result<Vec<String>, Error> {
    let reader = open(path)?;
    let columns = reader.metadata().file_metadata().schema_descr().columns();
    Ok(columns.iter().map(|column| column.path().string()).collect())
}

/// The head in the metadata of a Parquet file; an empty one in a file of another program.
///
/// # Errors
/// When it cannot be opened as Parquet, or its head is not understood.
pub fn head_of(path: &Path) -> Result<Head, Error> {
    one::head_of(path, &open(path)?)
}

fn open(path: &Path) -> Result<SerializedFileReader<Ending>, Error> {
    let file = File::open(path).map_err(|source| Error::Open { path: path.into(), source })?;
    one::guarded(path, move || declared::open(path, file))
}

fn refused(path: &Path, message: String) -> Error {
    Error::Parquet { path: path.into(), message }
}

/// Whether the values of a column can name something: text, whole numbers, dates.
fn is_name(column: &ColumnDescriptor) -> bool {
    let flat = column.max_rep_level() == 0;
    let text = column.physical_type() == Physical::BYTE_ARRAY
        && matches!(column.converted_type(), ConvertedType::UTF8 | ConvertedType::ENUM);
    let whole =
        matches!(column.physical_type(), Physical::INT32 | Physical::INT64 | Physical::BOOLEAN)
            && column.converted_type() != ConvertedType::DECIMAL;
    flat && (text || whole)
}

#[cfg(test)]
mod tests;
