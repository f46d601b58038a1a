//! A folder in which every command has something to answer.

use std::fs;
use std::path::Path;

use palpate::trace::read_set;

use crate::specimens::{SILICONE, ball, crept, pad, pressed};
use crate::{bundled, palpate, workspace};

/// Recordings in `traces/` and models of them, laws of one's own, force curves, slides, hands, made-up specimens, practice sets and
/// surveys.
///
/// # Panics
/// If it cannot be made.
#[must_use]
pub fn lab() -> tempfile::TempDir {
    let lab = tempfile::tempdir().expect("a folder");
    let path = lab.path();
    fs::create_dir(path.join("traces")).expect("a folder");
    for row in 1..=3 {
        let name = format!("table-3.1-row-{row:02}.csv");
        fs::copy(bundled(&name), path.join("traces").join(name)).expect("a bundled recording");
    }
    fs::copy(bundled("press.csv"), path.join("press.csv")).expect("a bundled recording");
    let laws = workspace().join("tests/discover/teeth.toml");
    fs::copy(laws, path.join("laws.toml")).expect("laws of one's own");
    done(path, &["fit", "fung", "traces", "-o", "model.toml"]);
    done(path, &["add", "mullins", "model.toml", "traces", "-o", "better.toml"]);
    done(path, &["sensor", "press", "-o", "press.palpate"]);
    force_curves(path);
    slides(path);
    hands(path);
    specimens(path);
    practice(path);
    surveys(path);
    lab
}

/// Curves of a specimen that relaxes and adheres, of one that does neither, of a rigid one, and of none.
fn force_curves(folder: &Path) {
    let curve = |file: &str, of: &[&str]| {
        done(folder, &[&["afm", "simulate", "-o", file], of].concat());
    };
    curve("curve.csv", &["--hold", "1", "--relaxation", "0.2,4", "--pull-pn", "300"]);
    curve("still.csv", &["--hold", "1"]);
    curve("stiff.csv", &["--modulus-kpa", "1e7"]);
    let sample = |k: u32| [f64::from(k), 1e-5 * f64::from(k), 1e-11 * f64::from(7 * k % 13)];
    table(folder, "flat.csv", "time_s,displacement_mm,force_N", (0..200).map(sample));
}

/// A slide along a line, one that also turns, and a pull that slips in the end.
fn slides(folder: &Path) {
    let sample = |k: u32| [0.01 * f64::from(k), 2.0, 1.1 + 1e-3 * f64::from(k % 7)];
    table(folder, "slide.csv", "time_s,force_N,tangential_N", (0..100).map(sample));
    let sample = |k: u32| {
        let pull = (0.01 * (f64::from(k) - 40.0)).max(0.0);
        [0.01 * f64::from(k), if k < 20 { 0.0 } else { 2.0 }, pull]
    };
    table(folder, "pull.csv", "time_s,force_N,tangential_N", (0..300).map(sample));
    let pad = ["--contact", "rectangle:30x20", "--exponent", "4", "--friction", "0.6"];
    let surface = ["grasp", "surface", "--force", "2", "-o", "surface.csv"];
    done(folder, &[surface, pad].concat());
    let surface = fs::read_to_string(folder.join("surface.csv")).unwrap();
    let sample = |(k, point): (usize, &str)| {
        let load: Vec<f64> = point.split(',').skip(5).map(|cell| cell.parse().unwrap()).collect();
        [0.01 * k as f64, 2.0, load[0], load[1], load[2]]
    };
    let samples = surface.lines().skip(1).enumerate().map(sample);
    table(folder, "twist.csv", "time_s,force_N,tangential_N,shear_N,moment_Nmm", samples);
}

/// A hand of two fingers, and its first finger alone.
fn hands(folder: &Path) {
    let hand = fs::read_to_string(workspace().join("tests/hands/two-fingers.toml")).unwrap();
    let (finger, _) = hand.rsplit_once("[[finger]]").unwrap();
    fs::write(folder.join("finger.toml"), finger).unwrap();
    fs::write(folder.join("hand.toml"), &hand).unwrap();
}

