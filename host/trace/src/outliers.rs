//! Impossible samples: a motion that jumps away and back faster than the machine ever goes, a signal
//! that does so while the motion is smooth. They are told, never mended.

use std::ops::Range;

use super::{DISPLACEMENT, Trace};

/// A sample that cannot be.
#[derive(Clone, Debug, PartialEq)]
pub struct Outlier {
    /// Name of the trace.
    pub trace: String,
    /// Row of data, from 1.
    pub row: usize,
    /// Time, s.
    pub time_s: f64,
    /// The column.
    pub column: String,
    /// What it says.
    pub value: f64,
    /// The straight line between the samples around it.
    pub expected: f64,
}

/// Most samples in a row that jump away together.
const MAX_SAMPLES_AWAY: usize = 3;
/// Intervals over which a speed counts as one that the machine keeps up.
const KEPT_UP: usize = 5;
/// Times that speed, or that usual step of a signal, beyond which a step is a jump.
const JUMP_STEPS: f64 = 10.0;
/// Part of a jump by which what comes after it may differ from what was before.
const RETURN_SHARE: f64 = 0.5;
/// Samples on each side from which the usual step of a signal is taken.
const NEIGHBOURS: usize = 20;
/// Part of its largest step by which a motion may bend where a signal is said to jump by itself.
const MAX_BEND_SHARE: f64 = 0.2;

/// The impossible samples of a trace: of its motion, and of a column.
#[must_use]
pub fn outliers(trace: &Trace, column: &str) -> Vec<Outlier> {
    let told = |name: &str, values: &[f64], range: Range<usize>| -> Vec<Outlier> {
        let found = range.clone().map(|k| Outlier {
            trace: trace.label(),
            row: k + 1,
            time_s: trace.time[k],
            column: name.into(),
            value: values[k],
            expected: between(&trace.time, values, &range, k),
        });
        found.collect()
    };
    let motion = trace.displacement();
    let jumps = motion.map(|x| jumps_of_motion(&trace.time, x)).unwrap_or_default();
    let mut found = Vec::new();
    if let Some(x) = motion {
        found.extend(jumps.iter().flat_map(|range| told(DISPLACEMENT, x, range.clone())));
    }
    if column != DISPLACEMENT
        && let Some(values) = trace.column(column)
    {
        let jumps = jumps_of_signal(&trace.time, values).into_iter().filter(smooth(motion));
        found.extend(jumps.flat_map(|range| told(column, values, range)));
    }
    found
}

/// The trace without some rows.
#[must_use]
pub fn without(trace: &Trace, outliers: &[Outlier]) -> Trace {
    let label = trace.label();
    let own = |k: usize| outliers.iter().any(|out| out.row == k + 1 && out.trace == label);
    let kept: Vec<usize> = (0..trace.len()).filter(|&k| !own(k)).collect();
    with_rows(trace, &kept)
}

/// The trace with these rows alone.
pub(super) fn with_rows(trace: &Trace, kept: &[usize]) -> Trace {
    let take = |values: &[f64]| kept.iter().map(|&k| values[k]).collect();
    let mut left = Trace { time: take(&trace.time), ..trace.clone() };
    for column in &mut left.columns {
        column.values = take(&column.values);
    }
    left
}

/// A signal with the straight line between their neighbours in the place of samples that jump away and back while the motion is smooth:
/// they are no part of its noise.
#[must_use]
pub fn bridged(time: &[f64], motion: &[f64], signal: &[f64]) -> Vec<f64> {
    let mut bridged = signal.to_vec();
    for range in jumps_of_signal(time, signal).into_iter().filter(smooth(Some(motion))) {
        range.clone().for_each(|k| bridged[k] = between(time, signal, &range, k));
    }
    bridged
}

/// The straight line between the samples around a range, at one of its samples.
fn between(time: &[f64], values: &[f64], range: &Range<usize>, k: usize) -> f64 {
    let (from, to) = (range.start - 1, range.end);
    let part = (time[k] - time[from]) / (time[to] - time[from]);
    values[from] + part * (values[to] - values[from])
}

