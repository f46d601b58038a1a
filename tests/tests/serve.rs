//! The local page as a browser, and whoever should not, meets it.
#![cfg(unix)]

use std::io::Read;
use std::net::TcpStream;
use std::time::{Duration, Instant};

use palpate::serve::guard::{BODY_LIMIT, PROTOCOL, TOKEN_HEADER};
use palpate::serve::live::pyramid::SIGNALS;
use palpate::trace::recordable::{settings_of, write_recording};
use palpate::trace::recorded::{Options, read_recording};
use palpate_tests::bundled;
use palpate_tests::server::{PATIENCE, Server, program, simulate};
use serde_json::{Value, json};
use tungstenite::{Message, WebSocket};

const STREAM: &str = "/api/live/stream";

/// The page's side of the stream.
struct Page {
    socket: WebSocket<TcpStream>,
}

struct Rows {
    lost: f64,
    frames_dropped: f64,
    rows_dropped: f64,
    first: f64,
    count: usize,
    times: Vec<f64>,
    values: Vec<Vec<f32>>,
}

enum Heard {
    Rows(Rows),
    Health(Value),
}

impl Page {
    fn of(server: &Server) -> Self {
        let token = format!("token.{}", server.token);
        let origin = format!("http://{}", server.host());
        let socket =
            server.socket_with(STREAM, &[("origin", &origin)], &[PROTOCOL, &token]).unwrap();
        Self { socket }
    }

    /// The next message; rows are answered only if `answer`.
    fn hear(&mut self, answer: bool) -> Heard {
        loop {
            match self.socket.read().unwrap() {
                Message::Text(text) => return Heard::Health(serde_json::from_str(&text).unwrap()),
                Message::Binary(bytes) => {
                    if answer {
                        self.socket.send(Message::text("ok")).unwrap();
                    }
                    return Heard::Rows(Rows::read(&bytes));
                }
                _ => {}
            }
        }
    }

    fn rows(&mut self) -> Rows {
        loop {
            if let Heard::Rows(rows) = self.hear(true) {
                return rows;
            }
        }
    }

    /// Waits until health is as it should be.
    fn until(&mut self, words: &str, wanted: impl Fn(&Value) -> bool) -> Value {
        let begun = Instant::now();
        let mut last = Value::Null;
        while begun.elapsed() < PATIENCE {
            if let Heard::Health(message) = self.hear(true) {
                if wanted(&message["health"]) {
                    return message;
                }
                last = message;
            }
        }
        panic!("it never came to this: {words}; {last}");
    }
}

impl Rows {
    fn read(bytes: &[u8]) -> Self {
        let f64_at = |at: usize| f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
        let u32_at = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        let f32_at = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        let (count, signals) = (u32_at(40), u32_at(44));
        assert_eq!(signals, SIGNALS);
        assert_eq!(bytes.len(), 48 + count * (16 + 4 * signals));
        let values = |signal: usize| {
            (0..count).map(|row| f32_at(48 + 16 * count + 4 * (signal * count + row))).collect()
        };
        Self {
            lost: f64_at(0),
            frames_dropped: f64_at(8),
            rows_dropped: f64_at(16),
            first: f64_at(32),
            count,
            times: (0..count).map(|row| f64_at(48 + 8 * row)).collect(),
            values: (0..signals).map(values).collect(),
        }
    }
}

fn press() -> String {
    bundled("press.csv").display().to_string()
}

