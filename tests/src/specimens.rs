//! Recordings of made-up specimens, computed sample by sample.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use palpate::latency::Power;

/// Writes a trace.
///
/// # Panics
/// If it cannot be written.
pub fn write(
    folder: &Path,
    name: &str,
    head: &str,
    rows: impl Iterator<Item = [f64; 3]>,
) -> PathBuf {
    let mut text = format!("{head}time_s,displacement_mm,force_N\n");
    for [t, x, force] in rows {
        writeln!(text, "{t},{x},{force}").unwrap();
    }
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// Head of a cylinder of silicone.
pub const SILICONE: &str = "# [specimen]\n# shape = \"cylinder\"\n# radius_mm = 25\n# height_mm = 30\n# poisson_ratio = 0.48\n";

/// A press of a cylinder to 6 mm at a rate; the surface runs ahead of the equilibrium and comes back
/// at 0.5/s, k_s = 35 kPa. The last digits wobble, in place of noise.
pub fn pressed(folder: &Path, rate: f64, head: &str) -> PathBuf {
    let mut ahead = 0.0;
    let mut before = 0.0;
    let rows = (0..4000).map(move |k| {
        let t = 0.0025 * f64::from(k);
        let x = (rate * (t - 0.1)).clamp(0.0, 6.0);
        ahead = ahead * (-0.5f64 * 0.0025).exp() + 0.3 * (x - before) / 30.0;
        before = x;
        let area = 625e-6 * std::f64::consts::PI * (1.0 + 0.48 * x / 30.0).powi(2);
        let wobble = 0.02 * (f64::from(k * 7919 % 101) / 50.0 - 1.0);
        [t, x, 3.5e4 * (x / 30.0 + ahead) * area + wobble]
    });
    write(folder, &format!("{rate}.csv"), head, rows)
}

/// A pad pressed at 0.1 mm/s with 2 samples a second and pulled off at `speed` mm/s with 100, `pull` N at most.
pub fn pad(folder: &Path, speed: f64, pull: f64) -> PathBuf {
    let force = |x: f64| 3.0 * x.max(0.0);
    let wobble = |k: usize| 0.001 * ((k * 7919 % 101) as f64 / 29.0 - 1.74);
    let slow = (0..100).map(move |k| {
        let x = (0.05 * k as f64 - 2.0).min(1.0);
        [0.5 * k as f64, x, force(x) + wobble(k)]
    });
    let fast = (0..(300.0 / speed) as usize).map(move |k| {
        let x = 1.0 - 0.01 * speed * k as f64;
        let pulls = pull * (-((x + 0.4) / 0.2).powi(2)).exp();
        [50.0 + 0.01 * k as f64, x, force(x) - pulls + wobble(k)]
    });
    write(folder, &format!("pad-{speed}.csv"), "", slow.chain(fast))
}

/// A specimen under a force that rises to 2 N and is held: its displacement creeps at 0.6/s.
pub fn crept(folder: &Path) -> PathBuf {
    let mut z = 0.0;
    let mut before = 0.0;
    let rows = (0..3000).map(move |k| {
        let t = 0.005 * f64::from(k);
        let force = (2.0 * (t - 0.5)).clamp(0.0, 2.0);
        z = z * (-0.6f64 * 0.005).exp() + force - before;
        before = force;
        let wobble = 1e-3 * (f64::from(k * 7919 % 101) / 50.0 - 1.0);
        [t, 3.24 * (force - 0.105 * z) + wobble, force]
    });
    write(folder, "held.csv", "", rows)
}

/// A ball pressed by 10 mm and held: its strain follows a power law of order 5 at a modulus of 28 kPa.
pub fn ball(folder: &Path) -> PathBuf {
    let law = Power { rate: 2.6e4, order: 5.0, equilibrium: 0.2193, initial: 0.3193 };
    let area = std::f64::consts::PI * (35.0f64.powi(2) - 25.0f64.powi(2)) * 1e-6;
    let rows = (0..1200).map(|k| {
        let t = 0.01 * f64::from(k);
        let x = (10.0 * t).min(10.0);
        let strain = if t < 1.0 { law.initial * t * t } else { law.strain(t - 1.0) };
        [t, x, 2.8e4 * strain * area]
    });
    let head = "# [specimen]\n# shape = \"sphere\"\n# radius_mm = 35\n";
    write(folder, "ball.csv", head, rows)
}
