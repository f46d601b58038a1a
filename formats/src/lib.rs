//! Tables of numbers out of the files that laboratories have.
//!
//! Each module reads one format and gives back its *parts*: the sheets of a workbook, the groups of an HDF5 file, the topics of
//! a bag. Whoever calls says what format a file is of; nothing is guessed from its name.
//!
//! What every reader promises, whatever the bytes: no panic, no endless loop, a result or an error that names the format and
//! the place, and at most [`NUMBERS`] numbers or [`TEXT_LIMIT`] bytes of text in memory. A missing number is NaN.

mod error;
pub mod export;
pub mod force_curve;
mod gather;
pub mod hdf5;
mod limits;
pub mod mat;
pub mod packed;
pub mod parquet;
mod part;
pub mod ros;
pub mod spreadsheet;
pub mod tdms;

pub use error::Error;
pub use limits::{NUMBERS, TEXT_LIMIT};
pub use part::{Column, Content, Contents, Part};
