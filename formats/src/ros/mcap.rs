//! MCAP files.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::panic::AssertUnwindSafe;
use std::path::Path;

use mcap::records::op;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::{Decoder, Schema, Topic, contents, not_read};
use crate::error::guarded;
use crate::{Contents, Error};

const FORMAT: &str = "MCAP";
/// Longest record, packed or not: a longer one is damage.
const RECORD: usize = 64 << 20;

/// Reads the topics of an MCAP file whose messages are of ROS 2 (CDR) or JSON, or the one of that name.
///
/// # Errors
/// See [`Error`].
pub fn mcap(path: &Path, wanted: Option<&str>) -> Result<Contents, Error> {
    let mut file = BufReader::new(File::open(path)?);
    guarded(
        FORMAT,
        AssertUnwindSafe(|| {
            let mut found = Found { wanted, schemas: HashMap::new(), topics: HashMap::new() };
            let options = LinearReaderOptions::default()
                .with_record_length_limit(RECORD)
                .with_validate_chunk_crcs(true)
                .with_validate_data_section_crc(true)
                .with_validate_summary_section_crc(true);
            let mut reader = LinearReader::new_with_options(options);
            let mut at = 0_u64;
            while let Some(event) = reader.next_event() {
                let damaged = |error| Error::damaged(FORMAT, format!("byte {at}"), error);
                match event.map_err(damaged)? {
                    LinearReadEvent::ReadRequest(need) => {
                        let count = file.read(reader.insert(need))?;
                        reader.notify_read(count);
                        at += count as u64;
                    }
                    LinearReadEvent::Record { opcode, data } => {
                        let cut =
                            || Error::damaged(FORMAT, format!("byte {at}"), "a record is cut off");
                        found.take(opcode, data).ok_or_else(cut)??;
                    }
                }
            }
            contents(found.topics.into_values(), wanted)
        }),
    )
}

/// Name, encoding and text of a type.
type Definition = (String, String, Vec<u8>);

struct Found<'a> {
    wanted: Option<&'a str>,
    schemas: HashMap<u16, Definition>,
    /// Topics by the number of their channel.
    topics: HashMap<u16, Topic>,
}

impl Found<'_> {
    /// Takes a record; none if it ends too early. The library's own parser takes as much memory for a text as its length says,
    /// and that may be damaged.
    fn take(&mut self, kind: u8, record: &[u8]) -> Option<Result<(), Error>> {
        let mut rest = Fields(record);
        match kind {
            op::SCHEMA => {
                let (id, name, encoding) = (rest.u16()?, rest.text()?, rest.text()?);
                self.schemas.insert(id, (name, encoding, rest.bytes()?.to_vec()));
            }
            op::CHANNEL => {
                let (id, schema, name) = (rest.u16()?, rest.u16()?, rest.text()?);
                let decoder = decoder(&rest.text()?, self.schemas.get(&schema));
                self.topics.entry(id).or_insert_with(|| Topic::new(FORMAT, name, decoder));
            }
            op::MESSAGE => {
                let (channel, _sequence) = (rest.u16()?, rest.take::<4>()?);
                let (log_time, _publish_time) = (rest.u64()?, rest.u64()?);
                let Some(topic) = self.topics.get_mut(&channel) else {
                    let place = format!("channel {channel}");
                    return Some(Err(Error::damaged(FORMAT, place, "a message without its topic")));
                };
                if self.wanted.is_none_or(|wanted| wanted == topic.name) {
                    return Some(topic.take(rest.0, i128::from(log_time)));
                }
            }
            _ => {}
        }
        Some(Ok(()))
    }
}

/// The bytes of a record from which its fields are cut; none where they end.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*taken)
    }

    fn u16(&mut self) -> Option<u16> {
        self.take().map(u16::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.take().map(u64::from_le_bytes)
    }

    fn bytes(&mut self) -> Option<&'a [u8]> {
        let length = u32::from_le_bytes(self.take()?) as usize;
        let (taken, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(taken)
    }

    fn text(&mut self) -> Option<String> {
        self.bytes().map(|bytes| String::from_utf8_lossy(bytes).into_owned())
    }
}

fn decoder(encoding: &str, schema: Option<&Definition>) -> Decoder {
    match (encoding, schema) {
        ("json", _) => Decoder::Json,
        ("cdr", Some((name, kind, text))) if kind == "ros2msg" => {
            match Schema::parse(name, &String::from_utf8_lossy(text)) {
                Ok(schema) => Decoder::Ros(schema),
                Err(what) => Decoder::None(format!("its definition is not understood ({what})")),
            }
        }
        ("cdr", Some((_, kind, _))) => not_read(&format!("a type defined as `{kind}`")),
        ("cdr", None) => not_read("a type without its definition"),
        (other, _) => not_read(&format!("the encoding `{other}`")),
    }
}
