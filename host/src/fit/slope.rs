//! Velocity and acceleration of a recorded motion.

use crate::model::Motion;
use crate::trace::displacement_scatter;

/// Most samples on each side that a slope is taken over.
const WIDEST: usize = 8;
/// Scatter that a slope may have, as a part of the largest.
const QUIET: f64 = 0.01;

/// Velocity, mm/s: the slope of the least-squares line through as few samples around each as make its
/// scatter small against the fastest motion. A clean displacement gives the slope between the two
/// neighbours; a measured one is smoothed.
#[must_use]
pub fn velocity(motion: &Motion) -> Vec<f64> {
    let scatter = displacement_scatter(&motion.time, &motion.displacement);
    let width = |half: usize| {
        let slopes = slopes(&motion.time, &motion.displacement, half);
        let fastest = slopes.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let count = half as f64;
        let interval = motion.time.windows(2).map(|t| t[1] - t[0]).fold(f64::INFINITY, f64::min);
        // Standard deviation of the slope of a line through 2 half + 1 samples.
        let spread = (count * (count + 1.0) * (2.0 * count + 1.0) / 3.0).sqrt() * interval;
        (scatter / spread <= QUIET * fastest || half == WIDEST).then_some(slopes)
    };
    (1..=WIDEST).find_map(width).unwrap_or_default()
}

/// Acceleration, mm/s²: the slope of the velocity between the neighbours of each sample.
#[must_use]
pub fn acceleration(motion: &Motion, velocity: &[f64]) -> Vec<f64> {
    slopes(&motion.time, velocity, 1)
}

/// Slope of the least-squares line through each sample, `half` before it and `half` after.
fn slopes(time: &[f64], values: &[f64], half: usize) -> Vec<f64> {
    (0..time.len())
        .map(|index| {
            let range = index.saturating_sub(half)..(index + half + 1).min(time.len());
            let count = range.len() as f64;
            let mean_t = time[range.clone()].iter().sum::<f64>() / count;
            let mean_y = values[range.clone()].iter().sum::<f64>() / count;
            let (mut product, mut square) = (0.0, 0.0);
            for k in range {
                product += (time[k] - mean_t) * (values[k] - mean_y);
                square += (time[k] - mean_t).powi(2);
            }
            if square > 0.0 { product / square } else { 0.0 }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn velocity_and_acceleration_of_a_parabola_are_exact_inside() {
        let time: Vec<f64> = (0..50).map(|k| f64::from(k) * 0.01).collect();
        let displacement: Vec<f64> = time.iter().map(|t| 3.0 * t - 2.0 * t * t).collect();
        let motion =
            Motion { time: time.into(), displacement: displacement.into(), rest_before: None };
        let v = velocity(&motion);
        let a = acceleration(&motion, &v);
        for k in 9..41 {
            assert!((v[k] - (3.0 - 4.0 * motion.time[k])).abs() < 1e-10);
            assert!((a[k] + 4.0).abs() < 1e-9);
        }
    }
}
