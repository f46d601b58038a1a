//! The Device room and the margin of the local page, as a browser meets them.
#![cfg(unix)]

use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use palpate::model::{BaseLaw, Elastic, Kernel, Model, Separation};
use palpate::serve::guard::PROTOCOL;
use palpate_tests::bundled;
use palpate_tests::device::Foreign;
use palpate_tests::server::{PATIENCE, Server, program, simulate};
use serde_json::{Value, json};
use tungstenite::{Message, WebSocket};

fn end(process: &mut Child) {
    // One that has ended on its own is as good.
    let _ = process.kill();
    let _ = process.wait();
}

/// `palpate serve` as a process, with the simulated device that it serves, if it is a process of its own.
struct Bench {
    server: Server,
    device: Option<Child>,
}

impl Bench {
    fn begin(arguments: &[&str]) -> Self {
        Self { server: Server::begin(arguments), device: None }
    }

    /// Of a device that can be unplugged, and that keeps its settings.
    fn of_device() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let device = simulate(folder.path());
        Self { server: Server::begin_in(folder, &["--port", "fingertip"]), device: Some(device) }
    }

    fn folder(&self) -> &Path {
        self.server.folder.path()
    }

    fn unplug(&mut self) {
        end(self.device.as_mut().unwrap());
    }

    fn plug(&mut self) {
        self.device = Some(simulate(self.folder()));
    }

    /// What came of a wish, and the command that does the same.
    fn wish(&self, wish: &Value) -> (Value, Value) {
        let (status, mut answer) = self.server.wish(wish);
        assert_eq!(status, 200, "{wish}: {answer}");
        (answer["result"].take(), answer["command"].take())
    }

    /// Why a wish is refused.
    fn refused(&self, wish: &Value) -> String {
        let (status, answer) = self.server.wish(wish);
        assert_eq!(status, 409, "{wish}: {answer}");
        answer["message"].as_str().unwrap().into()
    }

    fn watch(&self) -> Watch {
        let token = format!("token.{}", self.server.token);
        let socket = self.server.socket_with("/api/device/watch", &[], &[PROTOCOL, &token]);
        Watch { socket: socket.unwrap(), readings: Vec::new() }
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        self.device.as_mut().map(end).unwrap_or_default();
    }
}

/// What a page is told of the device.
struct Watch {
    socket: WebSocket<TcpStream>,
    /// Of the margin, all that came.
    readings: Vec<Value>,
}

impl Watch {
    fn hear(&mut self) -> Value {
        loop {
            if let Message::Text(text) = self.socket.read().unwrap() {
                let told: Value = serde_json::from_str(&text).unwrap();
                self.readings.extend(told["bench"]["readings"].as_array().unwrap().clone());
                return told;
            }
        }
    }

    fn until(&mut self, words: &str, wanted: impl Fn(&Value) -> bool) -> Value {
        let begun = Instant::now();
        loop {
            let told = self.hear();
            if wanted(&told) {
                return told;
            }
            assert!(begun.elapsed() < PATIENCE, "it never came to this: {words}; {told}");
        }
    }
}

fn near(value: &Value, expected: f64, within: f64) -> bool {
    value.as_f64().is_some_and(|value| (value - expected).abs() <= within)
}

/// Known strains under which gauge 2 gives counts of about 1250 a µε.
fn points() -> Value {
    let points = [(0.0, 1_200.5), (100.0, 126_190.0), (200.0, 251_230.0), (400.0, 501_199.0)];
    points.map(|(strain, counts)| json!({ "gauge": 2, "strain": strain, "counts": counts })).into()
}

/// The same, as a file.
const CSV: &str =
    "gauge,strain_ustrain,counts\n2,0,1200.5\n2,100,126190\n2,200,251230\n2,400,501199\n";