/// Runs at three rates, pads that adhere, a ball, a hold of a force, markers in a hold, and a contact that slips.
fn specimens(lab: &Path) {
    for folder in ["runs", "pads"] {
        fs::create_dir(lab.join(folder)).unwrap();
    }
    for rate in [20.0, 50.0, 100.0] {
        pressed(&lab.join("runs"), rate, SILICONE);
    }
    for speed in [0.03, 0.1, 0.3, 1.0, 3.0, 10.0] {
        pad(&lab.join("pads"), speed, 0.5 * (1.0 + (speed / 0.3f64).powf(0.6)));
    }
    ball(lab);
    crept(lab);
    let row = |k: i32| {
        let t = 0.05 * f64::from(k);
        let wobble = 1e-3 * (f64::from(k * 7919 % 101) / 50.0 - 1.0);
        format!("{t},{},{}\n", 2.0 + 0.5 * (-0.8 * t).exp() + wobble, 7.0 + (-0.6 * t).exp())
    };
    let rows: String = (0..200).map(row).collect();
    fs::write(lab.join("markers.csv"), format!("time_s,marker1_mm,marker2_mm\n{rows}")).unwrap();
    done(lab, &["sensor", "slip", "-o", "slip.csv"]);
}

/// A practice set, and three recordings of it in N and in kPa with a model each.
fn practice(folder: &Path) {
    let hide = ["hide", "elastic-stiffening", "--seed", "2", "--size", "0.3", "-o", "set"];
    done(folder, &hide);
    fs::create_dir(folder.join("few")).unwrap();
    fs::create_dir(folder.join("stress")).unwrap();
    for trace in read_set(&[folder.join("set")]).unwrap().iter().take(3) {
        let text = fs::read_to_string(folder.join("set").join(trace.label())).unwrap();
        let stress = text.replace("force_N", "stress_kPa");
        fs::write(folder.join("few").join(trace.label()), text).unwrap();
        fs::write(folder.join("stress").join(trace.label()), stress).unwrap();
    }
    done(folder, &["fit", "fung", "few", "-o", "few.toml"]);
    done(folder, &["fit", "fung", "stress", "--signal", "stress_kPa", "-o", "stress.toml"]);
}

/// Surveys of eleven days, the last without a trace: their regions, and fits of each as a specimen; and one of a specimen that lacks an effect in its model.
fn surveys(lab: &Path) {
    let put = |from: &Path, day: usize| {
        let folder = lab.join(format!("days/date={day}"));
        fs::create_dir_all(&folder).unwrap();
        fs::copy(from, folder.join("trace.csv")).unwrap();
    };
    for day in 1..=9 {
        put(&bundled(&format!("table-3.1-row-{day:02}.csv")), day);
    }
    put(&bundled("press.csv"), 10);
    put(&lab.join("model.toml"), 11);
    done(lab, &["survey", "segment", "days", "--by", "date", "-o", "segmented"]);
    let fit = ["survey", "fit", "fung", "days", "--by", "folder", "--terms", "1", "-o", "fitted"];
    done(lab, &fit);
    done(lab, &["hide", "mullins", "--seed", "7", "-o", "practice"]);
    done(lab, &["fit", "fung", "practice", "-o", "practice.toml"]);
    fs::create_dir_all(lab.join("softened/date=1")).unwrap();
    for name in ["press-12mm-05mms.csv", "press-12mm-20mms.csv", "cycles-08mm-20mms.csv"] {
        fs::copy(lab.join("practice").join(name), lab.join("softened/date=1").join(name)).unwrap();
    }
    let diagnose = ["survey", "diagnose", "--model", "practice.toml", "softened", "--by", "date"];
    done(lab, &[&diagnose[..], &["-o", "diagnosed"]].concat());
}

fn table<const N: usize>(
    folder: &Path,
    file: &str,
    header: &str,
    rows: impl Iterator<Item = [f64; N]>,
) {
    let row = |row: [f64; N]| row.map(|cell| cell.to_string()).join(",") + "\n";
    let text = format!("{header}\n{}", rows.map(row).collect::<String>());
    fs::write(folder.join(file), text).unwrap();
}

fn done(folder: &Path, arguments: &[&str]) {
    let output = palpate().current_dir(folder).args(arguments).output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {error}");
}
