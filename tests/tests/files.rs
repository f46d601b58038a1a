//! What every command promises of files: nothing precious is written over, nothing is left half done, nothing is left behind.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use palpate_tests::{bundled, palpate};
use tempfile::TempDir;

/// Exit status and standard error of a call in a folder.
fn call(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let output = palpate().current_dir(folder).args(arguments).output().expect("palpate runs");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code().expect("an exit status"), error)
}

/// A folder with a recording, a motion and a model, by name, and the bytes of all of them.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(bundled("press.csv"), folder.path().join("press.csv")).unwrap();
    fs::create_dir(folder.path().join("set")).unwrap();
    fs::copy(bundled("press.csv"), folder.path().join("set/press.csv")).unwrap();
    fs::write(folder.path().join("model.toml"), MODEL).unwrap();
    fs::write(
        folder.path().join("map.toml"),
        "palpate-map = 1\n[table]\nheader_line = 1\n[time]\nfrom = \"t\"\nunit = \"s\"\n",
    )
    .unwrap();
    fs::write(folder.path().join("lab.txt"), "t,F\n0,1\n1,2\n").unwrap();
    folder
}

const MODEL: &str = "palpate-model = 1\n[base]\nlaw = \"fung\"\nsignal = \"force_N\"\n\
    [base.parameters]\np = { value = 0.2 }\nq = { value = 0.1 }\n\
    c1 = { value = 0.2 }\nv1 = { value = 4.0 }\nc2 = { value = 0.2 }\nv2 = { value = 0.5 }\n";

/// Each command that writes where it is told: the call, with the file that it writes in place of `OUT`, and a file of its
/// own inputs that has the right ending, if there is one.
const WRITERS: &[(&[&str], &str, Option<&str>)] = &[
    (&["fit", "fung", "press.csv", "-o", "OUT"], "toml", None),
    (&["fit", "fung", "press.csv", "--report", "OUT"], "html", None),
    (&["fit", "--all", "press.csv", "--report", "OUT"], "html", None),
    (&["add", "mullins", "model.toml", "press.csv", "-o", "OUT"], "toml", Some("model.toml")),
    (&["drop", "mullins", "model.toml", "press.csv", "-o", "OUT"], "toml", Some("model.toml")),
    (&["explore", "--model", "model.toml", "press.csv", "-o", "OUT"], "toml", Some("model.toml")),
    (&["discover", "--model", "model.toml", "press.csv", "-o", "OUT"], "toml", Some("model.toml")),
    (&["compare", "model.toml", "press.csv", "--report", "OUT"], "html", None),
    (&["diagnose", "--model", "model.toml", "press.csv", "--report", "OUT"], "html", None),
    (&["diagnose", "--model", "model.toml", "press.csv", "--figure", "OUT"], "svg", None),
    (&["explore", "--model", "model.toml", "press.csv", "--figure", "OUT"], "svg", None),
    (&["simulate", "model.toml", "--motion", "press.csv", "-o", "OUT"], "csv", Some("press.csv")),
    (&["sensor", "press", "-o", "OUT"], "csv", None),
    (&["sensor", "slide", "--report", "OUT"], "html", None),
    (&["sensor", "frequency", "--report", "OUT"], "html", None),
    (&["afm", "simulate", "-o", "OUT"], "csv", None),
    (&["afm", "rough", "--report", "OUT"], "html", None),
    (&["afm", "press.csv", "--report", "OUT"], "html", None),
    (&["convert", "press.csv", "-o", "OUT"], "csv", Some("press.csv")),
    (&["convert", "press.csv", "-o", "OUT"], "mat", None),
    (&["convert", "press.csv", "-o", "OUT"], "mcap", None),
    (&["import", "lab.txt", "--map", "map.toml", "-o", "OUT"], "csv", None),
    (&["record", "-o", "OUT"], "palpate", None),
    (&["record", "-o", "take.palpate", "--mcap", "OUT"], "mcap", None),
    (&["plot", "press.csv", "-o", "OUT"], "svg", None),
    (&["events", "press.csv", "--report", "OUT"], "html", None),
    (&["markers", "press.csv", "--report", "OUT"], "html", None),
    (&["demo", "--report", "OUT"], "html", None),
    (&["demo", "--trace", "OUT"], "csv", None),
    (&["hide", "mullins", "-o", "practice", "--report", "OUT"], "html", None),
    (&["effects", "--report", "OUT"], "html", None),
    (&["segment", "press.csv", "--report", "OUT"], "html", None),
    (&["relaxation", "press.csv", "--report", "OUT"], "html", None),
    (
        &["survey", "segment", "press.csv", "--by", "trace", "-o", "results", "--report", "OUT"],
        "html",
        None,
    ),
    (&["creep", "press.csv", "--report", "OUT"], "html", None),
    (&["rates", "press.csv", "--report", "OUT"], "html", None),
    (&["strain-rate", "press.csv", "--modulus", "1e4", "--report", "OUT"], "html", None),
    (&["decompose", "press.csv", "--report", "OUT"], "html", None),
    (
        &[
            "grasp",
            "surface",
            "--contact",
            "circle:5",
            "--friction",
            "1",
            "--force",
            "1",
            "-o",
            "OUT",
        ],
        "csv",
        None,
    ),
    (
        &["grasp", "margin", "press.csv", "--contact", "circle:5", "--friction", "1", "-o", "OUT"],
        "csv",
        Some("press.csv"),
    ),
    (
        &["grasp", "growth", "--contact", "circle:5", "--friction", "1", "--report", "OUT"],
        "html",
        None,
    ),
];

