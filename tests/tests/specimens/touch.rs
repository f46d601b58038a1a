//! Recordings in the coordinates of their rig: displacement does not count from the touch.

use std::path::Path;

use palpate::trace::{DISPLACEMENT, FORCE, Trace, write};
use palpate_tests::answer;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

const INTERVAL: f64 = 0.01;
/// Stiffness, N/mm^(q+1), exponent q, share and rate, 1/s, of what relaxes.
const SPECIMEN: (f64, f64, f64, f64) = (0.08, 0.8, 0.3, 1.5);
const NOISE: f64 = 0.02;

/// Writes three presses with a hold, of a specimen that is touched at the displacement `touch`, mm.
fn record(folder: &Path, touch: f64) {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let noise = Normal::new(0.0, NOISE).expect("a distribution");
    let (p, q, share, rate) = SPECIMEN;
    let decay = (-rate * INTERVAL).exp();
    let gain = (1.0 - decay) / (rate * INTERVAL);
    for (number, (deep, speed)) in [(4.0, 15.0), (5.0, 25.0), (6.0, 35.0)].into_iter().enumerate() {
        let mut trace = Trace::default();
        let (mut x, mut force) = (Vec::new(), Vec::new());
        let (mut before, mut branch) = (0.0, 0.0);
        for k in 0..1000 {
            let time = INTERVAL * f64::from(k);
            let pressed =
                (speed * (time - 0.8)).min(deep).min(deep - speed * (time - 6.5)).max(-1.0);
            let elastic = p / (q + 1.0) * pressed.max(0.0).powf(q + 1.0);
            branch = branch * decay + gain * (elastic - before);
            before = elastic;
            let carried = (1.0 - share) * elastic + share * branch;
            trace.time.push(time);
            x.push(touch + pressed);
            force.push(carried.max(0.0) + noise.sample(&mut random));
        }
        trace.set_column(DISPLACEMENT, x);
        trace.set_column(FORCE, force);
        write(&folder.join(format!("{number}.csv")), &trace).expect("a file");
    }
}

#[test]
fn a_touch_far_from_zero_is_named_and_told() {
    for touch in [0.0, 3.0, 12.0, 50.0] {
        let folder = tempfile::tempdir().expect("a folder");
        record(folder.path(), touch);
        let fitted = answer(
            folder.path(),
            &["fit", "fung", "--terms", "1", ".", "-o", "model.toml", "--json"],
        );
        let warnings = fitted["warnings"].to_string();
        // Up to 0.4 of the largest displacement it may as well be a steep law.
        let is_far = touch > 4.0;
        assert_eq!(warnings.contains("`contact-offset`"), is_far, "{touch}: {warnings}");
        let found = answer(folder.path(), &["diagnose", "--model", "model.toml", "--json", "."]);
        let named = &found["steps"][0]["effect"];
        if touch == 0.0 {
            assert_eq!(found["verdict"], "adequate", "{}", found["steps"]);
        } else {
            assert_eq!(named, "contact-offset", "{touch}: {}", found["steps"]);
            let offset = found["steps"][0]["parameters"]["offset"]["value"].as_f64();
            assert!((offset.expect("a number") - touch).abs() < 0.3, "{offset:?}");
            assert_eq!(found["steps"].as_array().map(Vec::len), Some(1), "{}", found["steps"]);
        }
    }
}
