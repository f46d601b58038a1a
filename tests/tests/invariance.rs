//! An answer does not depend on how the same measurement is written down: in which unit, in which order, from which clock, and on how
//! many threads.

use std::path::Path;

use palpate::trace::{DISPLACEMENT, FORCE, Trace, write};
use palpate_tests::hidden::{Day, LawKind, NoiseKind, Scenario, generate};
use palpate_tests::{answer, bundled, palpate};
use proptest::prelude::*;
use proptest::sample::select;
use proptest::test_runner::RngSeed;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use tempfile::TempDir;

/// Seconds from 1970 to 2023: where the clock of many a logger stands.
const EPOCH_S: f64 = 1.7e9;
/// What rounding may change, relative to a value.
const TOLERANCE: f64 = 1e-6;
/// What parameters and errors of scaled data may differ by, relative to them: a fit ends where the error falls no more.
const SCALED: f64 = 2e-5;

/// Ten traces of a specimen with one effect that the base law lacks.
fn measured(seed: u64, effect: &str) -> Vec<Trace> {
    let hidden = vec![(effect.to_owned(), LawKind::Reference)];
    generate(&Scenario { seed, hidden, r: 1.0, noise: NoiseKind::Correlated, day: Day::Usual })
        .traces
}

/// Writes the traces as files of a folder `set` of its own.
fn folder(traces: &[Trace]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    std::fs::create_dir(&set).unwrap();
    for trace in traces {
        write(&set.join(trace.label()), trace).unwrap();
    }
    folder
}

fn with_column(traces: &[Trace], name: &str, factor: f64) -> Vec<Trace> {
    let mut traces = traces.to_vec();
    for column in traces.iter_mut().flat_map(|trace| &mut trace.columns) {
        if column.name == name {
            column.values.iter_mut().for_each(|value| *value *= factor);
        }
    }
    traces
}

/// Fit, and what the diagnosis of the fitted model says.
fn fit_and_diagnosis(folder: &Path) -> (Value, Value) {
    let fit = answer(folder, &["fit", "fung", "set", "-o", "model.toml", "--json"]);
    let found = answer(folder, &["diagnose", "--model", "model.toml", "set", "--json"]);
    (fit, found)
}

fn number(answer: &Value, pointer: &str) -> f64 {
    answer.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("{pointer}: {answer}"))
}

fn near(found: f64, expected: f64) -> bool {
    (found / expected - 1.0).abs() < TOLERANCE
}

/// The names that a diagnosis gives: verdict, effects that entered, and which each of them cannot be told from.
fn names(found: &Value) -> (String, Vec<(String, Value)>) {
    let steps = found["steps"].as_array().unwrap().iter();
    let named = |step: &Value| (step["effect"].as_str().unwrap().to_owned(), step["set"].clone());
    (found["verdict"].as_str().unwrap().to_owned(), steps.map(named).collect())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4, failure_persistence: None, rng_seed: RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn powers_of_ten_in_force_and_displacement_scale_the_answer(
        force in -12..10_i32,
        displacement in -6..7_i32,
        (seed, effect) in select(vec![(61_u64, "mullins"), (62, "sensor-lag"), (63, "coulomb-friction"), (64, "permanent-set")]),
    ) {
        let traces = measured(seed, effect);
        let (fit, found) = fit_and_diagnosis(folder(&traces).path());
        let factors = (10_f64.powi(force), 10_f64.powi(displacement));
        let scaled = with_column(&with_column(&traces, FORCE, factors.0), DISPLACEMENT, factors.1);
        let (scaled_fit, scaled_found) = fit_and_diagnosis(folder(&scaled).path());

        prop_assert_eq!(names(&scaled_found), names(&found));
        for error in ["/base_rms", "/final_rms", "/noise_rms"] {
            let (now, before) = (number(&scaled_found, error), number(&found, error));
            let off = (now / (factors.0 * before)).ln().abs();
            prop_assert!(off < SCALED, "{}: {} from {}", error, now, before);
        }
        let exponent = number(&fit, "/parameters/q/value") + 1.0;
        for name in ["p", "q", "c1", "c2", "v1", "v2"] {
            let pointer = format!("/parameters/{name}/value");
            let (now, before) = (number(&scaled_fit, &pointer), number(&fit, &pointer));
            // The elastic response is p x^(q + 1).
            let scale = if name == "p" { factors.0 / factors.1.powf(exponent) } else { 1.0 };
            prop_assert!((now / (scale * before)).ln().abs() < SCALED, "{}: {} from {}", name, now, before);
        }
    }
}

