//! Slopes over time of what was recorded: velocity and acceleration of a motion, slopes of other channels.

use palpate_model::Motion;
use palpate_trace::scatter;

/// Most samples on each side that a slope is taken over.
const WIDEST: usize = 8;
/// Scatter that a slope may have, as a part of the largest.
const QUIET: f64 = 0.01;

/// Velocity, mm/s.
#[must_use]
pub fn velocity(motion: &Motion) -> Vec<f64> {
    slope(&motion.time, &motion.displacement)
}

/// Slope of a quantity at each sample, in its unit per second: that of the least-squares line through as few
/// samples around it as make the scatter of the slope small against the steepest. A clean quantity gives the
/// slope between the two neighbours; a measured one is smoothed.
#[must_use]
pub fn slope(time: &[f64], values: &[f64]) -> Vec<f64> {
    let scatter = scatter(time, values);
    let interval = time.windows(2).map(|t| t[1] - t[0]).fold(f64::INFINITY, f64::min);
    let width = |half: usize| {
        let slopes = slopes(time, values, half);
        let steepest = slopes.iter().fold(0.0, |most: f64, slope| most.max(slope.abs()));
        let count = half as f64;
        // Standard deviation of the slope of a line through 2 half + 1 samples.
        let spread = (count * (count + 1.0) * (2.0 * count + 1.0) / 3.0).sqrt() * interval;
        (scatter / spread <= QUIET * steepest || half == WIDEST).then_some(slopes)
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
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

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

    #[test]
    fn the_slope_of_a_noisy_quantity_scatters_little_and_keeps_its_ramp() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let time: Vec<f64> = (0..400).map(|k| f64::from(k) * 0.005).collect();
        // 500 units up within 0.5 s, from 1 s on.
        let values: Vec<f64> = time
            .iter()
            .map(|t| {
                let noise: f64 = StandardNormal.sample(&mut random);
                1000.0 * (t - 1.0).clamp(0.0, 0.5) + noise
            })
            .collect();
        let slopes = slope(&time, &values);
        let rms = |of: &[f64], level: f64| {
            (of.iter().map(|s| (s - level).powi(2)).sum::<f64>() / of.len() as f64).sqrt()
        };
        // The difference of neighbours would scatter by 283 units a second.
        assert!(rms(&slopes[10..190], 0.0) < 15.0);
        assert!(rms(&slopes[210..290], 1000.0) < 15.0);
    }
}