#[test]
fn the_page_and_all_it_loads_come_from_the_program_with_their_types() {
    let server = Server::simulated();
    let page = server.get("/");
    assert_eq!((page.status, page.header("content-type")), (200, "text/html; charset=utf-8"));
    let text = String::from_utf8(page.body).unwrap();
    assert!(!text.contains("http://") && !text.contains("https://"), "the page names a network");
    let mut files: Vec<String> = quoted(&text).filter(|file| file.starts_with('/')).collect();
    assert!(files.len() >= 6, "{files:?}");
    let mut seen = 0;
    while let Some(file) = files.get(seen).cloned() {
        seen += 1;
        // A browser asks for files without the token.
        let answer = server.ask("GET", &file, &server.headers()[..1], &[]);
        let kind = if file.ends_with(".css") { "text/css" } else { "text/javascript" };
        assert_eq!(answer.status, 200, "{file}");
        assert_eq!(answer.header("content-type"), format!("{kind}; charset=utf-8"), "{file}");
        // What a module imports is there too.
        let text = String::from_utf8(answer.body).unwrap();
        let imports = text.lines().filter(|line| line.starts_with("import "));
        let folder = file.rsplit_once('/').unwrap().0;
        for import in imports.flat_map(quoted) {
            let path = format!("{folder}/{}", import.trim_start_matches("./"));
            if !files.contains(&path) {
                files.push(path);
            }
        }
    }
    assert_eq!(server.get("/uplot/LICENSE").status, 200);
    for path in ["/nothing", "/../Cargo.toml", "/%2e%2e/Cargo.toml", "/uplot/", "/api/nothing"] {
        assert_eq!(server.get(path).status, 404, "{path}");
    }
}

fn quoted(text: &str) -> impl Iterator<Item = String> {
    text.split('"').skip(1).step_by(2).map(String::from)
}

#[test]
fn only_rooms_that_exist_are_told_of() {
    let server = Server::simulated();
    let rooms = server.json("/api/rooms");
    let (live, device) = (("live", "Live"), ("device", "Device"));
    let told = [live, device].map(|(name, title)| json!({ "name": name, "title": title }));
    assert_eq!(rooms["rooms"], json!(told));
    for room in rooms["rooms"].as_array().unwrap() {
        let module = format!("/{}.js", room["name"].as_str().unwrap());
        assert_eq!(server.get(&module).status, 200);
    }
}

#[test]
fn every_answer_forbids_the_page_what_does_not_come_from_here() {
    let server = Server::simulated();
    let refused = server.ask("GET", "/api/rooms", &[], &[]);
    assert_eq!(refused.status, 403, "a request without a host");
    let answers = [
        server.get("/"),
        server.get("/api/rooms"),
        server.get("/nothing"),
        server.ask("GET", "/", &[("host".into(), "evil.example".into())], &[]),
    ];
    for answer in answers {
        let policy = answer.header("content-security-policy");
        assert!(policy.starts_with("default-src 'none'; script-src 'self';"), "{policy}");
        assert!(
            policy.contains("frame-ancestors 'none'") && !policy.contains("unsafe"),
            "{policy}"
        );
        assert_eq!(answer.header("x-content-type-options"), "nosniff");
        assert_eq!(answer.header("referrer-policy"), "no-referrer");
        assert_eq!(answer.header("cache-control"), "no-store");
        assert_eq!(answer.header("cross-origin-resource-policy"), "same-origin");
        assert_eq!(answer.header("access-control-allow-origin"), "");
    }
}

#[test]
fn a_name_that_was_made_to_point_here_is_refused() {
    let server = Server::simulated();
    let with = |host: &str| {
        let headers = [("host".into(), host.into()), (TOKEN_HEADER.into(), server.token.clone())];
        server.ask("GET", "/api/rooms", &headers, &[]).status
    };
    assert_eq!(with(&server.host()), 200);
    assert_eq!(with(&format!("localhost:{}", server.port)), 200);
    for host in ["evil.example", "127.0.0.1", "127.0.0.1:1"] {
        assert_eq!(with(host), 403, "{host}");
    }
    assert_eq!(with(&format!("evil.example:{}", server.port)), 403);
    assert_eq!(with(&format!("127.0.0.1.evil.example:{}", server.port)), 403);
}