/// What these calls print, one after the other.
fn printed(folder: &Path, calls: &[&str], threads: &str) -> Vec<String> {
    let print = |call: &&str| {
        let arguments: Vec<&str> = call.split(' ').collect();
        let mut command = palpate();
        command.current_dir(folder).args(&arguments).env("RAYON_NUM_THREADS", threads);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{call}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    calls.iter().map(print).collect()
}

/// The analyses of a data set, beginning with the fit that the others take.
const CALLS: [&str; 7] = [
    "fit fung set -o model.toml --force --json",
    "compare model.toml set --json",
    "diagnose --model model.toml set --json",
    "relaxation set --json",
    "segment set --json",
    "decompose set --signal force_N --json",
    "fit --all set --json",
];

#[test]
fn columns_files_and_threads_in_any_order_give_the_same_bytes() {
    let traces = measured(65, "backlash")[..4].to_vec();
    let before = printed(folder(&traces).path(), &CALLS, "2");
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut shuffled = traces;
    shuffled.iter_mut().for_each(|trace| trace.columns.shuffle(&mut random));
    let other = folder(&shuffled);
    for (call, (now, before)) in
        CALLS.iter().zip(printed(other.path(), &CALLS, "1").iter().zip(&before))
    {
        assert!(now == before, "{call} with other columns first, on one thread");
    }
    // Files in any order on the command line.
    let mut files: Vec<String> =
        shuffled.iter().map(|trace| format!("set/{}", trace.label())).collect();
    files.shuffle(&mut random);
    let listed: Vec<String> =
        CALLS.iter().map(|call| call.replace(" set ", &format!(" {} ", files.join(" ")))).collect();
    let listed: Vec<&str> = listed.iter().map(String::as_str).collect();
    let in_other_order = printed(other.path(), &listed[..3], "2");
    for (call, (now, before)) in CALLS.iter().zip(in_other_order.iter().zip(&before)) {
        assert!(now == before, "{call} with its files in another order");
    }
}

/// Where two answers differ by more than rounding, but for times that are later by [`EPOCH_S`].
fn differences(at: &str, later: &Value, before: &Value, found: &mut Vec<String>) {
    match (later, before) {
        (Value::Object(later), Value::Object(before)) if later.len() == before.len() => {
            for (name, before) in before {
                let later = later.get(name).unwrap_or(&Value::Null);
                differences(&format!("{at}.{name}"), later, before, found);
            }
        }
        (Value::Array(later), Value::Array(before)) if later.len() == before.len() => {
            for (k, (later, before)) in later.iter().zip(before).enumerate() {
                differences(&format!("{at}[{k}]"), later, before, found);
            }
        }
        _ if later == before || is_same(later, before) => {}
        _ => found.push(format!("{at}: {later} from {before}")),
    }
}

fn is_same(later: &Value, before: &Value) -> bool {
    if let Some((later, before)) = later.as_f64().zip(before.as_f64()) {
        return near(later, before) || (later - before - EPOCH_S).abs() < TOLERANCE;
    }
    let Some((later, before)) = later.as_str().zip(before.as_str()) else { return false };
    // Times in words are rounded.
    let later_in_words = |later: &str, before: &str| {
        let times = later.parse::<f64>().ok().zip(before.parse::<f64>().ok());
        times.is_some_and(|(later, before)| (later - before - EPOCH_S).abs() < 0.011)
    };
    later.split(' ').count() == before.split(' ').count()
        && later.split(' ').zip(before.split(' ')).all(|(a, b)| a == b || later_in_words(a, b))
}

/// Calls on the same traces with their clock from 1970.
fn with_a_clock_from_1970(traces: &[Trace], calls: &[&str]) {
    let before = printed(folder(traces).path(), calls, "2");
    let mut later = traces.to_vec();
    later.iter_mut().flat_map(|trace| &mut trace.time).for_each(|time| *time += EPOCH_S);
    let later = printed(folder(&later).path(), calls, "2");
    let mut found = Vec::new();
    for (call, (later, before)) in calls.iter().zip(later.iter().zip(&before)) {
        let read = |text: &String| serde_json::from_str::<Value>(text).unwrap();
        differences(call, &read(later), &read(before), &mut found);
    }
    assert!(
        found.is_empty(),
        "{} differ:\n{}",
        found.len(),
        found[..found.len().min(40)].join("\n")
    );
}

#[test]
fn the_clock_of_a_made_up_set_may_count_from_1970() {
    with_a_clock_from_1970(&measured(66, "mullins")[..4], &CALLS);
}

#[test]
fn the_clock_of_a_recording_may_count_from_1970() {
    let mut trace = palpate::trace::read(&bundled("press.csv")).unwrap();
    let begins = trace.time[0];
    trace.time.iter_mut().for_each(|time| *time -= begins);
    trace.path = Some("press.csv".into());
    let signal = "--signal gauge1_ustrain";
    let calls = [
        format!("fit fung set {signal} -o model.toml --json"),
        "diagnose --model model.toml set --json".into(),
        "segment set --json".into(),
        format!("relaxation set {signal} --json"),
    ];
    let calls: Vec<&str> = calls.iter().map(String::as_str).collect();
    with_a_clock_from_1970(&[trace], &calls);
}
