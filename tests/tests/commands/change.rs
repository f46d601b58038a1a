//! Effects added to a model and taken out again, through the command.

use std::fs;
use std::path::Path;

use palpate::model::{BaseLaw, Model, Motion, Separation};
use palpate::trace::{Column, DISPLACEMENT, FORCE, Trace, write};
use palpate_tests::{palpate, press};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use serde_json::Value;

const LAW: BaseLaw = BaseLaw::fung(2, Separation::Clamp);
const TRUTH: [f64; 6] = [0.08, 0.8, 0.25, 0.24, 4.0, 0.55];
const NOISE: f64 = 0.01;

/// Size, N, and pitch, mm, of what the poles of the drive add to the force.
const COGGING: (f64, f64) = (0.03, 1.7);

/// The law that the user writes for it.
const OWN: &str = r#"
[[candidate]]
name = "cogging"
meaning = "the drive is pulled from pole to pole"
stage = "sensor"
expression = "size * sin(2 * PI * x / pitch + phase)"
[candidate.parameters.size]
value = 0.0
unit = "N"
lower = 0.0
upper = 1.0
[candidate.parameters.pitch]
value = 1.65
unit = "mm"
lower = 0.5
upper = 5.0
[candidate.parameters.phase]
value = 0.5
"#;

/// Four presses by a drive that cogs, as files of a folder.
fn record(folder: &Path) {
    let motions: Vec<Motion> =
        [6.0, 10.0].iter().flat_map(|&x| [10.0, 40.0].map(|speed| press(x, speed, 0.8))).collect();
    let force = LAW.predict(&TRUTH, &motions);
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let normal = Normal::new(0.0, NOISE).unwrap();
    for (number, (motion, force)) in motions.into_iter().zip(force).enumerate() {
        let cogging = |x: f64| COGGING.0 * (std::f64::consts::TAU * x / COGGING.1 + 0.3).sin();
        let measured = motion.displacement.iter().zip(force);
        let measured = measured.map(|(&x, f)| f + cogging(x) + normal.sample(&mut random));
        let columns = vec![
            Column { name: FORCE.into(), values: measured.collect() },
            Column { name: DISPLACEMENT.into(), values: motion.displacement.into_owned() },
        ];
        let trace = Trace { time: motion.time.into_owned(), columns, ..Trace::default() };
        write(&folder.join(format!("take-{number}.csv")), &trace).unwrap();
    }
}

/// Exit status, standard output and standard error of a call in a folder.
fn call(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = palpate().current_dir(folder).args(arguments).output().expect("palpate runs");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().expect("an exit status"), text(&output.stdout), text(&output.stderr))
}

/// A folder `takes/` of recordings, a model fitted to them, and the same with a law of one's own.
fn place() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("takes")).unwrap();
    record(&folder.path().join("takes"));
    let (status, _, error) =
        call(folder.path(), &["fit", "fung", "takes", "-o", "model.toml", "--json"]);
    assert_eq!(status, 0, "{error}");
    let model = fs::read_to_string(folder.path().join("model.toml")).unwrap();
    fs::write(folder.path().join("own.toml"), model + OWN).unwrap();
    folder
}

fn read(folder: &Path, name: &str) -> Model {
    Model::read(&folder.join(name)).unwrap()
}

#[test]
fn a_law_of_ones_own_is_fitted_and_the_ladder_falls_to_the_noise() {
    let place = place();
    let folder = place.path();
    let add = ["add", "cogging", "own.toml", "takes", "-o", "better.toml", "--json"];
    let (status, out, error) = call(folder, &add);
    assert_eq!(status, 0, "{error}");
    let answer: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(answer["notes"].as_array().unwrap().len(), 0, "{answer}");
    let better = read(folder, "better.toml");
    let [base, rung] = &better.ladder[..] else { panic!("{:?}", better.ladder) };
    assert_eq!((&*base.add, &*rung.add), ("fung", "cogging"));
    assert!(base.fitted_rms > 1.5 * NOISE, "{base:?}");
    assert!((rung.fitted_rms / NOISE - 1.0).abs() < 0.05, "{rung:?}");
    assert!((rung.heldout_rms.unwrap() / NOISE - 1.0).abs() < 0.05, "{rung:?}");
    let effect = &better.effects[0];
    for (name, truth) in [("size", COGGING.0), ("pitch", COGGING.1), ("phase", 0.3)] {
        let found = &effect.parameters[name];
        let off = (found.value - truth).abs() / found.standard_error.unwrap();
        assert!(off < 4.0, "{name} = {} is {off} standard errors off", found.value);
    }
    assert_eq!(effect.meaning.as_deref(), Some("the drive is pulled from pole to pole"));
    assert!(better.candidates.is_empty());

    // The better model needs nothing else to be compared, and comes back when the law is taken out.
    assert_eq!(call(folder, &["compare", "better.toml", "takes", "--json"]).0, 0);
    let drop = ["drop", "cogging", "better.toml", "takes", "-o", "back.toml", "--report", "d.html"];
    let (status, out, error) = call(folder, &drop);
    assert_eq!(status, 0, "{error}");
    assert!(out.contains("The ladder") && out.contains("[[candidate]]"), "{out}");
    let back = read(folder, "back.toml");
    assert_eq!((back.effects.len(), back.candidates.len(), back.ladder.len()), (0, 1, 1));
    let first = &read(folder, "model.toml").ladder[0];
    assert!((back.ladder[0].fitted_rms / first.fitted_rms - 1.0).abs() < 1e-4);
}

