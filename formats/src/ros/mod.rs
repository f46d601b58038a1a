//! Recordings of robots: MCAP files and the SQLite bags of ROS 2, a part a topic.
//!
//! A message of ROS 2 is taken apart by the definition of its type, one of JSON as it is; every number in it is a column, named
//! by its path (`wrench.force.z`). Numbers of an array have their place or, where the message has as many names (JointState),
//! their name. `log_time` is when a message was recorded. Times that count from 1970 count from their first whole second.

mod bag;
mod cdr;
mod columns;
mod known;
mod mcap;
mod schema;
#[cfg(test)]
mod tests;

pub use bag::bag;
pub use mcap::mcap;

use crate::limits::Budget;
use crate::{Contents, Error, Part};
use cdr::Cdr;
use columns::Columns;
use schema::Schema;

/// A topic and how its messages are written.
struct Topic {
    format: &'static str,
    name: String,
    decoder: Decoder,
    columns: Columns,
    budget: Budget,
    counted: usize,
}

/// How messages are taken apart.
enum Decoder {
    Ros(Schema),
    Json,
    /// Why they are not.
    None(String),
}

/// Why messages of some kind are not read.
fn not_read(what: &str) -> Decoder {
    Decoder::None(format!(
        "{what} is not read; record as ROS 2 (CDR) or JSON, or export the topic as CSV"
    ))
}

impl Topic {
    fn new(format: &'static str, name: String, decoder: Decoder) -> Self {
        let (columns, budget) = (Columns::default(), Budget::new(format));
        Self { format, name, decoder, columns, budget, counted: 0 }
    }

    /// Takes one message, recorded so many nanoseconds after 1970.
    fn take(&mut self, message: &[u8], log_time_ns: i128) -> Result<(), Error> {
        let place = || format!("topic `{}`", self.name);
        let damaged = |what: String| Error::damaged(self.format, place(), what);
        self.columns.begin();
        match &self.decoder {
            Decoder::None(_) => return Ok(()),
            Decoder::Ros(schema) => {
                let mut cdr = Cdr::new(message).map_err(damaged)?;
                let path = &mut String::new();
                cdr.message(schema, 0, path, None, &mut self.columns, 0).map_err(damaged)?;
            }
            Decoder::Json => {
                let value: serde_json::Value =
                    serde_json::from_slice(message).map_err(|error| damaged(error.to_string()))?;
                json(&value, &mut String::new(), &mut self.columns);
            }
        }
        let seconds = log_time_ns.div_euclid(1_000_000_000) as i64;
        self.columns.time("log_time", seconds, log_time_ns.rem_euclid(1_000_000_000) as u32);
        let more = self.columns.size() - self.counted;
        self.counted += more;
        self.budget.take(more, &place())
    }
}

/// Puts every number of a JSON value into its column.
fn json(value: &serde_json::Value, path: &mut String, out: &mut Columns) {
    use serde_json::Value;
    let mut inner = |name: &str, value: &Value, out: &mut Columns| {
        let kept = path.len();
        if kept > 0 {
            path.push('.');
        }
        path.push_str(name);
        json(value, path, out);
        path.truncate(kept);
    };
    match value {
        Value::Object(members) => members.iter().for_each(|(name, value)| inner(name, value, out)),
        Value::Array(members) if members.len() <= 64 => {
            members.iter().enumerate().for_each(|(at, value)| inner(&at.to_string(), value, out));
        }
        Value::Number(number) => out.number(path, None, number.as_f64().unwrap_or(f64::NAN)),
        Value::Bool(value) => out.number(path, None, f64::from(u8::from(*value))),
        _ => {}
    }
}

/// The parts of the topics, by name; an error if none of their kinds of messages is read.
fn contents(topics: impl Iterator<Item = Topic>, wanted: Option<&str>) -> Result<Contents, Error> {
    let mut contents = Contents::default();
    let mut refused = None;
    let mut topics: Vec<Topic> = topics.collect();
    topics.sort_by(|a, b| a.name.cmp(&b.name));
    for topic in topics {
        let asked = wanted == Some(topic.name.as_str());
        if let Decoder::None(what) = topic.decoder {
            let error = Error::unread(topic.format, format!("topic `{}`", topic.name), what);
            if asked {
                return Err(error);
            }
            refused.get_or_insert(error);
            continue;
        }
        contents.names.push(topic.name.clone());
        let columns = topic.columns.finish();
        if wanted.is_none() || asked {
            contents.parts.push(Part::columns(topic.name, columns));
        }
    }
    match refused {
        Some(error) if contents.names.is_empty() => Err(error),
        _ => Ok(contents),
    }
}