fn with_output<'a>(arguments: &[&'a str], file: &'a str) -> Vec<&'a str> {
    arguments.iter().map(|argument| if *argument == "OUT" { file } else { argument }).collect()
}

/// Everything in a folder, by name.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut found: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.is_file())
        .map(|path| (path.display().to_string(), fs::read(&path).unwrap()))
        .collect();
    found.sort();
    found
}

#[test]
fn no_command_writes_over_a_file_that_palpate_did_not_write() {
    for (arguments, ending, _) in WRITERS {
        let folder = folder();
        let name = format!("precious.{ending}");
        fs::write(folder.path().join(&name), "not of palpate\n").unwrap();
        let before = contents(folder.path());
        let (status, error) = call(folder.path(), &with_output(arguments, &name));
        assert_eq!(status, 2, "{arguments:?}: {error}");
        assert!(error.contains(&format!("{name}: exists already")), "{arguments:?}: {error}");
        assert_eq!(contents(folder.path()), before, "{arguments:?}");
    }
}

#[test]
fn no_command_writes_over_what_it_reads_even_with_force() {
    for (arguments, _, input) in WRITERS {
        let Some(input) = input else { continue };
        let folder = folder();
        let before = contents(folder.path());
        let linked = folder.path().join("set").join("..").join(input).display().to_string();
        for name in [input, &linked[..]] {
            let forces = matches!(arguments[0], "simulate" | "grasp");
            let force = if forces { "--overwrite" } else { "--force" };
            let forced = [&with_output(arguments, name)[..], &[force]].concat();
            let (status, error) = call(folder.path(), &forced);
            assert_eq!(status, 2, "{forced:?}: {error}");
            assert!(error.contains("is read by this call"), "{forced:?}: {error}");
            assert_eq!(contents(folder.path()), before, "{forced:?}");
        }
    }
}

#[test]
fn a_result_has_the_ending_of_its_kind() {
    for (arguments, _, _) in WRITERS {
        let folder = folder();
        let before = contents(folder.path());
        let (status, error) = call(folder.path(), &with_output(arguments, "result.txt"));
        assert_eq!(status, 2, "{arguments:?}: {error}");
        assert!(error.contains("result.txt: the name must end in ."), "{arguments:?}: {error}");
        assert_eq!(contents(folder.path()), before, "{arguments:?}");
    }
}

/// A command that takes a file to write and is not in the table would not be tested.
#[test]
fn every_command_that_writes_a_file_is_in_the_table() {
    let known: BTreeSet<&str> = WRITERS.iter().map(|(arguments, ..)| arguments[0]).collect();
    let help = palpate().arg("--help").output().unwrap();
    let help = String::from_utf8(help.stdout).unwrap();
    let commands = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    for line in commands.take_while(|line| !line.is_empty()) {
        let Some(name) = line.strip_prefix("  ").and_then(|line| line.split(' ').next()) else {
            continue;
        };
        // A folder of its own, checked as such; a device that keeps its settings.
        if name.is_empty() || ["help", "dissertation", "device", "serve"].contains(&name) {
            continue;
        }
        let help = palpate().args([name, "--help"]).output().unwrap();
        let help = String::from_utf8(help.stdout).unwrap();
        let writes = help.contains("--output") || help.contains("--report");
        assert!(!writes || known.contains(name), "{name} writes files and is not tested");
    }
}

