//! How densely, and how evenly, a recording is sampled.

/// Sampling of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// Median interval between samples, s.
    pub median_s: f64,
    /// Shortest interval, s.
    pub shortest_s: f64,
    /// Longest interval, s.
    pub longest_s: f64,
    /// One unit of the last decimal with which times are given, s.
    pub resolution_s: f64,
    /// The one interval of an evenly sampled recording, s: every time lies on the grid through the
    /// first and the last within [`Self::resolution_s`] (rounding moves each by up to half of it).
    pub interval_s: Option<f64>,
}

impl Sampling {
    /// Whether the recording is evenly sampled.
    #[must_use]
    pub fn is_uniform(&self) -> bool {
        self.interval_s.is_some()
    }

    /// Samples per second: of the grid if there is one, else of the median interval.
    #[must_use]
    pub fn rate_hz(&self) -> f64 {
        1.0 / self.interval_s.unwrap_or(self.median_s)
    }
}

/// Sampling of strictly increasing times, s; none for fewer than two.
#[must_use]
pub fn sampling(time: &[f64]) -> Option<Sampling> {
    let (first, last) = (*time.first()?, *time.last()?);
    let mut intervals: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if intervals.is_empty() {
        return None;
    }
    let middle = intervals.len() / 2;
    let median_s = *intervals.select_nth_unstable_by(middle, f64::total_cmp).1;
    let resolution_s = resolution(time);
    let grid = (last - first) / intervals.len() as f64;
    let binary = 8.0 * f64::EPSILON * first.abs().max(last.abs());
    // Whole seconds at one per second are exact: a resolution as coarse as the interval allows nothing.
    let tolerance = if resolution_s < 0.5 * grid { resolution_s + binary } else { binary };
    let on_grid = |(i, t): (usize, &f64)| (t - (first + i as f64 * grid)).abs() <= tolerance;
    let uniform = time.iter().enumerate().all(on_grid);
    Some(Sampling {
        median_s,
        shortest_s: intervals.iter().copied().fold(f64::INFINITY, f64::min),
        longest_s: intervals.iter().copied().fold(0.0, f64::max),
        resolution_s,
        interval_s: uniform.then_some(grid),
    })
}

/// One unit of the last decimal that any of the first and last five hundred times needs.
fn resolution(time: &[f64]) -> f64 {
    let some = time.len().min(500);
    let ends = time[..some].iter().chain(&time[time.len() - some..]);
    let decimals = |t: &f64| {
        let text = t.to_string();
        text.split_once('.').map_or(0, |(_, decimals)| decimals.len())
    };
    let most = ends.map(decimals).max().unwrap_or(0);
    10f64.powi(-i32::try_from(most).unwrap_or(i32::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn printed(rate_hz: f64, decimals: usize, count: u32) -> Vec<f64> {
        (0..count)
            .map(|i| format!("{:.decimals$}", f64::from(i) / rate_hz).parse().unwrap())
            .collect()
    }

    #[test]
    fn times_rounded_by_printing_are_still_even() {
        for (rate, decimals) in [(200.0, 3), (300.0, 3), (44.1, 4), (4000.0, 5), (3.0, 1), (1.0, 0)]
        {
            let found = sampling(&printed(rate, decimals, 2000)).unwrap();
            assert!(found.is_uniform(), "{rate} Hz");
            assert!((found.rate_hz() / rate - 1.0).abs() < 1e-3, "{rate} Hz: {}", found.rate_hz());
        }
    }

    #[test]
    fn times_from_arithmetic_are_even() {
        let time: Vec<f64> = (0..5000).map(|i| 7.3 + f64::from(i) * 0.1).collect();
        assert!(sampling(&time).unwrap().is_uniform());
    }

    #[test]
    fn one_sample_off_the_grid_makes_it_uneven() {
        let mut time = printed(200.0, 3, 400);
        time[200] += 0.002;
        let found = sampling(&time).unwrap();
        assert!(!found.is_uniform());
        assert!((found.median_s - 0.005).abs() < 1e-9);
        let log: Vec<f64> = (0..50).map(|i| 1.2f64.powi(i)).collect();
        assert!(!sampling(&log).unwrap().is_uniform());
    }

    #[test]
    fn one_sample_has_no_sampling() {
        assert_eq!(sampling(&[]), None);
        assert_eq!(sampling(&[1.0]), None);
    }
}
