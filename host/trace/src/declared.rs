//! What a damaged file of Parquet declares, held against what it holds: the library makes room for as many values as a header says, and
//! looks beyond the end of a file for as many parts of a header as another one says.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use super::Error;
use super::parquet_header::{FILE, PAGE};
use super::thrift::{Kind, look_through};
use bytes::Bytes;
use parquet::basic::Compression;
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::column::reader::{ColumnReader, get_column_reader};
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::RowGroupMetaData;
use parquet::file::reader::{
    ChunkReader, FileReader, Length, RowGroupReader, SerializedFileReader,
};

/// Most values that are read at once, of all columns together: 4 GiB of memory.
const MOST_VALUES: u64 = 1 << 29;
/// Fewest bytes that a value of a dictionary takes: four of a number, or the length of a text.
const DICTIONARY_VALUE: usize = 4;

/// Length of what ends a file: that of the header before it, and the mark.
const END: u64 = 8;

/// A file beyond whose end nothing is read, and whose headers have bytes for what they declare.
#[derive(Debug)]
pub(super) struct Ending(File);

/// The same from one of its bytes on.
#[derive(Debug)]
pub(super) struct EndingRead(<File as ChunkReader>::T);

/// Opens a file.
///
/// # Errors
/// When it is none of Parquet, or compressed as this program cannot read it.
pub(super) fn open(
    path: &Path,
    file: File,
) -> std::result::Result<SerializedFileReader<Ending>, Error> {
    let reader = SerializedFileReader::new(Ending(file))
        .map_err(|error| Error::Parquet { path: path.into(), message: error.to_string() })?;
    let mut columns = reader.metadata().row_groups().iter().flat_map(RowGroupMetaData::columns);
    match columns.find_map(|column| unbuilt(column.compression())) {
        Some(format) => Err(Error::Unbuilt { path: path.into(), format }),
        None => Ok(reader),
    }
}

/// What a file compressed so is called, where this program was built without the reader of it.
fn unbuilt(compression: Compression) -> Option<&'static str> {
    match compression {
        _ if cfg!(feature = "formats") => None,
        Compression::GZIP(_) => Some("Parquet compressed with gzip"),
        Compression::BROTLI(_) => Some("Parquet compressed with Brotli"),
        Compression::LZ4 | Compression::LZ4_RAW => Some("Parquet compressed with LZ4"),
        _ => None,
    }
}

impl Length for Ending {
    fn len(&self) -> u64 {
        self.0.len()
    }
}

impl ChunkReader for Ending {
    type T = EndingRead;

    fn get_read(&self, start: u64) -> Result<EndingRead> {
        // But for the end of the file, the header of a page.
        if start.saturating_add(END) != self.len() {
            has_what_it_declares(self.0.get_read(start)?, PAGE)?;
        }
        self.0.get_read(start).map(EndingRead)
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<Bytes> {
        if start.saturating_add(length as u64) > self.len() {
            return Err(ParquetError::EOF("a part of the file lies beyond its end".into()));
        }
        let bytes = self.0.get_bytes(start, length)?;
        // Before the end of the file, its header.
        if start.saturating_add(length as u64).saturating_add(END) == self.len() {
            has_what_it_declares(&bytes[..], FILE)?;
        }
        Ok(bytes)
    }
}

fn has_what_it_declares(header: impl Read, fields: &[Kind]) -> Result<()> {
    look_through(header, fields).map_err(|error| ParquetError::General(error.to_string()))
}

impl Read for EndingRead {
    fn read(&mut self, room: &mut [u8]) -> io::Result<usize> {
        match self.0.read(room)? {
            0 if !room.is_empty() => Err(io::ErrorKind::UnexpectedEof.into()),
            count => Ok(count),
        }
    }
}

/// Pages whose dictionaries have room for as many values as they declare.
struct Pages(Box<dyn PageReader>);

impl Iterator for Pages {
    type Item = Result<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}

impl PageReader for Pages {
    fn get_next_page(&mut self) -> Result<Option<Page>> {
        self.0.get_next_page().and_then(held)
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
        self.0.peek_next_page()
    }