#[test]
fn one_file_is_not_two_results_and_a_table_does_not_fall_among_the_traces() {
    let folder = folder();
    let refused = |arguments: &[&str], words: &str| {
        let (status, error) = call(folder.path(), arguments);
        assert_eq!(status, 2, "{arguments:?}: {error}");
        assert!(error.contains(words), "{arguments:?}: {error}");
    };
    let twice = ["demo", "--report", "a.html", "--trace", "./a.html"];
    refused(&twice, "must end in .csv");
    fs::create_dir(folder.path().join("again")).unwrap();
    fs::copy(bundled("press.csv"), folder.path().join("again/press.csv")).unwrap();
    let same = ["decompose", "set/press.csv", "again/press.csv", "-o", "split"];
    refused(&same, "split/press.csv: is named for two results");
    refused(&["convert", "set", "-o", "set/all.csv"], "would be read as a trace by the next");
    refused(&["decompose", "set", "-o", "set", "--force"], "lies in a folder that this call reads");
    assert_eq!(fs::read_dir(folder.path().join("set")).unwrap().count(), 1);
    assert!(!folder.path().join("split").exists());
}

#[test]
fn what_palpate_wrote_it_writes_again_and_anything_else_with_force() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    for _ in 0..2 {
        for arguments in [
            &["demo"][..],
            &["plot", "press.csv", "-o", "p.svg"],
            &["demo", "--trace", "kept.csv"],
            &["segment", "press.csv", "--report", "m.html"],
            &["fit", "maxwell", "press.csv", "-o", "m.toml"],
            &["decompose", "press.csv", "-o", "split"],
            &["simulate", "model.toml", "--motion", "press.csv", "-o", "simulated.csv"],
            &["afm", "simulate", "-o", "curve.csv"],
            &["sensor", "press", "-o", "felt.csv"],
            &["sensor", "press", "-o", "felt.palpate"],
            &[
                "grasp",
                "margin",
                "press.csv",
                "--contact",
                "circle:5",
                "--friction",
                "1",
                "--tangential",
                "0.1",
                "-o",
                "margin.csv",
            ],
        ] {
            let (status, error) = call(folder.path(), arguments);
            assert_eq!(status, 0, "{arguments:?}: {error}");
        }
    }
    fs::write(at("p.svg"), "<svg>by another program</svg>").unwrap();
    fs::write(at("empty.svg"), "").unwrap();
    assert_eq!(call(folder.path(), &["plot", "press.csv", "-o", "p.svg"]).0, 2);
    assert_eq!(call(folder.path(), &["plot", "press.csv", "-o", "p.svg", "--force"]).0, 0);
    // There is nothing to lose in an empty file, as `mktemp` makes it.
    assert_eq!(call(folder.path(), &["plot", "press.csv", "-o", "empty.svg"]).0, 0);
    // Who wrote a trace is not known, unless it says that it was computed.
    fs::copy(at("press.csv"), at("s.csv")).unwrap();
    let predict = ["simulate", "model.toml", "--motion", "press.csv", "-o", "s.csv"];
    let (status, error) = call(folder.path(), &predict);
    assert_eq!(status, 2);
    assert!(error.contains("write over it with --overwrite"), "{error}");
    assert_eq!(call(folder.path(), &[&predict[..], &["--overwrite"]].concat()).0, 0);
    assert_eq!(call(folder.path(), &predict).0, 0);
}

#[cfg(unix)]
mod unix {
    use std::os::unix::fs::{FileTypeExt, symlink};
    use std::process::{Child, Command, Stdio};
    use std::time::{Duration, Instant};

    use palpate_tests::server::program;

    use super::*;

    /// Long enough for any machine; nothing is measured.
    const PATIENCE: Duration = Duration::from_secs(120);

    #[test]
    fn a_pipe_a_device_and_a_link_stay_what_they_are() {
        let folder = folder();
        let at = |name: &str| folder.path().join(name);
        assert!(Command::new("mkfifo").arg(at("pipe")).status().unwrap().success());
        let mut reader =
            Command::new("cat").arg(at("pipe")).stdout(Stdio::piped()).spawn().unwrap();
        let (status, error) =
            call(folder.path(), &["simulate", "model.toml", "--motion", "press.csv", "-o", "pipe"]);
        assert_eq!(status, 0, "{error}");
        assert!(fs::metadata(at("pipe")).unwrap().file_type().is_fifo());
        let mut got = String::new();
        std::io::Read::read_to_string(&mut reader.stdout.take().unwrap(), &mut got).unwrap();
        assert!(got.contains("time_s,displacement_mm,force_N"), "{got}");
        reader.wait().unwrap();

        let arguments = ["plot", "press.csv", "-o", "/dev/null"];
        assert_eq!(call(folder.path(), &arguments).0, 0);
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());

