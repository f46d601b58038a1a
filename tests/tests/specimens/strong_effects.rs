//! Effects so strong that the straight line of a screen leads astray: they are found none the less, and nothing beside them.

use std::path::Path;

use palpate::model::{BaseLaw, Motion, Separation};
use palpate_tests::held_press::{keep, times, warnings_and_diagnosis};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Writes presses of a specimen of which twice the elastic response relaxes within 24 ms, from far off and back without a stop.
fn record(folder: &Path) {
    let (share, noise) = (1.98, 0.0072);
    let all = 1.0 + share;
    let law = [0.186 * all, 0.508, 0.27 / all, 0.268 / all, share / all, 4.25, 0.393, 1.0 / 0.0243];
    let mut random = ChaCha8Rng::seed_from_u64(53);
    let (deep, speed, stay) = (12.0, 10.0, 1.0);
    for (number, retreat) in [5.0, 1.33, 20.0, 20.0, 1.33, 60.0, 5.0, 60.0].into_iter().enumerate()
    {
        let there = (deep + 15.0) / speed;
        let back = there + stay;
        let motion = |t: f64| (speed * t - 15.0).min(deep).min(deep - retreat * (t - back));
        let time = times((250.0 * (back + 13.0 / retreat + 1.0)) as u32, 250.0);
        let x: Vec<f64> = time.iter().map(|&t| motion(t)).collect();
        let moved = Motion {
            time: time.as_slice().into(),
            displacement: x.as_slice().into(),
            rest_before: None,
        };
        let mut force = BaseLaw::fung(3, Separation::Clamp).predict(&law, &[moved]).remove(0);
        for force in &mut force {
            let drawn: f64 = StandardNormal.sample(&mut random);
            *force += noise * drawn;
        }
        keep(folder, number, &time, &x, &force);
    }
}

#[test]
fn a_fast_mode_larger_than_the_elastic_response_is_named_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    record(folder.path());
    let (_, found) = warnings_and_diagnosis(folder.path());
    assert_eq!(found["verdict"], "named", "{found}");
    assert_eq!(found["steps"].as_array().map(Vec::len), Some(1), "{found}");
    assert_eq!(found["steps"][0]["effect"], "fast-mode", "{found}");
}
