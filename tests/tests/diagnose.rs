//! What the command says of a model that lacks something, and of one that lacks nothing.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use palpate::effects::find;
use palpate::fit::data::Data;
use palpate::fit::whole_motion::predict;
use palpate::model::{BaseLaw, Chain, Motion, Separation};
use palpate::trace::{Column, DISPLACEMENT, FORCE, Trace, write};
use palpate_tests::{cycles, palpate, press};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use serde_json::Value;

const LAW: BaseLaw = BaseLaw::fung(2, Separation::Clamp);
/// p, q, c1, c2, v1, v2 of the specimen.
const TRUTH: [f64; 6] = [0.08, 0.8, 0.25, 0.24, 4.0, 0.55];
/// Depth and width, mm, of the Mullins effect.
const MULLINS: [f64; 2] = [0.12, 3.0];
/// Standard deviation of the noise, N, and its correlation between neighbours.
const NOISE: (f64, f64) = (0.01, 0.4);

/// Folders with a data set each and the base law fitted to it: with the Mullins effect, and without.
struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Exit status, standard output and standard error of a call in the folder.
    fn call(&self, line: &str) -> (i32, String, String) {
        let mut command = palpate();
        let output = command.current_dir(self.folder.path()).args(line.split(' ')).output();
        let output = output.expect("palpate runs");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.code().expect("a status"), text(&output.stdout), text(&output.stderr))
    }

    fn json(&self, line: &str) -> Value {
        let (status, out, err) = self.call(line);
        assert_eq!(status, 0, "{line}: {err}");
        serde_json::from_str(&out).expect("one JSON object")
    }
}

fn place() -> &'static Place {
    static PLACE: OnceLock<Place> = OnceLock::new();
    PLACE.get_or_init(|| {
        let place = Place { folder: tempfile::tempdir().expect("a folder") };
        record(&place.path("hidden"), &[("mullins", &MULLINS)], 1);
        record(&place.path("plain"), &[], 2);
        for name in ["hidden", "plain"] {
            let (status, _, err) = place.call(&format!("fit fung {name} -o {name}.toml"));
            assert_eq!(status, 0, "{err}");
        }
        place
    })
}

/// Writes five presses of a specimen with these effects, with correlated noise.
fn record(folder: &Path, effects: &[(&str, &[f64])], seed: u64) {
    let steps = [(4.0, 20.0), (8.0, 5.0), (12.0, 60.0), (8.0, 20.0), (12.0, 5.0)];
    let presses = steps.into_iter().map(|(to_mm, speed)| press(to_mm, speed, 1.5)).collect();
    record_motions(folder, presses, effects, seed);
}

/// Writes a trace of each motion, of a specimen with these effects in their first law, with correlated noise.
fn record_motions(
    folder: &Path,
    motions: Vec<Motion<'static>>,
    effects: &[(&str, &[f64])],
    seed: u64,
) {
    std::fs::create_dir_all(folder).expect("a folder");
    let mut traces: Vec<Trace> = motions
        .into_iter()
        .map(|motion| {
            let displacement = motion.displacement.into_owned();
            let columns = vec![Column { name: DISPLACEMENT.into(), values: displacement }];
            Trace { time: motion.time.into_owned(), columns, ..Trace::default() }
        })
        .collect();
    let forces = {
        let data = Data::of_motions(&traces, FORCE).expect("motions");
        let mut chain = Chain::new(LAW);
        let mut values = TRUTH.to_vec();
        for (name, parameters) in effects {
            let effect = find(name).expect("an effect of the library");
            chain = chain.with(effect.laws[0].applied(effect, &data.setting()));
            values.extend_from_slice(parameters);
        }
        predict(&chain, &values, &data)
    };
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let normal = Normal::new(0.0, 1.0).expect("a deviation");
    let (size, correlation) = NOISE;
    let fresh = size * (1.0 - correlation * correlation).sqrt();
    for (index, (trace, force)) in traces.iter_mut().zip(forces).enumerate() {
        let mut error = size * normal.sample(&mut random);
        let measured = force.into_iter().map(|force| {
            error = correlation * error + fresh * normal.sample(&mut random);
            force + error
        });
        let values = measured.collect();
        trace.columns.push(Column { name: FORCE.into(), values });
        write(&folder.join(format!("{}.csv", index + 1)), trace).expect("a trace is written");
    }
}

