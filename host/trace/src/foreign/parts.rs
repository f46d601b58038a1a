//! Tables by the readers of `palpate-formats`.

use std::io::{BufRead, BufReader, Read};
use std::panic::AssertUnwindSafe;
use std::path::Path;

use palpate_formats::{
    Content, Contents, Part, export, force_curve, hdf5, mat, packed, parquet, ros, spreadsheet,
    tdms,
};

use super::kind::{Format, Reader};
use super::{Export, Opened};
use crate::caught::caught;
use crate::error::Error;
use crate::mapping::Delimiter;
use crate::table::{part_of, split};
use crate::{Column, TIME, Trace, read, write};

/// Packed text as it was.
pub(super) fn unpacked(path: &Path, format: Format) -> Result<Box<dyn Read>, Error> {
    let foreign = |error| foreign(path, error);
    Ok(match format.reader {
        Reader::Gzip => Box::new(packed::gzip(path).map_err(foreign)?),
        _ => Box::new(packed::zstandard(path).map_err(foreign)?),
    })
}

/// The table of that name, or the only one, as text.
pub(super) fn open_part(path: &Path, format: Format, part: Option<&str>) -> Result<Opened, Error> {
    let contents = contents(path, format, part)?;
    let several = contents.names.len() > 1;
    let mut found = contents.parts.into_iter();
    match (found.next(), found.next()) {
        (Some(one), None) => {
            let name = several.then(|| one.name.clone());
            Ok(Opened::Part { name, text: one.into_text() })
        }
        _ => Err(Error::WhichPart {
            path: path.into(),
            format: format.name,
            wanted: part.map(Into::into),
            present: contents.names,
        }),
    }
}

/// The only table that is a trace as it is.
pub(super) fn only_trace(path: &Path, format: Format) -> Result<Trace, Error> {
    let mut traces = traces_of(path, format)?;
    match traces.pop() {
        Some(part) if traces.is_empty() => trace_of(path, part),
        last => Err(not_one(path, format, true, traces.into_iter().chain(last))),
    }
}

/// All tables that are traces as they are, each under its name if there are several.
pub(super) fn all_traces(path: &Path, format: Format) -> Result<Vec<Trace>, Error> {
    let traces = traces_of(path, format)?;
    let several = traces.len() > 1;
    let trace = |part: Part| match several {
        true => trace_of(&part_of(path, &part.name), part),
        false => trace_of(path, part),
    };
    traces.into_iter().map(trace).collect()
}

/// The tables that name their columns as a trace does; at least one.
fn traces_of(path: &Path, format: Format) -> Result<Vec<Part>, Error> {
    let contents = contents(path, format, None)?;
    let (traces, others): (Vec<_>, Vec<_>) = contents.parts.into_iter().partition(has_time);
    if traces.is_empty() { Err(not_one(path, format, false, others)) } else { Ok(traces) }
}

fn not_one(
    path: &Path,
    format: Format,
    several: bool,
    parts: impl IntoIterator<Item = Part>,
) -> Error {
    let present = parts.into_iter().map(|part| part.name).collect();
    Error::NotOneTrace { path: path.into(), format: format.name, several, present }
}

/// The bytes of a trace as a file of another program.
pub(super) fn exported(
    path: &Path,
    trace: &Trace,
    head: &str,
    form: Export,
) -> Result<Vec<u8>, Error> {
    let mut columns = vec![(TIME, &trace.time[..])];
    columns.extend(trace.columns.iter().map(|column| (&column.name[..], &column.values[..])));
    let table = export::Table { columns: &columns, head };
    let made = match form {
        Export::Matlab => export::mat(table),
        Export::Mcap => export::mcap(table),
    };
    made.map_err(|error| foreign(path, error))
}

fn contents(path: &Path, format: Format, part: Option<&str>) -> Result<Contents, Error> {
    let read = || match format.reader {
        Reader::Excel => spreadsheet::excel(path, part),
        Reader::OpenDocument => spreadsheet::opendocument(path, part),
        Reader::Hdf5 => hdf5::hdf5(path, part),
        Reader::Matlab73 => hdf5::matlab(path, part),
        Reader::Matlab5 => mat::mat(path, part),
        Reader::Mcap => ros::mcap(path, part),
        Reader::Bag => ros::bag(path, part),
        Reader::Tdms => tdms::tdms(path, part),
        Reader::Parquet => parquet::parquet(path, part),
        Reader::Jpk => force_curve::jpk(path, part),
        Reader::Nid => force_curve::nid(path, part),
        Reader::Nanoscope => force_curve::nanoscope(path, part),
        Reader::Gzip | Reader::Zstandard | Reader::None(_) => Ok(Contents::default()),
    };
    let damaged = || Error::Foreign { path: path.into(), message: "is damaged".into() };
    caught(AssertUnwindSafe(read)).map_err(|_| damaged())?.map_err(|error| foreign(path, error))
}

fn foreign(path: &Path, error: palpate_formats::Error) -> Error {
    match error {
        palpate_formats::Error::Open(source) => Error::Open { path: path.into(), source },
        error => Error::Foreign { path: path.into(), message: error.to_string() },
    }
}

/// Whether a table names its columns as a trace does.
fn has_time(part: &Part) -> bool {
    match &part.content {
        Content::Columns(columns) => columns.iter().any(|column| column.name == TIME),
        Content::Cells(text) => {
            let lines = BufReader::new(&text[..]).lines().map_while(Result::ok);
            let header = lines.into_iter().find(|line| !line.is_empty() && !line.starts_with('#'));
            header.is_some_and(|header| {
                let mut cells = Vec::new();
                split(&header, Delimiter::Comma, &mut cells);
                cells.into_iter().any(|cell| header[cell].trim() == TIME)
            })
        }
    }
}

fn trace_of(path: &Path, part: Part) -> Result<Trace, Error> {
    let columns = match part.content {
        Content::Cells(text) => return read::parse(path, &text),
        Content::Columns(columns) => columns,
    };
    let mut trace = Trace { path: Some(path.into()), ..Trace::default() };
    let setup = part.setup.into_iter().map(|(key, value)| (key.into(), value.into()));
    trace.head.setup.other.extend(setup);
    for column in columns {
        match column.name == TIME {
            true => trace.time = column.values,
            false => {
                trace.columns.push(Column { name: column.name, values: column.values });
            }
        }
    }
    let refused = |message| Error::Foreign {
        path: path.into(),
        message: format!("`{}`: {message}", part.name),
    };
    write::check(&trace).map_err(refused)?;
    Ok(trace)
}