        fs::create_dir(at("models")).unwrap();
        symlink("models/press.svg", at("link.svg")).unwrap();
        for _ in 0..2 {
            assert_eq!(call(folder.path(), &["plot", "press.csv", "-o", "link.svg"]).0, 0);
            assert!(fs::symlink_metadata(at("link.svg")).unwrap().is_symlink());
            assert!(fs::read_to_string(at("models/press.svg")).unwrap().starts_with("<svg"));
        }
        // A link to an input is that input.
        symlink("press.csv", at("linked.csv")).unwrap();
        let over = ["convert", "press.csv", "-o", "linked.csv", "--force"];
        assert_eq!(call(folder.path(), &over).0, 2);
    }

    /// Files that are being written.
    fn unfinished(folder: &Path) -> usize {
        let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
        names.filter(|name| name.to_string_lossy().ends_with(".palpate-tmp")).count()
    }

    /// Waits until a process is writing a file in a folder.
    fn wait_for_unfinished(process: &mut Child, folder: &Path) {
        let begun = Instant::now();
        while unfinished(folder) == 0 {
            assert!(begun.elapsed() < PATIENCE, "nothing is written");
            assert!(process.try_wait().unwrap().is_none(), "it was written too fast to be seen");
        }
    }

    fn send(signal: &str, process: &Child) {
        let kill = Command::new("kill").args(["-s", signal, &process.id().to_string()]).status();
        assert!(kill.unwrap().success());
    }

    /// Whether this process, and so what it starts, ignores a signal, as under `nohup`.
    fn ignored(signal: u32) -> bool {
        let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
        let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
        mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
    }

    /// A trace that takes a while to write.
    fn long_trace(path: &Path) {
        let mut text = String::from("time_s,force_N\n");
        for row in 0..400_000 {
            text += &format!("{row},{}\n", f64::from(row).sin());
        }
        fs::write(path, text).unwrap();
    }

    #[test]
    fn a_signal_in_mid_write_leaves_nothing_and_what_a_kill_leaves_goes_with_the_next_call() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("out")).unwrap();
        long_trace(&at("long.csv"));
        for (number, signal) in [(2, "INT"), (15, "TERM"), (1, "HUP"), (9, "KILL")] {
            if ignored(number) {
                println!("{signal} is ignored by whoever runs this test: not tried");
                continue;
            }
            let arguments = ["convert", "long.csv", "-o", "out/long.csv"];
            let mut process = program().args(arguments).current_dir(folder.path()).spawn().unwrap();
            wait_for_unfinished(&mut process, &at("out"));
            send(signal, &process);
            let status = process.wait().unwrap();
            assert!(!status.success());
            assert_eq!(unfinished(&at("out")), usize::from(signal == "KILL"), "{signal}");
            assert!(!at("out/long.csv").exists(), "{signal}");
        }
        fs::copy(bundled("press.csv"), at("press.csv")).unwrap();
        assert_eq!(call(folder.path(), &["convert", "press.csv", "-o", "out/press.csv"]).0, 0);
        assert_eq!(unfinished(&at("out")), 0);
    }

    #[test]
    fn a_request_to_end_is_heard_where_another_signal_is_ignored() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("out")).unwrap();
        long_trace(&at("long.csv"));
        // As a shell begins what it runs in the background, and as `nohup` does.
        for ignored in ["INT", "HUP"] {
            let palpate = program().get_program().to_owned();
            let script = format!("trap '' {ignored}; exec \"$0\" convert long.csv -o out/long.csv");
            let mut shell = Command::new("sh");
            let mut process = shell
                .arg("-c")
                .arg(script)
                .arg(palpate)
                .current_dir(folder.path())
                .spawn()
                .unwrap();
            wait_for_unfinished(&mut process, &at("out"));
            send(ignored, &process);
            send("TERM", &process);
            assert_eq!(process.wait().unwrap().code(), Some(130), "{ignored}");
            assert_eq!(unfinished(&at("out")), 0, "{ignored}");
        }
    }

    #[test]
    fn a_reader_that_has_seen_enough_is_no_fault() {
        for arguments in [&["completions", "bash"][..], &["effects"], &["--help"]] {
            let mut process = program()
                .args(arguments)
                .stdout(Stdio::piped())
                .stderr(Stdio::piped())
                .spawn()
                .unwrap();
            drop(process.stdout.take());
            let output = process.wait_with_output().unwrap();
            let error = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success() && error.is_empty(), "{arguments:?}: {error}");
        }
    }
}