#[test]
fn another_site_can_neither_ask_nor_open_a_websocket() {
    let server = Server::simulated();
    let token = format!("token.{}", server.token);
    let ours = format!("http://{}", server.host());
    for (origin, status) in [(ours.as_str(), 200), ("http://evil.example", 403), ("null", 403)] {
        let mut headers = server.headers();
        headers.push(("origin".into(), origin.into()));
        assert_eq!(server.ask("GET", "/api/rooms", &headers, &[]).status, status, "{origin}");
        let socket = server.socket_with(STREAM, &[("origin", origin)], &[PROTOCOL, &token]);
        assert_eq!(socket.is_ok(), status == 200, "{origin}");
    }
}

#[test]
fn without_the_token_of_this_start_nothing_is_told_or_done() {
    let (server, other) = (Server::simulated(), Server::simulated());
    assert_ne!(server.token, other.token);
    let host = ("host".to_owned(), server.host());
    let with = |token: &str| {
        let headers = [host.clone(), (TOKEN_HEADER.into(), token.into())];
        server.ask("GET", "/api/rooms", &headers, &[]).status
    };
    assert_eq!(with(&server.token), 200);
    for token in ["", "0", &other.token, &server.token[1..]] {
        assert_eq!(with(token), 403, "{token}");
    }
    let wish = json!("stop").to_string();
    for path in ["/api/rooms", "/api/live/about", "/api/live/view?from=0&to=1", "/api/nothing"] {
        assert_eq!(server.ask("GET", path, std::slice::from_ref(&host), &[]).status, 403, "{path}");
    }
    let refused = server.ask("POST", "/api/live/wish", &[host], wish.as_bytes());
    assert_eq!(refused.status, 403);
    assert!(server.socket_with(STREAM, &[], &[PROTOCOL]).is_err());
    assert!(
        server.socket_with(STREAM, &[], &[PROTOCOL, &format!("token.{}", other.token)]).is_err()
    );
    Page::of(&server);
}

#[test]
fn the_page_stays_on_this_computer_unless_told_otherwise_and_then_it_warns() {
    let server = Server::simulated();
    let mut open = Server::begin(&["--simulate", "--bind", "0.0.0.0"]);
    let said = |server: &mut Server| {
        let _ = server.process.kill();
        let mut words = String::new();
        server.process.stderr.take().unwrap().read_to_string(&mut words).unwrap();
        words
    };
    let words = said(&mut open);
    assert!(words.contains("! 0.0.0.0 is no loopback address"), "{words}");
    let mut server = server;
    let words = said(&mut server);
    assert!(!words.contains('!'), "{words}");
}

#[test]
fn what_is_too_large_or_no_wish_is_refused() {
    let server = Server::simulated();
    let large = vec![b' '; BODY_LIMIT + 1];
    let answer = server.ask("POST", "/api/live/wish", &server.headers(), &large);
    assert_eq!(answer.status, 413);
    for wish in [json!("reboot"), json!([]), json!({ "tare": { "more": 1 } })] {
        assert!(matches!(server.wish(&wish).0, 400 | 422), "{wish}");
    }
    let mut page = Page::of(&server);
    let _ = page.socket.send(Message::text("x".repeat(1 << 20)));
    let begun = Instant::now();
    while page.socket.read().is_ok() {
        assert!(begun.elapsed() < PATIENCE, "a page that shouts is not shown out");
    }
    assert_eq!(server.get("/api/rooms").status, 200);
}

#[test]
fn a_page_sees_every_row_and_fast_and_slow_part_make_the_signal() {
    let server = Server::simulated();
    let mut page = Page::of(&server);
    let mut rows = page.rows();
    let mut next = rows.first;
    let mut seen = 0;
    while seen < 2_000 {
        assert_eq!(rows.first, next);
        assert_eq!((rows.lost, rows.frames_dropped), (0.0, 0.0));
        assert!(rows.times.is_sorted());
        for gauge in 0..4 {
            for row in 0..rows.count {
                let part = |signal: usize| rows.values[4 * signal + gauge][row];
                assert_eq!(part(0), part(1) + part(2));
            }
        }
        next += rows.count as f64;
        seen += rows.count;
        rows = page.rows();
    }
    let message = page.until("a rate of about 1 kHz", |health| {
        (900.0..1_050.0).contains(&health["rate_hz"].as_f64().unwrap())
    });
    let health = &message["health"];
    assert_eq!((&health["rows_lost"], &health["gaps"]), (&json!(0), &json!(0)));
    assert_eq!(health["status"]["temperature_celsius"], 25.0);
    assert_eq!(health["device"]["board"], "simulated");
}

