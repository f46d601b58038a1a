//! Force curves of a tip: known specimens come out as they went in, and real curves are read with plain words.

use std::path::{Path, PathBuf};

use palpate::afm::Estimate;
use palpate::afm::curve::ForceCurve;
use palpate::afm::fit::{CurveFit, Options, fit};
use palpate::afm::hereditary::Contact;
use palpate::afm::law::Law;
use palpate::afm::simulate::Practice;
use palpate::contact::Tip;
use palpate::grasp::PressureLaw;
use palpate::model::Relaxation;
use palpate_tests::palpate;
use palpate_tests::tip::{Ball, Way};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use serde_json::Value;

const CURVES: u64 = 60;

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

/// A gel of 5 kPa at once and 3 kPa after all has relaxed, under a ball of 2.5 µm.
const GEL: Ball = Ball {
    radius: 2.5e-6,
    reduced_modulus: 5e3 / 0.75,
    spring: 0.05,
    pull: 0.0,
    relaxation: |t| 0.6 + 0.2 * (-8.0 * t).exp() + 0.2 * (-0.6 * t).exp(),
};

#[test]
fn the_contact_of_a_specimen_that_relaxes_agrees_with_brute_force_both_ways() {
    for pull in [0.0, 2e-10] {
        let ball = Ball { pull, ..GEL };
        let corners = [(0.0, -1e-6), (0.5, 1e-6), (1.0, 1e-6), (1.5, -1e-6)];
        let way = Way::through(&corners, 5e-4);
        let expected = ball.forces(&way);
        let tip = Tip::Paraboloid { radius_m: ball.radius };
        let law = Law { tip, reduced_modulus: ball.reduced_modulus, adhesion_n: pull };
        let relaxation = Relaxation::new(&[0.2, 0.2], &[8.0, 0.6]);
        let mut contact = Contact::new(law, &relaxation, Some(ball.spring));
        let largest = expected.iter().copied().fold(0.0, f64::max);
        for (k, expected) in expected.iter().enumerate() {
            let found = contact.follow(way.time[k], way.z[k], k >= way.leaves);
            let time = way.time[k];
            assert!((found - expected).abs() < 1e-6 * largest, "{time} s: {found} {expected}");
        }
    }
}

/// A trace of such a way with noise of 20 pN.
fn recorded(way: &Way, forces: &[f64], seed: u64) -> String {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let normal = Normal::new(0.0, 2e-11).unwrap();
    let mut text =
        "# [setup]\n# spring_constant_N_per_m = 0.05\ntime_s,displacement_mm,force_N\n".to_owned();
    for ((t, z), f) in way.time.iter().zip(&way.z).zip(forces) {
        text += &format!("{t},{},{}\n", z * 1e3, f + normal.sample(&mut random));
    }
    text
}

/// Deviation from the truth in standard errors.
fn off(found: &Value, truth: f64) -> f64 {
    let [value, error] = ["value", "standard_error"].map(|key| found[key].as_f64().unwrap());
    (value - truth) / error
}

#[test]
fn relaxation_on_the_way_in_is_not_taken_for_adhesion() {
    let corners = [(0.0, -1e-6), (0.5, 1e-6), (3.5, 1e-6), (4.0, -1e-6)];
    let way = Way::through(&corners, 1e-3);
    let forces = GEL.forces(&way);
    let folder = tempfile::tempdir().unwrap();
    let mut square = 0.0;
    for seed in 1..=5 {
        std::fs::write(folder.path().join("gel.csv"), recorded(&way, &forces, seed)).unwrap();
        let found = json(folder.path(), &["afm", "gel.csv", "--tip-radius-nm", "2500"]);
        let curve = &found["curves"][0];
        assert!(curve["approach_pull_N"].is_null(), "seed {seed}: {}", curve["approach_pull_N"]);
        let z = off(&curve["modulus_Pa"], 5e3);
        square += z * z;
        assert!(z.abs() < 3.0, "seed {seed}: {z:.1} standard errors off");
        assert!(curve["modulus_Pa"]["standard_error"].as_f64().unwrap() < 100.0);
        assert!(off(&curve["equilibrium_modulus_Pa"], 3e3).abs() < 3.0, "seed {seed}");
        assert!(off(&curve["contact_m"], 0.0).abs() < 3.0, "seed {seed}");
        assert_eq!(curve["relaxation"].as_array().unwrap().len(), 2);
        let (left, noise) = (&curve["residual_rms_N"], &curve["noise_N"]);
        assert!(left.as_f64().unwrap() < 1.1 * noise.as_f64().unwrap(), "seed {seed}");
    }
    // Chi squared of 5 is above 15 in 1 % of tries.
    assert!(square < 15.0, "{square:.1}");
}