#[test]
fn a_page_is_told_who_the_device_is_that_it_goes_with_this_program_and_what_its_counts_are() {
    let bench = Bench::begin(&["--simulate"]);
    let mut watch = bench.watch();
    let told = watch.until("the counts are told", |told| !told["bench"]["counts"].is_null());
    assert_eq!((&told["linked"], &told["device"]["board"]), (&json!(true), &json!("simulated")));
    let release = &told["bench"]["release"];
    assert_eq!((&release["speaks"], &release["advice"]), (&json!(true), &json!("Nothing to do.")));
    let counts = told["bench"]["counts"].as_array().unwrap();
    assert_eq!(counts.len(), 4);
    for gauge in counts {
        assert!(gauge["samples"].as_u64() > Some(2) && gauge["settled"].is_boolean(), "{gauge}");
    }
    assert_eq!(told["log"], "A simulated device writes no log.");
    assert!(bench.server.json("/api/live/about")["port"].is_string());
}

#[test]
fn the_ports_are_listed_with_ours_first_and_without_disturbing_it() {
    let mut bench = Bench::of_device();
    let mut watch = bench.watch();
    watch.until("it streams", |told| told["rows"].as_u64() > Some(500));
    let list = bench.server.json("/api/device/ports");
    let ours = &list["ports"][0];
    assert_eq!((&ours["port"], &ours["ours"]), (&json!("fingertip"), &json!(true)));
    assert_eq!(ours["device"]["board"], "simulated");
    assert_eq!(list["command"], "palpate device list");
    let told = watch.until("it streams on", |told| told["rows"].as_u64() > Some(1_500));
    assert_eq!((&told["rows_lost"], &told["gaps"]), (&json!(0), &json!(0)));
    bench.unplug();
    watch.until("it is gone", |told| told["linked"] == false);
    let ours = bench.server.json("/api/device/ports")["ports"][0].take();
    assert!(ours["device"].is_null() && ours["error"].is_string(), "{ours}");
}

#[test]
fn settings_are_checked_set_and_kept_as_the_command_does() {
    let mut bench = Bench::of_device();
    let mut watch = bench.watch();
    let wish =
        json!({ "set": { "rate_hz": 2000.0, "thresholds": { "touch": 35.0 }, "save": true } });
    let (result, command) = bench.wish(&wish);
    assert_eq!(
        command,
        "palpate device set --port fingertip --rate 2000 --threshold touch=35 --save"
    );
    assert_eq!(result["note"], "the rate nearest to 2000 Hz is 1953.125 Hz");
    assert_eq!(result["settings"]["rate_hz"], 1953.125);
    watch.until("it streams at that rate", |told| near(&told["rate_hz"], 1953.0, 60.0));
    let (result, _) = bench.wish(&json!({ "set": { "gain": [64, 64, 128, 128] } }));
    assert_eq!(result["settings"]["gauges"][0]["gain"], 64);

    // What was saved is there after a loss of power; what was only set is not.
    bench.unplug();
    watch.until("it is gone", |told| told["linked"] == false);
    bench.plug();
    let told = watch.until("it is back", |told| told["linked"] == true);
    assert_eq!(told["settings"]["rate_hz"], 1953.125);
    assert_eq!(told["settings"]["thresholds"]["touch"], 35.0);
    assert_eq!(told["settings"]["gauges"][0]["gain"], 128);
    let (result, _) = bench.wish(&json!({ "set": { "defaults": true } }));
    assert_eq!(result["settings"]["rate_hz"], 976.5625);
}

#[test]
fn settings_out_of_range_are_refused_in_the_words_of_the_command() {
    let mut bench = Bench::of_device();
    let wishes = [
        (json!({ "gain": [3, 1, 1, 1] }), vec!["--gain", "3,1,1,1"]),
        (json!({ "thresholds": { "touch": 5.0 } }), vec!["--threshold", "touch=5"]),
        (json!({ "filter": [0.9, 4.0, 0.9, 0.5] }), vec!["--filter", "0.9", "4", "0.9", "0.5"]),
    ];
    let words: Vec<String> =
        wishes.iter().map(|(set, _)| bench.refused(&json!({ "set": set }))).collect();
    assert!(bench.refused(&json!({ "set": { "rate_hz": -1.0 } })).contains("above 0"));
    assert!(bench.refused(&json!({ "set": { "thresholds": { "grip": 1.0 } } })).contains("grip"));
    let (status, _) = bench.server.wish(&json!({"set": {"volume": 11}}));
    assert_eq!(status, 422);
    end(&mut bench.server.process);
    for ((_, options), words) in wishes.iter().zip(words) {
        let output = program()
            .args(["device", "set", "--port", "fingertip"])
            .args(options)
            .current_dir(bench.folder())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2));
        let said = String::from_utf8(output.stderr).unwrap();
        let plain = |text: &str| text.replace(['│', '×', '\n', ' '], "");
        assert!(plain(&said).contains(&plain(&words)), "{said}: {words}");
    }
}