#[test]
fn a_replayed_trace_goes_through_the_very_filter_of_the_device() {
    let server = Server::begin(&["--replay", &press(), "--speed", "20"]);
    let mut page = Page::of(&server);
    page.until("the trace is over", |health| {
        health["replayed"] == 1.0 && health["streaming"] == false
    });
    // The same trace as a recording of a device.
    let trace = palpate::trace::read(&bundled("press.csv")).unwrap();
    let file = server.folder.path().join("press.palpate");
    let mut bytes = Vec::new();
    write_recording(&trace, &settings_of(&trace), &mut bytes).unwrap();
    std::fs::write(&file, bytes).unwrap();
    let recorded = read_recording(&file, &Options::default()).unwrap().traces.remove(0);
    let view = server.get("/api/live/view?from=0&to=1e6&bins=5000");
    let count = view.numbers(0, 1)[0] as usize;
    assert_eq!(count, recorded.len(), "every sample is a bin of its own");
    let names = ["", "_fa", "_sa", "_elastic", "_equilibrium"];
    for (signal, part) in names.into_iter().enumerate() {
        for gauge in 0..4 {
            let name = format!("gauge{}{part}_ustrain", gauge + 1);
            let column = recorded.column(&name).unwrap_or_else(|| panic!("{name}"));
            let at = 16 + 24 * count + 16 * count * (4 * signal + gauge);
            for (row, expected) in column.iter().enumerate() {
                let bytes = view.body[at + 4 * row..at + 4 * row + 4].try_into().unwrap();
                assert_eq!(f64::from(f32::from_le_bytes(bytes)), *expected, "{name} {row}");
            }
        }
    }
    let events = server.json("/api/live/events?from=0&to=1e6");
    let found = |region: &str| events.as_array().unwrap().iter().any(|e| e["points"] == region);
    assert!(["AB", "CD", "DE"].into_iter().all(found), "{events}");
}

#[test]
fn a_page_that_stops_reading_loses_whole_frames_and_is_told_and_can_fetch_them() {
    let server = Server::simulated();
    let mut page = Page::of(&server);
    let mut heard = 0;
    while heard < 16 {
        if let Heard::Rows(_) = page.hear(false) {
            heard += 1;
        }
    }
    std::thread::sleep(Duration::from_secs(1));
    for _ in 0..16 {
        page.socket.send(Message::text("ok")).unwrap();
    }
    let rows = page.rows();
    assert!(rows.frames_dropped > 5.0 && rows.rows_dropped > 500.0);
    assert_eq!(rows.lost, 0.0, "the device lost nothing");
    let view = server.get("/api/live/view?from=0&to=1e6&bins=5000");
    assert!(view.numbers(0, 1)[0] >= rows.first);
}

