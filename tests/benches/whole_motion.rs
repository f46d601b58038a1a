//! The fit of Fung's law to a data set: 10 traces of 1,400 samples, six parameters, no start given.

use criterion::{Criterion, criterion_group, criterion_main};
use palpate::fit::data::Data;
use palpate::fit::whole_motion::fit;
use palpate::model::{BaseLaw, Motion, Separation};
use palpate::trace::{Column, DISPLACEMENT, FORCE, Trace};
use palpate_tests::press;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

const SAMPLES: usize = 1400;

/// The first 1,400 samples of a press.
fn motion(to_mm: f64, speed: f64) -> Motion<'static> {
    let mut motion = press(to_mm, speed, 7.0);
    motion.time.to_mut().truncate(SAMPLES);
    motion.displacement.to_mut().truncate(SAMPLES);
    motion
}

fn traces() -> Vec<Trace> {
    let law = BaseLaw::fung(2, Separation::Clamp);
    let motions: Vec<Motion> =
        (0..10).map(|k| motion(4.0 + f64::from(k), 10.0 + 5.0 * f64::from(k))).collect();
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let normal = Normal::new(0.0, 0.02).expect("a valid noise");
    let force = law.predict(&[0.08, 0.8, 0.25, 0.24, 4.0, 0.55], &motions);
    motions
        .into_iter()
        .zip(force)
        .map(|(motion, force)| {
            let noisy = force.iter().map(|force| force + normal.sample(&mut random)).collect();
            let column = |name: &str, values| Column { name: name.into(), values };
            Trace {
                time: motion.time.into_owned(),
                columns: vec![
                    column(DISPLACEMENT, motion.displacement.into_owned()),
                    column(FORCE, noisy),
                ],
                ..Trace::default()
            }
        })
        .collect()
}

fn whole_motion(criterion: &mut Criterion) {
    let traces = traces();
    let data = Data::of(&traces, FORCE).expect("the traces can be fitted");
    assert_eq!(data.samples(), 10 * SAMPLES);
    for separation in [Separation::Clamp, Separation::Free] {
        let law = BaseLaw::fung(2, separation);
        let name = format!("10 x 1400 samples, {separation:?}");
        criterion.bench_function(&name, |bencher| bencher.iter(|| fit(law, &data)));
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = whole_motion
}
criterion_main!(benches);
