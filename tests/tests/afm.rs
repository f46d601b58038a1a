//! Force curves of a tip: known specimens come out as they went in, and real curves are read with plain words.

use std::path::{Path, PathBuf};

use palpate::afm::Estimate;
use palpate::afm::curve::ForceCurve;
use palpate::afm::fit::{CurveFit, Options, fit};
use palpate::afm::simulate::Practice;
use palpate::grasp::PressureLaw;
use palpate_tests::palpate;
use serde_json::Value;

const CURVES: u64 = 200;

fn run(folder: &Path, call: &[&str]) {
    palpate().current_dir(folder).args(call).assert().success();
}

fn json(folder: &Path, call: &[&str]) -> Value {
    let output = palpate().current_dir(folder).args(call).arg("--json").assert().success();
    serde_json::from_slice(&output.get_output().stdout).unwrap()
}

/// Fits of many curves of one specimen with other noise each.
fn fits(practice: &Practice) -> Vec<CurveFit> {
    let options = Options { tip: practice.tip, poisson_ratio: 0.5, pressure: PressureLaw::HERTZ };
    let one = |seed| {
        let curve = ForceCurve::of(&practice.curve(seed).unwrap()).unwrap();
        fit(&curve, &options).unwrap()
    };
    (0..CURVES).map(one).collect()
}

/// Mean error in standard errors of the mean, and how many of the intervals of two standard errors hold the truth.
fn bias_and_coverage(found: &[Estimate], truth: f64) -> (f64, usize) {
    let count = found.len() as f64;
    let mean = found.iter().map(|e| e.value).sum::<f64>() / count;
    let square: f64 = found.iter().map(|e| (e.value - mean).powi(2)).sum();
    let deviation = (square / (count - 1.0)).sqrt();
    let holds = found.iter().filter(|e| (e.value - truth).abs() <= 2.0 * e.standard_error).count();
    ((mean - truth) / (deviation / count.sqrt()), holds)
}

#[test]
fn modulus_contact_and_pull_of_200_curves_are_without_bias_and_their_errors_hold() {
    let practice = Practice { pull_n: 2e-10, rate_hz: 400.0, ..Practice::gel() };
    let found = fits(&practice);
    let modulus: Vec<Estimate> = found.iter().map(|fit| fit.modulus_pa.unwrap()).collect();
    let contact: Vec<Estimate> = found.iter().map(|fit| fit.contact_m).collect();
    let pull: Vec<Estimate> = found.iter().map(|fit| fit.approach_pull_n.unwrap()).collect();
    for (name, values, truth) in
        [("modulus", modulus, 5e3), ("contact", contact, 0.0), ("pull", pull, 2e-10)]
    {
        let (bias, holds) = bias_and_coverage(&values, truth);
        // The mean of 200 lies within 3.5 of its standard errors, and 95.4 % of 200 within 4 of its deviations of 3.
        assert!(bias.abs() < 3.5, "{name}: bias of {bias:.1} standard errors of the mean");
        assert!((179..=200).contains(&holds), "{name}: {holds} of 200 intervals hold the truth");
    }
}

#[test]
fn without_adhesion_none_is_found_in_most_of_200_curves_and_the_modulus_is_right() {
    let practice = Practice { rate_hz: 400.0, ..Practice::gel() };
    let found = fits(&practice);
    let pulls = found.iter().filter(|fit| fit.approach_pull_n.is_some()).count();
    assert!(pulls <= 4, "{pulls} of 200");
    let modulus: Vec<Estimate> = found.iter().map(|fit| fit.modulus_pa.unwrap()).collect();
    let (bias, holds) = bias_and_coverage(&modulus, 5e3);
    assert!(bias.abs() < 3.5 && holds >= 179, "bias {bias:.1}, {holds} of 200");
}

#[test]
fn a_plain_trace_will_do_with_or_without_a_spring_constant() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), &["afm", "simulate", "--modulus-kpa", "8", "-o", "soft.csv"]);
    let tip = ["--tip-radius-nm", "2500"];
    let call =
        |more: &[&str]| json(folder.path(), &[&["afm", "soft.csv"], &tip[..], more].concat());
    let modulus = |found: &Value| found["curves"][0]["modulus_Pa"]["value"].as_f64().unwrap();
    assert!((modulus(&call(&[])) / 8e3 - 1.0).abs() < 0.05);
    // A stiffer cantilever bends less, so more of the way is depth, and the specimen softer.
    assert!(modulus(&call(&["--spring", "0.5"])) < 6e3);
    // The depth as the way: a trace without a head.
    let text = std::fs::read_to_string(folder.path().join("soft.csv")).unwrap();
    let bare: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
    std::fs::write(folder.path().join("bare.csv"), bare.join("\n")).unwrap();
    let found = json(folder.path(), &[&["afm", "bare.csv"], &tip[..]].concat());
    assert!(found["curves"][0]["notes"][0].as_str().unwrap().contains("that of the tip"));
}