#[test]
fn a_recording_begun_on_the_page_is_a_whole_recording_in_its_folder() {
    let server = Server::simulated();
    let mut page = Page::of(&server);
    page.rows();
    let (status, answer) = server.wish(&json!({ "record": { "file": "touch" } }));
    assert_eq!(status, 200, "{answer}");
    assert!(answer["command"].as_str().unwrap().starts_with("palpate record --port"));
    page.until("1000 rows", |health| health["recording"]["rows"].as_u64() > Some(1_000));
    let (status, again) = server.wish(&json!({ "record": { "file": "other" } }));
    assert_eq!((status, &again["message"]), (409, &json!("touch.palpate is being recorded")));
    assert_eq!(server.wish(&json!("end-recording")).0, 200);
    let file = server.folder.path().join("touch.palpate");
    let recorded = read_recording(&file, &Options::default()).unwrap();
    assert!(recorded.closed && recorded.traces[0].len() > 1_000);
    assert_eq!((recorded.rows_lost, recorded.rows_unknown), (0, 0));
    let (status, there) = server.wish(&json!({ "record": { "file": "touch" } }));
    assert_eq!(status, 409);
    assert!(there["message"].as_str().unwrap().contains("is there already"), "{there}");
    for name in ["../touch", "/tmp/touch", "a/b", ""] {
        assert_eq!(server.wish(&json!({ "record": { "file": name } })).0, 409, "{name}");
    }
}

#[test]
fn stream_zero_filter_and_thresholds_change_while_one_looks() {
    let server = Server::simulated();
    let mut page = Page::of(&server);
    page.rows();
    assert_eq!(server.wish(&json!("tare")).0, 200);
    let wish =
        json!({ "set": { "filter": [0.2, 6.0, 0.3, 0.4], "thresholds": { "touch": 40.0 } } });
    let (status, answer) = server.wish(&wish);
    assert_eq!(status, 200, "{answer}");
    page.until("the settings are said", |health| {
        health["settings"]["relaxation"]["v1"] == 6.0
            && health["settings"]["thresholds"]["touch"] == 40.0
    });
    let (status, wrong) = server.wish(&json!({ "set": { "thresholds": { "touch": -1.0 } } }));
    assert_eq!(status, 409);
    assert!(wrong["message"].as_str().unwrap().contains("thresholds"), "{wrong}");
    assert_eq!(server.wish(&json!("stop")).0, 200);
    page.until("it stands", |health| health["streaming"] == false);
    let (status, refused) = server.wish(&json!("tare"));
    assert_eq!(status, 409);
    assert!(refused["message"].as_str().unwrap().contains("only while it streams"), "{refused}");
    assert_eq!(server.wish(&json!("start")).0, 200);
    page.until("it streams", |health| health["streaming"] == true);
    page.rows();
}

#[test]
fn unplugging_shows_at_once_and_heals_by_itself() {
    let folder = tempfile::tempdir().unwrap();
    let mut device = simulate(folder.path());
    let server = Server::begin_in(folder, &["--port", "fingertip"]);
    let mut page = Page::of(&server);
    page.rows();
    device.kill().unwrap();
    device.wait().unwrap();
    let gone = Instant::now();
    let message = page.until("the device is gone", |health| health["linked"] == false);
    // At once, on a machine that has other work too.
    assert!(gone.elapsed() < Duration::from_secs(5), "{:?}", gone.elapsed());
    assert_eq!(message["health"]["gaps"], 1);
    let (status, refused) = server.wish(&json!("tare"));
    assert_eq!((status, &refused["message"]), (409, &json!("the device is gone; waiting for it")));
    let mut device = simulate(server.folder.path());
    page.until("it streams again", |health| {
        health["linked"] == true && health["streaming"] == true
    });
    page.rows();
    drop(server);
    device.kill().unwrap();
    device.wait().unwrap();
}

