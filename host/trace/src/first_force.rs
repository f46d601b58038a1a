//! Where contact begins, told by the force alone.

/// Least part of the samples, one in so many, that are taken to be before the touch.
const BEFORE_TOUCH_SHARE: usize = 20;
/// Fewest of them.
const MIN_REST_SAMPLES: usize = 5;
/// How many samples in a row are out of rest when something is touched.
const LASTS: usize = 3;
/// Part of the largest force below which nothing is told from rest.
const MIN_FORCE_SHARE: f64 = 0.01;

/// Index of the first sample in contact: from there the force, of either sign, leaves its value at rest by more than six
/// standard deviations of its noise and one percent of its largest. None where it never does or the recording is not at rest at
/// its beginning.
pub(super) fn first_force(force: &[f64]) -> Option<usize> {
    let rest = &force[..(force.len() / BEFORE_TOUCH_SHARE).max(MIN_REST_SAMPLES).min(force.len())];
    let middle = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied()
    };
    let zero = middle(&mut rest.to_vec())?;
    // 1.48 times the middle deviation is the standard deviation of normal noise.
    let noise = 1.48 * middle(&mut rest.iter().map(|value| (value - zero).abs()).collect())?;
    let largest = force.iter().map(|value| (value - zero).abs()).fold(0.0, f64::max);
    let off = |index: usize, bound: f64| (force[index] - zero).abs() > bound;
    let bound = (6.0 * noise).max(MIN_FORCE_SHARE * largest);
    let mut touched = (0..(force.len() + 1).saturating_sub(LASTS))
        .find(|&start| (start..start + LASTS).all(|index| off(index, bound)))?;
    while touched > 0 && off(touched - 1, 3.0 * noise) {
        touched -= 1;
    }
    (touched > 0).then_some(touched)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contact_begins_where_the_force_leaves_its_noise_for_good() {
        let noise = |i: usize| 0.001 * ((i * 7919 % 13) as f64 - 6.0);
        let press = |i: usize| if i < 100 { 0.0 } else { -0.05 * (i - 100) as f64 };
        let mut force: Vec<f64> = (0..200).map(|i| 2.0 + noise(i) + press(i)).collect();
        // A single spike is no touch.
        force[50] += 1.0;
        let found = first_force(&force).unwrap();
        assert!((100..104).contains(&found), "{found}");
        assert_eq!(first_force(&force[..90]), None);
        assert_eq!(first_force(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), None);
        assert_eq!(first_force(&[]), None);
    }
}
