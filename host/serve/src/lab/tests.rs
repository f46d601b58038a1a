use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::own_law::OwnLaw;
use super::session::Session;
use super::task::Task;
use super::{LabError, View};
use palpate_diagnose::criticism::{change, compare::compare};
use palpate_diagnose::practice::{Choice, hide, write_set};
use palpate_model::Model;
use palpate_present::answers::{self, ChangeAnswer, ComparisonAnswer};
use palpate_trace::read_set;

/// A folder with a hidden effect in it.
fn practice(effect: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let made = hide(&Choice::Named(vec![effect.into()]), 1.0, 3).unwrap();
    write_set(folder.path(), &made).unwrap();
    folder
}

fn task(value: Value) -> Task {
    serde_json::from_value(value).unwrap()
}

/// Waits for what is at work.
fn wait(session: &mut Session) -> Value {
    let begun = Instant::now();
    while !session.progress()["job"].is_null() {
        assert!(begun.elapsed() < Duration::from_secs(240), "it takes too long");
        std::thread::sleep(Duration::from_millis(20));
    }
    session.state()
}

fn done(session: &mut Session, wanted: Value) -> Value {
    session.start(task(wanted)).unwrap();
    let state = wait(session);
    assert_eq!(state["failed"], Value::Null);
    state
}

fn view(trace: usize) -> View {
    View { trace, from: None, to: None, width: 100 }
}

#[test]
fn a_hidden_effect_is_found_and_added_until_the_ladder_is_at_the_noise_floor() {
    let folder = practice("coulomb-friction");
    let mut session = Session::open(folder.path(), None).unwrap();
    assert_eq!(session.state()["traces"].as_array().unwrap().len(), 10);
    assert!(session.overlay(&view(0)).unwrap().get("predicted").is_none());
    let state = done(&mut session, json!({"fit": {"law": "fung"}}));
    assert_eq!(state["comparison"]["only_noise"], false);
    let overlay = session.overlay(&view(0)).unwrap();
    assert_eq!(overlay["time"].as_array().unwrap().len(), 200);
    assert_eq!(overlay["residual"].as_array().unwrap().len(), 200);
    let closer = session.closer(0).unwrap();
    let course = &closer["loop"][0];
    let points = |name: &str| course[name].as_array().unwrap().len();
    assert!(points("displacement") > 500 && points("displacement") <= 1500);
    assert_eq!(points("displacement"), points("measured"));
    assert_eq!(closer["residual"]["correlation"][0], 1.0);
    // What friction leaves lasts much longer than the noise.
    let later = |name: &str| closer["residual"][name][3].as_f64().unwrap();
    assert!(later("correlation") > later("noise_correlation") + 0.2, "{closer}");
    assert!(session.closer(99).is_err());

    let state = done(&mut session, json!("diagnose"));
    let diagnosis = &state["answers"]["diagnosis"];
    assert_eq!(diagnosis["verdict"], "named", "{}", diagnosis["in_words"]);
    assert_eq!(diagnosis["steps"][0]["effect"], "coulomb-friction");
    let candidates = state["answers"]["candidates"]["list"].as_array().unwrap();
    assert!(candidates[0]["picture"].is_array() && candidates[0]["experiment"].is_string());
    let before = state["comparison"]["rms"].as_f64().unwrap();
    let forecast = session.forecast("coulomb-friction", &view(0)).unwrap();
    let foretold = forecast["rms"].as_f64().unwrap();
    assert!(foretold < 0.9 * before, "{foretold} after {before}");

    let state = done(&mut session, json!({"add": {"effect": "coulomb-friction"}}));
    let ladder = state["model"]["ladder"].as_array().unwrap();
    assert_eq!(ladder.len(), 2);
    let noise = state["comparison"]["noise_rms"].as_f64().unwrap();
    assert!(ladder[1]["fitted_rms"].as_f64().unwrap() < 1.1 * noise);
    assert!(ladder[1]["heldout_rms"].as_f64().unwrap() < 1.1 * noise);
    assert_eq!(state["comparison"]["only_noise"], true);

    // The command line says the same.
    let traces = read_set(&[folder.path()]).unwrap();
    let saved = session.save(None).unwrap();
    let model = Model::read(Path::new(saved["file"].as_str().unwrap())).unwrap();
    let same = answers::json(&ComparisonAnswer::from(&compare(&model, &traces).unwrap()));
    assert_eq!(state["comparison"]["where"], same["where"]);
    assert_eq!(state["comparison"]["in_words"], same["in_words"]);
    let page = session.report("change").unwrap();
    let command = state["versions"][1]["command"].as_str().unwrap();
    assert!(command.starts_with("palpate add coulomb-friction "), "{command}");
    assert!(page["html"].as_str().unwrap().contains("palpate add coulomb-friction"));

    assert_eq!(session.reveal().unwrap()["effects"][0]["effect"], "coulomb-friction");
    session.undo().unwrap();
    let state = wait(&mut session);
    assert_eq!(state["versions"].as_array().unwrap().len(), 1);
    let base: Model = serde_json::from_value(state["model"].clone()).unwrap();
    let change = change::add(&base, "coulomb-friction", None, &traces).unwrap();
    let answer = answers::json(&ChangeAnswer::from(&change));
    let state = done(&mut session, json!({"add": {"effect": "coulomb-friction"}}));
    assert_eq!(state["answers"]["change"], answer);
    let state = done(&mut session, json!({"drop": {"effect": "coulomb-friction"}}));
    assert_eq!(state["model"]["effect"], Value::Null);
    assert!(matches!(session.forecast("mullins", &view(0)), Err(LabError::NoForecast(_))));
}

