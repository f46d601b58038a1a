//! What every subcommand promises: exit status, one clear error, no half-written file, JSON.

use std::fs;
use std::path::Path;

use palpate_tests::{bundled, palpate};
use serde_json::Value;

/// Exit status, standard output and standard error of a call in a folder.
fn call(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = palpate().current_dir(folder).args(arguments).output().expect("palpate runs");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().expect("an exit status"), text(&output.stdout), text(&output.stderr))
}

fn press() -> String {
    bundled("press.csv").display().to_string()
}

#[test]
fn completions_end_well_when_nobody_reads_on() {
    let mut process = std::process::Command::new(palpate().get_program())
        .args(["completions", "bash"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(process.stdout.take());
    let output = process.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Bad calls and bad files: what is in the folder, the call, and words that the error must have.
const BAD: &[(&str, &str, &[&str], &[&str])] = &[
    ("", "", &["plot", "absent.csv"], &["absent.csv"]),
    ("", "", &["fit", "fnug", "absent.csv"], &["did you mean `fung`?"]),
    ("", "", &["effects", "mulins"], &["did you mean `mullins`?"]),
    ("a.csv", "time_s,force_N\n0,1\n1\n", &["plot", "a.csv"], &["a.csv", "line 3"]),
    ("a.csv", "time_s,force_N\n0,1\n1,NaN\n", &["plot", "a.csv"], &["line 3", "force_N"]),
    ("a.csv", "time_s,force_N\n0,1\n2,1\n1,1\n", &["plot", "a.csv"], &["line 4", "time_s"]),
    ("a.csv", "time_s,force_mN\n0,1\n1,2\n", &["plot", "a.csv"], &["force_mN", "import"]),
    ("a.csv", "time_s,force_N\n0,1\n", &["plot", "a.csv"], &["a.csv", "sample"]),
    ("a.csv", "", &["decompose", "a.csv"], &["a.csv", "no samples"]),
    (
        "a.csv",
        "time_s,displacement_mm,force_N\n0,0,5\n1,1,5\n2,1,5\n3,0,5\n",
        &["fit", "fung", "a.csv", "-o", "m.toml"],
        &["force_N", "5"],
    ),
    (
        "a.csv",
        "time_s,displacement_mm,force_N\n0,0,0\n1,1,1\n2,2,2\n3,3,3\n4,2,1\n5,1,0.5\n",
        &["fit", "fung", "a.csv", "--hold-only", "-o", "m.toml"],
        &["a.csv", "hold"],
    ),
    (
        "a.csv",
        "time_s,displacement_mm,force_N\n0,-2,0\n1,-1,1\n2,-2,2\n",
        &["fit", "fung", "a.csv", "-o", "m.toml"],
        &["no trace reaches"],
    ),
    (
        "a.csv",
        "time_s,displacement_mm,force_N\n0,0,0\n1,1,1\n2,2,2\n",
        &["fit", "fung", "a.csv", "-o", "m.toml"],
        &["3 samples", "6 parameters"],
    ),
    (
        "m.toml",
        "palpate-model = 9\n",
        &["simulate", "m.toml", "--motion", "p.toml", "-o", "s.csv"],
        &["version 9", "version 1", "m.toml"],
    ),
    (
        "m.toml",
        "palpate-model = 1\n[base]\nlaw = \"fung\"\nsignal = \"force_N\"\n[base.parameters]\n",
        &["simulate", "m.toml", "--motion", "p.toml", "-o", "s.csv"],
        &["m.toml", "c1"],
    ),
    ("", "", &["plan", "--noise", "0"], &["noise"]),
    (
        "",
        "",
        &["plan", "--noise", "0.01", "--shares", "0.2,0.3", "--rates", "4"],
        &["2 shares", "1 rates"],
    ),
    ("", "", &["fit", "fang", "a.csv"], &["fang"]),
    ("", "", &["fit", "fung", "a.csv", "--terms", "7"], &["1 to 4"]),
];

#[test]
fn bad_input_ends_with_status_2_one_clear_error_and_no_file() {
    for (name, content, arguments, words) in BAD {
        let folder = tempfile::tempdir().unwrap();
        if !name.is_empty() {
            fs::write(folder.path().join(name), content).unwrap();
        }
        let (status, out, error) = call(folder.path(), arguments);
        assert_eq!(status, 2, "{arguments:?} on {content:?}: {error}");
        assert_eq!(out, "", "{arguments:?}");
        for word in *words {
            assert!(error.contains(word), "{arguments:?} on {content:?}: no {word:?} in {error}");
        }
        assert!(!error.contains("panicked"), "{error}");
        let left = fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(left, usize::from(!name.is_empty()), "{arguments:?} left files behind");
    }
}

#[test]
fn a_trace_of_two_gigabytes_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.csv");
    fs::File::create(&path).unwrap().set_len(2 << 30).unwrap();
    let (status, _, error) = call(folder.path(), &["fit", "fung", "long.csv"]);
    assert_eq!(status, 2);
    assert!(error.contains("long.csv") && error.contains("--every"), "{error}");
}

#[test]
fn a_result_that_cannot_be_written_is_status_1() {
    let folder = tempfile::tempdir().unwrap();
    let press = press();
    for arguments in
        [["plot", &press, "-o", "nowhere/a.svg"], ["fit", "fung", &press, "-o=nowhere/m.toml"]]
    {
        let (status, _, error) = call(folder.path(), &arguments);
        assert_eq!(status, 1, "{error}");
        assert!(error.contains("nowhere"), "{error}");
    }
}

#[test]
fn a_file_that_is_there_survives_a_failed_call() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.toml"), "precious").unwrap();
    let (status, ..) = call(folder.path(), &["fit", "fung", "absent.csv", "-o", "m.toml"]);
    assert_eq!(status, 2);
    assert_eq!(fs::read_to_string(folder.path().join("m.toml")).unwrap(), "precious");
}

#[test]
fn json_is_one_object_of_its_version() {
    let folder = tempfile::tempdir().unwrap();
    let press = press();
    let model = folder.path().join("m.toml").display().to_string();
    assert_eq!(call(folder.path(), &["fit", "fung", &press, "-o", "m.toml"]).0, 0);
    let calls: [(&[&str], &str); 7] = [
        (&["compare", &model, &press, "--json"], "palpate_comparison"),
        (&["fit", "fung", &press, "--json"], "palpate_fit"),
        (&["fit", "fung", &press, "--hold-only", "--json"], "palpate_fit"),
        (&["decompose", &press, "--json"], "palpate_decomposition"),
        (&["segment", &press, "--json"], "palpate_segment"),
        (&["relaxation", &press, "--json"], "palpate_relaxation"),
        (&["plan", "--noise", "0.01", "--json"], "palpate_plan"),
    ];
    for (arguments, version) in calls {
        let (status, out, error) = call(folder.path(), arguments);
        assert_eq!(status, 0, "{error}");
        let value: Value = serde_json::from_str(&out).expect("one JSON object");
        assert_eq!(value[version], 1, "{arguments:?}");
    }
}

#[test]
fn every_subcommand_has_help_with_examples() {
    let folder = tempfile::tempdir().unwrap();
    let (_, help, _) = call(folder.path(), &["--help"]);
    let commands = [
        "demo",
        "decompose",
        "segment",
        "relaxation",
        "creep",
        "rates",
        "strain-rate",
        "fit",
        "compare",
        "simulate",
        "import",
        "plot",
        "plan",
        "completions",
    ];
    for command in commands {
        assert!(help.contains(command), "{help}");
        let (status, help, _) = call(folder.path(), &[command, "--help"]);
        assert_eq!(status, 0);
        assert!(
            help.contains("Examples:") && help.contains(&format!("palpate {command}")),
            "{help}"
        );
    }
}

#[test]
fn completions_are_made_for_every_shell() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let (status, out, _) = call(folder.path(), &["completions", shell]);
        assert!(status == 0 && out.contains("decompose"), "{shell}");
    }
}

