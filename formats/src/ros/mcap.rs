//! MCAP files.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::panic::AssertUnwindSafe;
use std::path::Path;

use mcap::records::Record;
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
                        let record = mcap::parse_record(opcode, data).map_err(damaged)?;
                        found.take(record)?;
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
    fn take(&mut self, record: Record) -> Result<(), Error> {
        match record {
            Record::Schema { header, data } => {
                self.schemas.insert(header.id, (header.name, header.encoding, data.into_owned()));
            }
            Record::Channel(channel) => {
                let schema = self.schemas.get(&channel.schema_id);
                let decoder = decoder(&channel.message_encoding, schema);
                let name = channel.topic;
                self.topics.entry(channel.id).or_insert_with(|| Topic::new(FORMAT, name, decoder));
            }
            Record::Message { header, data } => {
                let unknown = || {
                    let place = format!("channel {}", header.channel_id);
                    Error::damaged(FORMAT, place, "a message without its topic")
                };
                let topic = self.topics.get_mut(&header.channel_id).ok_or_else(unknown)?;
                if self.wanted.is_none_or(|wanted| wanted == topic.name) {
                    topic.take(&data, i128::from(header.log_time))?;
                }
            }
            _ => {}
        }
        Ok(())
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
