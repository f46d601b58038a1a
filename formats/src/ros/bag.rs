//! Bags of ROS 2 in SQLite (`.db3`).

use std::collections::HashMap;
use std::panic::AssertUnwindSafe;
use std::path::{Path, PathBuf};

use rusqlite::{Connection, OpenFlags, OptionalExtension};

use super::{Decoder, Schema, Topic, contents, known, not_read};
use crate::error::guarded;
use crate::{Contents, Error};

const FORMAT: &str = "ROS 2 bag";

/// Reads the topics of a bag, or the one of that name. Bags older than ROS 2 Iron do not hold the definitions of their types;
/// the usual ones of `std_msgs`, `geometry_msgs` and `sensor_msgs` are known.
///
/// # Errors
/// See [`Error`].
pub fn bag(path: &Path, wanted: Option<&str>) -> Result<Contents, Error> {
    std::fs::File::open(path)?;
    check_closed(path)?;
    guarded(
        FORMAT,
        AssertUnwindSafe(|| {
            let bag = Connection::open_with_flags(
                path,
                OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX,
            )
            .map_err(|error| damaged(&error))?;
            let sound: String = bag
                .query_row("PRAGMA quick_check(1)", [], |row| row.get(0))
                .map_err(|error| damaged(&error))?;
            if sound != "ok" {
                return Err(damaged(&sound));
            }
            let mut topics = topics(&bag)?;
            take(&bag, &mut topics, wanted)?;
            contents(topics.into_values(), wanted)
        }),
    )
}

fn damaged(error: &dyn std::fmt::Display) -> Error {
    Error::damaged(FORMAT, "data base", error)
}

/// Refuses a bag part of which is in a file beside it: the recorder still writes, or broke off.
fn check_closed(path: &Path) -> Result<(), Error> {
    for ending in ["-wal", "-journal"] {
        let mut beside = path.as_os_str().to_owned();
        beside.push(ending);
        if std::fs::metadata(PathBuf::from(beside)).is_ok_and(|about| about.len() > 0) {
            let what = format!(
                "its recorder has not closed it (`{ending}` beside it); let `ros2 bag reindex` mend it"
            );
            return Err(Error::unread(FORMAT, "data base", what));
        }
    }
    Ok(())
}

fn topics(bag: &Connection) -> Result<HashMap<i64, Topic>, Error> {
    let tables = "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name IN ('topics', 'messages')";
    let count: i64 =
        bag.query_row(tables, [], |row| row.get(0)).map_err(|error| damaged(&error))?;
    if count < 2 {
        let what = "a data base of SQLite that is no bag of ROS 2; export its table as CSV";
        return Err(Error::unread(FORMAT, "data base", what));
    }
    let mut found = HashMap::new();
    let mut query = bag
        .prepare("SELECT id, name, type, serialization_format FROM topics")
        .map_err(|error| damaged(&error))?;
    let rows = query
        .query_map([], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?)))
        .map_err(|error| damaged(&error))?;
    for row in rows {
        let (id, name, kind, written): (i64, String, String, String) =
            row.map_err(|error| damaged(&error))?;
        let decoder = match written.as_str() {
            "cdr" => decoder(bag, &kind)?,
            other => not_read(&format!("the encoding `{other}`")),
        };
        found.insert(id, Topic::new(FORMAT, name, decoder));
    }
    Ok(found)
}

/// How messages of a type are read: by the definition in the bag, else by one that is known.
fn decoder(bag: &Connection, kind: &str) -> Result<Decoder, Error> {
    let tables =
        "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = 'message_definitions'";
    let has: i64 = bag.query_row(tables, [], |row| row.get(0)).map_err(|error| damaged(&error))?;
    let stored: Option<String> = match has {
        0 => None,
        _ => bag
            .query_row(
                "SELECT encoded_message_definition FROM message_definitions WHERE topic_type = ?1 AND encoding = 'ros2msg'",
                [kind],
                |row| row.get(0),
            )
            .optional()
            .map_err(|error| damaged(&error))?,
    };
    let stored = stored.filter(|text| !text.trim().is_empty());
    let Some(text) = stored.or_else(|| known::definition(kind)) else {
        return Ok(not_read(&format!("the type `{kind}`, whose definition is not in the bag,")));
    };
    Ok(match Schema::parse(kind, &text) {
        Ok(schema) => Decoder::Ros(schema),
        Err(what) => {
            Decoder::None(format!("the definition of `{kind}` is not understood ({what})"))
        }
    })
}

fn take(
    bag: &Connection,
    topics: &mut HashMap<i64, Topic>,
    wanted: Option<&str>,
) -> Result<(), Error> {
    let mut query = bag
        .prepare("SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp, id")
        .map_err(|error| damaged(&error))?;
    let mut rows = query.query([]).map_err(|error| damaged(&error))?;
    while let Some(row) = rows.next().map_err(|error| damaged(&error))? {
        let id: i64 = row.get(0).map_err(|error| damaged(&error))?;
        let topic = topics.get_mut(&id).ok_or_else(|| damaged(&"a message without its topic"))?;
        if wanted.is_some_and(|wanted| wanted != topic.name) {
            continue;
        }
        let time: i64 = row.get(1).map_err(|error| damaged(&error))?;
        let data = row.get_ref(2).map_err(|error| damaged(&error))?;
        let data = data.as_blob().map_err(|error| damaged(&error))?;
        topic.take(data, i128::from(time))?;
    }
    Ok(())
}