#[test]
fn what_a_law_is_given_is_no_parameter_to_be_warned_of() {
    let place = place();
    let add = ["add", "viscous-drag", "--law", "power", "model.toml", "takes", "-o", "drag.toml"];
    let (status, out, error) = call(place.path(), &add);
    assert_eq!(status, 0, "{error}");
    let lines: Vec<&str> = out.lines().filter(|line| line.contains("full_speed")).collect();
    assert!(matches!(lines[..], [line] if line.contains("given, not fitted")), "{out}");
}

#[test]
fn an_effect_of_the_library_is_added_beside_another_and_taken_from_below() {
    let place = place();
    let folder = place.path();
    for (name, from, to) in
        [("viscous-drag", "own.toml", "one.toml"), ("cogging", "one.toml", "two.toml")]
    {
        let (status, _, error) = call(folder, &["add", name, from, "takes", "-o", to, "--json"]);
        assert_eq!(status, 0, "{error}");
    }
    let names = |model: &Model| -> Vec<String> {
        model.ladder.iter().map(|rung| rung.add.clone()).collect()
    };
    assert_eq!(names(&read(folder, "two.toml")), ["fung", "viscous-drag", "cogging"]);
    let drop = ["drop", "viscous-drag", "two.toml", "takes", "-o", "left.toml", "--json"];
    let (status, _, error) = call(folder, &drop);
    assert_eq!(status, 0, "{error}");
    let left = read(folder, "left.toml");
    assert_eq!(names(&left), ["fung", "cogging"]);
    assert!((left.ladder[1].fitted_rms / NOISE - 1.0).abs() < 0.05, "{:?}", left.ladder);
}

#[test]
fn a_ladder_from_other_traces_is_fitted_anew_and_said_to_be() {
    let place = place();
    let folder = place.path();
    let (status, out, error) =
        call(folder, &["add", "cogging", "own.toml", "takes/take-1.csv", "-o", "better.toml"]);
    assert_eq!(status, 0, "{error}");
    assert!(out.contains("fitted to other traces"), "{out}");
    let better = read(folder, "better.toml");
    assert_eq!(better.fit.as_ref().unwrap().traces, ["take-1.csv"]);
    assert!(better.ladder.iter().all(|rung| rung.heldout_rms.is_none()));
    assert!(better.ladder[1].fitted_rms < 0.8 * better.ladder[0].fitted_rms);
}

#[test]
fn what_cannot_be_added_or_taken_out_is_refused() {
    let place = place();
    let folder = place.path();
    let broken = |expression: &str| {
        let own = fs::read_to_string(folder.join("own.toml")).unwrap();
        let own = own.replace("size * sin(2 * PI * x / pitch + phase)", expression);
        fs::write(folder.join("broken.toml"), own).unwrap();
    };
    let refused = |arguments: &[&str], words: &[&str]| {
        let (status, out, error) = call(folder, &[arguments, &["-o", "no.toml"]].concat());
        assert_eq!((status, out.as_str()), (2, ""), "{arguments:?}: {error}");
        for word in words {
            assert!(error.contains(word), "{arguments:?}: no {word:?} in\n{error}");
        }
        assert!(!folder.join("no.toml").exists(), "{arguments:?}");
    };
    refused(&["add", "coging", "own.toml", "takes"], &["coging", "[[candidate]]", "effects"]);
    refused(&["add", "thermal-output", "own.toml", "takes"], &["temperature_C"]);
    refused(&["add", "mullins", "own.toml", "takes", "--law", "x"], &["`x`", "energy"]);
    refused(&["drop", "mullins", "own.toml", "takes"], &["not in the model", "none"]);
    broken("size * sin(2 * PI * y / pitch)");
    refused(
        &["add", "cogging", "broken.toml", "takes"],
        &["`y` is unknown", "pitch", "\n                      ^"],
    );
    broken("size * sin(2 * PI * x / pitch");
    refused(&["add", "cogging", "broken.toml", "takes"], &["never closed", "^"]);
    broken("size * tnah(x / pitch + phase)");
    refused(
        &["add", "cogging", "broken.toml", "takes"],
        &["no function `tnah`; did you mean `tanh`?", "^"],
    );
}

#[test]
fn a_model_that_would_be_worse_is_not_written() {
    let place = place();
    let folder = place.path();
    // Vast wherever its parameters may go: no fit can take it away.
    let own = fs::read_to_string(folder.join("own.toml")).unwrap();
    let own = own
        .replace(
            "size * sin(2 * PI * x / pitch + phase)",
            "size * exp(pitch * x^2) * (1 + phase^2)",
        )
        .replace("lower = 0.0\nupper = 1.0", "lower = 0.5\nupper = 1.0");
    fs::write(folder.join("vast.toml"), own).unwrap();
    let add = ["add", "cogging", "vast.toml", "takes", "-o", "no.toml"];
    let (status, out, error) = call(folder, &add);
    assert_eq!((status, out.as_str()), (1, ""), "{error}");
    assert!(error.contains("worse") && error.contains("rises from 0.0"), "{error}");
    assert!(!folder.join("no.toml").exists());
}
