//! What the command says where the specimen is not that of any law: what real recordings show, made up.

use std::fmt::Write;
use std::path::Path;

use palpate_tests::{bundled, palpate};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use serde_json::Value;

fn call(folder: &Path, line: &str) -> (i32, String) {
    let output = palpate().current_dir(folder).args(line.split(' ')).output().expect("it runs");
    (output.status.code().expect("a status"), String::from_utf8_lossy(&output.stdout).into_owned())
}

fn diagnosis(folder: &Path, model: &str, what: &str) -> Value {
    let (status, out) = call(folder, &format!("diagnose --model {model} {what} --json"));
    assert_eq!(status, 0);
    serde_json::from_str(&out).expect("one JSON object")
}

/// Writes presses to 1 mm and back to −3 mm at several speeds. While parting the surfaces pull with up
/// to 2 N (v/v0)^0.2, most at −0.8 mm: far beyond where a made-up specimen lets go.
fn sticky_pads(folder: &Path) {
    let normal = Normal::new(0.0, 0.005).expect("a deviation");
    let mut random = ChaCha8Rng::seed_from_u64(8);
    for (index, speed) in [0.1, 0.3, 1.0, 3.0].into_iter().enumerate() {
        let mut text = format!("# palpate-trace = 1\n# [setup]\n# sequence = {}\n", index + 1);
        text += "time_s,displacement_mm,force_N\n";
        let (mut memory, mut last) = (0.0, 0.0f64);
        let (down, held, up) = (4.0 / 0.5, 5.0, 4.0 / speed);
        for k in 0..((down + held + up + 2.0) * 50.0) as usize {
            let t = 0.02 * k as f64;
            let x = if t < 1.0 {
                -3.0
            } else if t < 1.0 + down {
                -3.0 + 0.5 * (t - 1.0)
            } else if t < 1.0 + down + held {
                1.0
            } else {
                (1.0 - speed * (t - 1.0 - down - held)).max(-3.0)
            };
            let elastic = 3.0 * x.max(0.0).powf(1.5);
            memory = memory * (-0.02f64 / 2.0).exp() + 0.3 * (elastic - last);
            last = elastic;
            let parting = t > 1.0 + down + held;
            let pull = 2.0 * (speed / 3.0f64).powf(0.2) * (-((x + 0.8) / 0.7).powi(2)).exp();
            let force = 0.7 * elastic + memory - if parting && x > -3.0 { pull } else { 0.0 };
            let _ = writeln!(text, "{t:.2},{x:.5},{:.5}", force + normal.sample(&mut random));
        }
        std::fs::write(folder.join(format!("{index}.csv")), text).expect("a trace is written");
    }
}

#[test]
fn surfaces_that_let_go_far_beyond_the_touch_adhere() {
    let place = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(place.path().join("pads")).expect("a folder");
    sticky_pads(&place.path().join("pads"));
    assert_eq!(call(place.path(), "fit fung pads -o base.toml").0, 0);
    let answer = diagnosis(place.path(), "base.toml", "pads");
    assert_eq!(answer["steps"][0]["effect"], "adhesion", "{answer:#}");
    let after = answer["steps"][0]["rms_after_N"].as_f64().expect("a number");
    assert!(after < 0.1, "{after}");
}

/// All gauges feel the same press, so each carries what the model lacks for all of them.
#[test]
fn a_misfit_that_all_gauges_share_is_no_crosstalk() {
    let place = tempfile::tempdir().expect("a folder");
    let press = bundled("press.csv");
    let press = press.to_str().expect("a path");
    let fit = format!("fit fung {press} --signal gauge1_ustrain -o gauge.toml");
    assert_eq!(call(place.path(), &fit).0, 0);
    let answer = diagnosis(place.path(), "gauge.toml", press);
    for step in answer["steps"].as_array().expect("steps") {
        assert_ne!(step["effect"], "crosstalk", "{answer:#}");
    }
}

/// Writes holds of 10 minutes at three compressions, 20 samples a second, that relax as a power of the time:
/// over every decade, where two exponentials cover two.
fn long_holds(folder: &Path) {
    let normal = Normal::new(0.0, 0.002).expect("a deviation");
    let mut random = ChaCha8Rng::seed_from_u64(3);
    for (index, most) in [1.0f64, 2.0, 3.0].into_iter().enumerate() {
        let mut text = format!("# palpate-trace = 1\n# [setup]\n# sequence = {}\n", index + 1);
        text += "time_s,displacement_mm,force_N\n";
        for k in 0..12_100 {
            let t = 0.05 * f64::from(k) - 4.0;
            let x = (2.0 * t).clamp(-0.2, most);
            let since = (t - 0.5 * most).max(0.0);
            let force = 0.5 * x.max(0.0).powf(1.5) * (0.3 + 0.7 * (1.0 + since / 0.1).powf(-0.2));
            let _ =
                writeln!(text, "{:.2},{x:.5},{:.5}", t + 4.0, force + normal.sample(&mut random));
        }
        std::fs::write(folder.join(format!("{index}.csv")), text).expect("a trace is written");
    }
}

#[test]
fn holds_of_many_rows_are_told_from_their_means_by_the_errors_of_all_rows() {
    let place = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(place.path().join("holds")).expect("a folder");
    long_holds(&place.path().join("holds"));
    assert_eq!(call(place.path(), "fit fung holds -o base.toml").0, 0);
    let answer = diagnosis(place.path(), "base.toml", "holds");
    let step = &answer["steps"][0];
    assert_eq!(step["effect"], "slow-relaxation", "{answer:#}");
    let number = |key: &str| step[key].as_f64().expect("a number");
    assert!(number("rms_after_N") < 0.6 * number("rms_before_N"), "{step:#}");
    assert!(number("heldout_rms_after_N") < number("heldout_rms_before_N"), "{step:#}");
    let notes = answer["notes"].to_string();
    assert!(notes.contains("means of the 36300 rows"), "{notes}");
    // The ladder speaks of all rows: the error that `compare` finds for the model as it was given.
    let (status, out) = call(place.path(), "compare base.toml holds --json");
    assert_eq!(status, 0);
    let compared: Value = serde_json::from_str(&out).expect("one JSON object");
    let (given, rms) = (&answer["given_rms"], &compared["rms"]);
    let (given, rms) = (given.as_f64().expect("a number"), rms.as_f64().expect("a number"));
    assert!((given / rms - 1.0).abs() < 1e-6, "{given} and {rms}");
}
