//! In place of Parquet, where palpate was built without it.

use std::io;
use std::path::Path;

use super::{Error, Head, Trace};

/// What is said of such a file.
const MESSAGE: &str = "this program was built without the feature `parquet`";

fn refused<T>(path: &Path) -> Result<T, Error> {
    Err(Error::Parquet { path: path.into(), message: MESSAGE.into() })
}

/// Refuses.
pub(super) fn to_bytes(_: &Trace) -> io::Result<Vec<u8>> {
    Err(io::Error::new(io::ErrorKind::Unsupported, MESSAGE))
}

/// Refuses.
pub(super) fn read(path: &Path) -> Result<Trace, Error> {
    refused(path)
}

/// Refuses.
pub(super) fn read_head(path: &Path) -> Result<Head, Error> {
    refused(path)
}
