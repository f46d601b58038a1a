//! One recording: columns of numbers over time, with a head that says what was pressed and how.
//!
//! The file format is a contract (see `docs/formats.md`): a commented TOML head, one header row whose
//! names carry their unit, then numbers; the same as Parquet. Compression is positive in displacement and
//! force. [`recorded`] makes traces of a recording of a device, [`recordable`] a recording of a trace.
//!
//! ```
//! # fn main() -> Result<(), palpate_trace::Error> {
//! # let press = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/traces/press.csv");
//! use palpate_trace::{Kind, read, segments};
//!
//! let trace = read(press.as_ref())?;
//! let motion = trace.displacement().expect("the motion was recorded");
//! let holds = segments(&trace.time, motion).into_iter().filter(|it| it.kind == Kind::Hold);
//! assert_eq!(holds.count(), 2);
//! # Ok(())
//! # }
//! ```
#![forbid(unsafe_code)]

mod block_means;
pub mod caught;
mod control;
#[cfg(feature = "parquet")]
mod declared;
mod elapsed;
mod error;
pub mod files;
mod first_force;
mod foreign;
mod from_columns;
mod gaps;
mod head;
mod holds;
mod import;
mod import_error;
mod levels;
mod lines;
mod local_lines;
#[cfg(feature = "parquet")]
pub mod many;
pub mod mapping;
pub mod meant;
mod motion_noise;
mod names;
mod noise;
mod outliers;
#[cfg(feature = "parquet")]
mod parquet;
#[cfg(feature = "parquet")]
mod parquet_header;
mod pooled_noise;
mod read;
pub mod recordable;
pub mod recorded;
pub mod recording;
mod repeats;
mod sampling;
mod scatter;
mod segments;
mod set;
mod stairs;
mod stamp;
#[cfg(feature = "suggest")]
mod suggest;
mod table;
mod tare;
#[cfg(feature = "parquet")]
mod thrift;
#[cfg(not(feature = "parquet"))]
mod unbuilt;
pub mod units;
mod write;

pub use block_means::{REST, block_begins, block_means};
pub use control::control;
pub use elapsed::elapsed;
pub use error::{Error, Place, SignalError};
pub use foreign::Export;
pub use from_columns::ColumnsError;
pub use gaps::{Gap, gaps, runs};
pub use head::{Control, Head, Setup, Shape, Specimen};
pub use holds::holds;
pub use import::{Imported, import, import_parts, import_tests, places};
pub use import_error::ImportError;
pub use mapping::Mapping;
pub use motion_noise::{MotionNoise, motion_noise};
pub use noise::{Noise, Source, force_noise, noise};
pub use outliers::{Outlier, bridged, outliers, without};
pub use pooled_noise::pooled_noise;
pub use read::{SIZE_LIMIT, parse, read, read_all, read_head};
pub use repeats::{Repeats, repeats, without_repeats};
pub use sampling::{Sampling, sampling};
pub use scatter::scatter;
pub use segments::{Kind, Segment, segments};
pub use set::{order, ordered_by, read_set};
pub use stairs::{Cause, Stairs, join, stairs};
pub use stamp::Stamp;
#[cfg(feature = "suggest")]
pub use suggest::{Proposal, propose, suggest};
pub use tare::{resting_value, tare};
pub use write::{shortest, write, write_to};

#[cfg(not(feature = "parquet"))]
use unbuilt as parquet;

use std::borrow::Cow;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Extension of the name of a Parquet file.
const PARQUET: &str = "parquet";
/// Column of time, s; every trace has it, strictly increasing, not necessarily uniform.
pub const TIME: &str = "time_s";
/// Column of displacement, mm; positive into the specimen, 0 at the nominal first touch.
pub const DISPLACEMENT: &str = "displacement_mm";
/// Column of contact force, N; compression positive.
pub const FORCE: &str = "force_N";
/// Column of temperature, °C.
pub const TEMPERATURE: &str = "temperature_C";
/// Column of tangential force, N.
pub const TANGENTIAL: &str = "tangential_N";
/// The key of a head's `[setup]` under which a simulation says what happened when.
pub const HAPPENED: &str = "happened";
/// Columns of the four embedded gauges, microstrain.
pub const GAUGES: [&str; 4] =
    ["gauge1_ustrain", "gauge2_ustrain", "gauge3_ustrain", "gauge4_ustrain"];

/// Whether a file's name ends in `.extension`, in large or small letters.
#[must_use]
pub fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

/// One named column; `values` is as long as the trace.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name with its unit, as in the header row: `force_N`.
    pub name: String,
    /// One finite value for each sample.
    pub values: Vec<f64>,
}

/// One recording.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Trace {
    /// The file it came from, where there is one.
    pub path: Option<PathBuf>,
    /// What the file's head says.
    pub head: Head,
    /// Time of each sample, s, strictly increasing.
    pub time: Vec<f64>,
    /// All other columns in the order of the file, unknown ones included.
    pub columns: Vec<Column>,
}

impl Trace {
    /// The values of a column, by its name in the header row.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.columns.iter().find(|column| column.name == name).map(|column| &column.values[..])
    }

    /// Displacement, mm.
    #[must_use]
    pub fn displacement(&self) -> Option<&[f64]> {
        self.column(DISPLACEMENT)
    }

    /// Contact force, N.
    #[must_use]
    pub fn force(&self) -> Option<&[f64]> {
        self.column(FORCE)
    }

    /// The values of a column that is there and changes.
    ///
    /// # Errors
    /// [`SignalError::NoColumn`], [`SignalError::Constant`].
    pub fn changing(&self, name: &str) -> Result<&[f64], SignalError> {
        holds::changing(self, name)
    }

    /// Names of the gauge columns this trace has, in order.
    #[must_use]
    pub fn gauges(&self) -> Vec<&'static str> {
        GAUGES.into_iter().filter(|name| self.column(name).is_some()).collect()
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Time from the first of these samples to each of them, s; see [`elapsed`].
    ///
    /// # Panics
    /// When the trace does not have these samples.
    #[must_use]
    pub fn elapsed(&self, samples: Range<usize>) -> Cow<'_, [f64]> {
        elapsed(&self.time[samples])
    }

    /// Time from the first sample to the last, s; 0 where there is none.
    #[must_use]
    pub fn duration(&self) -> f64 {
        let ends = self.time.first().zip(self.time.last());
        ends.map_or(0.0, |(&first, &last)| elapsed(&[first, last])[1])
    }

    /// Whether there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// What to call this trace in tables and plots: the file's name, else the name in its head.
    #[must_use]
    pub fn label(&self) -> String {
        self.path
            .as_deref()
            .and_then(Path::file_name)
            .map(|name| name.to_string_lossy().into_owned())
            .or_else(|| self.head.name.clone())
            .unwrap_or_else(|| "trace".into())
    }

    /// Number of pulses of a line that several devices share from which the recorder's time was taken; none where it was not.
    #[must_use]
    pub fn pulses(&self) -> Option<i64> {
        self.head.other.get("recording")?.get("pulses")?.as_integer()
    }

    /// Adds a column, replacing one of the same name.
    ///
    /// # Panics
    /// If `values` is not as long as the trace.
    pub fn set_column(&mut self, name: impl Into<String>, values: Vec<f64>) {
        assert_eq!(values.len(), self.len(), "a column is as long as its trace");
        let name = name.into();
        match self.columns.iter_mut().find(|column| column.name == name) {
            Some(column) => column.values = values,
            None => self.columns.push(Column { name, values }),
        }
    }
}
