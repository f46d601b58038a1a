//! The Lab over HTTP: what the page asks for, what it is refused, and the same answers as the commands.
#![cfg(unix)]

use std::path::Path;
use std::time::{Duration, Instant};

use palpate::serve::guard::{BODY_LIMIT, UPLOAD_LIMIT};
use palpate::trace::{DISPLACEMENT, FORCE, Trace, write};
use palpate_tests::server::{PATIENCE, Server, memory_mb, program};
use palpate_tests::{bundled, workspace};
use serde_json::{Value, json};

/// `palpate serve FOLDER` as a process, in the folder above.
struct Lab {
    server: Server,
}

impl Lab {
    fn open(above: tempfile::TempDir, arguments: &[&str]) -> Self {
        Self { server: Server::begin_in(above, arguments) }
    }

    /// The folder above.
    fn above(&self) -> &Path {
        self.server.folder.path()
    }

    /// Status and body of the answer to a request.
    fn ask(&self, method: &str, path: &str, body: Option<&[u8]>) -> (u16, Vec<u8>) {
        let (path, headers) = (format!("/api/lab/{path}"), self.server.headers());
        let answer = self.server.ask(method, &path, &headers, body.unwrap_or_default());
        (answer.status, answer.body)
    }

    /// The answer to a question, or why there is none.
    fn post(&self, path: &str, body: &Value) -> (u16, Value) {
        let (status, answer) = self.ask("POST", path, Some(body.to_string().as_bytes()));
        let text = || Value::String(String::from_utf8_lossy(&answer).into_owned());
        (status, serde_json::from_slice(&answer).unwrap_or_else(|_| text()))
    }

    /// Does something that is done at once.
    fn done(&self, path: &str, body: &Value) -> Value {
        let (status, answer) = self.post(path, body);
        assert_eq!(status, 200, "{path} {body}: {answer}");
        answer
    }

    /// What is wrong with something, told with this status.
    fn refused(&self, status: u16, path: &str, body: &Value) -> String {
        let (found, answer) = self.post(path, body);
        assert_eq!(found, status, "{path} {body}: {answer}");
        answer["message"].as_str().or(answer.as_str()).unwrap_or_default().to_owned()
    }