#[test]
fn what_is_at_work_is_cancelled_at_once_and_the_model_stays_as_it_was() {
    let folder = practice("mullins");
    let mut session = Session::open(folder.path(), None).unwrap();
    done(&mut session, json!({"fit": {"law": "kelvin-voigt"}}));
    let model = session.state()["model"].clone();
    session.start(task(json!("diagnose"))).unwrap();
    assert!(matches!(session.start(task(json!("compare"))), Err(LabError::Busy)));
    assert!(session.progress()["job"]["command"].as_str().unwrap().contains("diagnose"));
    session.cancel();
    assert_eq!(session.progress(), json!({"job": null, "failed": "cancelled"}));
    assert_eq!(session.state()["model"], model);
    done(&mut session, json!("compare"));
}

#[test]
fn work_that_is_given_up_ends_before_it_is_done() {
    let folder = practice("mullins");
    let mut session = Session::open(folder.path(), None).unwrap();
    done(&mut session, json!({"fit": {"law": "fung"}}));
    let state = session.state();
    let model: Model = serde_json::from_value(state["model"].clone()).unwrap();
    let traces = read_set(&[folder.path()]).unwrap();
    let watch = std::sync::Arc::new(palpate_fit::watch::Watch::default());
    watch.end();
    let begun = Instant::now();
    let given_up = palpate_fit::watch::under(&watch, || {
        palpate_diagnose::criticism::diagnose::diagnose(&model, &traces).is_ok()
    });
    let short = begun.elapsed();
    assert!(given_up.is_ok());
    assert!(short < Duration::from_secs(10), "{short:?}");
}

#[test]
fn a_law_with_a_typing_error_is_refused_with_its_place_and_a_right_one_can_be_added() {
    let law = |expression: &str| -> OwnLaw {
        let value = json!({
            "name": "pull", "stage": "contact", "expression": expression,
            "parameters": [{"name": "k", "value": 0.0, "unit": "N"}],
        });
        serde_json::from_value(value).unwrap()
    };
    let unknown = law("k * tanh(vv)").fault().unwrap();
    assert_eq!((unknown["at"].as_u64(), unknown["length"].as_u64()), (Some(9), Some(2)));
    assert!(law("k * (v").fault().unwrap()["at"].is_number());
    let wrong = OwnLaw { name: "mullins".into(), ..law("k * tanh(v)") };
    assert!(wrong.fault().unwrap()["message"].as_str().unwrap().contains("library"));
    assert!(law("k * tanh(v)").fault().is_none());
    assert!(law("k * tanh(v)").toml().contains("[[candidate]]"));

    let folder = practice("coulomb-friction");
    let mut session = Session::open(folder.path(), None).unwrap();
    assert!(matches!(session.add_candidate(&law("k * tanh(v)")), Err(LabError::NoModel)));
    done(&mut session, json!({"fit": {"law": "fung"}}));
    assert!(matches!(session.add_candidate(&law("k * tanh(")), Err(LabError::Law(_))));
    session.add_candidate(&law("k * tanh(v)")).unwrap();
    let before = session.state()["comparison"]["rms"].as_f64().unwrap();
    let state = done(&mut session, json!({"add": {"effect": "pull"}}));
    assert!(state["comparison"]["rms"].as_f64().unwrap() < before);
    assert_eq!(state["model"]["effect"][0]["expression"], "k * tanh(v)");
}

#[test]
fn nothing_outside_the_folder_is_opened_or_written() {
    let above = tempfile::tempdir().unwrap();
    let folder = above.path().join("traces");
    let made = hide(&Choice::Named(vec!["mullins".into()]), 1.0, 3).unwrap();
    write_set(&folder, &made).unwrap();
    write_set(&above.path().join("other"), &made).unwrap();
    let mut session = Session::open(&folder, None).unwrap();
    for name in ["..", "../other", "/etc", "a/../../other", "./..", "."] {
        let refused = session.choose_set(name);
        assert!(matches!(refused, Err(LabError::Outside(_))), "{name}: {refused:?}");
        assert!(matches!(session.open_model(name), Err(LabError::Outside(_))), "{name}");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(above.path().join("other"), folder.join("link")).unwrap();
        assert!(matches!(session.choose_set("link"), Err(LabError::Outside(_))));
    }
    session.choose_set("").unwrap();
    assert_eq!(wait(&mut session)["failed"], Value::Null);
    done(&mut session, json!({"fit": {"law": "maxwell"}}));
    for name in ["../model.toml", "/tmp/model.toml", "../other/model.toml"] {
        assert!(matches!(session.save(Some(name)), Err(LabError::Outside(_))), "{name}");
    }
    assert!(session.save(Some("model.html")).is_err());
    assert_eq!(std::fs::read_dir(above.path()).unwrap().count(), 2);
    session.save(Some("mine.toml")).unwrap();
    assert!(folder.join("mine.toml").is_file());
}