#[test]
fn a_calibration_is_that_of_the_command_and_is_written_only_when_asked_for() {
    let mut bench = Bench::of_device();
    let mut watch = bench.watch();
    let (fit, command) = bench.wish(&json!({ "fit": { "points": points() } }));
    assert_eq!(command, "palpate device calibrate --port fingertip --points points.csv --dry-run");
    assert_eq!(bench.wish(&json!({ "fit": { "csv": CSV } })).0, fit);
    let gauge = &fit["gauges"][0];
    let residuals: Vec<f64> = gauge["points"]
        .as_array()
        .unwrap()
        .iter()
        .map(|point| point["residual_ustrain"].as_f64().unwrap())
        .collect();
    let most = residuals.iter().fold(0.0, |most: f64, r| most.max(r.abs()));
    assert!(near(&gauge["nonlinearity"], most / 400.0, 1e-12), "{gauge}");
    let settings =
        watch.until("it is told", |told| told["settings"].is_object())["settings"].take();
    assert_eq!(settings["gauges"][1]["offset_counts"], 0, "a fit writes nothing");
    assert!(!bench.folder().join("settings.bin").exists());

    bench.wish(&json!({ "calibrate": { "points": points() } }));
    let offset = gauge["offset_counts"].clone();
    let is_set = |told: &Value| told["settings"]["gauges"][1]["offset_counts"] == offset;
    watch.until("it is set", is_set);
    let told = watch.until("it streams on", |told| !told["bench"]["counts"].is_null());
    assert_eq!(told["settings"]["gauges"][1]["ustrain_per_count"], gauge["ustrain_per_count"]);
    bench.unplug();
    watch.until("it is gone", |told| told["linked"] == false);
    bench.plug();
    let told = watch.until("it is back", |told| told["linked"] == true);
    assert!(is_set(&told), "it was saved");

    end(&mut bench.server.process);
    let file = bench.folder().join("points.csv");
    std::fs::write(&file, CSV).unwrap();
    let call = [
        "device",
        "calibrate",
        "--port",
        "fingertip",
        "--points",
        "points.csv",
        "--dry-run",
        "--json",
    ];
    let output = program().args(call).current_dir(bench.folder()).output().unwrap();
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    for (name, value) in printed["gauges"][0].as_object().unwrap() {
        assert_eq!(&gauge[name], value, "{name}");
    }
}

#[test]
fn a_calibration_that_cannot_be_is_refused_with_its_reason() {
    let bench = Bench::begin(&["--simulate"]);
    let point = |gauge: u8, strain: f64, counts: f64| json!({ "gauge": gauge, "strain": strain, "counts": counts });
    for (basis, reason) in [
        (json!({ "points": [point(1, 0.0, 5.0)] }), "gauge 1: two different strains are needed"),
        (json!({ "points": [point(1, 0.0, 5.0), point(1, 9.0, 5.0)] }), "is the gauge connected?"),
        (json!({ "points": [point(5, 0.0, 5.0)] }), "there is no gauge 5"),
        (json!({ "points": [] }), "there are no points"),
        (json!({ "csv": "gauge,strain_ustrain,counts\n1,x,2\n" }), "line"),
        (json!({ "numbers": { "gauge": 1, "gain": 0.0, "offset": 1 } }), "gauge 1: gain of 0"),
        (json!({ "numbers": { "gauge": 0, "gain": 1e-3, "offset": 1 } }), "there is no gauge 0"),
        (json!({ "numbers": { "gauge": 1, "gain": 1e-3, "offset": 9_000_000 } }), "24 bits"),
    ] {
        for wish in ["fit", "calibrate"] {
            let refused = bench.refused(&json!({ wish: basis }));
            assert!(refused.contains(reason), "{basis}: {refused}");
        }
    }
    let (result, command) =
        bench.wish(&json!({ "fit": { "numbers": { "gauge": 3, "gain": -1e-3, "offset": 7 } } }));
    assert_eq!(result["gauges"][0]["ustrain_per_count"], -1e-3);
    assert!(command.as_str().unwrap().ends_with("--gauge 3 --gain -0.001 --offset 7 --dry-run"));
}

