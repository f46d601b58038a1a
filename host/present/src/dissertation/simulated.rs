//! Recordings that are not printed, simulated from what is.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use palpate_trace::{Control, DISPLACEMENT, FORCE, Trace};

/// A trace of displacement (mm) and force (N) over time (s).
pub(super) fn trace(
    name: impl Into<String>,
    control: Control,
    time: Vec<f64>,
    displacement: Vec<f64>,
    force: Vec<f64>,
) -> Trace {
    let mut trace = Trace { time, ..Trace::default() };
    trace.head.name = Some(name.into());
    trace.head.control = Some(control);
    trace.set_column(DISPLACEMENT, displacement);
    trace.set_column(FORCE, force);
    trace
}

/// Times from 0 at a rate in Hz.
pub(super) fn times(duration_s: f64, rate_hz: f64) -> Vec<f64> {
    (0..=(duration_s * rate_hz).round() as usize).map(|k| k as f64 / rate_hz).collect()
}

/// The values with independent normal noise of a standard deviation; 0 adds none.
pub(super) fn noisy(values: Vec<f64>, deviation: f64, seed: u64) -> Vec<f64> {
    let Ok(normal) = Normal::new(0.0, deviation) else { return values };
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    values.into_iter().map(|value| value + normal.sample(&mut random)).collect()
}

/// A course through corners of (time, value), straight between them.
pub(super) fn course(corners: &[(f64, f64)], time: f64) -> f64 {
    let last = corners[corners.len() - 1];
    let next = corners.iter().position(|corner| corner.0 > time);
    match next {
        None => last.1,
        Some(0) => corners[0].1,
        Some(next) => {
            let ((t0, x0), (t1, x1)) = (corners[next - 1], corners[next]);
            x0 + (x1 - x0) * (time - t0) / (t1 - t0)
        }
    }
}
