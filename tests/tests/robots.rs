//! The tools of robots: what a fingertip feels as topics of ROS 2, into a file and live.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Stdio};

use palpate_formats::{Content, ros};
use palpate_tests::palpate;
use palpate_tests::server::{Server, program, simulate};
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket, connect};

/// `palpate device simulate`, until the test ends.
struct Simulated(Child);

impl Drop for Simulated {
    fn drop(&mut self) {
        // One that has ended on its own is as good.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A recording of a simulated fingertip, `take.palpate`, with `take.mcap` beside it.
fn recorded(folder: &Path) {
    let _simulated = Simulated(simulate(folder));
    let record =
        ["record", "-o", "take.palpate", "--mcap", "take.mcap", "--duration", "3", "--all"];
    let mut command = palpate();
    command.current_dir(folder).args(record).args(["--port", "fingertip"]);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

type Columns = BTreeMap<String, Vec<f64>>;

/// The numbers of each topic.
fn topics(file: &Path) -> BTreeMap<String, Columns> {
    let parts = ros::mcap(file, None).unwrap().parts.into_iter().map(|part| {
        let Content::Columns(columns) = part.content else { panic!("{}", part.name) };
        (part.name, columns.into_iter().map(|column| (column.name, column.values)).collect())
    });
    parts.collect()
}

/// The only trace of a recording.
fn converted(folder: &Path) -> palpate::trace::Trace {
    let mut command = palpate();
    command.current_dir(folder).args(["convert", "take.palpate", "-o", "take.csv"]).unwrap();
    palpate::trace::read_set(&[folder.join("take.csv")]).unwrap().remove(0)
}

/// The regions of a gauge, those that were recognised late put back to where they were entered, as in a trace.
fn put_back(rows: &Columns, gauge: usize) -> Vec<f64> {
    let mut regions = rows[&format!("region.{gauge}")].clone();
    for (row, ago) in rows[&format!("entered_rows_ago.{gauge}")].iter().enumerate() {
        if *ago >= 0.0 {
            let now = regions[row];
            regions[row.saturating_sub(*ago as usize)..row].fill(now);
        }
    }
    regions
}

#[test]
fn an_mcap_file_holds_every_row_of_the_recording_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    recorded(folder.path());
    let trace = converted(folder.path());
    let topics = topics(&folder.path().join("take.mcap"));
    let rows = &topics["/palpate/finger_1/fingertip"];
    let pairs = [
        ("fa", "fa_ustrain"),
        ("sa", "sa_ustrain"),
        ("elastic", "elastic_ustrain"),
        ("equilibrium", "equilibrium_ustrain"),
        ("counts", "counts"),
        ("flags", "flags"),
    ];
    for (message, column) in pairs {
        for gauge in 0..4 {
            let name = format!("gauge{}_{column}", gauge + 1);
            let wanted = trace.column(&name).unwrap_or_else(|| panic!("no {name}"));
            assert!(rows[&format!("{message}.{gauge}")] == wanted, "{name}");
        }
    }
    for gauge in 0..4 {
        let wanted = trace.column(&format!("gauge{}_region", gauge + 1)).unwrap();
        assert!(put_back(rows, gauge) == wanted, "regions of gauge {}", gauge + 1);
    }
    assert!(rows["number"].len() > 2_000, "{} rows", rows["number"].len());
    assert!(rows["number"].windows(2).all(|pair| pair[1] == pair[0] + 1.0));
    // Stamps run as the device does, and do not go back.
    let times = &rows["log_time"];
    assert!(times.windows(2).all(|pair| pair[1] >= pair[0]));
    let device = &rows["device_time_us"];
    let passed = |times: &[f64]| times.last().unwrap() - times[0];
    assert!((passed(times) - passed(device) * 1e-6).abs() < 0.1, "{}", passed(times));
}

#[test]
fn a_file_that_is_there_is_kept_and_a_device_that_refuses_leaves_none() {
    let folder = tempfile::tempdir().unwrap();
    let call = |arguments: &[&str]| {
        let mut command = palpate();
        let output = command.current_dir(folder.path()).args(arguments).output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    std::fs::write(folder.path().join("old.mcap"), "precious").unwrap();
    let record = ["record", "-o", "take.palpate", "--port", "nowhere", "--mcap"];
    let (status, error) = call(&[&record[..], &["old.mcap"]].concat());
    assert!(status == Some(2) && error.contains("old.mcap: exists already"), "{error}");
    let (status, _) = call(&[&record[..], &["old.mcap", "--force"]].concat());
    assert_eq!(status, Some(2));
    assert_eq!(std::fs::read(folder.path().join("old.mcap")).unwrap(), b"precious");
    let (status, error) = call(&[&record[..], &["new.mcap"]].concat());
    assert!(status == Some(2) && error.contains("nowhere"), "{error}");
    assert!(!folder.path().join("new.mcap").exists());
    let (status, error) = call(&[&record[..], &["take.csv"]].concat());
    assert!(status == Some(2) && error.contains("must end in .mcap"), "{error}");
}

/// Where viewers connect to, as a server says it.
fn door(server: &mut Server) -> String {
    let said = BufReader::new(server.process.stderr.take().unwrap());
    let mut lines = said.lines().map(Result::unwrap);
    let line = lines.find(|line| line.contains("ws://")).unwrap();
    // It goes on saying things, which nobody reads but somebody must take.
    std::thread::spawn(move || lines.for_each(drop));
    line.split_whitespace().last().unwrap().to_owned()
}

type Viewer = WebSocket<MaybeTlsStream<std::net::TcpStream>>;

/// A viewer, and the topics it was told.
fn viewer(url: &str) -> (Viewer, Vec<Value>) {
    let mut request = url.into_client_request().unwrap();
    request.headers_mut().insert("Sec-WebSocket-Protocol", "foxglove.sdk.v1".parse().unwrap());
    let (mut viewer, _) = connect(request).unwrap();
    loop {
        let Message::Text(text) = viewer.read().unwrap() else { continue };
        let said: Value = serde_json::from_str(&text).unwrap();
        if said["op"] == "advertise" {
            return (viewer, said["channels"].as_array().unwrap().clone());
        }
    }
}

#[test]
fn a_viewer_sees_every_finger_of_a_hand_and_the_margin_of_its_grasp() {
    let mut server = Server::begin(&["--simulate", "--fingers", "2", "--foxglove=0"]);
    let url = door(&mut server);
    assert!(url.starts_with("ws://127.0.0.1:"), "{url}");
    let (mut viewer, channels) = viewer(&url);
    let mut told: Vec<&str> =
        channels.iter().map(|channel| channel["topic"].as_str().unwrap()).collect();
    told.sort_unstable();
    let all = ["events", "fingertip", "margin"];
    let wanted = [1, 2].map(|finger| all.map(|name| format!("/palpate/finger_{finger}/{name}")));
    assert_eq!(told, wanted.concat());
    let holding = json!({ "grasp": { "contact": "circle:5", "friction": 0.7, "normal": "0.001" } });
    assert_eq!(server.wish_of(2, &holding).0, 200);
    let ids = ["finger_1/fingertip", "finger_2/fingertip", "finger_2/margin"].map(|name| {
        let is = |channel: &&Value| channel["topic"].as_str().unwrap().ends_with(name);
        channels.iter().find(is).unwrap()["id"].clone()
    });
    let asked: Vec<Value> =
        ids.iter().zip(1..).map(|(id, number)| json!({ "id": number, "channelId": id })).collect();
    let ask = json!({ "op": "subscribe", "subscriptions": asked });
    viewer.send(Message::text(ask.to_string())).unwrap();
    let mut heard = [0; 3];
    while heard[0] < 500 || heard[1] < 500 || heard[2] < 2 {
        if let Message::Binary(bytes) = viewer.read().unwrap() {
            heard[usize::from(bytes[1]) - 1] += 1;
        }
    }
}

#[test]
fn a_door_that_cannot_be_opened_is_refused_before_anything_begins() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    let output = program()
        .args(["serve", "--simulate", &format!("--foxglove={port}")])
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains(&format!("127.0.0.1:{port}")), "{error}");
    let folder = tempfile::tempdir().unwrap();
    let output = program().arg("serve").arg(folder.path()).arg("--foxglove=0").output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("--simulate"), "{error}");
}