#[test]
fn a_model_predicts_the_press_it_was_fitted_to_down_to_the_noise() {
    let folder = tempfile::tempdir().unwrap();
    let press = press();
    let model = ["fit", "fung", &press, "--separation", "free", "-o", "m.toml"];
    assert_eq!(call(folder.path(), &model).0, 0);
    let simulate = ["simulate", "m.toml", "--motion", &press, "-o", "predicted.csv"];
    assert_eq!(call(folder.path(), &simulate).0, 0);
    let read = |path: &Path| palpate::trace::read(path).unwrap();
    let (measured, predicted) =
        (read(Path::new(&press)), read(&folder.path().join("predicted.csv")));
    let square: f64 = measured
        .force()
        .unwrap()
        .iter()
        .zip(predicted.force().unwrap())
        .map(|(a, b)| (a - b).powi(2))
        .sum();
    let rms = (square / measured.len() as f64).sqrt();
    // The press was made with noise of 0.006 N.
    assert!((0.0055..0.0066).contains(&rms), "{rms}");
}

#[test]
fn noise_is_seeded_and_the_seed_is_told() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(
        folder.path().join("p.toml"),
        "palpate-profile = 1\nrate_hz = 100.0\nspeed_mm_per_s = 5.0\n[[step]]\nto_mm = 2.0\n",
    )
    .unwrap();
    assert_eq!(call(folder.path(), &["fit", "fung", &press(), "-o", "m.toml"]).0, 0);
    let simulate = |seed: &str| {
        call(
            folder.path(),
            &["simulate", "m.toml", "--motion", "p.toml", "--noise", "0.01", "--seed", seed],
        )
    };
    let (first, again, other) = (simulate("3"), simulate("3"), simulate("4"));
    assert_eq!(first, again);
    assert_ne!(first.1, other.1);
    assert!(first.2.contains("seed 3"), "{}", first.2);
}

