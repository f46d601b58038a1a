//! Gaps in time: reported, never filled.

use std::ops::Range;

/// How many times longer than its neighbours an interval must be to count as a gap.
const GAP_FACTOR: f64 = 10.0;

/// A long interval is part of the sampling, and no gap, where it is not that much longer than the mean of
/// so many on either side, or others at least half as long are not rare among them: more than one in
/// [`RARE_ONE_IN`], and more than one.
const NEIGHBOURS: usize = 100;
const RARE_ONE_IN: usize = 60;

/// An interval in which samples are missing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Index of the first sample after the gap.
    pub index: usize,
    /// Time of the last sample before it, s.
    pub from_s: f64,
    /// Time of the first sample after it, s.
    pub to_s: f64,
}

/// Gaps of a recording: intervals more than ten times as long as both the one before and the one
/// after, unless such long ones are usual nearby. A recording that thins out steadily (log-spaced,
/// decimated) so has none at any scale, and neither has one in bursts or at random instants. The first
/// and the last interval have neighbours on one side only and are compared with the two nearest.
#[must_use]
pub fn gaps(time: &[f64]) -> Vec<Gap> {
    let interval: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let last = interval.len().saturating_sub(1);
    let usual = |i: usize| {
        let around = i.saturating_sub(NEIGHBOURS)..(i + NEIGHBOURS + 1).min(interval.len());
        let others = || around.clone().filter(|&j| j != i);
        let mean = others().map(|j| interval[j]).sum::<f64>() / others().count().max(1) as f64;
        let as_long = others().filter(|&j| interval[j] >= 0.5 * interval[i]).count();
        interval[i] <= GAP_FACTOR * mean || as_long > (around.len() / RARE_ONE_IN).max(1)
    };
    (0..interval.len())
        .filter(|_| interval.len() >= 3)
        .filter(|&i| {
            let neighbours = match i {
                0 => [1, 2],
                _ if i == last => [last - 1, last - 2],
                _ => [i - 1, i + 1],
            };
            neighbours.iter().all(|&j| interval[i] > GAP_FACTOR * interval[j]) && !usual(i)
        })
        .map(|i| Gap { index: i + 1, from_s: time[i], to_s: time[i + 1] })
        .collect()
}

/// The stretches between gaps, as ranges of samples; together they are the whole recording.
#[must_use]
pub fn runs(time: &[f64]) -> Vec<Range<usize>> {
    let mut starts = vec![0];
    starts.extend(gaps(time).iter().map(|gap| gap.index));
    let ends = starts.iter().skip(1).copied().chain([time.len()]).collect::<Vec<_>>();
    starts
        .into_iter()
        .zip(ends)
        .map(|(start, end)| start..end)
        .filter(|run| !run.is_empty())
        .collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn a_dropout_is_a_gap_wherever_it_falls() {
        for missing in [1..30, 40..60, 70..99] {
            let time: Vec<f64> =
                (0..100).filter(|i| !missing.contains(i)).map(|i| f64::from(i) * 0.005).collect();
            let found = gaps(&time);
            assert_eq!(found.len(), 1, "{missing:?}");
            assert!((found[0].to_s - f64::from(missing.end) * 0.005).abs() < 1e-12);
            assert_eq!(runs(&time).len(), 2);
        }
    }

    #[test]
    fn bursts_and_random_instants_have_no_gap_but_a_dropout_among_them_is_one() {
        // Three samples within 2 ms, every 20 ms.
        let bursts: Vec<f64> =
            (0..1280).map(|k| f64::from(k / 3) * 0.02 + f64::from(k % 3) * 0.001).collect();
        assert_eq!(gaps(&bursts), []);
        // Instants without memory, 200 a second: a Poisson process.
        let mut state = 7u64;
        let random: Vec<f64> = (0..2000)
            .scan(0.0, |now, _| {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                *now -= ((state >> 11) as f64 / (1u64 << 53) as f64).ln() / 200.0;
                Some(*now)
            })
            .collect();
        assert_eq!(gaps(&random), []);
        for time in [bursts, random] {
            let late = |(k, t): (usize, &f64)| if k < 600 { *t } else { t + 3.0 };
            let time: Vec<f64> = time.iter().enumerate().map(late).collect();
            let found = gaps(&time);
            assert_eq!((found.len(), found[0].index), (1, 600));
        }
    }

    #[test]
    fn log_spaced_and_decimated_recordings_have_no_gap() {
        let log: Vec<f64> = (0..60).map(|i| 10f64.powf(f64::from(i) / 10.0 - 3.0)).collect();
        let decades: Vec<f64> = (0..8).map(|i| 10f64.powi(i)).collect();
        let two_rates: Vec<f64> =
            (0..50).map(|i| f64::from(i) * 0.01).chain((1..50).map(f64::from)).collect();
        for time in [log, decades, two_rates] {
            assert_eq!(gaps(&time), []);
        }
    }

    proptest! {
        #[test]
        fn runs_cover_every_sample_once_and_ignore_the_unit_of_time(
            steps in proptest::collection::vec(1e-3..1e3_f64, 0..40)
        ) {
            let time: Vec<f64> = steps.iter().scan(0.0, |now, step| { *now += step; Some(*now) }).collect();
            let runs_found = runs(&time);
            let covered: Vec<usize> = runs_found.iter().cloned().flatten().collect();
            prop_assert_eq!(covered, (0..time.len()).collect::<Vec<_>>());
            let doubled: Vec<f64> = time.iter().map(|t| t * 2.0).collect();
            prop_assert_eq!(runs(&doubled), runs_found);
        }
    }
}