#[test]
fn a_call_that_cannot_be_is_refused_with_status_2() {
    let said = |arguments: &[&str]| {
        let output = program().arg("serve").args(arguments).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let row = bundled("table-3.1-row-01.csv").display().to_string();
    let (status, words) = said(&["--replay", &row]);
    assert_eq!(status, Some(2));
    assert!(words.contains("no gauge"), "{words}");
    let (status, words) = said(&["--simulate", "--recordings", "no-such-folder"]);
    assert_eq!(status, Some(2));
    assert!(words.contains("no folder for recordings"), "{words}");
    assert_eq!(said(&["--simulate", "--replay", &press()]).0, Some(2));
    assert_eq!(said(&["--replay", &press(), "--speed", "0"]).0, Some(2));
}

/// A page that looks at one finger of a hand.
fn page_of(server: &Server, number: usize) -> Page {
    let token = format!("token.{}", server.token);
    let origin = format!("http://{}", server.host());
    let path = format!("/api/fingers/{number}/live/stream");
    let socket = server.socket_with(&path, &[("origin", &origin)], &[PROTOCOL, &token]);
    Page { socket: socket.unwrap() }
}

#[test]
fn each_finger_of_a_hand_has_a_device_of_its_own() {
    let server = Server::begin(&["--simulate", "--fingers", "3"]);
    let about = server.json("/api/rooms");
    assert_eq!(about["first"], "hand");
    let ports: Vec<&str> = about["fingers"]
        .as_array()
        .unwrap()
        .iter()
        .map(|of| of["port"].as_str().unwrap())
        .collect();
    assert_eq!(ports.len(), 3);
    for (port, number) in ports.iter().zip(1..) {
        assert_eq!(server.json(&format!("/api/fingers/{number}/live/about"))["port"], *port);
    }
    assert_eq!(server.json("/api/live/about")["port"], ports[0], "the first, where none is named");
    assert_eq!(server.get("/api/fingers/4/live/about").status, 404);
    assert_eq!(server.wish_of(2, &json!("stop")).0, 200);
    let streams = |number: usize| {
        let mut page = page_of(&server, number);
        page.until("the device is there", |health| health["linked"] == true)["health"]["streaming"]
            .clone()
    };
    assert_eq!([1, 2, 3].map(streams), [true, false, true], "each is asked for itself");
    // No port of the hand is asked who is there: it is open.
    let listed = server.json("/api/fingers/2/device/ports");
    let listed: Vec<&Value> =
        listed["ports"].as_array().unwrap().iter().map(|of| &of["port"]).collect();
    assert!(
        listed.contains(&&json!(ports[1])) && !listed.contains(&&json!(ports[0])),
        "{listed:?}"
    );
}

#[test]
fn the_fingers_of_a_hand_are_recorded_into_one_file_on_one_clock() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().display().to_string();
    let server = Server::begin(&["--simulate", "--fingers", "3", "--recordings", &place]);
    let wish = |number: usize, wish: &Value| server.wish_of(number, wish).0;
    let record = json!({ "record": { "file": "grasp", "together": true } });
    assert_eq!([1, 2, 3].map(|number| wish(number, &record)), [200; 3]);
    for number in 1..=3 {
        let recorded = |health: &Value| health["recording"]["rows"].as_u64() > Some(1_400);
        page_of(&server, number).until("1400 rows", recorded);
    }
    assert_eq!([1, 2, 3].map(|number| wish(number, &json!("end-recording"))), [200; 3]);
    assert_ne!(wish(2, &record), 200, "the file is there now");
    let call = ["convert", "grasp.palpate", "-o", "hand.csv"];
    let done = program().current_dir(&folder).args(call).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    for finger in 1..=3 {
        let name = format!("hand-{finger}.csv");
        let trace = palpate::trace::read(&folder.path().join(&name)).unwrap();
        assert!(trace.len() > 1_000, "{name}: {}", trace.len());
        assert!((-0.1..1.0).contains(&trace.time[0]), "{name} began at {} s", trace.time[0]);
    }
}

#[test]
fn a_hand_that_cannot_be_is_refused() {
    for (arguments, words) in [
        (&["--fingers", "3"][..], "--simulate"),
        (&["--simulate", "--fingers", "9"], "1..=8"),
        (&["--port", "/dev/null", "--port", "/dev/../dev/null"], "named twice"),
    ] {
        let refused = program().arg("serve").args(arguments).output().unwrap();
        let said = String::from_utf8_lossy(&refused.stderr);
        assert!(!refused.status.success() && said.contains(words), "{arguments:?}: {said}");
    }
}
