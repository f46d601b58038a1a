//! What is published is what a reader and a viewer find.

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv4Addr};

use palpate_formats::{Content, ros};
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message as Socket, connect};

use crate::{Door, Fingertip, GraspMargin, Message, Topics, TouchEvent};

const UNIX_NS: u64 = 1_700_000_000_123_456_789;

fn row(topics: &Topics) -> Fingertip {
    Fingertip {
        header: topics.header(UNIX_NS),
        number: 7,
        device_time_us: 5_000_000_001,
        counts: [1, -2, 8_388_607, -8_388_608],
        fa: [0.1, -1e-300, 0.0, 1.0 / 3.0],
        sa: [1.0, 2.0, 3.0, f64::MAX],
        elastic: vec![9.0, 8.0, 7.0, 6.0],
        equilibrium: Vec::new(),
        region: [0, 2, 4, 6],
        entered_rows_ago: [-1, 12, -1, 0],
        relaxation: [0, 1, 2, 0],
        flags: [0, 0, 4, 7],
    }
}

fn event(topics: &Topics) -> TouchEvent {
    let header = topics.header(UNIX_NS + 1);
    TouchEvent { header, number: 3, row: 7, began_rows_before: 12, kind: 2, gauge: 4 }
}

fn margin(topics: &Topics) -> GraspMargin {
    GraspMargin {
        header: topics.header(UNIX_NS + 2),
        normal_force: 2.0,
        tangential_force: 0.5,
        moment: 1.5,
        margin: 1.75,
        settled_margin: 0.875,
        slips_in: 3.5,
        tighten: f64::NAN,
    }
}

/// The numbers of each topic, by name.
fn read(file: &std::path::Path) -> BTreeMap<String, BTreeMap<String, Vec<f64>>> {
    let contents = ros::mcap(file, None).unwrap();
    let parts = contents.parts.into_iter().map(|part| {
        let Content::Columns(columns) = part.content else { panic!("{}", part.name) };
        (part.name, columns.into_iter().map(|column| (column.name, column.values)).collect())
    });
    parts.collect()
}

#[test]
fn a_file_holds_every_number_under_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("take.mcap");
    let mut door = Door::new();
    let topics = door.finger(2).unwrap();
    topics.row(&row(&topics));
    door.write(std::fs::File::create(&path).unwrap()).unwrap();
    for _ in 0..2 {
        topics.row(&row(&topics));
        topics.event(&event(&topics));
        topics.margin(&margin(&topics));
    }
    door.end_file().unwrap();
    topics.row(&row(&topics));
    let found = read(&path);
    let names = ["events", "fingertip", "margin"].map(|name| format!("/palpate/finger_2/{name}"));
    assert!(found.keys().eq(&names), "{:?}", found.keys());
    let rows = &found["/palpate/finger_2/fingertip"];
    let wanted = row(&topics);
    for gauge in 0..4 {
        let is = |name: &str, value: f64| {
            assert_eq!(rows[&format!("{name}.{gauge}")], [value; 2], "{name} {gauge}");
        };
        is("fa", wanted.fa[gauge]);
        is("sa", wanted.sa[gauge]);
        is("elastic", wanted.elastic[gauge]);
        is("counts", wanted.counts[gauge].into());
        is("region", wanted.region[gauge].into());
        is("entered_rows_ago", wanted.entered_rows_ago[gauge].into());
        is("relaxation", wanted.relaxation[gauge].into());
        is("flags", wanted.flags[gauge].into());
    }
    assert_eq!(rows["number"], [7.0; 2]);
    assert_eq!(rows["device_time_us"], [5_000_000_001.0; 2]);
    let events = &found["/palpate/finger_2/events"];
    let numbers = ["number", "row", "began_rows_before", "kind", "gauge"];
    assert_eq!(numbers.map(|name| events[name][0]), [3.0, 7.0, 12.0, 2.0, 4.0]);
    let margins = &found["/palpate/finger_2/margin"];
    assert_eq!(margins["settled_margin"], [0.875; 2]);
    assert!(margins["tighten"][0].is_nan());
}

#[test]
fn a_viewer_is_told_the_topics_and_sent_what_it_asks_for() {
    let mut door = Door::new();
    let topics = door.finger(1).unwrap();
    let url = door.serve(IpAddr::V4(Ipv4Addr::LOCALHOST), 0).unwrap();
    let mut request = url.as_str().into_client_request().unwrap();
    request.headers_mut().insert("Sec-WebSocket-Protocol", "foxglove.sdk.v1".parse().unwrap());
    let (mut viewer, _) = connect(request).unwrap();
    let channels = loop {
        let Socket::Text(text) = viewer.read().unwrap() else { continue };
        let said: Value = serde_json::from_str(&text).unwrap();
        if said["op"] == "advertise" {
            break said["channels"].as_array().unwrap().clone();
        }
    };
    let rows = channels.iter().find(|one| one["topic"] == "/palpate/finger_1/fingertip").unwrap();
    assert_eq!((channels.len(), &rows["schemaName"]), (3, &json!(Fingertip::NAME)));
    assert!(rows["schema"].as_str().unwrap().contains("float64[4] fa"));
    let wish =
        json!({ "op": "subscribe", "subscriptions": [{ "id": 5, "channelId": rows["id"] }] });
    viewer.send(Socket::text(wish.to_string())).unwrap();
    while !topics.is_heard() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    topics.row(&row(&topics));
    let bytes = loop {
        if let Socket::Binary(bytes) = viewer.read().unwrap() {
            break bytes;
        }
    };
    // A message: its kind, the subscription, when it was logged, and what was published.
    assert_eq!((bytes[0], &bytes[1..5]), (1, &5_u32.to_le_bytes()[..]));
    assert_eq!(bytes[5..13], UNIX_NS.to_le_bytes());
    assert_eq!(bytes[13..], row(&topics).cdr().unwrap());
}

#[test]
fn an_address_that_is_taken_is_refused_by_its_name() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    let refused = Door::new().serve(IpAddr::V4(Ipv4Addr::LOCALHOST), port).unwrap_err();
    assert!(refused.to_string().contains(&format!("127.0.0.1:{port}")), "{refused}");
}