#[test]
fn the_exponent_of_the_pressure_scales_the_modulus_by_its_factor() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), &["afm", "simulate", "-o", "gel.csv"]);
    let with = |k: &str| {
        let call = ["afm", "gel.csv", "--tip-radius-nm", "2500", "--pressure-exponent", k];
        json(folder.path(), &call)["curves"][0]["modulus_Pa"]["value"].as_f64().unwrap()
    };
    let factor = 8.0 / (3.0 * std::f64::consts::PI);
    assert!((with("inf") / with("2") - factor).abs() < 1e-9);
}

#[test]
fn a_hold_is_told_by_exponentials_and_by_the_latency_model() {
    let folder = tempfile::tempdir().unwrap();
    let relaxation = "0.2,6,0.2,0.5";
    let call = ["afm", "simulate", "--hold", "8", "--relaxation", relaxation, "--noise-pn", "3"];
    run(folder.path(), &[&call[..], &["-o", "held.csv"]].concat());
    let found = json(folder.path(), &["afm", "held.csv", "--tip-radius-nm", "2500"]);
    let hold = &found["curves"][0]["hold"];
    let slow = hold["terms"][1]["rate_per_s"].as_f64().unwrap();
    assert!((0.4..0.7).contains(&slow), "{slow}");
    let rms = |name: &str| hold[name]["rms"].as_f64().unwrap();
    assert!(hold["latency_power"]["order"].as_u64().unwrap() > 1);
    assert!(rms("latency_power") < rms("latency_linear"));
}

#[test]
fn rough_surfaces_are_the_same_on_every_run_and_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let told = |threads: &str| {
        let output = palpate()
            .current_dir(folder.path())
            .env("RAYON_NUM_THREADS", threads)
            .args(["afm", "rough", "--trials", "40", "--seed", "9", "--json"])
            .assert()
            .success();
        output.get_output().stdout.clone()
    };
    assert_eq!(told("1"), told("3"));
}

#[test]
fn nonsense_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), &["afm", "simulate", "-o", "gel.csv"]);
    std::fs::write(
        folder.path().join("flat.csv"),
        "time_s,displacement_mm,force_N\n0,0,1\n1,0,1\n",
    )
    .unwrap();
    let cone = ["gel.csv", "--shape", "cone", "--half-angle-deg", "20"];
    for (call, word) in [
        (&["gel.csv"][..], "--tip-radius-nm"),
        (&["gel.csv", "--shape", "cone"], "--half-angle-deg"),
        (&["gel.csv", "--shape", "cone", "--tip-radius-nm", "20"], "does not go with"),
        (&[&cone[..], &["--pressure-exponent", "4"]].concat(), "round tip"),
        (&["gel.csv", "--tip-radius-nm", "20", "--pressure-exponent", "0.5"], "1 or more"),
        (&["gel.csv", "--tip-radius-nm", "20", "--poisson", "0.7"], "Poisson"),
        (&["gel.csv", "--tip-radius-nm", "0"], "the tip's radius"),
        (&["flat.csv", "--tip-radius-nm", "20"], "samples"),
        (&["missing.csv", "--tip-radius-nm", "20"], "missing.csv"),
        (&["simulate", "--relaxation", "0.5", "-o", "a.csv"], "pairs"),
        (&["simulate", "-o", "a.txt"], ".csv"),
        (&["simulate", "--modulus-kpa", "0", "-o", "a.csv"], "modulus"),
        (&["rough", "--per-um2", "0"], "number of asperities"),
    ] {
        let call = [&["afm"], call].concat();
        let output = palpate().current_dir(folder.path()).args(&call).assert().code(2);
        let said = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
        assert!(said.contains(word), "{call:?}: {said}");
        assert!(output.get_output().stdout.is_empty());
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

/// A real curve, if they are here.
fn real(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("PALPATE_TRACES");
    let Some(folder) = folder else {
        eprintln!("PALPATE_TRACES names no folder of real recordings: not run");
        return None;
    };
    Some(Path::new(&folder).join("afm-jpk").join(name))
}

#[test]
fn real_curves_on_a_hard_specimen_give_adhesion_and_no_modulus() {
    for name in ["afmexperiment-force-save-1.txt", "force-save-JPK-2h.txt"] {
        let Some(path) = real(name) else { return };
        let path = path.to_str().unwrap();
        let found = json(Path::new("."), &["afm", path, "--tip-radius-nm", "20"]);
        let curve = &found["curves"][0];
        assert!(curve["modulus_Pa"].is_null(), "{curve:#}");
        assert!(curve["no_modulus"].as_str().unwrap().contains("stiffer cantilever"));
        assert!(curve["retreat"]["adheres"].as_bool().unwrap());
        let pull = curve["retreat"]["pull_off_N"].as_f64().unwrap();
        assert!((1e-10..2e-9).contains(&pull), "{pull}");
    }
}
