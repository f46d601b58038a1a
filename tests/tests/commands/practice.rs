//! Practice sets: what is hidden is as large as asked for, is found, and is told only on purpose.

use std::fs;
use std::path::Path;

use palpate_tests::{answer, palpate};
use serde_json::Value;

/// Exit status, standard output and standard error of a call in a folder.
fn call(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = palpate().current_dir(folder).args(arguments).output().expect("palpate runs");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().expect("an exit status"), text(&output.stdout), text(&output.stderr))
}

#[test]
fn what_is_hidden_is_as_large_as_asked_for_and_is_found() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    let made =
        answer(folder, &["hide", "mullins", "--seed", "5", "--size", "2", "-o", "set", "--json"]);
    assert_eq!(made["traces"].as_array().unwrap().len(), 10);
    let fit = answer(folder, &["fit", "fung", "set", "-o", "model.toml", "--json"]);
    let truth = answer(folder, &["hide", "--open", "set", "--json"]);
    assert_eq!(truth["effects"][0]["effect"], "mullins");
    let number = |value: &Value| value.as_f64().unwrap();
    let times = number(&fit["residual_rms"]) / number(&truth["noise_rms"]);
    let misfit = (times * times - 1.0).sqrt();
    assert!((misfit / 2.0 - 1.0).abs() < 0.1, "{misfit}");
    let found = answer(folder, &["diagnose", "--model", "model.toml", "set", "--json"]);
    assert_eq!(found["steps"][0]["effect"], "mullins", "{found}");
    let add = ["add", "mullins", "model.toml", "set", "-o", "better.toml", "--json"];
    let better = answer(folder, &add);
    let left = number(&better["heldout_rms_after"]) / number(&truth["noise_rms"]);
    assert!((left - 1.0).abs() < 0.05, "{left}");
}

#[test]
fn nothing_but_the_sealed_file_tells_and_that_only_on_purpose() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    let (status, out, _) = call(folder, &["hide", "--any", "2", "--seed", "8", "-o", "set"]);
    assert_eq!(status, 0);
    let truth = answer(folder, &["hide", "--open", "set", "--json"]);
    let effects = truth["effects"].as_array().unwrap();
    assert_eq!(effects.len(), 2);
    let mut texts = vec![out];
    for entry in fs::read_dir(folder.join("set")).unwrap() {
        texts.push(fs::read_to_string(entry.unwrap().path()).unwrap());
    }
    assert_eq!(texts.len(), 12);
    for effect in effects {
        let name = effect["effect"].as_str().unwrap();
        assert!(texts.iter().all(|text| !text.contains(name)), "{name}");
    }
    // The same on every run.
    assert_eq!(call(folder, &["hide", "--any", "2", "--seed", "8", "-o", "again"]).0, 0);
    for entry in fs::read_dir(folder.join("set")).unwrap() {
        let name = entry.unwrap().file_name();
        let read = |set: &str| fs::read(folder.join(set).join(&name)).unwrap();
        assert!(read("set") == read("again"), "{name:?}");
    }
}

#[test]
fn a_practice_set_is_not_made_over_anything_nor_of_nothing() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    fs::create_dir(folder.join("full")).unwrap();
    fs::write(folder.join("full/notes.txt"), "mine").unwrap();
    for (arguments, word) in [
        (&["hide", "-o", "full"][..], "not empty"),
        (&["hide", "-o", "full/notes.txt"], "not a folder"),
        (&["hide", "mulins", "-o", "new"], "mulins"),
        (&["hide", "mullins", "mullins", "-o", "new"], "twice"),
        (&["hide", "mullins", "--size", "0", "-o", "new"], "size"),
        (&["hide", "mullins", "--any", "2", "-o", "new"], "--any"),
        (&["hide", "mullins"], "--output"),
        (&["hide", "--open", "full"], "truth.sealed"),
    ] {
        let (status, out, error) = call(folder, arguments);
        assert_eq!((status, out.as_str()), (2, ""), "{arguments:?}: {error}");
        assert!(error.contains(word), "{arguments:?}: {error}");
    }
    assert!(!folder.join("new").exists());
    assert_eq!(fs::read_to_string(folder.join("full/notes.txt")).unwrap(), "mine");
}