/// Every key of the format, with its type.
fn check_format(answer: &Value) {
    let number = |value: &Value| assert!(value.as_f64().is_some_and(f64::is_finite), "{answer:#}");
    let text = |value: &Value| assert!(value.is_string(), "{answer:#}");
    assert_eq!(answer["palpate_diagnosis"], 1);
    let verdict = answer["verdict"].as_str().expect("a verdict");
    assert!(["adequate", "named", "ambiguous", "unknown"].contains(&verdict));
    text(&answer["unit"]);
    for key in ["noise_rms", "given_rms", "base_rms", "final_rms"] {
        number(&answer[key]);
    }
    let in_newtons = answer["unit"] == "N";
    for key in ["noise_rms", "base_rms", "final_rms"] {
        let old = &answer[format!("{key}_N")];
        assert_eq!(old, if in_newtons { &answer[key] } else { &Value::Null });
    }
    for step in answer["steps"].as_array().expect("steps") {
        text(&step["effect"]);
        let set = step["credible_set"].as_array().expect("a credible set");
        assert_eq!(set[0], step["effect"]);
        set.iter().for_each(text);
        let parameters = step["parameters"].as_object().expect("parameters");
        assert!(!parameters.is_empty());
        for parameter in parameters.values() {
            number(&parameter["value"]);
            assert!(parameter["standard_error"].is_null() || parameter["standard_error"].is_f64());
        }
        for rival in step["rivals"].as_array().expect("rivals") {
            let own = find(rival["effect"].as_str().expect("a name"));
            let has_law = own.is_none_or(|own| own.laws.iter().any(|law| rival["law"] == law.name));
            assert!(has_law, "a law of another effect: {rival:#}");
        }
        for key in ["rms_before", "rms_after", "delta_bic", "p_value"] {
            number(&step[key]);
        }
        for key in ["heldout_rms_before", "heldout_rms_after"] {
            assert!(step[key].is_null() || step[key].is_f64(), "{step:#}");
        }
        for key in ["rms_before", "rms_after", "heldout_rms_before", "heldout_rms_after"] {
            let old = &step[format!("{key}_N")];
            assert_eq!(old, if in_newtons { &step[key] } else { &Value::Null });
        }
    }
    let places = answer["where"].as_array().expect("places");
    assert!(!places.is_empty());
    for place in places {
        text(&place["trace"]);
        text(&place["phase"]);
        number(&place["share_of_excess"]);
        number(&place["rms"]);
        assert_eq!(place["rms_N"].is_number(), in_newtons);
    }
    for untestable in answer["untestable"].as_array().expect("untestable effects") {
        text(&untestable["effect"]);
        text(&untestable["reason"]);
    }
    let experiment = &answer["next_experiment"];
    assert_eq!(["ambiguous", "unknown"].contains(&verdict), experiment.is_string(), "{answer:#}");
}

#[test]
fn a_hidden_effect_is_named_with_its_size() {
    let answer = place().json("diagnose --model hidden.toml hidden --json");
    check_format(&answer);
    assert_eq!(answer["verdict"], "named", "{answer:#}");
    let [step] = &answer["steps"].as_array().expect("steps")[..] else { panic!("{answer:#}") };
    assert_eq!(step["effect"], "mullins");
    for (name, truth) in ["depth", "width"].into_iter().zip(MULLINS) {
        let found = &step["parameters"][name];
        let [value, error] = ["value", "standard_error"].map(|key| found[key].as_f64().unwrap());
        assert!((value - truth).abs() < 4.0 * error, "{name}: {value} ± {error}");
    }
    let rms = |key: &str| answer[key].as_f64().unwrap();
    assert!(rms("final_rms_N") < 1.05 * rms("noise_rms_N"));
    assert!(rms("base_rms_N") > 1.3 * rms("noise_rms_N"));
    assert!((rms("noise_rms_N") / NOISE.0 - 1.0).abs() < 0.15);
    assert!(step["heldout_rms_after_N"].as_f64() < step["heldout_rms_before_N"].as_f64());
}