#[test]
fn an_approach_in_steps_with_pauses_is_one_contact() {
    // Touch in the first step, a pause, deeper in the second, a pause, and back: 400 pN and more over 20 pN.
    let corners = [(0.0, -5e-7), (0.2, 3e-7), (1.2, 3e-7), (1.4, 1e-6), (3.4, 1e-6), (3.8, -6e-7)];
    let way = Way::through(&corners, 1e-3);
    let forces = GEL.forces(&way);
    let segments =
        [("extend", 0.0), ("pause", 0.2), ("extend", 1.2), ("pause", 1.4), ("retract", 3.4)];
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let normal = Normal::new(0.0, 2e-11).unwrap();
    let mut export = String::from("# TEXT EXPORT\n");
    for (k, (kind, from)) in segments.iter().enumerate() {
        export += &format!(
            "# segmentIndex: {k}\n# segment: {kind}\n# columns: height vDeflection seriesTime\n# springConstant: 0.05\n# units: m N s\n"
        );
        let to = segments.get(k + 1).map_or(f64::INFINITY, |next| next.1);
        for (i, t) in
            way.time.iter().enumerate().filter(|(_, t)| **t >= from - 1e-9 && **t < to - 1e-9)
        {
            let force = forces[i] + normal.sample(&mut random);
            export += &format!("{} {force} {t}\n", 5e-6 - way.z[i]);
        }
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("steps.txt"), export).unwrap();
    let found = json(folder.path(), &["afm", "steps.txt", "--tip-radius-nm", "2500"]);
    let curve = &found["curves"][0];
    assert!(off(&curve["modulus_Pa"], 5e3).abs() < 3.0, "{curve:#}");
    assert!(off(&curve["contact_m"], -5e-6).abs() < 3.0, "{curve:#}");
    assert!(curve["approach_pull_N"].is_null());
    assert_eq!(curve["holds"].as_array().unwrap().len(), 2, "both pauses are relaxation tests");
    // The same as a trace, in which nothing says what is a pause.
    std::fs::write(folder.path().join("steps.csv"), recorded(&way, &forces, 3)).unwrap();
    let found = json(folder.path(), &["afm", "steps.csv", "--tip-radius-nm", "2500"]);
    let curve = &found["curves"][0];
    assert!(off(&curve["modulus_Pa"], 5e3).abs() < 3.0, "{curve:#}");
    assert_eq!(curve["holds"].as_array().unwrap().len(), 2);
}

#[test]
fn modulus_contact_and_pull_of_60_curves_are_without_bias_and_their_errors_hold() {
    let practice = Practice { pull_n: 2e-10, rate_hz: 400.0, ..Practice::gel() };
    let found = fits(&practice);
    let modulus: Vec<Estimate> = found.iter().map(|fit| fit.modulus_pa.unwrap()).collect();
    let contact: Vec<Estimate> = found.iter().map(|fit| fit.contact_m).collect();
    let pull: Vec<Estimate> = found.iter().map(|fit| fit.approach_pull_n.unwrap()).collect();
    for (name, values, truth) in
        [("modulus", modulus, 5e3), ("contact", contact, 0.0), ("pull", pull, 2e-10)]
    {
        let (bias, holds) = bias_and_coverage(&values, truth);
        // The mean of 60 lies within 3.5 of its standard errors, and 95.4 % of 60 within 4 of its deviations of 1.6.
        assert!(bias.abs() < 3.5, "{name}: bias of {bias:.1} standard errors of the mean");
        assert!((51..=60).contains(&holds), "{name}: {holds} of 60 intervals hold the truth");
    }
}

#[test]
fn without_adhesion_none_is_found_in_most_of_60_curves_and_the_modulus_is_right() {
    let practice = Practice { rate_hz: 400.0, ..Practice::gel() };
    let found = fits(&practice);
    let pulls = found.iter().filter(|fit| fit.approach_pull_n.is_some()).count();
    assert!(pulls <= 2, "{pulls} of 60");
    let modulus: Vec<Estimate> = found.iter().map(|fit| fit.modulus_pa.unwrap()).collect();
    let (bias, holds) = bias_and_coverage(&modulus, 5e3);
    assert!(bias.abs() < 3.5 && holds >= 51, "bias {bias:.1}, {holds} of 60");
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
