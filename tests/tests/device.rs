//! A fingertip as its user meets it, here a simulated one.
#![cfg(unix)]

use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use palpate::recording::{Entry, Gap, Note, Reader};
use palpate_tests::device::{self, Checked, Foreign};
use palpate_tests::palpate;
use palpate_tests::server::{program, simulate};
use serde_json::Value;
use shared::wire::{Rows, Source, ToHost};

/// `palpate device simulate` as a process, at a path that stays the same.
struct Simulated {
    folder: tempfile::TempDir,
    process: Child,
}

impl Simulated {
    fn begin() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let process = simulate(folder.path());
        Self { folder, process }
    }

    fn port(&self) -> PathBuf {
        self.folder.path().join("fingertip")
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn kill(&mut self) {
        self.process.kill().unwrap();
        self.process.wait().unwrap();
    }

    fn restart(&mut self) {
        self.kill();
        self.process = simulate(self.folder.path());
    }

    /// Exit status, standard output and standard error of `palpate … --port PORT`.
    fn call(&self, arguments: &[&str]) -> (i32, String, String) {
        let mut command = palpate();
        command.current_dir(self.folder.path()).args(arguments).args(["--port", "fingertip"]);
        said(&command.output().unwrap())
    }

    /// What a successful call prints as JSON.
    fn json(&self, arguments: &[&str]) -> Value {
        let (status, out, error) = self.call(&[arguments, &["--json"]].concat());
        assert_eq!(status, 0, "{arguments:?}: {error}");
        serde_json::from_str(&out).unwrap()
    }
}