#[test]
#[ignore = "needs the libraries of Python: cargo xtask formats"]
fn libraries_that_share_no_code_with_it_read_the_same_from_the_file_and_live() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let folder = tempfile::tempdir().unwrap();
    recorded(folder.path());
    let mut server = Server::begin(&["--simulate", "--foxglove=0"]);
    let output = std::process::Command::new(top.join("target/formats/python/bin/python"))
        .arg(top.join("tests/robots/read.py"))
        .arg(folder.path().join("take.mcap"))
        .args([&door(&mut server), "500"])
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let (file, live) = (&found["file"], &found["live"]);
    assert_eq!(file["same"], true, "two libraries read two things");
    let trace = converted(folder.path());
    let fa = trace.column("gauge3_fa_ustrain").unwrap();
    let rows = file["rows"].as_array().unwrap();
    assert!(rows.iter().map(|row| row["fa"][2].as_f64().unwrap()).eq(fa.iter().copied()));
    assert_eq!(rows[0]["frame_id"], "finger_1");
    assert_eq!(live["topics"].as_array().unwrap().len(), 3);
    let numbers: Vec<u64> = live["rows"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| row["number"].as_u64().unwrap())
        .collect();
    assert!(numbers.windows(2).all(|pair| pair[1] == pair[0] + 1), "{numbers:?}");
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap();
    let stamp = live["rows"][499]["stamp_s"].as_f64().unwrap();
    assert!((now.as_secs_f64() - stamp).abs() < 10.0, "{stamp}");
}
