//! What recordings do not tell apart, the motion that is proposed does: `diagnose --next`, `hide --record`.

use std::fs;
use std::path::Path;

use palpate::trace::read;
use palpate_tests::{follows_schema, palpate};
use serde_json::Value;
use tempfile::TempDir;

/// Runs a command in a folder; its JSON answer where it was asked for.
fn run(folder: &Path, command: &str) -> Value {
    let (status, out, error) = call(folder, command);
    assert_eq!(status, 0, "{command}: {error}");
    serde_json::from_str(&out).unwrap_or(Value::Null)
}

/// Exit status, standard output and standard error.
fn call(folder: &Path, command: &str) -> (i32, String, String) {
    let arguments = command.split(' ');
    let output = palpate().current_dir(folder).args(arguments).output().expect("palpate runs");
    let text = |bytes| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

/// The first three recordings of a practice set, with a model of them.
fn few(effect: &str, seed: u64) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), &format!("hide {effect} --seed {seed} --size 0.3 -o set"));
    for trace in palpate::trace::read_set(&[folder.path().join("set")]).unwrap().iter().skip(3) {
        fs::remove_file(folder.path().join("set").join(trace.label())).unwrap();
    }
    run(folder.path(), "fit fung set -o model.toml");
    folder
}

const NEXT: &str = "diagnose --model model.toml set --next motion.csv --json";

fn members(diagnosis: &Value) -> Vec<&str> {
    let set = diagnosis["steps"][0]["credible_set"].as_array();
    set.into_iter().flatten().filter_map(Value::as_str).collect()
}

#[test]
fn the_motion_that_is_proposed_leaves_one_name() {
    let folder = few("elastic-stiffening", 2);
    let before = run(folder.path(), NEXT);
    follows_schema("diagnose", &before);
    assert_eq!(before["verdict"], "ambiguous");
    assert!(members(&before).len() > 1, "{before:#}");
    let proposed = &before["next_motion"];
    assert_eq!(proposed["pairs_told"], proposed["pairs"]);
    assert!(proposed["separates"].as_f64() >= proposed["separates_of_menu"].as_f64());
    let motion = read(&folder.path().join("motion.csv")).unwrap();
    let foreseen = motion.columns.iter().filter(|column| column.name.ends_with("_N")).count();
    assert_eq!(foreseen, members(&before).len());
    run(folder.path(), "hide --record motion.csv -o set");
    let after = run(folder.path(), "diagnose --model model.toml set --json");
    assert_eq!((&after["verdict"], members(&after)), (&"named".into(), vec!["elastic-stiffening"]));
}

#[test]
fn the_motion_keeps_to_the_limits_of_the_rig() {
    let folder = few("elastic-stiffening", 2);
    let limits = "displacement_mm = 9.0\nspeed_mm_per_s = 8.0\nacceleration_mm_per_s2 = 50.0\ntime_s = 40.0\n";
    fs::write(folder.path().join("rig.toml"), limits).unwrap();
    run(folder.path(), &format!("{NEXT} --rig rig.toml"));
    let motion = read(&folder.path().join("motion.csv")).unwrap();
    let place = motion.displacement().unwrap();
    assert!(motion.duration() <= 40.0 && place.iter().all(|x| *x <= 9.0), "{}", motion.duration());
    let speed = |k: usize| (place[k] - place[k - 1]) / (motion.time[k] - motion.time[k - 1]);
    let speeds: Vec<f64> = (1..place.len()).map(speed).collect();
    // Places are written to 10 nm, 200 times a second.
    assert!(speeds.iter().all(|speed| speed.abs() < 8.0 + 0.002));
    assert!(speeds.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 50.0 * 0.005 + 0.004));
}

#[test]
fn where_nothing_is_open_no_motion_is_written() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), "hide mullins --seed 7 -o set");
    run(folder.path(), "fit fung set -o model.toml");
    let (status, out, error) = call(folder.path(), NEXT);
    assert_eq!(status, 1);
    follows_schema("diagnose", &serde_json::from_str(&out).unwrap());
    assert!(
        error.contains("motion.csv was not written: these traces distinguish all effects"),
        "{error}"
    );
    assert!(!folder.path().join("motion.csv").exists());
}

#[test]
fn a_limit_that_no_rig_has_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("rig.toml"), "speed_mm_per_s = -1.0\n").unwrap();
    let (status, _, error) =
        call(folder.path(), "diagnose --model m.toml set --next motion.csv --rig rig.toml");
    assert_eq!(status, 2);
    assert!(error.contains("`speed_mm_per_s` is -1"), "{error}");
}

#[test]
fn after_the_motion_for_a_parameter_it_is_known_better_than_after_any_of_the_menu() {
    let folder = few("elastic-stiffening", 2);
    let asked = run(folder.path(), &format!("{NEXT} --for v1"));
    follows_schema("diagnose", &asked);
    let told = &asked["next_motion"]["informs"];
    let error = |name: &str| told[0][name].as_f64().unwrap_or(f64::INFINITY);
    assert_eq!((&told[0]["name"], told.as_array().map(Vec::len)), (&"v1".into(), Some(1)));
    assert!(error("standard_error_then") < error("standard_error"), "{told:#}");
    assert!(error("standard_error_then") <= error("standard_error_of_menu"), "{told:#}");
    let motion = read(&folder.path().join("motion.csv")).unwrap();
    assert!(motion.column("predicted_N").is_some());
    let (status, _, error) = call(folder.path(), &format!("{NEXT} --force --for speed"));
    assert_eq!(status, 2);
    assert!(error.contains("no free parameter `speed`"), "{error}");
}

/// Prints how often one proposed motion leaves one name, for every effect.
#[test]
#[ignore = "minutes; `cargo test -p palpate-tests --test next_motion -- --ignored --nocapture`"]
fn how_often_one_motion_decides() {
    let (mut open, mut proposed, mut decided, mut right) = (0, 0, 0, 0);
    let (mut separable, mut decided_of_these) = (0, 0);
    for effect in palpate::effects::LIBRARY {
        for seed in [2, 5] {
            let place = tempfile::tempdir().unwrap();
            let hide = format!("hide {} --seed {seed} --size 0.3 -o set", effect.name);
            if call(place.path(), &hide).0 != 0 {
                continue;
            }
            let folder = few(effect.name, seed);
            let (_, out, error) = call(folder.path(), NEXT);
            let before: Value = serde_json::from_str(&out).unwrap_or_else(|_| panic!("{error}"));
            if before["verdict"] != "ambiguous" {
                continue;
            }
            open += 1;
            let found = &before["next_motion"];
            if found["file"].is_null() {
                continue;
            }
            run(folder.path(), "hide --record motion.csv -o set");
            let after = run(folder.path(), "diagnose --model model.toml set --json");
            let one = after["verdict"] == "named";
            let all = found["pairs"] == found["pairs_told"];
            proposed += 1;
            decided += i32::from(one);
            right += i32::from(one && members(&after) == [effect.name]);
            separable += i32::from(all);
            decided_of_these += i32::from(one && all);
        }
    }
    println!(
        "{open} sets of three recordings with several names: a motion for {proposed}, one that tells all of them apart for \
         {separable}; measured, it leaves one name in {decided} and {decided_of_these}, the right one in {right}"
    );
}
