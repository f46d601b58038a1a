//! Long recordings in block means: as many as a contact model can tell apart, whatever the rate.
//!
//! Whatever its rates, a sum of exponentials answers ever more slowly to a motion that has come to rest: at
//! a time s after it, the answer within ε s is straight up to ε²/8 of what still relaxes. So samples at rest
//! are taken together over a small part of the time since the motion. Samples of a motion stay as they are.
//! A block lasts no longer than an even part of its trace, so that long holds keep their weight beside the
//! motions as they have it among all samples.

use super::{Column, Trace};

/// Samples of a set from which on a search on the means is worth it.
const WORTH_FROM_SAMPLES: usize = 20_000;
/// Samples for each mean from which on it is worth it.
const SAMPLES_PER_MEAN: usize = 4;
/// Duration of a block, over the time since the motion.
const BLOCK_SHARE: f64 = 0.05;
/// Change of the compression, over the largest of the set, within which a motion is at rest.
pub const REST: f64 = 2e-3;
/// Blocks that a set at rest throughout would have, and the fewest of a trace.
const BLOCKS: usize = 3000;
const MIN_TRACE_BLOCKS: usize = 300;
/// Samples of a set that stay as they are off the specimen, and the fewest and most of a trace: the noise is
/// seen there.
const KEPT_OFF_SPECIMEN: usize = 3000;
const FEWEST_QUIET: usize = 200;
const MOST_QUIET: usize = 1000;

/// The traces of a set in block means; none where they are not long, hardly fewer or without a motion.
#[must_use]
pub fn block_means(traces: &[Trace]) -> Option<Vec<Trace>> {
    let samples: usize = traces.iter().map(Trace::len).sum();
    if samples < WORTH_FROM_SAMPLES {
        return None;
    }
    let motions: Vec<&[f64]> = traces.iter().map(Trace::displacement).collect::<Option<_>>()?;
    let largest = motions.iter().flat_map(|x| x.iter().copied()).fold(0.0, f64::max);
    let blocks = (BLOCKS / traces.len()).max(MIN_TRACE_BLOCKS) as f64;
    let quiet = (KEPT_OFF_SPECIMEN / traces.len()).clamp(FEWEST_QUIET, MOST_QUIET);
    let means: Vec<Trace> = traces
        .iter()
        .zip(motions)
        .map(|(trace, x)| {
            let lasts = trace.time.last().zip(trace.time.first()).map_or(0.0, |(b, a)| b - a);
            means_of(trace, &begins(&trace.time, x, REST * largest, (lasts / blocks, quiet)))
        })
        .collect();
    let left: usize = means.iter().map(Trace::len).sum();
    (SAMPLES_PER_MEAN * left <= samples).then_some(means)
}

fn means_of(trace: &Trace, begins: &[usize]) -> Trace {
    let means = |values: &[f64]| -> Vec<f64> {
        let ends = begins.iter().skip(1).copied().chain([values.len()]);
        let mean = |(&begin, end): (&usize, usize)| {
            values[begin..end].iter().sum::<f64>() / (end - begin) as f64
        };
        begins.iter().zip(ends).map(mean).collect()
    };
    let column =
        |column: &Column| Column { name: column.name.clone(), values: means(&column.values) };
    Trace {
        path: trace.path.clone(),
        head: trace.head.clone(),
        time: means(&trace.time),
        columns: trace.columns.iter().map(column).collect(),
    }
}

/// Where the blocks of a motion begin, motions within `band`, mm, being rest.
#[must_use]
pub fn block_begins(time: &[f64], x: &[f64], band: f64) -> Vec<usize> {
    begins(time, x, band, (f64::INFINITY, 0))
}

/// Where the blocks of a motion begin; motions within `band` are rest, no block is longer than `longest`, s,
/// and so many samples off the specimen stay as they are.
fn begins(time: &[f64], x: &[f64], band: f64, (longest, most_quiet): (f64, usize)) -> Vec<usize> {
    let Some((&first, &start)) = x.first().zip(time.first()) else { return Vec::new() };
    let mut begins = vec![0];
    // The last place that the motion has left, and when.
    let (mut place, mut since) = (first, start);
    let (mut begin, mut quiet) = (0, usize::from(first <= 0.0));
    for k in 1..time.len() {
        let moved = (x[k] - place).abs() > band;
        quiet += usize::from(x[k] <= 0.0);
        let kept = x[k] <= 0.0 && quiet <= most_quiet;
        let most = longest.min(BLOCK_SHARE * (time[begin] - since));
        if moved || kept || time[k] - time[begin] > most {
            begins.push(k);
            begin = k;
        }
        if moved {
            (place, since) = (x[k], time[k]);
        }
    }
    begins
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DISPLACEMENT, FORCE, gaps};

    /// A rest, a press of a second, a hold, a release of a second, and a rest, at a rate.
    fn press(rate: f64, hold: f64) -> Trace {
        let count = ((4.0 + hold) * rate) as usize;
        let time: Vec<f64> = (0..count).map(|k| k as f64 / rate).collect();
        let x = |t: &f64| (4.0 * (t - 1.0)).min(4.0).min(4.0 * (3.0 + hold - t)).max(-0.1);
        let column = |name: &str, values| Column { name: name.into(), values };
        let displacement: Vec<f64> = time.iter().map(x).collect();
        let force = time.iter().map(|t| 3.0 * t).collect();
        let columns = vec![column(DISPLACEMENT, displacement), column(FORCE, force)];
        Trace { time, columns, ..Trace::default() }
    }

    #[test]
    fn motions_and_the_beginning_of_rests_off_the_specimen_stay_as_they_are() {
        let trace = press(100.0, 600.0);
        let means = block_means(std::slice::from_ref(&trace)).unwrap().remove(0);
        // A second of rest and a second of pressing.
        assert_eq!(means.time[..200], trace.time[..200]);
        assert_eq!(means.displacement().unwrap()[..200], trace.displacement().unwrap()[..200]);
        assert!(gaps(&means.time).is_empty());
        assert!(means.time.is_sorted_by(|a, b| a < b));
        // Every sample is in one block: a line through the time is one through the means.
        let line = means.time.iter().zip(means.force().unwrap());
        assert!(line.into_iter().all(|(t, f)| (f - 3.0 * t).abs() < 1e-9));
    }

    #[test]
    fn there_are_no_more_means_of_an_hour_than_of_ten_minutes() {
        let count = |hold: f64| block_means(&[press(50.0, hold)]).unwrap()[0].len();
        let (short, long) = (count(600.0), count(3600.0));
        assert!(long < short + 500 && long < BLOCKS + 1000, "{long} for {short}");
    }

    #[test]
    fn short_sets_and_those_without_a_rest_stay_as_they_are() {
        assert!(block_means(&[press(50.0, 60.0)]).is_none());
        let mut trace = press(50.0, 6000.0);
        trace.columns.remove(0);
        assert!(block_means(&[trace]).is_none());
        let swing: Vec<f64> = (0..50_000).map(|k| 2.0 + (0.1 * f64::from(k)).sin()).collect();
        let time = (0..50_000).map(|k| f64::from(k) * 0.01).collect();
        let columns = vec![Column { name: DISPLACEMENT.into(), values: swing }];
        assert!(block_means(&[Trace { time, columns, ..Trace::default() }]).is_none());
    }
}
