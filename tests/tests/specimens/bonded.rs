//! A specimen that is glued between two plates and moved to either side.

use std::f64::consts::TAU;
use std::path::Path;

use palpate::trace::{DISPLACEMENT, FORCE, Trace, write};
use palpate_tests::answer;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

const INTERVAL: f64 = 0.01;
/// Stiffness of a spring and of one with a damper, N/mm, and the rate at which that relaxes, 1/s.
const SPECIMEN: (f64, f64, f64) = (0.8, 0.5, 1.5);
const NOISE: f64 = 0.01;

/// Writes six recordings of three cycles each along a course, which gives a displacement for a size and the turns since the begin; below
/// the largest displacement so far the springs carry less by up to `lost`, as Mullins found.
fn record(folder: &Path, lost: f64, course: fn(f64, f64) -> f64) {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let noise = Normal::new(0.0, NOISE).expect("a distribution");
    let (alone, spring, rate) = SPECIMEN;
    let decay = (-rate * INTERVAL).exp();
    let gain = (1.0 - decay) / (rate * INTERVAL);
    let mut largest: f64 = 0.0;
    let cycles: [(f64, f64); 6] =
        [(1.0, 0.2), (1.0, 1.0), (2.0, 0.5), (3.0, 0.2), (3.0, 1.0), (1.5, 0.4)];
    for (number, (size, frequency)) in cycles.into_iter().enumerate() {
        let mut trace = Trace::default();
        trace.head.setup.sequence = Some(number as i64 + 1);
        let (mut x, mut force) = (Vec::new(), Vec::new());
        let (mut before, mut branch) = (0.0, 0.0);
        for k in 0..((3.0 / frequency + 3.0) / INTERVAL) as usize {
            let time = INTERVAL * k as f64;
            let turns = frequency * (time - 1.0);
            let moves = (0.0..3.0).contains(&turns);
            let now = if moves { course(size, turns) } else { 0.0 };
            largest = largest.max(now.abs());
            let elastic = now * (1.0 - lost * ((largest - now.abs()) / 0.5).tanh());
            branch = branch * decay + gain * (elastic - before);
            before = elastic;
            trace.time.push(time);
            x.push(now);
            force.push(alone * elastic + spring * branch + noise.sample(&mut random));
        }
        trace.set_column(DISPLACEMENT, x);
        trace.set_column(FORCE, force);
        write(&folder.join(format!("{number}.csv")), &trace).expect("a file");
    }
}

#[test]
fn a_hidden_effect_is_named_over_cycles_to_either_side() {
    for (lost, verdict) in [(0.0, "adequate"), (0.1, "named")] {
        let folder = tempfile::tempdir().expect("a folder");
        // The first way is to the negative side.
        record(folder.path(), lost, |size, turns| -size * (TAU * turns).sin());
        let fit = "fit generalized-maxwell --terms 1 --separation bonded . -o model.toml --json";
        let fitted = answer(folder.path(), &fit.split(' ').collect::<Vec<_>>());
        let of = |name: &str| fitted["parameters"][name]["value"].as_f64().expect("a number");
        if lost == 0.0 {
            assert!((of("k0") - SPECIMEN.0).abs() < 0.01 && (of("k1") - SPECIMEN.1).abs() < 0.01);
        }
        let found = answer(folder.path(), &["diagnose", "--model", "model.toml", "--json", "."]);
        assert_eq!(found["verdict"], verdict, "{lost}: {}", found["steps"]);
        assert!((found["noise_rms_N"].as_f64().expect("a number") / NOISE - 1.0).abs() < 0.1);
        if lost > 0.0 {
            assert_eq!(found["steps"][0]["effect"], "mullins", "{}", found["steps"]);
        }
    }
}

#[test]
fn a_specimen_that_is_glued_and_pushed_to_one_side_is_told_from_one_that_lacks_an_effect() {
    for lost in [0.0, 0.1] {
        let folder = tempfile::tempdir().expect("a folder");
        // It pulls on the way back, when its springs have relaxed.
        record(folder.path(), lost, |size, turns| 0.5 * size * (1.0 - (TAU * turns).cos()));
        let fit = "fit generalized-maxwell --terms 1 . -o model.toml --json";
        answer(folder.path(), &fit.split(' ').collect::<Vec<_>>());
        let found = answer(folder.path(), &["diagnose", "--model", "model.toml", "--json", "."]);
        let steps = found["steps"].as_array().expect("steps");
        let names: Vec<_> = steps.iter().map(|step| step["effect"].as_str().unwrap()).collect();
        assert_eq!(names, if lost > 0.0 { &["mullins"][..] } else { &[] }, "{}", found["verdict"]);
        let notes = found["notes"].to_string();
        assert!(notes.contains("fit with `--separation bonded`"), "{notes}");
    }
}