/// A trace that rests, is strained, and rests in that state.
fn steps(folder: &Path) -> String {
    let path = folder.join("steps.csv");
    let strain = |k: u32| if k < 1_000 { 0.0 } else { 500.0 };
    let rows = (0..4_000).map(|k| format!("{},{}\n", f64::from(k) * 5e-3, strain(k)));
    let text = format!("time_s,gauge1_ustrain\n{}", rows.collect::<String>());
    std::fs::write(&path, text).unwrap();
    path.display().to_string()
}

#[test]
fn readings_under_known_strains_give_the_gain_of_the_device() {
    let folder = tempfile::tempdir().unwrap();
    let trace = steps(folder.path());
    let bench = Bench { server: Server::begin_in(folder, &["--replay", &trace]), device: None };
    let mut watch = bench.watch();
    let read = |watch: &mut Watch, strain: f64| {
        // Counts of a replay are 256 a µε.
        watch.until("it stands still", |told| {
            let now = &told["bench"]["counts"][0];
            near(&now["counts"], strain * 256.0, 1.0) && now["settled"] == true
        });
        let mut means = bench.wish(&json!({ "average": 0.5 })).0;
        assert_eq!(means.as_array().unwrap().len(), 4);
        assert_eq!(means[0]["samples"], 100, "{means}");
        json!({ "gauge": 1, "strain": strain, "counts": means[0]["counts"].take() })
    };
    let points = [read(&mut watch, 0.0), read(&mut watch, 500.0)];
    let (fit, _) = bench.wish(&json!({ "fit": { "points": points } }));
    let gauge = &fit["gauges"][0];
    assert!(near(&gauge["ustrain_per_count"], 1.0 / 256.0, 1e-9), "{gauge}");
    assert_eq!(gauge["offset_counts"], 0);
    assert!(gauge["offset_counts_standard_error"].is_null(), "two points tell no errors");
}

#[test]
fn an_average_that_cannot_be_taken_is_refused_and_one_that_is_interrupted_too() {
    let bench = Bench::begin(&["--simulate"]);
    let means = bench.wish(&json!({ "average": 0.3 })).0;
    assert_eq!(means[2]["samples"], 293, "{means}");
    for seconds in [0.0, -1.0, 61.0] {
        let refused = bench.refused(&json!({ "average": seconds }));
        assert!(refused.contains("above 0, up to 60 s"), "{refused}");
    }
    // Whether it is asked for before the stop comes is up to the machine; then it is tried again.
    while !std::thread::scope(|scope| {
        let averaged = scope.spawn(|| bench.refused(&json!({ "average": 30.0 })));
        std::thread::sleep(Duration::from_millis(300));
        bench.wish(&json!("stop"));
        averaged.join().unwrap() == "the stream was stopped"
    }) {
        bench.wish(&json!("start"));
    }
    let refused = bench.refused(&json!({ "average": 0.3 }));
    assert!(refused.contains("the stream is stopped"), "{refused}");
}

#[test]
fn the_self_test_tells_each_item_with_its_limits_and_the_stream_goes_on_as_it_was() {
    let bench = Bench::begin(&["--simulate"]);
    let mut watch = bench.watch();
    let (result, command) = bench.wish(&json!("self-test"));
    assert!(command.as_str().unwrap().starts_with("palpate device self-test --port "));
    assert_eq!(result["passed"], true);
    assert!(result["samples"].as_u64() >= Some(256), "{result}");
    let checks = result["checks"].as_array().unwrap();
    let names: Vec<&str> = checks.iter().map(|check| check["name"].as_str().unwrap()).collect();
    let bridges = (1..=4).map(|gauge| format!("bridge of gauge {gauge}"));
    let own = ["rate", "converter's own offset", "converter's test signal"].map(String::from);
    let expected: Vec<String> =
        std::iter::once("converter".into()).chain(bridges).chain(own).collect();
    assert_eq!(names, expected);
    for check in checks {
        assert_eq!(check["passed"], true, "{check}");
        assert!(check["measured"].is_string() && check["limits"].is_string(), "{check}");
    }
    let before = watch.hear()["rows"].as_u64().unwrap();
    watch.until("it streams on", |told| told["rows"].as_u64() > Some(before + 500));
    bench.wish(&json!("stop"));
    bench.wish(&json!("self-test"));
    let told = watch.until("it stands", |told| told["streaming"] == false);
    assert_eq!(told["linked"], true);
}

