use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use super::{bag, mcap};
use crate::{Column, Content, Contents, Error};

/// A message of WrenchStamped in CDR, little-endian: numbers at places that are multiples of their size.
fn wrench(sec: i32, nanosec: u32, frame: &str, z: f64) -> Vec<u8> {
    let mut body = [sec.to_le_bytes(), nanosec.to_le_bytes()].concat();
    body.extend((frame.len() as u32 + 1).to_le_bytes());
    body.extend(frame.bytes().chain([0]));
    body.resize(body.len().next_multiple_of(8), 0);
    for number in [0.5, -1.0, z, 0.0, 0.0, 0.25] {
        body.extend(f64::to_le_bytes(number));
    }
    [&[0, 1, 0, 0][..], &body].concat()
}

fn column(contents: &Contents, name: &str) -> Column {
    let Content::Columns(columns) = &contents.parts[0].content else { panic!("columns") };
    columns.iter().find(|column| column.name == name).cloned().unwrap()
}

fn in_a_file<T>(bytes: &[u8], read: impl Fn(&Path) -> T) -> T {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x");
    std::fs::write(&path, bytes).unwrap();
    read(&path)
}

fn recorded() -> Vec<u8> {
    let mut writer = ::mcap::Writer::new(Cursor::new(Vec::new())).unwrap();
    let text = super::known::definition("geometry_msgs/msg/WrenchStamped").unwrap();
    let schema =
        writer.add_schema("geometry_msgs/msg/WrenchStamped", "ros2msg", text.as_bytes()).unwrap();
    let none = BTreeMap::new();
    let tip = writer.add_channel(schema, "/tip", "cdr", &none).unwrap();
    let plain = writer.add_channel(0, "/plain", "json", &none).unwrap();
    let other = writer.add_channel(0, "/other", "protobuf", &none).unwrap();
    for i in 0..3_u32 {
        let log_time = 1_700_000_000_000_000_000 + 250_000_000 * u64::from(i);
        let head = |channel_id| ::mcap::records::MessageHeader {
            channel_id,
            sequence: i,
            log_time,
            publish_time: log_time,
        };
        let message = wrench(1_700_000_000, 250_000_000 * i, "tip", f64::from(i));
        writer.write_to_known_channel(&head(tip), &message).unwrap();
        let body = format!("{{\"a\": {{\"b\": {i}}}, \"list\": [1.5, true], \"word\": \"x\"}}");
        writer.write_to_known_channel(&head(plain), body.as_bytes()).unwrap();
        writer.write_to_known_channel(&head(other), &[8, 1]).unwrap();
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

#[test]
fn numbers_of_messages_are_columns_by_their_path_and_times_keep_their_digits() {
    let bytes = recorded();
    let contents = in_a_file(&bytes, |path| mcap(path, Some("/tip"))).unwrap();
    assert_eq!(contents.names, ["/plain", "/tip"]);
    let force = column(&contents, "wrench.force.z");
    assert_eq!((force.unit.as_deref(), &force.values[..]), (Some("N"), &[0.0, 1.0, 2.0][..]));
    assert_eq!(column(&contents, "wrench.torque.z").values, [0.25; 3]);
    assert_eq!(column(&contents, "header.stamp").values, [0.0, 0.25, 0.5]);
    assert_eq!(column(&contents, "log_time").values, [0.0, 0.25, 0.5]);
    let contents = in_a_file(&bytes, |path| mcap(path, Some("/plain"))).unwrap();
    assert_eq!(column(&contents, "a.b").values, [0.0, 1.0, 2.0]);
    assert_eq!(column(&contents, "list.1").values, [1.0; 3]);
    let error = in_a_file(&bytes, |path| mcap(path, Some("/other"))).unwrap_err();
    assert!(
        error.to_string().contains("topic `/other`: the encoding `protobuf` is not read"),
        "{error}"
    );
}

#[test]
fn every_cut_of_an_mcap_file_is_refused() {
    let whole = recorded();
    for end in 0..whole.len() {
        let error = in_a_file(&whole[..end], |path| mcap(path, None)).unwrap_err();
        assert!(matches!(error, Error::Damaged { .. }), "{end}: {error}");
    }
}

#[test]
fn a_bag_without_definitions_is_read_by_the_known_ones() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.db3");
    let data = rusqlite::Connection::open(&path).unwrap();
    data.execute_batch(
        "CREATE TABLE topics (id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT, offered_qos_profiles TEXT);
         CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);
         INSERT INTO topics VALUES (1, '/tip', 'geometry_msgs/msg/WrenchStamped', 'cdr', '');
         INSERT INTO topics VALUES (2, '/odd', 'my_msgs/msg/Odd', 'cdr', '');",
    )
    .unwrap();
    // Later in the table, earlier in time.
    for i in [2, 0, 1] {
        let message = wrench(5, 100_000_000 * i, "a", f64::from(i));
        let time = 5_000_000_000 + 100_000_000 * i64::from(i);
        data.execute(
            "INSERT INTO messages (topic_id, timestamp, data) VALUES (1, ?1, ?2)",
            (time, message),
        )
        .unwrap();
    }
    drop(data);
    let contents = bag(&path, None).unwrap();
    assert_eq!(contents.names, ["/tip"]);
    assert_eq!(column(&contents, "wrench.force.z").values, [0.0, 1.0, 2.0]);
    assert_eq!(column(&contents, "header.stamp").values, [5.0, 5.1, 5.2]);
    let error = bag(&path, Some("/odd")).unwrap_err().to_string();
    assert!(error.contains("`my_msgs/msg/Odd`, whose definition is not in the bag"), "{error}");
    std::fs::write(folder.path().join("run.db3-wal"), "x").unwrap();
    assert!(bag(&path, None).unwrap_err().to_string().contains("has not closed it"));
}