    /// Waits until nothing is at work; why it failed, if it did.
    fn wait(&self) -> Value {
        let begun = Instant::now();
        loop {
            let progress = self.get("progress");
            if progress["job"].is_null() {
                return progress["failed"].clone();
            }
            assert!(begun.elapsed() < PATIENCE, "it takes too long: {progress}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Works something out; the state after it.
    fn work(&self, task: &Value) -> Value {
        self.done("start", task);
        assert_eq!(self.wait(), Value::Null, "{task}");
        self.get("state")
    }

    /// What the command of a task prints with `--json`.
    fn command(&self, task: &Value) -> Value {
        let command = self.done("command", task)["command"].as_str().unwrap().to_owned();
        self.run(&command)
    }

    /// What a command that was copied from the page prints with `--json`.
    fn run(&self, command: &str) -> Value {
        let arguments = command.strip_prefix("palpate ").expect("a command of palpate");
        let output = program()
            .args(arguments.split(' '))
            .arg("--json")
            .current_dir(self.above())
            .output()
            .unwrap();
        assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    }

    fn get(&self, path: &str) -> Value {
        let (status, body) = self.ask("GET", path, None);
        let answer: Value = serde_json::from_slice(&body).unwrap();
        assert_eq!(status, 200, "{path}: {answer}");
        answer
    }
}

/// A folder with the practice sets `friction` and `mullins` in `traces`, and one beside it.
fn practice_sets() -> tempfile::TempDir {
    let above = tempfile::tempdir().unwrap();
    std::fs::create_dir(above.path().join("traces")).unwrap();
    for (effect, seed, folder) in [
        ("coulomb-friction", "3", "traces/friction"),
        ("mullins", "4", "traces/mullins"),
        ("drift", "5", "elsewhere"),
    ] {
        let made = program()
            .args(["hide", effect, "--seed", seed, "-o", folder])
            .current_dir(above.path())
            .output()
            .unwrap();
        assert!(made.status.success());
    }
    above
}

fn lab() -> Lab {
    Lab::open(practice_sets(), &["traces"])
}

fn fung() -> Value {
    json!({"fit": {"law": "fung"}})
}

/// Every key of an answer of the command is in that of the page, with the same value.
fn holds_all_of(page: &Value, command: &Value) {
    for (key, value) in command.as_object().unwrap() {
        assert_eq!(&page[key], value, "{key}");
    }
}

#[test]
fn fit_compare_diagnose_add_and_drop_answer_as_the_commands_that_are_copied() {
    let lab = lab();
    let state = lab.get("state");
    assert_eq!(state["sets"], json!(["friction", "mullins"]));
    let (status, none) = lab.ask("GET", "relaxation", None);
    assert_eq!(
        (status, String::from_utf8_lossy(&none).contains("there is no model yet")),
        (422, true)
    );
    assert_eq!((&state["set"], &state["signal"]), (&json!("friction"), &json!("force_N")));
    let fit = lab.done("command", &fung())["command"].as_str().unwrap().to_owned();
    let state = lab.work(&fung());
    assert_eq!(lab.done("save", &json!({}))["file"], "traces/model-1.toml");
    assert_eq!(state["versions"][0]["command"], fit);
    assert_eq!(state["answers"]["fit"], lab.run(&fit));

    let parameters = &state["answers"]["fit"]["parameters"];
    let relaxation = lab.get("relaxation");
    for name in ["c1", "v1", "c2", "v2"] {
        assert_eq!(relaxation[name], parameters[name]["value"], "{name}");
    }

    let compared = lab.command(&json!("compare"));
    holds_all_of(&lab.work(&json!("compare"))["comparison"], &compared);
    assert_eq!(
        lab.work(&json!("diagnose"))["answers"]["diagnosis"],
        lab.command(&json!("diagnose"))
    );
    let forecast = lab.get("forecast?effect=coulomb-friction&trace=0&width=300");
    let overlay = lab.get("overlay?trace=0&width=300");
    assert_eq!(forecast["time"], overlay["time"]);
    assert!(forecast["rms"].as_f64() < state["comparison"]["rms"].as_f64());

    let add = json!({"add": {"effect": "coulomb-friction"}});
    let command = lab.command(&add);
    let state = lab.work(&add);
    assert_eq!(state["answers"]["change"], command);
    assert_eq!(state["comparison"]["only_noise"], true);
    // The command has written model-2.toml by then, which is not written over.
    assert_eq!(lab.done("save", &json!({}))["file"], "traces/model-3.toml");
    lab.done("save", &json!({"file": "friction.toml"}));
    let drop = json!({"drop": {"effect": "coulomb-friction"}});
    let command = lab.command(&drop);
    assert_eq!(lab.work(&drop)["answers"]["change"], command);
    let report = lab.get("report?kind=change");
    assert_eq!(report["file"], "change.html");
    assert!(report["html"].as_str().unwrap().contains("palpate drop coulomb-friction"));
    assert_eq!(lab.done("undo", &json!({}))["model"]["effect"][0]["name"], "coulomb-friction");
    assert_eq!(lab.wait(), Value::Null);
}

#[test]
fn exploring_reaches_the_noise_floor_and_answers_as_the_command() {
    let lab = lab();
    lab.work(&fung());
    lab.done("save", &json!({}));
    let command = lab.done("command", &json!("explore"))["command"].clone();
    let state = lab.work(&json!("explore"));
    assert_eq!(state["comparison"]["only_noise"], true);
    assert_eq!(state["versions"][1]["command"], command);
    let answer = lab.run(command.as_str().unwrap());
    assert_eq!(state["answers"]["diagnosis"], answer);
    assert_eq!(answer["model"], "traces/model-2.toml");
}

#[test]
fn two_models_beside_the_same_traces_have_the_figures_of_two_comparisons() {
    let lab = lab();
    lab.work(&json!({"fit": {"law": "kelvin-voigt"}}));
    lab.done("save", &json!({}));
    lab.work(&fung());
    lab.done("save", &json!({}));
    let task = json!({"beside": {"version": 0}});
    let commands = lab.done("command", &task)["command"].as_str().unwrap().to_owned();
    let (now, other) = commands.split_once("; ").unwrap();
    let state = lab.work(&task);
    assert_eq!(state["beside"]["file"], "traces/model-1.toml");
    holds_all_of(&state["comparison"], &lab.run(now));
    holds_all_of(&state["beside"]["comparison"], &lab.run(other));
    assert_eq!(lab.work(&json!({"beside": {"file": "model-1.toml"}}))["beside"], state["beside"]);
    let overlay = lab.get("overlay?trace=2&width=200&from=1&to=3");
    assert_eq!(overlay["beside"]["time"], overlay["time"]);
    assert_ne!(overlay["beside"]["predicted"], overlay["predicted"]);
    assert_eq!(lab.done("alone", &json!({}))["beside"], Value::Null);
    assert_eq!(lab.get("overlay?trace=2")["beside"], Value::Null);

    let said = lab.refused(422, "start", &json!({"beside": {"version": 7}}));
    assert!(said.contains("no model is called `7`"), "{said}");
    let said = lab.refused(422, "start", &json!({"beside": {"file": "../elsewhere/press.toml"}}));
    assert!(said.contains("not in the folder"), "{said}");
    let model = std::fs::read_to_string(lab.above().join("traces/model-1.toml")).unwrap();
    let gauge = model.replace("\"force_N\"", "\"gauge1_ustrain\"");
    std::fs::write(lab.above().join("traces/gauge.toml"), gauge).unwrap();
    lab.done("start", &json!({"beside": {"file": "gauge.toml"}}));
    let failed = lab.wait();
    assert!(failed.as_str().unwrap().contains("of gauge1_ustrain"), "{failed}");
}

#[test]
fn nothing_outside_the_folder_is_opened_or_written() {
    let lab = lab();
    lab.work(&json!({"fit": {"law": "maxwell"}}));
    let before = std::fs::read_dir(lab.above()).unwrap().count();
    for name in ["..", "../elsewhere", "/etc", "friction/../../elsewhere", "."] {
        for body in [json!({"set": name}), json!({"model": name})] {
            let said = lab.refused(422, "choose", &body);
            assert!(said.contains("not in the folder that was opened"), "{said}");
        }
        let said = lab.refused(422, "start", &json!({"beside": {"file": name}}));
        assert!(said.contains("not in the folder that was opened"), "{said}");
        lab.done("start", &json!({"open": name}));
        assert!(lab.wait().as_str().unwrap().contains("not in the folder"), "{name}");
    }
    std::os::unix::fs::symlink("../elsewhere", lab.above().join("traces/link")).unwrap();
    lab.refused(422, "choose", &json!({"set": "link"}));
    assert_eq!(lab.get("state")["sets"], json!(["friction", "mullins"]));
    for name in ["../model.toml", "/tmp/model.toml", "link/model.toml", "model.html", ""] {
        lab.refused(422, "save", &json!({"file": name}));
    }
    assert_eq!(std::fs::read_dir(lab.above()).unwrap().count(), before);
    assert!(!lab.above().join("elsewhere/model.toml").exists());
    assert_eq!(lab.get("state")["set"], "friction", "the set that was open stays");
}

#[test]
fn what_cannot_be_done_is_refused_in_words() {
    let lab = lab();
    let wrong = |task: Value, words: &str| {
        let said = lab.refused(422, "start", &task);
        assert!(said.contains(words), "{task}: {said}");
    };
    wrong(json!("compare"), "no model yet");
    wrong(json!({"add": {"effect": "drift"}}), "no model yet");
    wrong(json!({"fit": {"law": "fang"}}), "no law is called `fang`");
    wrong(json!({"fit": {"law": "fung", "terms": 9}}), "1 to 4");
    wrong(json!({"fit": {"law": "fung", "segments": 8}}), "not for `fung`");
    wrong(json!({"fit": {"law": "latency", "segments": 1}}), "2 or more");
    wrong(json!({"fit": {"law": "latency-power", "exponent": 99.0}}), "from 1 to 9");
    wrong(json!({"fit": {"law": "creep", "separation": "bonded"}}), "cannot be bonded");
    for (path, body) in [
        ("undo", json!({})),
        ("save", json!({})),
        ("law", json!({"name": "a", "stage": "contact", "expression": "k", "parameters": []})),
        ("choose", json!({"traces": []})),
        ("choose", json!({"traces": [99]})),
        ("choose", json!({"signal": "no_such"})),
        ("choose", json!({"model": "no-such.toml"})),
    ] {
        assert!(!lab.refused(422, path, &body).is_empty(), "{path} {body}");
    }
    for path in ["overlay?trace=99", "forecast?effect=drift&trace=0", "report?kind=fit"] {
        assert_eq!(lab.ask("GET", path, None).0, 422, "{path}");
    }
    lab.work(&fung());
    for (task, words) in [
        (json!({"add": {"effect": "no-such"}}), "no effect of the library is called `no-such`"),
        (json!({"drop": {"effect": "drift"}}), "`drift` is not in the model"),
        (json!({"hide": {"effects": ["no-such"]}}), "no-such"),
        (json!({"hide": {"any": 9}}), "1 to 5 effects, not 9"),
    ] {
        lab.done("start", &task);
        let failed = lab.wait();
        assert!(failed.as_str().unwrap().contains(words), "{task}: {failed}");
    }
    assert_eq!(lab.get("state")["versions"].as_array().unwrap().len(), 1);
}

#[test]
fn a_request_that_is_none_is_refused() {
    let lab = lab();
    for (path, body, status) in [
        ("start", &b"{"[..], 400),
        ("start", b"{\"reboot\": null}", 422),
        ("start", b"{\"add\": {}}", 422),
        ("start", b"{\"fit\": {\"law\": \"fung\", \"more\": 1}}", 422),
        ("choose", b"{\"folder\": \"/\"}", 422),
        ("check", b"[]", 422),
        ("save", b"{\"path\": \"a.toml\"}", 422),
    ] {
        let (found, answer) = lab.ask("POST", path, Some(body));
        let answer = String::from_utf8_lossy(&answer).into_owned();
        assert_eq!((found, answer.is_empty()), (status, false), "{path}: {answer}");
    }
    for path in
        ["overlay", "overlay?trace=x", "overlay?trace=0&from=a", "forecast?trace=0", "report"]
    {
        assert_eq!(lab.ask("GET", path, None).0, 400, "{path}");
    }
    let large = vec![b' '; BODY_LIMIT + 1];
    for path in ["start", "choose", "law", "check", "save", "command"] {
        assert_eq!(lab.ask("POST", path, Some(&large)).0, 413, "{path}");
        assert_eq!(lab.ask("GET", path, None).0, 405, "{path}");
    }
    assert_eq!(lab.ask("GET", "nothing", None).0, 404);
    assert_eq!(lab.get("choices")["laws"].as_array().unwrap().len(), 7);
}

#[test]
fn one_thing_is_worked_out_at_a_time_with_progress_and_it_can_be_cancelled() {
    let lab = lab();
    lab.work(&fung());
    let model = lab.get("state")["model"].clone();
    let job = lab.done("start", &json!("diagnose"))["job"].clone();
    assert!(
        job["command"]
            .as_str()
            .unwrap()
            .starts_with("palpate diagnose --model traces/model-1.toml")
    );
    for (path, body) in [
        ("start", json!("compare")),
        ("choose", json!({"set": "mullins"})),
        ("choose", json!({"traces": [0]})),
        ("undo", json!({})),
    ] {
        let said = lab.refused(422, path, &body);
        assert!(said.contains("something is being worked out"), "{path}: {said}");
    }
    let mut stages = Vec::new();
    let begun = Instant::now();
    while stages.is_empty() && begun.elapsed() < PATIENCE {
        let progress = lab.get("progress");
        assert!(!progress["job"].is_null(), "it was done before a stage of it was seen");
        stages.extend(progress["job"]["stage"].as_object().cloned());
    }
    assert!(stages[0]["done"].as_u64() < stages[0]["of"].as_u64(), "{stages:?}");
    assert_eq!(lab.done("cancel", &json!({})), json!({"job": null, "failed": "cancelled"}));
    assert_eq!(lab.get("state")["model"], model);
    let state = lab.work(&json!("compare"));
    assert_eq!(state["failed"], Value::Null);
    lab.done("cancel", &json!({}));
    assert_eq!(lab.get("state")["failed"], Value::Null, "there was nothing to cancel");
}

#[test]
fn a_law_of_ones_own_is_checked_in_place_and_added() {
    let lab = lab();
    lab.work(&fung());
    let law = |expression: &str| {
        let strength = json!({"name": "k", "value": 0.0, "unit": "N"});
        json!({"name": "pull", "stage": "contact", "expression": expression, "parameters": [strength]})
    };
    let fault = lab.done("check", &law("k * tanh(vv)"))["fault"].clone();
    assert_eq!((&fault["at"], &fault["length"]), (&json!(9), &json!(2)));
    assert!(lab.refused(422, "law", &law("k * tanh(vv)")).contains("`vv` is unknown"));
    let right = lab.done("check", &law("k * tanh(v)"));
    assert_eq!(right["fault"], Value::Null);
    assert!(right["toml"].as_str().unwrap().contains("[[candidate]]"));
    let state = lab.done("law", &law("k * tanh(v)"));
    assert_eq!(state["model"]["candidate"][0]["name"], "pull");
    lab.done("save", &json!({}));
    let add = json!({"add": {"effect": "pull"}});
    let command = lab.command(&add);
    assert_eq!(lab.work(&add)["answers"]["change"], command);
    assert!(lab.refused(422, "law", &law("k * v")).contains("in the model already"));
}

#[test]
fn practice_is_hidden_in_a_new_folder_and_revealed_as_by_the_command() {
    let lab = lab();
    let state = lab.work(&json!({"hide": {"any": 1, "seed": 11}}));
    assert_eq!((&state["set"], &state["practice"]), (&json!("practice-11"), &json!(true)));
    assert_eq!(state["traces"].as_array().unwrap().len(), 10);
    let mut truth = lab.done("reveal", &json!({}));
    let command = truth.as_object_mut().unwrap().remove("command").unwrap();
    assert_eq!(command, "palpate hide --open traces/practice-11");
    holds_all_of(&truth, &lab.run(command.as_str().unwrap()));
    let sealed = std::fs::read_dir(lab.above().join("traces/mullins")).unwrap();
    for file in sealed.map(|entry| entry.unwrap().path()) {
        if file.extension().is_none_or(|extension| extension != "csv") {
            std::fs::remove_file(file).unwrap();
        }
    }
    lab.done("choose", &json!({"set": "mullins"}));
    assert_eq!(lab.wait(), Value::Null);
    assert_eq!(lab.get("state")["practice"], false);
    lab.refused(422, "reveal", &json!({}));
}

#[test]
fn sets_traces_and_signals_are_picked_and_a_set_that_cannot_be_read_leaves_the_other_open() {
    let lab = lab();
    lab.done("choose", &json!({"set": "mullins"}));
    assert_eq!(lab.wait(), Value::Null);
    let state = lab.done("choose", &json!({"traces": [0, 4], "signal": "force_N"}));
    let chosen = state["traces"].as_array().unwrap().iter().filter(|of| of["chosen"] == true);
    assert_eq!(chosen.count(), 2);
    let command = lab.done("command", &fung())["command"].as_str().unwrap().to_owned();
    assert_eq!(command.matches("traces/mullins/").count(), 2, "{command}");
    let fit = lab.run(&command);
    assert_eq!(lab.work(&fung())["answers"]["fit"], fit);
    assert_eq!(lab.ask("GET", "overlay?trace=2", None).0, 422);

    let broken = lab.above().join("traces/broken");
    std::fs::create_dir(&broken).unwrap();
    std::fs::write(broken.join("a.csv"), "time_s,force_N\n0,1\n1,x\n").unwrap();
    lab.done("choose", &json!({"set": "broken"}));
    let failed = lab.wait();
    assert!(failed.as_str().unwrap().contains("a.csv"), "{failed}");
    let state = lab.get("state");
    assert_eq!(
        (&state["set"], state["versions"].as_array().unwrap().len()),
        (&json!("mullins"), 1)
    );
}

#[test]
fn lines_are_broken_where_rows_are_missing_with_and_without_a_model() {
    let above = tempfile::tempdir().unwrap();
    std::fs::create_dir(above.path().join("traces")).unwrap();
    let mut trace = long_trace(20_000);
    let kept: Vec<usize> = (0..20_000).filter(|k| !(9_600..10_400).contains(k)).collect();
    let keep = |values: &[f64]| kept.iter().map(|&k| values[k]).collect::<Vec<_>>();
    trace.time = keep(&trace.time);
    for column in &mut trace.columns {
        column.values = keep(&column.values);
    }
    write(&above.path().join("traces/gap.parquet"), &trace).unwrap();
    let lab = Lab::open(above, &["traces"]);
    let broken = |line: &str, overlay: &Value| -> Vec<f64> {
        let (time, values) =
            (overlay["time"].as_array().unwrap(), overlay[line].as_array().unwrap());
        let missing = time.iter().zip(values).filter(|(_, value)| value.is_null());
        missing.map(|(time, _)| time.as_f64().unwrap()).collect()
    };
    for window in ["", "&from=9&to=11"] {
        let overlay = lab.get(&format!("overlay?trace=0&width=500{window}"));
        let found = broken("measured", &overlay);
        assert!(matches!(found[..], [at] if (9.599..10.4).contains(&at)), "{found:?}");
    }
    lab.work(&json!({"fit": {"law": "kelvin-voigt"}}));
    let overlay = lab.get("overlay?trace=0&width=500");
    for line in ["measured", "predicted", "residual"] {
        assert_eq!(broken(line, &overlay).len(), 1, "{line}");
    }
    assert_eq!(overlay["extents"]["loading"][0].as_f64().unwrap().round(), 1.0, "{overlay}");
}

/// Presses of a viscoelastic specimen, one every ten seconds at 1 kHz.
fn long_trace(samples: usize) -> Trace {
    let mut trace =
        Trace { time: (0..samples).map(|k| k as f64 / 1e3).collect(), ..Trace::default() };
    let depth = |time: f64| -> f64 {
        let within = time % 10.0;
        let up = within.min(10.0 - within) - 1.0;
        up.clamp(-0.5, 2.0)
    };
    let mut state = 1_u64;
    let mut noise = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / f64::from(1 << 24) - 0.5
    };
    let displacement: Vec<f64> = trace.time.iter().map(|&time| depth(time)).collect();
    let force = displacement.iter().map(|x| x.max(0.0).powf(1.5) + 0.01 * noise()).collect();
    trace.set_column(DISPLACEMENT, displacement);
    trace.set_column(FORCE, force);
    trace
}

/// Times of opening and of panning, for docs/measured.md.
#[test]
#[ignore = "ten million samples: run it with --release"]
fn ten_million_samples_open_and_pan() {
    let trace = long_trace(10_000_000);
    for format in ["parquet", "csv"] {
        let above = tempfile::tempdir().unwrap();
        std::fs::create_dir(above.path().join("traces")).unwrap();
        let file = above.path().join(format!("traces/long.{format}"));
        write(&file, &trace).unwrap();
        let bytes = std::fs::metadata(&file).unwrap().len();
        let begun = Instant::now();
        let lab = Lab::open(above, &["traces"]);
        let printed = begun.elapsed();
        lab.get("state");
        lab.get("overlay?trace=0&width=1200");
        let opened = begun.elapsed();
        println!(
            "{format}: file of {:.0} MB, address after {printed:.2?}, drawn after {opened:.2?}, pan {}, {} MB",
            bytes as f64 / 1e6,
            panned(&lab),
            memory_mb(&lab.server, "VmHWM"),
        );
    }
}

/// The same with a model: time of the comparison, in the background, and of panning all its lines.
#[test]
#[ignore = "ten million samples: run it with --release"]
fn ten_million_samples_pan_beside_a_model() {
    let above = tempfile::tempdir().unwrap();
    std::fs::create_dir(above.path().join("traces")).unwrap();
    let at = |name: &str| above.path().join(name);
    write(&at("short.csv"), &long_trace(50_000)).unwrap();
    write(&at("traces/long.parquet"), &long_trace(10_000_000)).unwrap();
    let fit = ["fit", "fung", "short.csv", "-o", "model.toml"];
    assert!(program().args(fit).current_dir(above.path()).output().unwrap().status.success());
    let begun = Instant::now();
    let lab = Lab::open(above, &["traces", "--model", "model.toml"]);
    lab.get("overlay?trace=0&width=1200");
    println!("drawn without the model after {:.2?}", begun.elapsed());
    assert_eq!(lab.wait(), Value::Null);
    println!("compared after {:.1?}", begun.elapsed());
    println!("pan {}, {} MB", panned(&lab), memory_mb(&lab.server, "VmHWM"));
    assert!(lab.get("overlay?trace=0")["residual"].is_array());
}

/// Median and worst time of 200 pans.
fn panned(lab: &Lab) -> String {
    let mut pans: Vec<Duration> = (0..200)
        .map(|k| {
            let (from, to) = (f64::from(k) * 40.0, f64::from(k) * 40.0 + 2_000.0);
            let begun = Instant::now();
            lab.get(&format!("overlay?trace=0&width=1200&from={from}&to={to}"));
            begun.elapsed()
        })
        .collect();
    pans.sort();
    format!("median {:.1?}, worst {:.1?}", pans[100], pans[199])
}

impl Lab {
    /// Status of the answer to a file that is dropped, and what is told of it.
    fn dropped(&self, name: &str, into: &str, bytes: &[u8]) -> (u16, Value) {
        let (status, answer) =
            self.ask("POST", &format!("drop?name={name}&into={into}"), Some(bytes));
        (status, serde_json::from_slice(&answer).unwrap_or_default())
    }
}

#[test]
fn files_that_are_dropped_are_a_data_set_in_a_new_folder_of_the_one_opened() {
    let lab = Lab::open(practice_sets(), &["traces"]);
    let press = std::fs::read(bundled("press.csv")).unwrap();
    let (status, told) = lab.dropped("press.csv", "", &press);
    assert_eq!((status, &told["kind"], &told["set"]), (200, &json!("trace"), &json!("dropped")));
    assert_eq!(std::fs::read(lab.above().join("traces/dropped/press.csv")).unwrap(), press);
    lab.done("choose", &json!({"set": "dropped"}));
    assert_eq!(lab.wait(), Value::Null);
    let state = lab.get("state");
    assert_eq!(state["traces"][0]["name"], "press.csv");
    assert_eq!(lab.work(&fung())["comparison"]["labels"], json!(["press.csv"]));
    // A name leads nowhere else, nor does a folder.
    let (status, told) = lab.dropped("..%2F..%2Fescape.csv", "dropped", &press);
    assert_eq!((status, &told["file"]), (200, &json!("escape.csv")));
    for other in ["friction", "..", "%2Ftmp", "..%2Felsewhere", "dropped%2Fforeign"] {
        assert_eq!(lab.dropped("a.csv", other, &press).0, 422, "{other}");
    }
    assert!(!lab.above().join("escape.csv").exists());
}

#[test]
fn a_file_that_is_too_large_is_not_taken_and_other_bodies_are_as_small_as_before() {
    let lab = lab();
    let large = vec![b'0'; UPLOAD_LIMIT + 1];
    assert_eq!(lab.dropped("large.csv", "", &large).0, 413);
    assert!(!lab.above().join("traces/dropped").exists());
    let (status, told) = lab.dropped("noise.bin", "", &large[..BODY_LIMIT + 1]);
    assert_eq!((status, &told["kind"]), (200, &json!("foreign")));
    assert!(told["why"].is_string() && told["mapping"].is_null(), "{told}");
}

#[test]
fn a_foreign_recording_is_imported_with_its_mapping_and_the_command_does_the_same() {
    let lab = lab();
    let text = std::fs::read(workspace().join("tests/foreign/lab.txt")).unwrap();
    let mapping = std::fs::read_to_string(workspace().join("tests/foreign/lab.map.toml")).unwrap();
    let (_, told) = lab.dropped("lab.txt", "", &text);
    assert_eq!((&told["kind"], told["mapping"].is_string()), (&json!("foreign"), true), "{told}");
    let import = |keep: bool, mapping: &str| json!({"set": "dropped", "file": "lab.txt", "mapping": mapping, "keep": keep});
    let seen = lab.done("import", &import(false, &mapping));
    assert!(seen["samples"].as_u64() > Some(2) && seen["head"].is_array(), "{seen}");
    assert!(!lab.above().join("traces/dropped/lab.trace.csv").exists());
    let kept = lab.done("import", &import(true, &mapping));
    assert_eq!(kept["file"], "lab.trace.csv");
    let made = std::fs::read(lab.above().join("traces/dropped/lab.trace.csv")).unwrap();
    let command = kept["command"].as_str().unwrap().strip_prefix("palpate ").unwrap();
    let again = program()
        .args(command.replace("lab.trace.csv", "again.csv").split(' '))
        .current_dir(lab.above())
        .output()
        .unwrap();
    assert!(again.status.success(), "{command}: {}", String::from_utf8_lossy(&again.stderr));
    assert_eq!(std::fs::read(lab.above().join("traces/dropped/again.csv")).unwrap(), made);
    let refused = lab.refused(422, "import", &import(true, "palpate-map = 1\nwhat = 3\n"));
    assert!(refused.contains("what") && !refused.contains(&lab.above().display().to_string()));
    let elsewhere = json!({"set": "dropped", "file": "../../friction/trace-01.csv", "mapping": "", "keep": false});
    lab.refused(422, "import", &elsewhere);
}

#[test]
fn a_recording_of_a_device_is_a_data_set_as_it_is() {
    let above = tempfile::tempdir().unwrap();
    std::fs::create_dir(above.path().join("traces")).unwrap();
    let press = bundled("press.csv").display().to_string();
    let made = program()
        .args(["convert", &press, "-o", "traces/touch.palpate"])
        .current_dir(above.path())
        .output()
        .unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let lab = Lab::open(above, &["traces"]);
    let state = lab.get("state");
    assert_eq!(
        (&state["sets"], &state["set"]),
        (&json!(["touch.palpate"]), &json!("touch.palpate"))
    );
    assert!(state["signals"].as_array().unwrap().contains(&json!("gauge1_ustrain")), "{state}");
    let overlay = lab.get("overlay?trace=0&width=100");
    assert!(overlay["measured"].as_array().unwrap().len() > 100);
}

#[test]
fn the_motion_that_decides_is_that_of_the_command() {
    let above = tempfile::tempdir().unwrap();
    let hide = ["hide", "elastic-stiffening", "--seed", "2", "--size", "0.3", "-o", "set"];
    let made = program().args(hide).current_dir(above.path()).output().unwrap();
    assert!(made.status.success());
    for file in above.path().join("set").read_dir().unwrap() {
        let path = file.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        let first = (1..=3).any(|k| text.contains(&format!("\n# sequence = {k}\n")));
        if path.extension().is_some_and(|of| of == "csv") && !first {
            std::fs::remove_file(path).unwrap();
        }
    }
    let lab = Lab::open(above, &["set"]);
    lab.work(&fung());
    let state = lab.work(&json!({"motion": null}));
    let motion = &state["answers"]["motion"];
    assert!(motion["separates"].as_f64().unwrap() > 10.0, "{motion}");
    lab.done("save", &json!({}));
    let command = lab.done("command", &json!({"motion": null}));
    assert_eq!(
        command["command"],
        "palpate diagnose --model set/model-1.toml set --next next-motion.csv"
    );
    let asked = lab.run(command["command"].as_str().unwrap());
    holds_all_of(motion, &asked["next_motion"]);
    let written = std::fs::read_to_string(lab.above().join("next-motion.csv")).unwrap();
    assert_eq!(motion["csv"], written, "what the page saves is what the command writes");
}

#[test]
fn a_survey_is_opened_and_so_is_one_group_of_it() {
    let above = tempfile::tempdir().unwrap();
    for finger in ["thumb", "index"] {
        let folder = above.path().join("data/lab").join(finger);
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::copy(bundled("press.csv"), folder.join("press.csv")).unwrap();
    }
    std::fs::write(above.path().join("data/lab/index/other.csv"), "no trace").unwrap();
    let outside = above.path().join("outside");
    std::fs::create_dir_all(&outside).unwrap();
    std::fs::copy(bundled("press.csv"), outside.join("press.csv")).unwrap();
    let survey = |data: &str, out: &str| {
        let words = ["survey", "segment", data, "--by", "folder", "-o", out];
        let made = program().args(words).current_dir(above.path()).output().unwrap();
        assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    };
    survey("data/lab", "data/results");
    survey("outside", "data/away");
    let lab = Lab::open(above, &["data"]);
    assert_eq!(lab.get("state")["surveys"], json!(["away", "results"]));
    assert_eq!(lab.get("state")["sets"], json!([]), "the tables of a survey are no traces");
    let state = lab.work(&json!({"survey": "results"}));
    let listed = state["survey"]["listed"].as_array().unwrap();
    assert_eq!(listed.len(), 2);
    assert_eq!(listed[0]["status"], "refused", "what failed comes first: {listed:?}");
    let good = &listed[1];
    assert!(good["key"].as_str().unwrap().ends_with("thumb"), "{good}");
    let task = json!({"group": {"survey": "results", "group": good["group"]}});
    let command = lab.done("command", &task)["command"].as_str().unwrap().to_owned();
    assert_eq!(
        command,
        format!(
            "palpate survey traces data/results {} -o data/results-group-{}",
            good["group"], good["group"]
        )
    );
    for _ in 0..2 {
        let state = lab.work(&task);
        assert_eq!(state["set"], format!("results-group-{}", good["group"]).as_str());
        assert_eq!(state["traces"][0]["name"], "press.csv");
    }
    // The traces of the other survey lie where the page may not read.
    lab.done("start", &json!({"group": {"survey": "away", "group": 0}}));
    let why = lab.wait();
    assert!(why.as_str().unwrap().contains("outside the folder that was opened"), "{why}");
    assert!(!lab.above().join("data/away-group-0").exists());
    lab.done("start", &json!({"group": {"survey": "results", "group": 99}}));
    assert!(lab.wait().as_str().unwrap().contains("no group 99"));
}