#[test]
fn what_would_interrupt_a_recording_waits_for_its_end() {
    let bench = Bench::begin(&["--simulate"]);
    bench.wish(&json!({ "record": { "file": "touch" } }));
    let interrupting = [
        json!("self-test"),
        json!({ "set": { "save": true } }),
        json!({ "set": { "rate_hz": 500.0 } }),
        json!({ "calibrate": { "points": points() } }),
    ];
    for wish in &interrupting {
        let refused = bench.refused(wish);
        assert!(refused.starts_with("touch.palpate is being recorded"), "{refused}");
    }
    bench.wish(&json!({ "set": { "thresholds": { "touch": 30.0 } } }));
    bench.wish(&json!("end-recording"));
    for wish in &interrupting {
        bench.wish(wish);
    }
}

#[test]
fn without_a_device_everything_says_so_and_goes_on_when_it_is_back() {
    let mut bench = Bench::of_device();
    let mut watch = bench.watch();
    let holding =
        json!({ "contact": "circle:5", "friction": 0.7, "normal": "0.001", "tangential": 0.4 });
    bench.wish(&json!({ "grasp": holding }));
    watch.until("the margin is told", |told| told["bench"]["readings"][0].is_object());
    std::thread::scope(|scope| {
        let averaged = scope.spawn(|| bench.refused(&json!({ "average": 30.0 })));
        std::thread::sleep(Duration::from_millis(300));
        // The process, for the server is being asked.
        Command::new("kill").arg(bench.device.as_ref().unwrap().id().to_string()).status().unwrap();
        assert_eq!(averaged.join().unwrap(), "the device is gone; waiting for it");
    });
    let told = watch.until("it is gone", |told| told["linked"] == false);
    assert!(told["trouble"].is_string());
    for wish in [
        json!("self-test"),
        json!({ "set": { "rate_hz": 500.0 } }),
        json!({ "average": 1.0 }),
        json!({ "fit": { "points": points() } }),
        json!({ "calibrate": { "points": points() } }),
        json!({ "grasp": holding }),
    ] {
        assert_eq!(bench.refused(&wish), "the device is gone; waiting for it");
    }
    watch.until("no old counts are shown", |told| told["bench"]["counts"].is_null());
    bench.unplug();
    bench.plug();
    watch.until("it is back, and so is the margin", |told| {
        told["linked"] == true
            && told["bench"]["counts"].is_array()
            && told["bench"]["readings"][0].is_object()
    });
    assert_eq!(bench.wish(&json!("self-test")).0["passed"], true);
}

#[test]
fn firmware_of_another_schema_is_named_with_what_to_do_and_a_device_in_its_place_is_taken() {
    let folder = tempfile::tempdir().unwrap();
    let foreign = Foreign::begin().unwrap();
    let link = folder.path().join("fingertip");
    std::os::unix::fs::symlink(&foreign.port, &link).unwrap();
    let mut bench =
        Bench { server: Server::begin_in(folder, &["--port", "fingertip"]), device: None };
    let mut watch = bench.watch();
    let told = watch.until("its release is known", |told| told["bench"]["release"].is_object());
    let release = &told["bench"]["release"];
    assert_eq!((&told["linked"], &release["speaks"]), (&json!(false), &json!(false)));
    assert_eq!(release["firmware"], Foreign::VERSION);
    let (words, advice) = (release["words"].as_str().unwrap(), release["advice"].as_str().unwrap());
    assert!(words.contains("newer") && advice.contains("Install palpate 99.0.0"), "{release}");
    assert!(told["trouble"].as_str().unwrap().contains("another language"));
    assert_eq!(bench.server.json("/api/device/ports")["ports"][0]["release"], *release);
    std::fs::remove_file(&link).unwrap();
    bench.plug();
    let told = watch.until("the other is taken", |told| told["linked"] == true);
    assert_eq!(told["bench"]["release"]["speaks"], true);
}