/// Ranges of a few samples that stand off the line between their neighbours so far that `is_far` says so of the nearest of them,
/// all to one side, where the samples around them agree.
fn excursions(
    time: &[f64],
    values: &[f64],
    is_far: impl Fn(&Range<usize>, f64) -> bool,
) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut k = 1;
    while k + 1 < values.len() {
        let away = |length: &usize| {
            let range = k..k + length;
            range.end < values.len()
                && least_off(time, values, &range).is_some_and(|least| {
                    let back = (values[range.end] - values[k - 1]).abs();
                    back <= RETURN_SHARE * least && is_far(&range, least)
                })
        };
        match (1..=MAX_SAMPLES_AWAY).find(away) {
            Some(length) => {
                found.push(k..k + length);
                k += length + 1;
            }
            None => k += 1,
        }
    }
    found
}

/// How far the nearest of some samples is off the line between their neighbours; none where they are on both sides of it.
fn least_off(time: &[f64], values: &[f64], range: &Range<usize>) -> Option<f64> {
    let off = |k: usize| values[k] - between(time, values, range, k);
    let first = off(range.start);
    let mut least = first.abs();
    for k in range.start + 1..range.end {
        let other = off(k);
        if other.signum() != first.signum() {
            return None;
        }
        least = least.min(other.abs());
    }
    Some(least)
}

/// Excursions of a motion that only a speed beyond the machine's could make.
fn jumps_of_motion(time: &[f64], x: &[f64]) -> Vec<Range<usize>> {
    let speeds: Vec<f64> = (1..x.len())
        .map(|k| ((x[k] - x[k - 1]) / (time[k] - time[k - 1]).max(f64::MIN_POSITIVE)).abs())
        .collect();
    if speeds.len() < KEPT_UP {
        return Vec::new();
    }
    let fastest = fastest_kept_up(&speeds);
    // The scatter of a motion that stands still, and the last digit that it is written with.
    let scatter = median(steps(x).filter(|step| *step > 0.0).collect());
    excursions(time, x, |range, least| {
        let lasts =
            (time[range.start] - time[range.start - 1]).max(time[range.end] - time[range.end - 1]);
        least > JUMP_STEPS * (fastest * lasts).max(scatter)
    })
}

/// The largest of the middle speeds of neighbours.
fn fastest_kept_up(speeds: &[f64]) -> f64 {
    speeds.windows(KEPT_UP).fold(0.0, |fastest, kept| {
        // Only where more than half are faster is their middle.
        if kept.iter().filter(|speed| **speed > fastest).count() <= KEPT_UP / 2 {
            return fastest;
        }
        let mut sorted = [0.0; KEPT_UP];
        sorted.copy_from_slice(kept);
        sorted.sort_unstable_by(f64::total_cmp);
        sorted[KEPT_UP / 2]
    })
}

/// By how much each sample differs from the one before.
fn steps(values: &[f64]) -> impl Iterator<Item = f64> {
    values.windows(2).map(|pair| (pair[1] - pair[0]).abs())
}

/// Excursions of a signal far beyond its usual step around them.
fn jumps_of_signal(time: &[f64], values: &[f64]) -> Vec<Range<usize>> {
    let steps: Vec<f64> = steps(values).collect();
    let overall = median(steps.iter().copied().filter(|step| *step > 0.0).collect());
    excursions(time, values, |range, least| {
        // What costs least first: nearly no sample comes to the median.
        if least <= JUMP_STEPS * overall {
            return false;
        }
        let before = range.start.saturating_sub(NEIGHBOURS)..range.start - 1;
        let after = range.end..(range.end + NEIGHBOURS).min(steps.len());
        let around = [&steps[before], &steps[after]];
        let largest = around.iter().copied().flatten().copied().fold(0.0, f64::max);
        least > 2.0 * largest && least > JUMP_STEPS * median(around.concat())
    })
}

/// Whether a motion goes straight on across a range of samples and their neighbours; so it does where there is none.
fn smooth(motion: Option<&[f64]>) -> impl Fn(&Range<usize>) -> bool {
    let largest = motion.map_or(0.0, |x| steps(x).fold(0.0, f64::max));
    move |range| {
        let Some(x) = motion else { return true };
        let around = range.start.saturating_sub(1)..(range.end + 1).min(x.len());
        let bend = |x: &[f64]| (x[2] - 2.0 * x[1] + x[0]).abs();
        x[around].windows(3).all(|x| bend(x) <= MAX_BEND_SHARE * largest)
    }
}