#[test]
fn the_decomposed_trace_is_a_trace_whose_parts_add_up() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(call(folder.path(), &["decompose", &press(), "-o", "split"]).0, 0);
    let trace = palpate::trace::read(&folder.path().join("split/press.csv")).unwrap();
    let column = |name: &str| trace.column(name).unwrap_or_else(|| panic!("no {name}"));
    for gauge in 1..=4 {
        let part = |part: &str| column(&format!("gauge{gauge}_{part}_ustrain"));
        for k in 0..trace.len() {
            let sum = part("fa")[k] + part("sa")[k];
            let signal = column(&format!("gauge{gauge}_ustrain"))[k];
            // The signal was rounded to 2⁻⁸ µε on its way in.
            assert!((sum - signal).abs() <= 1.0 / 512.0, "gauge {gauge}, sample {k}");
            assert_eq!(part("equilibrium")[k] + part("latent")[k], sum);
        }
    }
    let regions = column("gauge1_region");
    let mut seen: Vec<f64> = regions.to_vec();
    seen.dedup();
    // Rest, OA, AB, BC, CD (Type I), DE, CD (Type II), DE, EF.
    assert_eq!(seen, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 4.0, 5.0, 6.0]);
}

#[test]
fn a_decomposition_never_overwrites_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("press.csv");
    fs::copy(bundled("press.csv"), &copy).unwrap();
    let (status, _, error) = call(folder.path(), &["decompose", "press.csv", "-o", "."]);
    assert_eq!(status, 2, "{error}");
    assert_eq!(fs::read(&copy).unwrap(), fs::read(bundled("press.csv")).unwrap());
}

#[test]
fn the_demo_writes_one_page_that_asks_nothing_of_a_network() {
    let folder = tempfile::tempdir().unwrap();
    let (status, out, error) = call(folder.path(), &["demo"]);
    assert_eq!(status, 0, "{error}");
    assert!(out.contains("Type I") && out.contains("Type II") && out.contains("±"), "{out}");
    let page = fs::read_to_string(folder.path().join("palpate-demo.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("default-src 'none'"));
    let outside = page.replace("http://www.w3.org/2000/svg", "");
    assert!(!outside.contains("http://") && !outside.contains("https://"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    // The same bytes again.
    call(folder.path(), &["demo"]);
    assert_eq!(fs::read_to_string(folder.path().join("palpate-demo.html")).unwrap(), page);
}
