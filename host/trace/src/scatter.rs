//! Scatter of samples about a smooth course: what is left of second differences.

/// Median; none of an empty list.
pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Standard deviation of normal scatter whose median absolute deviation is 1.
pub(super) const NORMAL_MAD: f64 = 1.482_602_218_505_602;

/// What each inner sample is off the straight line between its neighbours, divided by the standard
/// deviation that independent scatter of 1 would give it; times need not be even.
pub(super) fn second_differences<'a>(
    time: &'a [f64],
    values: &'a [f64],
) -> impl Iterator<Item = f64> + 'a {
    time.windows(3).zip(values.windows(3)).map(|(t, y)| {
        let w = (t[1] - t[0]) / (t[2] - t[0]);
        (y[1] - ((1.0 - w) * y[0] + w * y[2])) / (1.0 + w * w + (1.0 - w) * (1.0 - w)).sqrt()
    })
}

/// Standard deviation of the scatter of a displacement or another quantity, in its unit: robust against its
/// ramps and corners; 0 where most of it rests exactly.
#[must_use]
pub fn scatter(time: &[f64], values: &[f64]) -> f64 {
    let differences = second_differences(time, values).map(f64::abs).collect();
    median(differences).unwrap_or(0.0) * NORMAL_MAD
}

/// Standard deviation of the scatter from second differences: robust (median absolute deviation),
/// or their root mean square where more than half of them are zero (a coarse resolution).
pub(super) fn deviation(differences: &[f64]) -> f64 {
    let robust = median(differences.iter().map(|d| d.abs()).collect()).unwrap_or(0.0) * NORMAL_MAD;
    if robust > 0.0 || differences.is_empty() {
        return robust;
    }
    (differences.iter().map(|d| d * d).sum::<f64>() / differences.len() as f64).sqrt()
}