#[test]
fn a_practice_set_is_made_below_the_folder_and_its_command_names_the_seed() {
    let folder = tempfile::tempdir().unwrap();
    let mut session = Session::open(folder.path(), None).unwrap();
    assert!(matches!(session.start(task(json!("compare"))), Err(LabError::NoTraces)));
    session.start(task(json!({"hide": {"seed": 5}}))).unwrap();
    let command = session.progress()["job"]["command"].as_str().unwrap().to_owned();
    assert!(command.contains("palpate hide --seed 5 -o "), "{command}");
    let state = wait(&mut session);
    assert_eq!((&state["set"], &state["practice"]), (&json!("practice-5"), &json!(true)));
    assert_eq!(state["traces"].as_array().unwrap().len(), 10);
    session.choose_traces(&[0, 3]).unwrap();
    let command = session.command(&task(json!({"fit": {"law": "fung"}}))).unwrap();
    assert!(command.contains(".csv") && command.ends_with("model-1.toml"), "{command}");
}

/// Two traces that are none, beside one that is.
fn spoiled() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("a.csv"), "time_s,displacement_mm,force_N\n0,0,0\n1,1,1\n2,2,3\n").unwrap();
    std::fs::write(at("b.csv"), "zeit;kraft\n0;1\n").unwrap();
    std::fs::write(at("c.csv"), "").unwrap();
    folder
}

#[test]
fn what_cannot_be_read_is_left_out_with_its_reason_and_the_rest_opens() {
    let folder = spoiled();
    let mut session = Session::open(folder.path(), None).unwrap();
    let state = session.state();
    assert_eq!(state["traces"].as_array().unwrap().len(), 1);
    let left_out = state["left_out"].as_array().unwrap();
    assert_eq!((&left_out[0]["name"], &left_out[1]["name"]), (&json!("b.csv"), &json!("c.csv")));
    assert!(left_out[0]["why"].as_str().unwrap().contains("semicolons"), "{left_out:?}");
    assert!(left_out[1]["why"].as_str().unwrap().contains("no samples"), "{left_out:?}");
    // A command that named the folder would not read it.
    let command = session.command(&task(json!({"fit": {"law": "fung"}}))).unwrap();
    assert!(command.contains("a.csv"), "{command}");
}

#[test]
fn two_traces_that_claim_one_place_are_not_both_taken() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.csv", "b.csv"] {
        let text = "# [setup]\n# sequence = 2\ntime_s,displacement_mm,force_N\n0,0,0\n1,1,1\n";
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let session = Session::open(folder.path(), None).unwrap();
    let [(name, why)] = session.left_out() else { panic!("{:?}", session.left_out()) };
    assert!(name == "b.csv" && why.contains("sequence = 2"), "{name}: {why}");
}

#[cfg(unix)]
#[test]
fn no_link_leads_out_of_the_folder_to_read_or_to_write() {
    use std::os::unix::fs::symlink;

    let outside = tempfile::tempdir().unwrap();
    let secret = outside.path().join("secret.csv");
    std::fs::write(&secret, "a secret first line\n").unwrap();
    let folder = spoiled();
    let at = |name: &str| folder.path().join(name);
    symlink(&secret, at("d.csv")).unwrap();
    symlink("a.csv", at("e.csv")).unwrap();
    symlink(outside.path().join("model.toml"), at("new.toml")).unwrap();
    let mut session = Session::open(folder.path(), None).unwrap();
    let state = session.state().to_string();
    assert!(!state.contains("secret first"), "{state}");
    let why = |file: &str| {
        let found = session.left_out().iter().find(|(name, _)| name == file);
        found.map(|(_, why)| why.as_str()).unwrap_or_default()
    };
    assert!(why("d.csv").contains("not in the folder"), "{state}");
    assert!(why("e.csv").contains("same file as `a.csv`"), "{state}");

    let text = "palpate-model = 1\n[base]\nlaw = \"maxwell\"\nsignal = \"force_N\"\n\
                [base.parameters]\nk = { value = 1.0 }\neta = { value = 1.0 }\n";
    std::fs::write(at("model.toml"), text).unwrap();
    std::fs::write(at("notes.toml"), "mine = true\n").unwrap();
    session.open_model("model.toml").unwrap();
    assert!(matches!(session.save(Some("new.toml")), Err(LabError::Outside(_))));
    assert!(!outside.path().join("model.toml").exists());
    assert!(matches!(session.save(Some("notes.toml")), Err(LabError::Foreign(_))));
    assert_eq!(std::fs::read(at("notes.toml")).unwrap(), b"mine = true\n");
    session.save(Some("model.toml")).unwrap();
}