#[test]
fn the_margin_is_that_of_the_command() {
    let press = bundled("press.csv").display().to_string();
    let bench = Bench::begin(&["--replay", &press, "--speed", "20"]);
    let mut watch = bench.watch();
    let over = |told: &Value| told["replayed"] == 1.0 && told["streaming"] == false;
    watch.until("the trace is over", over);
    let options = ["--contact=circle:5", "--friction=0.7", "--normal=0.001", "--tangential=0.57"];
    let holding = json!({ "contact": "circle:5", "friction": 0.7, "normal": "0.001", "tangential": 0.57, "rest": 0.3 });
    let (_, command) = bench.wish(&json!({ "grasp": holding }));
    let expected = format!(" {} --rest=0.3", options.join(" "));
    assert!(command.as_str().unwrap().starts_with("palpate grasp watch --port "));
    assert!(command.as_str().unwrap().ends_with(&expected), "{command}");
    bench.wish(&json!("start"));
    watch.until("it begins", |told| told["streaming"] == true);
    let told = watch.until("it is over again", over);
    assert_eq!(told["bench"]["holding"]["friction"], 0.7);

    let output = program()
        .args(["grasp", "watch", "--recording", &press, "--rest=0.3", "--json"])
        .args(options)
        .output()
        .unwrap();
    let printed: Vec<Value> = String::from_utf8(output.stdout)
        .unwrap()
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert!(
        printed.len() > 40 && watch.readings.len() == printed.len(),
        "{}",
        watch.readings.len()
    );
    let mut same = 0;
    for (told, printed) in watch.readings.iter().zip(&printed) {
        let late = told["time_s"].as_f64().unwrap() - printed["time_s"].as_f64().unwrap();
        // The device's clock counts whole microseconds, so a reading can be due one sample later.
        assert!(late.abs() < 5.1e-3, "{told} {printed}");
        if late.abs() > 1e-6 {
            continue;
        }
        same += 1;
        assert_eq!(told["state"], printed["state"], "{told} {printed}");
        for when in ["now", "settled"] {
            let force = printed[when]["normal_N"].as_f64().unwrap();
            // Strain on the line is whole 1/256 µε, and so is the equilibrium.
            assert!(near(&told[when]["normal_N"], force, 1e-4), "{told} {printed}");
        }
    }
    assert!(2 * same > printed.len(), "{same} of {} at the same sample", printed.len());
}

#[test]
fn a_margin_that_is_not_known_says_what_is_missing() {
    let bench = Bench::begin(&["--simulate"]);
    let mut watch = bench.watch();
    assert!(watch.hear()["bench"]["holding"].is_null());
    let whole = json!({ "contact": "circle:5", "friction": 0.7, "normal": "0.001" });
    let missing =
        [("contact", "the contact"), ("friction", "friction"), ("normal", "normal force")];
    for (name, words) in missing {
        let mut part = whole.clone();
        part.as_object_mut().unwrap().remove(name);
        let refused = bench.refused(&json!({ "grasp": part }));
        assert!(refused.starts_with("still missing: ") && refused.contains(words), "{refused}");
    }
    let mut growing = whole.clone();
    growing["contact"] = "sphere:35".into();
    let refused = bench.refused(&json!({ "grasp": growing }));
    assert!(refused.contains("grows as it is pressed"), "{refused}");
    bench.wish(&json!({ "grasp": whole }));
    let told = watch.until("it is told", |told| told["bench"]["readings"][0].is_object());
    assert!(told["bench"]["readings"][0]["now"]["margin"].is_null(), "nothing pulls");
    assert!(bench.wish(&json!({ "grasp": null })).1.is_null());
    watch.until("it is told no longer", |told| told["bench"]["holding"].is_null());
}