#[test]
fn where_nothing_is_missing_nothing_is_named() {
    let answer = place().json("diagnose --model plain.toml plain --json");
    check_format(&answer);
    assert_eq!(answer["verdict"], "adequate", "{answer:#}");
    assert_eq!(answer["steps"].as_array().map(Vec::len), Some(0));
    assert_eq!(answer["base_rms_N"], answer["final_rms_N"]);
    let (status, out, _) = place().call("diagnose --model plain.toml plain");
    assert_eq!(status, 0);
    assert!(out.contains("Nothing is missing") && !out.contains("palpate add"), "{out}");
}

/// What `diagnose` says of three series of cycles, each at a speed of its own, with an effect of these parameters.
fn of_cycles(name: &str, effect: &str, parameters: &[f64], seed: u64) -> Value {
    let place = place();
    let series = [(10.0, 2.0), (4.0, 5.0), (6.0, 10.0)];
    let motions = series.map(|(to_mm, speed)| cycles(to_mm, speed, 3)).into();
    record_motions(&place.path(name), motions, &[(effect, parameters)], seed);
    let (status, _, err) = place.call(&format!("fit fung {name} -o {name}.toml"));
    assert_eq!(status, 0, "{err}");
    place.json(&format!("diagnose --model {name}.toml {name} --json"))
}

#[test]
fn a_parameter_that_the_data_leave_open_denies_no_effect() {
    // Sliding is complete far below every speed of the motion, wherever exactly.
    for seed in 1..4 {
        let answer = of_cycles(&format!("rubbed-{seed}"), "load-friction", &[0.03, 0.05], seed);
        assert_eq!(answer["verdict"], "named", "{seed}: {answer:#}");
        assert_eq!(answer["steps"][0]["effect"], "load-friction");
    }
}

/// One model on one data set has one error and one noise.
#[test]
fn every_command_tells_the_same_error_and_the_same_noise() {
    let told = [
        ("fit fung hidden --json", "residual_rms"),
        ("compare hidden.toml hidden --json", "rms"),
        ("diagnose --model hidden.toml hidden --json", "given_rms"),
        ("add mullins hidden.toml hidden -o added.toml --json", "rms_before"),
    ];
    let answers = told.map(|(line, key)| {
        let answer = place().json(line);
        [key, "noise_rms"].map(|key| answer[key].as_f64().expect("a number"))
    });
    for (found, (line, _)) in answers.iter().zip(told) {
        for (found, expected) in found.iter().zip(&answers[0]) {
            assert!((found / expected - 1.0).abs() < 1e-6, "{line}: {found} for {expected}");
        }
    }
}

#[test]
fn one_trace_has_no_held_out_error() {
    let answer = place().json("diagnose --model hidden.toml hidden/5.csv --json");
    check_format(&answer);
    // It has rest off the specimen, in which its noise is seen.
    assert_eq!(answer["noise"]["seen_off_the_specimen"], true, "{answer:#}");
    assert!(!answer["notes"].to_string().contains("does not show its noise"), "{answer:#}");
    for step in answer["steps"].as_array().expect("steps") {
        assert!(step["heldout_rms_before_N"].is_null() && step["heldout_rms_after_N"].is_null());
    }
}

#[test]
fn the_terminal_says_what_is_missing_how_sure_and_what_to_do_next() {
    let (status, out, _) = place().call("diagnose --model hidden.toml hidden --report d.html");
    assert_eq!(status, 0);
    let first = out.lines().next().unwrap_or_default();
    assert!(first.starts_with("=> mullins is missing. The error falls from 0.0"), "{out}");
    assert!(out.contains("palpate add mullins hidden.toml hidden -o better.toml"), "{out}");
    let report = std::fs::read_to_string(place().path("d.html")).expect("a report");
    for words in ["Evidence for mullins", "cyclic-softening", "Ljung–Box", "crosstalk"] {
        assert!(report.contains(words), "no {words}");
    }
}

