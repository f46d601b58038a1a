//! What is named where the elasticity or the spectrum of a specimen is another than the law's.

use std::f64::consts::TAU;
use std::path::Path;

use palpate::criticism::fitted::Fitted;
use palpate::fit::data::Data;
use palpate::fit::least_squares::Effort;
use palpate::fit::problem::Problem;
use palpate::fit::whitening::Whitening;
use palpate::model::effects::candidates;
use palpate::model::{BaseLaw, Chain, Separation};
use palpate::trace::{DISPLACEMENT, FORCE, Trace, write};
use palpate_tests::answer;
use palpate_tests::held_press::{TRUTH, force, held_press, times};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;

const INTERVAL: f64 = 0.01;
/// The largest compression, mm, and about the force there, N.
const DEEP: f64 = 10.0;
const FULL: f64 = 20.0;

/// The force of a contact whose elastic force relaxes: shares and rates, 1/s.
fn relaxed(elastic: &[f64], modes: &[(f64, f64)]) -> Vec<f64> {
    let mut branches = vec![0.0; modes.len()];
    let mut before = 0.0;
    let step = |&elastic: &f64| {
        let rise = elastic - before;
        before = elastic;
        let lost = branches.iter_mut().zip(modes).map(|(branch, &(share, rate))| {
            let decay = (-rate * INTERVAL).exp();
            *branch = *branch * decay + (1.0 - decay) / (rate * INTERVAL) * rise;
            share * (elastic - *branch)
        });
        (elastic - lost.sum::<f64>()).max(0.0)
    };
    elastic.iter().map(step).collect()
}

/// Writes a trace with noise of this standard deviation, N; it begins so many seconds after the first.
fn keep(folder: &Path, start: f64, x: &[f64], force: &[f64], noise: f64) {
    let mut random = ChaCha8Rng::seed_from_u64(start.to_bits());
    let mut noisy = |force: &f64| {
        let drawn: f64 = StandardNormal.sample(&mut random);
        force + noise * drawn
    };
    let force = force.iter().map(&mut noisy).collect();
    let mut trace = Trace::default();
    trace.head.setup.start_s = Some(start);
    trace.time = (0..x.len()).map(|k| INTERVAL * k as f64).collect();
    trace.set_column(DISPLACEMENT, x.to_vec());
    trace.set_column(FORCE, force);
    write(&folder.join(format!("{start:06}.csv")), &trace).expect("a file");
}

/// The diagnosis of Fung's law on the traces of a folder.
fn diagnosis(folder: &Path) -> Value {
    answer(folder, &["fit", "fung", ".", "-o", "model.toml", "--json"]);
    answer(folder, &["diagnose", "--model", "model.toml", ".", "--json"])
}

fn names(diagnosis: &Value) -> Vec<&str> {
    let steps = diagnosis["steps"].as_array().expect("steps").iter();
    steps.map(|step| step["effect"].as_str().expect("a name")).collect()
}

/// Zeros of each trace take on more of what the elasticity lacks than one drift does, and lie where that puts them.
#[test]
fn a_drift_stands_beside_the_zeros_of_each_trace() {
    let folder = tempfile::tempdir().expect("a folder");
    let motions =
        [(0.5, 5.0, 3.0), (1.0, 6.0, 2.0), (2.0, 5.5, 3.5), (0.2, 4.5, 2.5), (4.0, 5.0, 2.0)];
    for (number, (frequency, mean, size)) in motions.into_iter().enumerate() {
        let start = 40.0 * number as f64;
        let x: Vec<f64> = (0..1000)
            .map(|k| {
                let t = INTERVAL * f64::from(k) - 1.0;
                let sine = mean + size * (TAU * frequency * (t - 0.5).max(0.0)).sin();
                if t < 0.5 { -1.0 + (mean + 1.0) * (t / 0.5).max(0.0) } else { sine }
            })
            .collect();
        let steep = |x: f64| FULL * ((1.6 * x.max(0.0) / DEEP).exp() - 1.0) / (1.6f64.exp() - 1.0);
        let elastic: Vec<f64> = x.iter().map(|&x| steep(x)).collect();
        let drift = |k: usize| 0.3 * (start + INTERVAL * k as f64) / 60.0;
        let force = relaxed(&elastic, &[(0.25, 4.0), (0.2, 0.5)]).into_iter().enumerate();
        let force: Vec<f64> = force.map(|(k, force)| force + drift(k)).collect();
        keep(folder.path(), start, &x, &force, 0.15);
    }
    let found = diagnosis(folder.path());
    let steps = found["steps"].as_array().expect("steps").iter();
    let sets = steps.map(|step| step["credible_set"].as_array().expect("a set"));
    assert!(sets.flatten().any(|name| name == "drift"), "{found}");
}