#[test]
fn words_for_the_log_that_are_none_are_refused_at_the_start() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("wrong.elf"), "nothing").unwrap();
    for (arguments, words) in [
        (vec!["--elf", "wrong.elf"], "wrong.elf is no firmware with a log"),
        (vec!["--elf", "gone.elf"], "gone.elf cannot be read"),
        (vec!["--force"], "--elf"),
    ] {
        let output = program()
            .args(["serve", "--simulate"])
            .args(arguments)
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2));
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains(words), "{said}");
    }
}

/// A model that relaxes by these shares at the rates of the simulated fingertip, as a file in a folder.
fn model_file(folder: &Path, shares: [f64; 2]) -> String {
    let law = BaseLaw::fung(2, Separation::Free);
    let values = [0.07, 1.0, shares[0], shares[1], 3.981, 0.5325];
    let model = Model::of(&law, "force_N", &values, &[None; 6]);
    let path = folder.join("model.toml");
    model.write(&path).unwrap();
    path.display().to_string()
}

/// What is told of the model once its words begin so.
fn told_of_the_model(bench: &Bench, words: &str) -> Value {
    let told = |told: &Value| told["bench"]["foretold"].clone();
    let said = |now: &Value| told(now)["words"].as_str().is_some_and(|it| it.starts_with(words));
    told(&bench.watch().until(words, said))
}

#[test]
fn the_filter_of_the_device_foretells_the_hold_of_a_fingertip_that_relaxes_like_it() {
    let bench = Bench::begin(&["--simulate"]);
    let mut watch = bench.watch();
    let foretold = |told: &Value| told["bench"]["foretold"].clone();
    // Two of its gauges are never at rest, as bridges that are not tared: they are followed for a while first. Then through a whole
    // hold of three seconds and out of it again.
    watch.until("a hold is judged at every gauge", |told| {
        foretold(told)["gauges"] == json!(["agrees", "agrees", "agrees", "agrees"])
    });
    let over = watch.until("it is over", |told| {
        foretold(told)["words"].as_str().is_some_and(|words| words.starts_with("The finger moves"))
    });
    let told = foretold(&over);
    assert_eq!(told["law"]["file"], Value::Null);
    let holds = told["holds"].as_array().unwrap();
    let holds = &holds[holds.len() - 4..];
    for hold in holds {
        assert!(hold["failure"].is_null() && near(&hold["residual"], 0.0, 0.5), "{hold}");
        let seconds = hold["to_s"].as_f64().unwrap() - hold["entered_s"].as_f64().unwrap();
        assert!((seconds - 3.0).abs() < 0.2, "{hold}");
    }
    let (from, to) = (&holds[0]["from_s"], &holds[0]["to_s"]);
    let again = bench.server.json(&format!("/api/live/foretold?from={from}&to={to}"));
    assert_eq!(again.as_array().map(Vec::len), Some(4), "{again}");
    assert_eq!(bench.server.json("/api/live/foretold?from=1e6&to=2e6"), json!([]));
}

#[test]
fn a_model_that_relaxes_too_little_fails_while_the_press_is_held_and_says_where_and_which_way() {
    let folder = tempfile::tempdir().unwrap();
    let model = model_file(folder.path(), [0.2472, 0.15]);
    let bench = Bench::begin(&["--simulate", "--model", &model]);
    let told = told_of_the_model(&bench, "The model fails now, in region CD, since ");
    assert_eq!(told["law"]["file"], json!(model));
    let words = told["words"].as_str().unwrap();
    assert!(
        words.contains("changes more than the model predicts") && words.contains("µε"),
        "{words}"
    );
    let failed = told["holds"].as_array().unwrap().iter().find(|hold| !hold["failure"].is_null());
    assert_eq!(failed.unwrap()["failure"]["changes_less"], false);
}

#[test]
fn a_model_whose_hold_does_not_follow_from_the_signal_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let law = BaseLaw::fung(1, Separation::Free).with(Elastic::POWER, Kernel::POWER_LAW);
    let values = vec![0.5; law.count()];
    let path = folder.path().join("power.toml");
    Model::of(&law, "force_N", &values, &vec![None; values.len()]).write(&path).unwrap();
    let refused = program().args(["serve", "--simulate", "--model"]).arg(&path).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    let said = String::from_utf8(refused.stderr).unwrap();
    assert!(said.contains("power.toml: a hold of") && said.contains("is no sum"), "{said}");
}
