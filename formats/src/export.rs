//! Tables of numbers into the files of other programs: MATLAB 7.3 and MCAP.

use std::collections::BTreeMap;
use std::io::Cursor;

use hdf5_pure::mat::{MatBuilder, Options};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, WriteOptions};
use serde_json::{Map, Value, json};

use crate::Error;

const MATLAB: &str = "MATLAB 7.3";
const MCAP: &str = "MCAP";
/// What the text about a table is called in a file: the variable of MATLAB, the key of the metadata of MCAP.
pub const HEAD: &str = "head";
/// The topic of a table.
pub const TOPIC: &str = "/palpate/trace";

/// A table, and what is to be said of it.
#[derive(Clone, Copy, Debug)]
pub struct Table<'a> {
    /// The columns by name, all of one length; the first rises and is in seconds.
    pub columns: &'a [(&'a str, &'a [f64])],
    /// What is known of it, as text.
    pub head: &'a str,
}

/// The bytes of a file of MATLAB 7.3 (HDF5 in its form of 1.8, which every MATLAB since R2006b opens): a vector for each
/// column, called by its name, and the head as text.
///
/// # Errors
/// [`Error::Unread`] where MATLAB allows no variable of the name of a column.
pub fn mat(table: Table<'_>) -> Result<Vec<u8>, Error> {
    let mut file = MatBuilder::new(Options::default());
    for (name, values) in table.columns {
        let refused = |_| Error::unread(MATLAB, name.to_string(), "MATLAB allows no such name");
        if *name == HEAD {
            return Err(Error::unread(MATLAB, *name, "the text about the table is called so"));
        }
        file.write_f64(name, &[values.len(), 1], values).map_err(refused)?;
    }
    let failed = |error: hdf5_pure::mat::MatError| Error::unread(MATLAB, HEAD, error.to_string());
    file.write_char(HEAD, table.head).map_err(failed)?;
    file.finish().map_err(failed)
}

/// The bytes of an MCAP file: one topic with a message of JSON for each row, and a schema of it. A message is recorded as long
/// after 1970 as its row stands after the first.
///
/// # Errors
/// [`Error::Unread`] where the writer refuses.
pub fn mcap(table: Table<'_>) -> Result<Vec<u8>, Error> {
    write(table).map_err(|error| Error::unread(MCAP, TOPIC, error.to_string()))
}

fn write(Table { columns, head }: Table<'_>) -> mcap::McapResult<Vec<u8>> {
    let options = WriteOptions::new()
        .compression(Some(Compression::Zstd))
        .library(concat!("palpate ", env!("CARGO_PKG_VERSION")));
    let mut file = options.create(Cursor::new(Vec::new()))?;
    let schema = file.add_schema("palpate.Trace", "jsonschema", schema(columns).as_bytes())?;
    let channel_id = file.add_channel(schema, TOPIC, "json", &BTreeMap::new())?;
    let head = BTreeMap::from([(HEAD.to_owned(), head.to_owned())]);
    file.write_metadata(&Metadata { name: "palpate".into(), metadata: head })?;
    let time = columns.first().map_or(&[][..], |(_, time)| time);
    for (row, seconds) in time.iter().enumerate() {
        let message: Map<String, Value> =
            columns.iter().map(|(name, values)| ((*name).into(), values[row].into())).collect();
        let log_time = ((seconds - time[0]) * 1e9).round() as u64;
        let header =
            MessageHeader { channel_id, sequence: row as u32, log_time, publish_time: log_time };
        file.write_to_known_channel(&header, Value::Object(message).to_string().as_bytes())?;
    }
    file.finish()?;
    Ok(file.into_inner().into_inner())
}

fn schema(columns: &[(&str, &[f64])]) -> String {
    let number = json!({"type": "number"});
    let properties: Map<String, Value> =
        columns.iter().map(|(name, _)| ((*name).into(), number.clone())).collect();
    json!({"title": "palpate.Trace", "type": "object", "properties": properties}).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Content, Contents};

    const TIME: [f64; 3] = [-0.5, 0.1 + 0.2, 1e3];
    const FORCE: [f64; 3] = [0.0, -1.0 / 3.0, 5e-324];

    fn table() -> Table<'static> {
        Table { columns: &[("time_s", &TIME), ("force_N", &FORCE)], head: "name = \"ä\"\n" }
    }

    /// The columns that a reader finds.
    fn numbers(found: &Contents) -> BTreeMap<String, Vec<f64>> {
        let [part] = &found.parts[..] else { panic!("{:?}", found.names) };
        let Content::Columns(columns) = &part.content else { panic!("{}", part.name) };
        columns.iter().map(|column| (column.name.clone(), column.values.clone())).collect()
    }

    #[test]
    fn what_is_written_comes_back_to_the_last_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table");
        std::fs::write(&path, mat(table()).unwrap()).unwrap();
        let back = numbers(&crate::hdf5::matlab(&path, None).unwrap());
        assert_eq!((&back["time_s"][..], &back["force_N"][..]), (&TIME[..], &FORCE[..]));
        std::fs::write(&path, mcap(table()).unwrap()).unwrap();
        let back = numbers(&crate::ros::mcap(&path, None).unwrap());
        assert_eq!((&back["time_s"][..], &back["force_N"][..]), (&TIME[..], &FORCE[..]));
    }

    #[test]
    fn a_name_that_matlab_does_not_allow_is_refused() {
        for name in ["Kraft (N)", "2nd", "head", "end"] {
            let columns: [(&str, &[f64]); 1] = [(name, &TIME)];
            let refused = mat(Table { columns: &columns, head: "" }).unwrap_err().to_string();
            assert!(refused.contains(name), "{refused}");
        }
    }
}