    fn skip_next_page(&mut self) -> Result<()> {
        self.0.skip_next_page()
    }

    fn supports_deferred_dictionary(&self) -> bool {
        self.0.supports_deferred_dictionary()
    }

    fn take_deferred_dictionary(&mut self) -> Result<Option<Page>> {
        self.0.take_deferred_dictionary().and_then(held)
    }

    fn at_record_boundary(&mut self) -> Result<bool> {
        self.0.at_record_boundary()
    }
}

/// A page that holds what it declares.
fn held(page: Option<Page>) -> Result<Option<Page>> {
    if let Some(Page::DictionaryPage { buf, num_values, .. }) = &page
        && *num_values as usize > buf.len() / DICTIONARY_VALUE
    {
        return Err(ParquetError::General(format!(
            "a dictionary of {} bytes declares {num_values} values",
            buf.len()
        )));
    }
    Ok(page)
}

/// What reads a column of a row group.
///
/// # Errors
/// When there is none of this number.
pub(super) fn column_reader(group: &dyn RowGroupReader, index: usize) -> Result<ColumnReader> {
    let column = group.metadata().column(index).column_descr_ptr();
    Ok(get_column_reader(column, Box::new(Pages(group.get_column_page_reader(index)?))))
}

/// Rows of every row group, if so many columns of them can be read at once.
///
/// # Errors
/// How many are declared, if they are too many or none could be so many.
pub(super) fn rows(
    declared: impl Iterator<Item = i64>,
    columns: usize,
) -> std::result::Result<Vec<u64>, String> {
    let groups: Vec<i64> = declared.collect();
    let rows = |rows: &i64| u64::try_from(*rows).ok();
    let all = groups.iter().map(rows).try_fold(0_u64, |sum, rows| sum.checked_add(rows?));
    match all.map(|all| all.saturating_mul(columns as u64)) {
        Some(values) if values <= MOST_VALUES => Ok(groups.iter().filter_map(rows).collect()),
        Some(values) => Err(format!("it declares {values} values, more than {MOST_VALUES}")),
        None => Err("it declares a number of rows that cannot be".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_values_than_a_dictionary_has_bytes_for_and_more_than_are_read_at_once_are_refused() {
        let dictionary = |num_values| Page::DictionaryPage {
            buf: Bytes::from_static(&[0; 80]),
            num_values,
            encoding: parquet::basic::Encoding::PLAIN,
            is_sorted: false,
        };
        assert!(held(Some(dictionary(20))).is_ok());
        let error = held(Some(dictionary(u32::MAX))).err().unwrap().to_string();
        assert!(error.contains("80 bytes declares 4294967295"), "{error}");
        assert_eq!(rows([3, 4].into_iter(), 2), Ok(vec![3, 4]));
        assert!(rows([1 << 40].into_iter(), 1).unwrap_err().contains("more than"));
        assert!(rows([i64::MAX, i64::MAX, i64::MAX].into_iter(), 9).is_err());
        assert!(rows([-1].into_iter(), 1).is_err());
    }

    #[test]
    fn beyond_the_end_of_a_file_there_is_an_error_and_not_nothing() {
        let mut file = tempfile::tempfile().unwrap();
        io::Write::write_all(&mut file, &[0; 4]).unwrap();
        let file = Ending(file);
        let mut room = [0; 8];
        let mut read = file.get_read(1).unwrap();
        assert_eq!(read.read(&mut room).unwrap(), 3);
        assert_eq!(read.read(&mut room).unwrap_err().kind(), io::ErrorKind::UnexpectedEof);
        assert!(file.get_bytes(2, usize::MAX).is_err() && file.get_bytes(0, 4).is_ok());
    }
}
