//! A displacement that scatters, as a camera sees it: a play that only smooths it is no backlash.

use palpate::model::{BaseLaw, Motion, Separation};
use palpate::trace::{DISPLACEMENT, FORCE, Trace, write};
use palpate_tests::answer;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

const LAW: BaseLaw = BaseLaw::fung(2, Separation::Clamp);
const TRUTH: [f64; 6] = [0.08, 0.8, 0.25, 0.24, 4.0, 0.55];
/// Frames a second, scatter of the displacement, mm, and noise of the force, N.
const RATE: f64 = 30.0;
const SCATTER: f64 = 0.02;
const NOISE: f64 = 0.01;

#[test]
fn a_play_within_the_scatter_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut random = ChaCha8Rng::seed_from_u64(41);
    let scatter = Normal::new(0.0, SCATTER).expect("a distribution");
    let noise = Normal::new(0.0, NOISE).expect("a distribution");
    let presses = [(4.0, 5.0), (5.0, 10.0), (6.0, 20.0), (5.0, 40.0), (3.0, 10.0), (6.0, 5.0)];
    for (number, (deep, speed)) in presses.into_iter().enumerate() {
        let motion = |t: f64| {
            let back = deep - speed * (t - 1.0 - deep / speed - 4.0);
            (speed * (t - 1.0)).min(deep).min(back).max(-1.0)
        };
        let time: Vec<f64> = (0..270).map(|k| f64::from(k) / RATE).collect();
        let x: Vec<f64> = time.iter().map(|&t| motion(t)).collect();
        let pressed = Motion { time: (&time).into(), displacement: (&x).into(), rest_before: None };
        let force = LAW.predict(&TRUTH, &[pressed]).remove(0);
        let force = force.into_iter().map(|f| f + noise.sample(&mut random)).collect();
        let seen = x.into_iter().map(|x| x + scatter.sample(&mut random)).collect();
        let mut trace = Trace { time, ..Trace::default() };
        trace.set_column(DISPLACEMENT, seen);
        trace.set_column(FORCE, force);
        write(&folder.path().join(format!("{number}.csv")), &trace).expect("a file");
    }
    answer(folder.path(), &["fit", "fung", ".", "-o", "model.toml", "--json"]);
    let found = answer(folder.path(), &["diagnose", "--model", "model.toml", ".", "--json"]);
    let refused = found["refused"].as_array().unwrap().iter();
    let play = refused.clone().find(|it| it["effect"] == "backlash").expect("it was tried");
    assert!(play["reason"].as_str().unwrap().contains("only smooths the displacement"), "{play}");
    let steps = found["steps"].as_array().unwrap();
    assert!(steps.iter().all(|step| step["effect"] != "backlash"), "{steps:?}");
}
