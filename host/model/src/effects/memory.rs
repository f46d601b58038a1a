//! Operators with a memory that several laws share; each keeps it in what the law remembers.

use crate::{Remembered, Scene, low_pass};

/// Largest value so far, this one among them; not below 0.
pub(super) fn largest(remembered: &mut Remembered, value: f64) -> f64 {
    remembered.resize(1, 0.0);
    remembered[0] = remembered[0].max(value);
    remembered[0]
}

/// Largest value so far in the trace at hand, this one among them; not below 0.
pub(super) fn largest_in_trace(scene: &Scene, remembered: &mut Remembered, value: f64) -> f64 {
    let largest = of_trace(scene, remembered, 0.0);
    *largest = largest.max(value);
    *largest
}

/// Number of loadings completed in the trace at hand before each of its samples.
pub(super) fn loadings_in_trace(scene: &Scene, remembered: &mut Remembered) -> Vec<f64> {
    let first = scene.loadings.first().copied().unwrap_or(0.0);
    let before = *of_trace(scene, remembered, first);
    scene.loadings.iter().map(|loadings| loadings - before).collect()
}

/// What is remembered of the trace at hand; it is `first` where the trace begins.
fn of_trace<'a>(scene: &Scene, remembered: &'a mut Remembered, first: f64) -> &'a mut f64 {
    let trace = scene.trace as f64;
    if remembered.first() != Some(&trace) {
        *remembered = vec![trace, first];
    }
    &mut remembered[1]
}

/// Which way a path leads, from −1 to 1: after each turn the sign settles exponentially over `length`
/// of path and stays as it is where the path rests (Dahl 1968). It starts from `start`.
pub(super) fn direction(
    remembered: &mut Remembered,
    start: f64,
    length: f64,
    path: &[f64],
) -> Vec<f64> {
    path.iter().map(|&place| turned(remembered, start, length, place)).collect()
}

/// The same at the next place of the path alone.
pub(super) fn turned(remembered: &mut Remembered, start: f64, length: f64, place: f64) -> f64 {
    if remembered.is_empty() {
        *remembered = vec![start, place];
    }
    let way = place - remembered[1];
    if way != 0.0 {
        let towards = way.signum();
        remembered[0] = towards + (remembered[0] - towards) * (-way.abs() / length).exp();
    }
    remembered[1] = place;
    remembered[0]
}

/// Temperature above the reference, K, of a body that follows that of the air with a time constant,
/// s. At the first sample of the set it is that of the air; in a pause the air changes steadily.
pub(super) fn body_warmth(scene: &Scene, remembered: &mut Remembered, time: f64) -> Vec<f64> {
    let follow = |k| {
        let (air, now) = (scene.warmth(k), scene.set_time(k));
        if remembered.is_empty() {
            *remembered = vec![air, air, now];
        }
        let turns = (now - remembered[2]) / time;
        let body = low_pass(remembered[0], remembered[1], air, turns);
        *remembered = vec![body, air, now];
        body
    };
    (0..scene.len()).map(follow).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_low_pass_is_exact_on_a_ramp_in_steps_of_any_size() {
        let time = 0.3;
        let closed = |t: f64| t - time * (1.0 - (-t / time).exp());
        for steps in [1, 7, 100] {
            let interval = 1.7 / f64::from(steps);
            let output = (0..steps).fold(0.0, |output, k| {
                let before = interval * f64::from(k);
                low_pass(output, before, before + interval, interval / time)
            });
            assert!((output - closed(1.7)).abs() < 1e-12, "{steps} steps");
        }
        assert_eq!(low_pass(5.0, 1.0, 2.0, f64::INFINITY), 2.0);
    }

    #[test]
    fn a_direction_turns_over_its_length_and_rests_with_the_path() {
        let path = [0.0, 1.0, 10.0, 10.0, 10.0, 9.9, 9.9, 0.0];
        let found = direction(&mut Vec::new(), 0.0, 0.1, &path);
        assert_eq!(found[0], 0.0);
        assert!((found[2] - 1.0).abs() < 1e-12 && found[2] == found[4]);
        assert!((found[5] - (2.0 * (-1f64).exp() - 1.0)).abs() < 1e-9 && found[5] == found[6]);
        assert!((found[7] + 1.0).abs() < 1e-12);
    }
}
