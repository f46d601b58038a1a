//! The inner speed of fits: one normal equation, one fit from a given start, one grasp without a start, one hold alone.
//!
//! Prints the least processor time of many rounds, one after the other in one thread, so that other work changes little. A word after
//! `--` chooses the rows that have it.

use std::hint::black_box;

use palpate::fit::data::Data;
use palpate::fit::exponentials::{Options, Parameter, Prepared};
use palpate::fit::least_squares::{LeastSquares, minimise};
use palpate::fit::problem::Problem;
use palpate::fit::whitening::Whitening;
use palpate::fit::whole_motion::{fit, held_out};
use palpate::model::{BaseLaw, Chain, Motion, Separation};
use palpate::trace::{Column, DISPLACEMENT, FORCE, Trace};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use rayon::{ThreadPoolBuildError, ThreadPoolBuilder};

/// p, q, c1, c2, v1, v2 of Fung's law, and a start 20 % off.
const TRUTH: [f64; 6] = [0.08, 0.8, 0.25, 0.24, 4.0, 0.55];
const START: [f64; 6] = [0.1, 0.7, 0.2, 0.3, 3.2, 0.7];
/// Samples a second.
const RATE: f64 = 200.0;

fn main() -> Result<(), ThreadPoolBuildError> {
    // What runs in parallel by itself runs here one after the other.
    ThreadPoolBuilder::new().num_threads(1).build()?.install(rows);
    Ok(())
}

fn rows() {
    let law = BaseLaw::fung(2, Separation::Clamp);
    let ten: Vec<Trace> = (0..10)
        .map(|k| press(1_400, 7.0, 4.0 + f64::from(k), 10.0 + 5.0 * f64::from(k), k))
        .collect();
    let data = Data::of(&ten, FORCE).expect("the traces can be fitted");
    let chain = Chain::new(law);
    let white = Whitening::none();
    let problem = Problem::new(&chain, &data, &white, None);
    let samples = data.samples() as f64;
    let at = problem.point(&TRUTH);
    told("one prediction, ns a sample", 1e9 / samples, || problem.cost(&at));
    told("one normal equation, ns a sample", 1e9 / samples, || problem.normal(&at));
    let start = problem.point(&START);
    told("10 x 1,400 samples, one start given, ms", 1e3, || minimise(&problem, &start));
    told("10 x 1,400 samples, no start, covariance, ms", 1e3, || fit(law, &data));
    let fitted = fit(law, &data).expect("the traces can be fitted");
    told("10 x 1,400 samples, each trace left out, ms", 1e3, || held_out(&fitted, &data));

    let one = [press(1_000, 5.0, 8.0, 30.0, 3)];
    told("one grasp of 1,000 samples: data, µs", 1e6, || Data::of(&one, FORCE));
    let grasp = Data::of(&one, FORCE).expect("the traces can be fitted");
    told("one grasp of 1,000 samples: no start, covariance, µs", 1e6, || fit(law, &grasp));

    let times: Vec<f64> = (0..860).map(|k| f64::from(k) / RATE).collect();
    let mut noise = noise(36, 0.01);
    let relaxed = |t: &f64| 0.4852 + 0.2472 * (-3.981 * t).exp() + 0.2676 * (-0.5325 * t).exp();
    let hold: Vec<f64> = times.iter().map(|t| relaxed(t) + noise()).collect();
    told("one hold of 860 samples: alone, all included, µs", 1e6, || {
        let alone = Prepared::for_one(&times, &Options::relaxation())?;
        alone.fit(&hold).map(|fit| fit.standard_error(Parameter::Rate(1)))
    });
    told("one hold of 860 samples: times prepared, µs", 1e6, || {
        Prepared::new(&times, &Options::relaxation())
    });
    let prepared = Prepared::new(&times, &Options::relaxation()).expect("these times can be used");
    told("one hold of 860 samples: prepared before, µs", 1e6, || {
        prepared.fit(&hold).map(|fit| fit.standard_error(Parameter::Rate(1)))
    });
}

/// The least processor time of many rounds in some unit of so many to the second.
fn told<T>(what: &str, unit: f64, mut work: impl FnMut() -> T) {
    if std::env::args().nth(1).is_some_and(|word| !word.starts_with("--") && !what.contains(&word))
    {
        return;
    }
    let mut least = f64::INFINITY;
    let begun = cpu_seconds();
    while cpu_seconds() - begun < 0.5 {
        let start = cpu_seconds();
        black_box(work());
        least = least.min(cpu_seconds() - start);
    }
    println!("{what:<60} {:>9.3}", unit * least);
}

/// Processor time of this thread, s.
#[cfg(unix)]
fn cpu_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Where the system tells no processor time of a thread: the time on the clock, s.
#[cfg(not(unix))]
fn cpu_seconds() -> f64 {
    use std::sync::OnceLock;
    use std::time::Instant;
    static BEGUN: OnceLock<Instant> = OnceLock::new();
    BEGUN.get_or_init(Instant::now).elapsed().as_secs_f64()
}

fn noise(seed: u64, deviation: f64) -> impl FnMut() -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let normal = Normal::new(0.0, deviation).expect("a valid noise");
    move || normal.sample(&mut random)
}

/// A press with a hold of three quarters of the time, in mm and mm/s.
fn press(samples: u32, lasts: f64, deep: f64, speed: f64, seed: u32) -> Trace {
    let time: Vec<f64> = (0..samples).map(|k| f64::from(k) / RATE).collect();
    let course = |t: &f64| {
        deep.min(speed * (t - 0.1 * lasts)).min(deep - speed * (t - 0.75 * lasts)).max(-1.0)
    };
    let displacement: Vec<f64> = time.iter().map(course).collect();
    let motion = Motion {
        time: time.clone().into(),
        displacement: displacement.clone().into(),
        rest_before: None,
    };
    let force = BaseLaw::fung(2, Separation::Clamp).predict(&TRUTH, &[motion]).remove(0);
    let mut noise = noise(u64::from(seed), 0.02);
    let force = force.into_iter().map(|force| force + noise()).collect();
    let column = |name: &str, values| Column { name: name.into(), values };
    Trace {
        time,
        columns: vec![column(DISPLACEMENT, displacement), column(FORCE, force)],
        ..Trace::default()
    }
}