#[test]
fn explore_climbs_to_a_model_that_leaves_only_noise() {
    let line = "explore --model hidden.toml hidden -o better.toml";
    let (status, out, err) = place().call(line);
    assert_eq!(status, 0, "{err}");
    assert!(out.contains("rung 1: + mullins") && out.contains("Only noise is left."), "{out}");
    let comparison = place().json("compare better.toml hidden --json");
    assert_eq!(comparison["only_noise"], true, "{comparison:#}");
    let better: toml::Table = std::fs::read_to_string(place().path("better.toml"))
        .expect("a model")
        .parse()
        .expect("a model is TOML");
    let added: Vec<&str> = better["ladder"]
        .as_array()
        .expect("a ladder")
        .iter()
        .filter_map(|rung| rung["add"].as_str())
        .collect();
    assert_eq!(added, ["fung", "mullins"]);
    assert!(better["ladder"][1]["heldout_rms"].is_float());
    assert!(better["effect"][0]["parameters"]["depth"]["standard_error"].is_float());
    // From there, nothing is missing any more.
    let again = place().json("explore --model better.toml hidden -o best.toml --json");
    check_format(&again);
    assert_eq!((&again["verdict"], &again["model"]), (&"adequate".into(), &"best.toml".into()));
}

#[test]
fn bad_input_ends_with_status_2_and_nothing_on_standard_output() {
    let place = place();
    std::fs::write(place.path("bad.csv"), "time_s,displacement_mm\n0,0\n1,1\n2,0\n").unwrap();
    let model = std::fs::read_to_string(place.path("plain.toml")).unwrap();
    let effect = "\n[[effect]]\nname = \"mulins\"\n";
    std::fs::write(place.path("misspelt.toml"), model.clone() + effect).unwrap();
    let own = "\n[[candidate]]\nname = \"own\"\nstage = \"contact\"\nexpression = \"k * y\"\n\
               [candidate.parameters.k]\nvalue = 0.1\n";
    std::fs::write(place.path("own.toml"), model + own).unwrap();
    for command in ["diagnose", "explore"] {
        for (rest, words) in [
            ("--model absent.toml plain", "absent.toml"),
            ("--model plain.toml absent", "absent"),
            ("--model plain.toml bad.csv", "force_N"),
            ("--model misspelt.toml plain", "mulins"),
            ("--model own.toml plain", "`y` is unknown"),
            ("plain", "--model"),
        ] {
            let (status, out, err) = place.call(&format!("{command} {rest} --json"));
            assert_eq!((status, out.as_str()), (2, ""), "{command} {rest}: {err}");
            assert!(err.contains("error") && err.contains(words), "{command} {rest}: {err}");
        }
    }
}

#[test]
fn errors_of_a_gauge_are_told_in_its_unit_not_in_newtons() {
    let folder = tempfile::tempdir().unwrap();
    let press = concat!(env!("CARGO_MANIFEST_DIR"), "/traces/press.csv");
    let model = folder.path().join("gauge.toml");
    let fit = palpate()
        .args(["fit", "fung", press, "--signal", "gauge1_ustrain", "--json", "-o"])
        .arg(&model)
        .output()
        .unwrap();
    assert!(fit.status.success(), "{}", String::from_utf8_lossy(&fit.stderr));
    let answer = palpate().args(["diagnose", press, "--json", "--model"]).arg(&model).output();
    let answer = answer.unwrap();
    assert!(answer.status.success(), "{}", String::from_utf8_lossy(&answer.stderr));
    let text = String::from_utf8(answer.stdout).unwrap();
    check_format(&serde_json::from_str(&text).unwrap());
    assert!(!text.contains("_N\""), "{text}");
}