impl Drop for Simulated {
    fn drop(&mut self) {
        // One that has ended on its own is as good.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn said(output: &std::process::Output) -> (i32, String, String) {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap_or(-1), text(&output.stdout), text(&output.stderr))
}

/// Prints the figures of a check that held.
fn held(checked: Checked) {
    match checked {
        Ok(report) => println!("{report}"),
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn a_device_says_who_it_is_and_refuses_a_host_of_another_schema() {
    let simulated = Simulated::begin();
    held(device::check_handshake(&simulated.port()));
    held(device::check_wrong_schema_is_refused(&simulated.port()));
}

#[test]
fn a_device_of_another_schema_is_refused_with_both_versions_named() {
    held(device::check_foreign_device_is_refused());
    let foreign = Foreign::begin().unwrap();
    let port = foreign.port.to_str().unwrap();
    let (status, out, error) =
        said(&palpate().args(["device", "info", "--port", port]).output().unwrap());
    assert_eq!((status, out.as_str()), (2, ""));
    for part in [Foreign::VERSION, env!("CARGO_PKG_VERSION"), "schema"] {
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn every_bundled_recording_comes_back_as_the_host_decomposes_it() {
    held(device::check_every_recording(&Simulated::begin().port()));
}

#[test]
fn whatever_a_flood_of_rows_costs_is_counted() {
    held(device::check_flooding(&Simulated::begin().port()));
}

#[test]
fn a_noisy_line_brings_no_wrong_row_and_costs_two_frames_a_hit_at_most() {
    let rates = [1e-4, 5e-4, 2e-3];
    held(device::check_noisy_line(&Simulated::begin().port(), &rates, 640, 7));
}

#[test]
fn a_stream_in_time_loses_nothing() {
    held(device::check_steady_stream(&Simulated::begin().port(), Duration::from_secs(5)));
}

#[test]
fn a_recording_goes_on_when_the_device_dies_and_comes_back() {
    let mut simulated = Simulated::begin();
    let (port, file) = (simulated.port(), simulated.file("take.palpate"));
    held(device::check_restart_while_recording(&port, Source::Converter, &file, &mut || {
        simulated.restart();
        Ok(())
    }));
    let source = Source::Link { interval_ns: 1_000_000 };
    held(device::check_restart_while_recording(&port, source, &file, &mut || {
        simulated.restart();
        Ok(())
    }));
}

#[test]
fn info_shows_what_set_changed_and_saved_over_a_loss_of_power() {
    let mut simulated = Simulated::begin();
    let set =
        ["device", "set", "--rate", "2000", "--gain", "64,64,32,32", "--threshold", "touch=33"];
    let (status, out, error) = simulated.call(&[&set[..], &["--save"]].concat());
    assert_eq!(status, 0, "{error}");
    assert!(out.contains("1953.125 Hz"), "{out}");
    assert!(error.contains("the rate nearest to 2000 Hz is 1953.125 Hz"), "{error}");
    simulated.json(&["device", "set", "--filter", "0.3", "5", "0.2", "0.5"]);
    simulated.restart();
    let settings = &simulated.json(&["device", "info"])["settings"];
    assert_eq!(settings["rate_hz"], 1953.125);
    assert_eq!(settings["gauges"][3]["gain"], 32);
    assert_eq!(settings["thresholds"]["touch"], 33.0);
    // The filter was set, but not saved.
    assert_eq!(settings["relaxation"]["c1"], 0.2472);
    simulated.json(&["device", "set", "--defaults", "--save"]);
    simulated.restart();
    assert_eq!(simulated.json(&["device", "info"])["settings"]["gauges"][3]["gain"], 128);
}

#[test]
fn a_setting_out_of_range_is_refused_in_words_and_changes_nothing() {
    let simulated = Simulated::begin();
    let before = simulated.json(&["device", "info"])["settings"].clone();
    for (arguments, words) in [
        (&["--gain", "3"][..], "power of two"),
        (&["--gain", "1,2"], "one gain, or four"),
        (&["--threshold", "touch=1"], "thresholds:"),
        (&["--threshold", "tuch=1"], "one of touch (µε), release"),
        (&["--filter", "0.9", "5", "0.9", "0.5"], "relaxation function:"),
        (&["--rate", "-3"], "--rate"),
        (&[], "required"),
    ] {
        let (status, out, error) = simulated.call(&[&["device", "set"], arguments].concat());
        assert_eq!((status, out.as_str()), (2, ""), "{arguments:?}");
        assert!(error.contains(words), "{arguments:?}: {error}");
    }
    assert_eq!(simulated.json(&["device", "info"])["settings"], before);
}

#[test]
fn a_tare_reads_zero_and_can_be_taken_back() {
    let simulated = Simulated::begin();
    let tare = simulated.json(&["device", "tare"])["tare_ustrain"].clone();
    assert!(tare[0].as_f64().unwrap().abs() > 1.0, "{tare}");
    assert_eq!(
        simulated.json(&["device", "info"])["settings"]["gauges"][0]["tare_ustrain"],
        tare[0]
    );
    assert_eq!(simulated.json(&["device", "tare", "--undo"])["tare_ustrain"][0], 0.0);
}

#[test]
fn a_self_test_passes_on_a_device_that_is_well() {
    let simulated = Simulated::begin();
    let test = simulated.json(&["device", "self-test"]);
    assert_eq!(test["passed"], true, "{test}");
    assert!((test["rate_ratio"].as_f64().unwrap() - 1.0).abs() < 0.02);
}

#[test]
fn a_calibration_from_points_is_set_and_saved() {
    let mut simulated = Simulated::begin();
    let bench = "gauge,strain_ustrain,counts\n1,0,1000\n1,500,251010\n1,1000,500990\n3,0,-40\n3,100,-50040\n";
    std::fs::write(simulated.file("bench.csv"), bench).unwrap();
    let dry = simulated.json(&["device", "calibrate", "--points", "bench.csv", "--dry-run"]);
    let unset = simulated.json(&["device", "info"])["settings"]["gauges"][0].clone();
    assert_eq!(unset["offset_counts"], 0);
    let set = simulated.json(&["device", "calibrate", "--points", "bench.csv"]);
    assert_eq!(dry, set);
    assert!((set["gauges"][0]["ustrain_per_count"].as_f64().unwrap() - 0.002).abs() < 1e-6);
    assert!(set["gauges"][0]["offset_counts_standard_error"].as_f64().unwrap() > 0.0);
    assert_eq!(set["gauges"][1]["offset_counts_standard_error"], Value::Null);
    simulated.restart();
    let gauges = simulated.json(&["device", "info"])["settings"]["gauges"].clone();
    assert_eq!(gauges[2]["offset_counts"], -40);
    assert_eq!(gauges[2]["ustrain_per_count"], -0.002);
    assert_eq!(gauges[1]["offset_counts"], 0);
}

#[test]
fn a_calibration_asks_for_strains_and_averages_counts() {
    let simulated = Simulated::begin();
    let mut process = program()
        .current_dir(simulated.folder.path())
        .args(["device", "calibrate", "--gauge", "2", "--per-load", "10", "--seconds", "0.2"])
        .args(["--dry-run", "--port", "fingertip"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut typed = process.stdin.take().unwrap();
    let mut told = BufReader::new(process.stderr.take().unwrap());
    typed.write_all(b"0\nx\n").unwrap();
    let mut before = String::new();
    while !before.contains("`x` is no number") {
        assert!(told.read_line(&mut before).unwrap() > 0, "{before}");
    }
    // Whatever the simulated finger does then, its gauges read something else after two seconds.
    std::thread::sleep(Duration::from_secs(2));
    typed.write_all(b"40\n\n").unwrap();
    let mut error = String::new();
    told.read_to_string(&mut error).unwrap();
    let (status, out, _) = said(&process.wait_with_output().unwrap());
    assert_eq!(status, 0, "{before}{error}");
    assert!(error.contains("400 µε:"), "{before}{error}");
    assert!(out.contains("Offset"), "{out}");
}

#[test]
fn ports_are_listed_with_who_is_there() {
    let simulated = Simulated::begin();
    let port = simulated.port();
    let mut command = palpate();
    let list = command.args(["device", "list", "--json"]).arg(&port).arg("/dev/absent");
    let (status, out, error) = said(&list.output().unwrap());
    assert_eq!(status, 0, "{error}");
    let listed: Value = serde_json::from_str(&out).unwrap();
    let of = |name: &str| {
        listed["ports"].as_array().unwrap().iter().find(|found| found["port"] == name).unwrap()
    };
    assert_eq!(of(port.to_str().unwrap())["device"]["board"], "simulated");
    assert!(of("/dev/absent")["error"].as_str().unwrap().contains("cannot be opened"));
}

#[test]
fn a_port_without_a_device_is_one_clear_error() {
    let mut command = palpate();
    let absent = ["device", "info", "--port", "/dev/absent"];
    let (status, out, error) = said(&command.args(absent).output().unwrap());
    assert_eq!((status, out.as_str()), (2, ""));
    assert!(error.starts_with("error: /dev/absent: cannot be opened"), "{error}");
    assert_eq!(error.lines().count(), 1);
}

#[test]
fn the_log_needs_the_elf_file_of_the_firmware() {
    let simulated = Simulated::begin();
    let (status, _, error) = simulated.call(&["device", "log"]);
    assert_eq!(status, 2);
    assert!(error.contains("cargo xtask firmware"), "{error}");
    std::fs::write(simulated.file("wrong.elf"), "nothing").unwrap();
    let (status, _, error) = simulated.call(&["device", "log", "--elf", "wrong.elf"]);
    assert_eq!(status, 2);
    assert!(error.contains("wrong.elf is no firmware"), "{error}");
}

#[test]
fn dfu_begins_the_loader_and_says_how_to_go_on() {
    let mut simulated = Simulated::begin();
    let (status, out, error) = simulated.call(&["device", "dfu"]);
    assert_eq!(status, 0, "{error}");
    assert_eq!(out, "dfu-util -a 0 -s 0x08000000:leave -D palpate.bin\n");
    assert!(simulated.process.wait().unwrap().success());
}

#[test]
fn a_file_that_cannot_be_flashed_leaves_the_device_as_it_is() {
    let simulated = Simulated::begin();
    let (status, _, error) = simulated.call(&["device", "dfu", "--flash", "absent.bin"]);
    assert_eq!(status, 2);
    assert!(error.contains("absent.bin cannot be read"), "{error}");
    simulated.json(&["device", "info"]);
}

#[test]
fn a_touch_is_told_while_it_is_recorded_and_found_again_in_the_recording() {
    let simulated = Simulated::begin();
    let record = ["record", "-o", "touch.palpate", "--duration", "3.5", "--json"];
    let (status, out, error) = simulated.call(&record);
    assert_eq!(status, 0, "{error}");
    let objects = out.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    let told: Vec<Value> =
        objects.filter_map(|object| object["events"].as_array().cloned()).flatten().collect();
    let mut events = palpate();
    events.arg("events").arg(simulated.file("touch.palpate")).arg("--json");
    let (status, again, error) = said(&events.output().unwrap());
    assert_eq!(status, 0, "{error}");
    let again: Value = serde_json::from_str(&again).unwrap();
    let found = again["traces"][0]["events"].as_array().unwrap();
    let kinds = |events: &[Value], key| events.iter().map(|it| it[key].clone()).collect::<Vec<_>>();
    assert_eq!(kinds(&told, "event")[0], "touch", "{out}");
    assert_eq!(kinds(&told, "event")[..], kinds(found, "kind")[..told.len()], "{again}");
}

/// Rows and gaps of a recording, and whether it was ended in order.
fn contents(file: &Path) -> (u64, Vec<Gap>, bool) {
    let mut reader = Reader::open(file).unwrap();
    let (mut rows, mut gaps) = (0, Vec::new());
    while let Some(entry) = reader.next_entry().unwrap() {
        match entry {
            Entry::Frame { head, message: ToHost::Samples(block), .. } => {
                rows += Rows::decode(head, &block).unwrap().len() as u64;
            }
            Entry::Note { note: Note::Gap(gap), .. } => gaps.push(gap),
            _ => {}
        }
    }
    (rows, gaps, reader.closed())
}

#[test]
fn a_recording_has_every_row_and_tells_programs_how_it_goes() {
    let simulated = Simulated::begin();
    let record = ["record", "-o", "take.palpate", "--duration", "2.5", "--json"];
    let (status, out, error) = simulated.call(&record);
    assert_eq!(status, 0, "{error}");
    let lines: Vec<Value> = out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.len(), 3, "{out}");
    assert!((lines[1]["rate_hz"].as_f64().unwrap() - 976.6).abs() < 10.0, "{out}");
    assert!(lines[1]["gauges"][3]["sa_ustrain"].is_number(), "{out}");
    let summary = &lines[2]["summary"];
    let (rows, gaps, closed) = contents(&simulated.file("take.palpate"));
    assert!(rows > 1_000 && closed && gaps.is_empty(), "{rows} {gaps:?}");
    assert_eq!(summary["rows"], rows);
    assert_eq!((&summary["gaps"], &summary["drops"]), (&0.into(), &0.into()));
    let (status, _, error) = simulated.call(&["record", "-o", "take.palpate", "--duration", "1"]);
    assert_eq!(status, 2);
    assert!(error.contains("take.palpate: exists already") && error.contains("--force"), "{error}");
}

#[test]
fn two_devices_are_recorded_into_one_file_and_their_rows_have_one_clock() {
    let (first, second) = (Simulated::begin(), Simulated::begin());
    let file = first.file("hand.palpate");
    let mut record = palpate();
    record.args(["record", "--duration", "2.5", "--json", "-o"]).arg(&file);
    record.arg("--port").arg(first.port()).arg("--port").arg(second.port());
    let (status, out, error) = said(&record.output().unwrap());
    assert_eq!(status, 0, "{error}");
    let ended: Vec<Value> = out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let ended: Vec<_> = ended.iter().filter(|object| object["summary"].is_object()).collect();
    assert_eq!(ended.len(), 2, "{out}");
    let (rows, gaps, closed) = contents(&file);
    assert!(closed && gaps.is_empty(), "{gaps:?}");
    let told = |it: &&Value| it["summary"]["rows"].as_u64().unwrap();
    assert!(ended.iter().all(|it| told(it) > 1_000) && ended.iter().map(told).sum::<u64>() == rows);
    let mut convert = palpate();
    convert.arg("convert").arg(&file).arg("-o").arg(first.file("hand.csv"));
    let (status, _, error) = said(&convert.output().unwrap());
    assert_eq!(status, 0, "{error}");
    assert_eq!(error.matches("timed by").count(), 1, "{error}");
    let traces =
        ["hand-1.csv", "hand-2.csv"].map(|name| palpate::trace::read(&first.file(name)).unwrap());
    // Their time rests on the line that they share, in the host's time of the first.
    let pulses = traces.each_ref().map(palpate::trace::Trace::pulses);
    assert!(matches!(pulses, [None, Some(1..)]), "{pulses:?}");
    // Both streams were begun within a second, and ended together.
    let [a, b] = traces.map(|trace| (trace.time[0], *trace.time.last().unwrap()));
    assert!((0.0..1.0).contains(&a.0) && (0.0..1.0).contains(&b.0), "{a:?} {b:?}");
    assert!((a.1 - b.1).abs() < 0.5 && a.1 > 2.0, "{a:?} {b:?}");
}

/// A recording as a process.
fn recording(simulated: &Simulated) -> Child {
    let process = program()
        .args(["record", "--port", "fingertip", "-o", "take.palpate", "--quiet"])
        .current_dir(simulated.folder.path())
        .spawn()
        .unwrap();
    grows(&simulated.file("take.palpate"));
    process
}

/// Waits until a file has some more in it.
fn grows(file: &Path) {
    let size = || std::fs::metadata(file).map_or(0, |file| file.len());
    let (before, until) = (size(), Instant::now() + Duration::from_secs(20));
    while size() < before + 20_000 {
        assert!(Instant::now() < until, "{} does not grow", file.display());
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_recording_that_is_killed_is_readable_and_the_port_is_free_again() {
    let simulated = Simulated::begin();
    let mut process = recording(&simulated);
    process.kill().unwrap();
    process.wait().unwrap();
    let (rows, _, closed) = contents(&simulated.file("take.palpate"));
    assert!(rows > 500 && !closed, "{rows}");
    // The stream it began is ended by the next that needs quiet.
    std::thread::sleep(Duration::from_millis(600));
    simulated.json(&["device", "self-test"]);
}

#[test]
fn a_recording_goes_on_over_the_death_of_the_device_and_ends_in_order_when_told() {
    let mut simulated = Simulated::begin();
    let mut process = recording(&simulated);
    simulated.restart();
    grows(&simulated.file("take.palpate"));
    let told = Command::new("kill").args(["-INT", &process.id().to_string()]).status().unwrap();
    assert!(told.success());
    assert!(process.wait().unwrap().success());
    let (rows, gaps, closed) = contents(&simulated.file("take.palpate"));
    assert!(rows > 1_000 && closed, "{rows}");
    let marks: Vec<_> = gaps.iter().filter(|gap| !matches!(gap, Gap::RowsLost(_))).collect();
    assert_eq!(marks, [&Gap::LinkLost, &Gap::LinkBack, &Gap::Reset]);
}

#[test]
fn a_recording_whose_disk_is_full_leaves_no_stream_behind() {
    let simulated = Simulated::begin();
    // A limit of the file's size is an error of its writing, as a full disk is.
    let limited =
        "trap '' XFSZ; ulimit -f 64; exec \"$0\" record --port fingertip -o take.palpate --quiet";
    let output = Command::new("sh")
        .args(["-c", limited])
        .arg(program().get_program())
        .current_dir(simulated.folder.path())
        .output()
        .unwrap();
    let (status, _, error) = said(&output);
    assert_eq!(status, 1, "{error}");
    assert!(error.contains("take.palpate"), "{error}");
    let (rows, _, closed) = contents(&simulated.file("take.palpate"));
    assert!(rows > 100 && !closed, "{rows}");
    assert_eq!(simulated.json(&["device", "info"])["status"]["streaming"], Value::Null);
}

#[test]
fn the_margin_of_a_grasp_is_told_while_it_is_held() {
    let simulated = Simulated::begin();
    let watch =
        ["grasp", "watch", "--contact", "circle:5", "--friction", "0.7", "--normal", "0.001"];
    let load = ["--tangential", "0.3", "--every", "0.1", "--duration", "7.5", "--json"];
    let (status, out, error) = simulated.call(&[&watch[..], &load].concat());
    assert_eq!(status, 0, "{error}");
    let lines: Vec<Value> = out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(lines.len() > 60, "{} lines", lines.len());
    let of = |state: &str| lines.iter().filter(|line| line["state"] == state).count();
    // A grasp is pressed, held for three seconds and released, over and over.
    assert!(of("holds") > 10 && of("holds") + of("will-slip") < 60, "{out}");
    let pressed = lines.iter().max_by(|a, b| {
        let normal = |line: &Value| line["now"]["normal_N"].as_f64().unwrap();
        normal(a).total_cmp(&normal(b))
    });
    let (now, settled) = (&pressed.unwrap()["now"], &pressed.unwrap()["settled"]);
    assert!(settled["margin"].as_f64().unwrap() < 0.9 * now["margin"].as_f64().unwrap());
    assert!(error.contains(" 0 lost"), "{error}");
}

#[test]
fn a_watch_ends_in_order_when_told_and_leaves_the_port_free() {
    let simulated = Simulated::begin();
    let mut process = program()
        .args([
            "grasp",
            "watch",
            "--port",
            "fingertip",
            "--contact",
            "circle:5",
            "--friction",
            "0.7",
        ])
        .args(["--normal", "0.001"])
        .current_dir(simulated.folder.path())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(process.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
    assert!(line.contains("margin"), "{line}");
    let told = Command::new("kill").args(["-INT", &process.id().to_string()]).status().unwrap();
    assert!(told.success());
    assert!(process.wait().unwrap().success());
    simulated.json(&["device", "self-test"]);
}