/// The middle value; 0 of none.
fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::{Column, FORCE};

    /// To 10 mm at 20 mm/s, a hold and back, at 100 Hz, with a force of `noise`.
    fn press(noise: f64) -> Trace {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let time: Vec<f64> = (0..400).map(|k| 0.01 * f64::from(k)).collect();
        let x: Vec<f64> = time
            .iter()
            .map(|t| (20.0 * (t - 0.5)).min(20.0 * (3.5 - t)).clamp(-0.5, 10.0))
            .collect();
        let force = x.iter().map(|x| {
            let error: f64 = StandardNormal.sample(&mut random);
            0.1 * x.max(0.0).powf(1.8) + noise * error
        });
        let force = force.collect();
        let column = |name: &str, values| Column { name: name.into(), values };
        let columns = vec![column(DISPLACEMENT, x), column(FORCE, force)];
        Trace { time, columns, ..Trace::default() }
    }

    fn changed(mut trace: Trace, column: usize, changes: &[(usize, f64)]) -> Trace {
        for (k, change) in changes {
            trace.columns[column].values[*k] += change;
        }
        trace
    }

    fn rows(trace: &Trace) -> Vec<(usize, String)> {
        outliers(trace, FORCE).into_iter().map(|out| (out.row, out.column)).collect()
    }

    #[test]
    fn a_clean_recording_has_none() {
        for noise in [0.0, 0.001, 0.02, 0.2] {
            assert_eq!(rows(&press(noise)), [], "{noise}");
        }
    }

    #[test]
    fn drop_outs_of_the_motion_are_found_by_their_row() {
        let out = changed(press(0.02), 0, &[(60, 12.0), (150, -12.0), (151, -12.0), (290, 12.0)]);
        let x = || DISPLACEMENT.to_owned();
        assert_eq!(rows(&out), [(61, x()), (151, x()), (152, x()), (291, x())]);
        let found = &outliers(&out, FORCE)[1];
        assert!((found.expected - 10.0).abs() < 1e-9 && (found.value + 2.0).abs() < 1e-9);
        assert!((found.time_s - 1.5).abs() < 1e-9);
    }

    #[test]
    fn single_jumps_of_the_signal_are_found_by_their_row() {
        let out = changed(press(0.02), 1, &[(20, 0.5), (90, 2.0), (200, -1.0)]);
        let force = || FORCE.to_owned();
        assert_eq!(rows(&out), [(21, force()), (91, force()), (201, force())]);
    }

    #[test]
    fn corners_steps_and_snaps_are_none() {
        // A motion that steps and stays; a force that snaps off and stays; a peak at a sharp turn.
        let mut stepped = press(0.01);
        stepped.columns[0].values = (0..400).map(|k| if k < 100 { 0.0 } else { 5.0 }).collect();
        assert_eq!(rows(&stepped), []);
        let mut snapped = press(0.01);
        for k in 0..400 {
            snapped.columns[1].values[k] -= if (320..350).contains(&k) { 2.0 } else { 0.0 };
        }
        assert_eq!(rows(&snapped), []);
        let triangle = |k: i32| f64::from((k % 10 - 5).abs());
        let mut turning = press(0.0);
        turning.columns[0].values = (0..400).map(triangle).collect();
        turning.columns[1].values = (0..400).map(|k| triangle(k).powi(2)).collect();
        assert_eq!(rows(&turning), []);
    }

    #[test]
    fn a_bridged_signal_differs_at_its_jumps_alone() {
        let clean = press(0.02);
        let out = changed(clean.clone(), 1, &[(20, 0.5), (90, 2.0), (91, 2.2)]);
        let signal = |trace: &Trace| trace.columns[1].values.clone();
        let bridged =
            |trace: &Trace| bridged(&trace.time, &trace.columns[0].values, &signal(trace));
        assert_eq!(bridged(&clean), signal(&clean));
        for (k, (bridged, clean)) in bridged(&out).into_iter().zip(signal(&clean)).enumerate() {
            let jumps = [20, 90, 91].contains(&k);
            assert!((bridged - clean).abs() < if jumps { 0.1 } else { 1e-12 }, "{k}");
        }
    }

    #[test]
    fn what_is_left_has_every_column_without_the_rows() {
        let whole = press(0.02);
        let out = changed(whole.clone(), 0, &[(60, 12.0)]);
        let left = without(&out, &outliers(&out, FORCE));
        assert_eq!(left.len(), 399);
        assert_eq!(left.time[60], whole.time[61]);
        assert_eq!(
            left.columns[1].values[59..61],
            [whole.columns[1].values[59], whole.columns[1].values[61]]
        );
    }
}