/// A press to `deep` at `speed` mm/s, held for `hold` seconds, and back to 1 mm off the specimen, where it stays for a second.
fn press(x: &mut Vec<f64>, deep: f64, speed: f64, hold: f64) {
    let way = |from: f64, to: f64| {
        let count = ((to - from).abs() / speed / INTERVAL).ceil();
        (1..=count as usize).map(move |k| from + (to - from) * k as f64 / count)
    };
    x.extend(way(-1.0, deep));
    x.extend((0..(hold / INTERVAL) as usize).map(|_| deep));
    x.extend(way(deep, -1.0));
    x.extend([-1.0; 100]);
}

#[test]
fn friction_that_is_frozen_in_the_hold_and_gone_off_the_specimen_is_named() {
    const NOISE: f64 = 0.1;
    let folder = tempfile::tempdir().expect("a folder");
    let presses = [(10.0, 5.0), (7.0, 20.0), (4.0, 60.0), (10.0, 60.0), (7.0, 5.0), (10.0, 20.0)];
    for (number, (deep, speed)) in presses.into_iter().enumerate() {
        let mut x = vec![-1.0; 100];
        press(&mut x, deep, speed, 4.0);
        let elastic: Vec<f64> = x.iter().map(|x| FULL * (x.max(0.0) / DEEP).powf(1.8)).collect();
        let (mut stuck, mut before) = (0.0, -1.0f64);
        let rubs = |(x, force): (&f64, f64)| {
            let way = x - before;
            before = *x;
            if force <= 0.0 {
                stuck = 0.0;
            } else if way != 0.0 {
                stuck = way.signum() + (stuck - way.signum()) * (-way.abs() / 0.05).exp();
            }
            force + 0.3 * stuck
        };
        let force: Vec<f64> =
            x.iter().zip(relaxed(&elastic, &[(0.25, 4.0), (0.2, 0.5)])).map(rubs).collect();
        keep(folder.path(), 40.0 * number as f64, &x, &force, NOISE);
    }
    let found = diagnosis(folder.path());
    assert_eq!(names(&found), ["coulomb-friction"]);
    assert!(found["final_rms"].as_f64().expect("a number") < 1.05 * NOISE, "{found}");
}

/// The strength of a drag over its standard error, fitted to four presses of a specimen that has so much of it, N s/mm.
fn drag_over_error(drag: f64) -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let presses = [(4.0, 5.0), (5.0, 10.0), (6.0, 20.0), (5.0, 40.0)];
    let record = |(deep, speed)| {
        let motion = held_press(deep, speed);
        let time = times(900, 1.0 / INTERVAL);
        let felt = time.iter().zip(force(&time, motion)).map(|(t, force)| {
            let drawn: f64 = StandardNormal.sample(&mut random);
            force + drag * (motion(*t) - motion(t - INTERVAL)) / INTERVAL + 0.02 * drawn
        });
        let (felt, x) = (felt.collect(), time.iter().map(|&t| motion(t)).collect());
        let mut trace = Trace { time, ..Trace::default() };
        trace.set_column(DISPLACEMENT, x);
        trace.set_column(FORCE, felt);
        trace
    };
    let traces: Vec<Trace> = presses.into_iter().map(record).collect();
    let data = Data::of(&traces, FORCE).expect("usable traces");
    let candidates = candidates(&data.setting(), &[]).expect("the library");
    let own = candidates.iter().find(|it| it.name == "viscous-drag").expect("it is in the library");
    let chain = Chain::new(BaseLaw::fung(2, Separation::Clamp)).with(own.forms[0].applied.clone());
    let white = Whitening::none();
    let problem = Problem::new(&chain, &data, &white, None);
    let start = problem.point(&[&TRUTH[..], &[1e-3]].concat());
    let fitted = Fitted::new(&problem, &start, Effort::LONG);
    fitted.strength_over_error(&problem).expect("one strength")
}

#[test]
fn a_strength_stands_out_of_its_error_where_the_data_determine_it() {
    assert!(drag_over_error(0.01) > 10.0);
    assert!(drag_over_error(0.0) < 3.0);
}
