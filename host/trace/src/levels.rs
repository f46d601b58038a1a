//! Levels at which a measured force was held.
//!
//! A controlled force is noisy, ramps at rates that differ by far, and arrives late: a controller settles.
//! So a level is the longest stretch that stays within a band and is flat in it: a ramp crosses the band
//! from end to end however slow it is, and the turn of a wave bends in it. It begins where the force has
//! arrived for good, and not before the ramp to it has ended.

use std::iter;
use std::ops::Range;

use super::scatter::{self, scatter};

/// Half the width of the band, of the whole range of the force.
const BAND_SHARE: f64 = 0.01;
/// The same in standard deviations of what smoothing leaves of the noise.
const BAND_DEVIATIONS: f64 = 5.0;
/// Smoothing aims at this part of the band.
const SMOOTHING_SHARE: f64 = 0.1;
/// Most samples to smooth over.
const MAX_SMOOTHED_SAMPLES: usize = 51;
/// Fewest of these in a recording for their scatter to be told.
const MIN_SCATTER_SAMPLES: usize = 20;
/// Largest difference between thirds of a level, of half the width of the band: a ramp has 4/3, a turn 0.9.
const MAX_THIRDS_DIFFERENCE: f64 = 0.6;
/// Fewest samples of a level.
const MIN_LEVEL_SAMPLES: usize = 6;
/// Shortest level, of the recording.
const MIN_LEVEL_SHARE: f64 = 0.005;
/// A controller overshoots by less than so many half widths of the band, and for less than this part of the
/// level that it then settles to.
const OVERSHOOT: f64 = 6.0;
const BRIEF_SHARE: f64 = 0.2;
/// Parts of the way to a level between which the ramp is taken for straight.
const RAMP: (f64, f64) = (0.25, 0.75);

/// The levels at which a force rests away from its zero, as ranges of samples, in order.
///
/// The band is 1 % of the range of the force, or what noise asks for.
pub(super) fn levels(time: &[f64], force: &[f64]) -> Vec<Range<usize>> {
    if time.len() < MIN_LEVEL_SAMPLES {
        return Vec::new();
    }
    let noise = scatter(time, force);
    let range = |values: &[f64]| {
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        most - values.iter().copied().fold(f64::INFINITY, f64::min)
    };
    let wide = noise / (SMOOTHING_SHARE * BAND_SHARE * range(force)).max(f64::MIN_POSITIVE);
    // Odd, so that what is smoothed stays where it is.
    let width = ((wide * wide) as usize).clamp(1, MAX_SMOOTHED_SAMPLES) | 1;
    let smooth = smoothed(force, width);
    let left = (noise / (width as f64).sqrt()).max(correlated(time, &smooth));
    let band = (BAND_SHARE * range(&smooth)).max(BAND_DEVIATIONS * left);
    let shortest = (MIN_LEVEL_SHARE * time.len() as f64) as usize;
    let course = Course { time, force, smooth: &smooth, noise, band };
    let mut open: Vec<Range<usize>> = iter::once(0..time.len()).collect();
    let mut found = Vec::new();
    while let Some(part) = open.pop() {
        let Some(longest) = course.longest_rest(part.clone()) else { continue };
        if longest.len() < MIN_LEVEL_SAMPLES.max(shortest) {
            continue;
        }
        open.push(part.start..longest.start);
        open.push(longest.end..part.end);
        // What is left of a ramp between two rests would be flat by itself.
        let whole = course.extended(&longest);
        if course.is_flat(&whole) && course.level(&longest).abs() > 2.0 * band {
            found.push(longest);
        }
    }
    found.sort_by_key(|level| level.start);
    let settling = |pair: &[Range<usize>]| course.is_overshoot(&pair[0], &pair[1]);
    let overshoots: Vec<bool> = found.windows(2).map(settling).chain([false]).collect();
    let mut overshoots = overshoots.into_iter();
    found.retain(|_| !overshoots.next().unwrap_or(false));
    let ends: Vec<Range<usize>> = (0..found.len()).map(|k| course.ends(&found, k)).collect();
    ends.into_iter().filter(|level| level.len() >= MIN_LEVEL_SAMPLES).collect()
}

/// Scatter of every [`MAX_SMOOTHED_SAMPLES`]th of the smoothed samples: neighbours of a filtered force hide how much it still wanders.
/// None of a recording too short to tell.
fn correlated(time: &[f64], smooth: &[f64]) -> f64 {
    if smooth.len() < MIN_SCATTER_SAMPLES * MAX_SMOOTHED_SAMPLES {
        return 0.0;
    }
    let thinned =
        |values: &[f64]| values.iter().step_by(MAX_SMOOTHED_SAMPLES).copied().collect::<Vec<f64>>();
    scatter(&thinned(time), &thinned(smooth))
}

/// A force over time, with what counts as rest in it.
struct Course<'a> {
    time: &'a [f64],
    force: &'a [f64],
    smooth: &'a [f64],
    /// Standard deviation of the noise of the force, N.
    noise: f64,
    /// Half the width within which a force rests, N.
    band: f64,
}

impl Course<'_> {
    /// The longest stretch in time within which the smoothed force spans no more than the band.
    fn longest_rest(&self, part: Range<usize>) -> Option<Range<usize>> {
        let (mut highest, mut lowest) = (Queue::default(), Queue::default());
        let mut start = part.start;
        let mut longest: Option<Range<usize>> = None;
        let lasts = |range: &Range<usize>| self.time[range.end - 1] - self.time[range.start];
        for k in part {
            highest.push(k, self.smooth[k], |last, new| last <= new);
            lowest.push(k, self.smooth[k], |last, new| last >= new);
            while highest.first() - lowest.first() > 2.0 * self.band {
                start += 1;
                highest.forget(start);
                lowest.forget(start);
            }
            let rest = start..k + 1;
            if longest.as_ref().is_none_or(|longest| lasts(&rest) > lasts(longest)) {
                longest = Some(rest);
            }
        }
        longest
    }

    /// A rest as far as the force stays within the band about its level, whatever else lies there.
    fn extended(&self, rest: &Range<usize>) -> Range<usize> {
        let level = self.level(rest);
        let near = |k: &usize| (self.smooth[*k] - level).abs() <= self.band;
        let start = (0..rest.start).rev().take_while(near).last().unwrap_or(rest.start);
        let more = (rest.end..self.time.len()).take_while(near).count();
        start..rest.end + more
    }

    /// Whether its thirds lie at one level.
    fn is_flat(&self, rest: &Range<usize>) -> bool {
        let third = rest.len() / 3;
        let part = |from: usize| mean(&self.force[from..from + third]);
        let (first, middle, last) =
            (part(rest.start), part(rest.start + third), part(rest.end - third));
        let most = MAX_THIRDS_DIFFERENCE * self.band;
        (first - last).abs() <= most && (middle - 0.5 * (first + last)).abs() <= most
    }

    /// Whether a rest is where a controller turned back on its way to the next one.
    fn is_overshoot(&self, rest: &Range<usize>, next: &Range<usize>) -> bool {
        let (way, gap) = (self.level(rest) - self.level(next), next.start - rest.end);
        way.abs() < OVERSHOOT * self.band
            && gap <= rest.len()
            && (rest.len() as f64) < BRIEF_SHARE * next.len() as f64
    }

    fn level(&self, rest: &Range<usize>) -> f64 {
        scatter::median(self.force[rest.clone()].to_vec()).unwrap_or(0.0)
    }

    /// A level of several, from where the force has arrived to where it leaves.
    fn ends(&self, levels: &[Range<usize>], k: usize) -> Range<usize> {
        let rest = &levels[k];
        let level = self.level(rest);
        let before = k.checked_sub(1).map_or(0, |k| levels[k].end);
        let after = levels.get(k + 1).map_or(self.time.len(), |next| next.start);
        let middle = (rest.start + rest.end) / 2;
        let near = |k: &usize| (self.smooth[*k] - level).abs() <= self.band;
        let arrived = (before..middle).rev().take_while(near).last().unwrap_or(middle);
        let left = (middle..after).take_while(near).last().unwrap_or(middle);
        let from = self.corner(level, (before..arrived).rev());
        let to = self.corner(level, left + 1..after);
        let start = (arrived..middle).find(|&k| from.is_none_or(|from| self.time[k] >= from));
        let end = (middle..=left).rev().find(|&k| to.is_none_or(|to| self.time[k] <= to));
        start.unwrap_or(arrived)..end.unwrap_or(left) + 1
    }

    /// When the straight part of the ramp beside a level meets it, s; `away` leads away from the level.
    fn corner(&self, level: f64, away: impl Iterator<Item = usize>) -> Option<f64> {
        let mut ramp = Vec::new();
        let mut farthest: f64 = 0.0;
        for k in away {
            let off = self.smooth[k] - level;
            // The way ends where it turns back, or at a level of its own.
            if off.abs() < farthest - 2.0 * self.band {
                break;
            }
            farthest = farthest.max(off.abs());
            ramp.push((self.time[k], off));
        }
        let inner = (RAMP.0 * farthest, RAMP.1 * farthest);
        let end = ramp.iter().position(|(_, off)| off.abs() > inner.1).unwrap_or(ramp.len());
        let straight: Vec<(f64, f64)> =
            ramp[..end].iter().copied().filter(|(_, off)| off.abs() >= inner.0).collect();
        let count = straight.len() as f64;
        if straight.len() < 3 || farthest < 4.0 * (self.band + self.noise) {
            return None;
        }
        let (t, y) = straight.iter().fold((0.0, 0.0), |(t, y), (dt, dy)| (t + dt, y + dy));
        let (t, y) = (t / count, y / count);
        let square: f64 = straight.iter().map(|(at, _)| (at - t).powi(2)).sum();
        let product: f64 = straight.iter().map(|(at, off)| (at - t) * (off - y)).sum();
        let corner = t - y * square / product;
        corner.is_finite().then_some(corner)
    }
}

/// The largest (or smallest) values of a moving window.
#[derive(Default)]
struct Queue(std::collections::VecDeque<(usize, f64)>);

impl Queue {
    fn push(&mut self, k: usize, value: f64, beaten: impl Fn(f64, f64) -> bool) {
        while self.0.back().is_some_and(|&(_, last)| beaten(last, value)) {
            self.0.pop_back();
        }
        self.0.push_back((k, value));
    }

    fn forget(&mut self, before: usize) {
        while self.0.front().is_some_and(|&(k, _)| k < before) {
            self.0.pop_front();
        }
    }

    fn first(&self) -> f64 {
        self.0.front().map_or(0.0, |&(_, value)| value)
    }
}

/// Means over so many samples about each; fewer at the ends.
fn smoothed(values: &[f64], width: usize) -> Vec<f64> {
    let reach = width / 2;
    let mut sums = vec![0.0];
    sums.extend(values.iter().scan(0.0, |sum, value| {
        *sum += value;
        Some(*sum)
    }));
    (0..values.len())
        .map(|k| {
            let reach = reach.min(k).min(values.len() - 1 - k);
            (sums[k + reach + 1] - sums[k - reach]) / (2 * reach + 1) as f64
        })
        .collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    use super::*;

    /// A programme through corners of (time, force) at 200 Hz, followed by a controller with this time
    /// constant, with noise.
    fn followed(corners: &[(f64, f64)], lag: f64, noise: f64, seed: u64) -> (Vec<f64>, Vec<f64>) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let normal = Normal::new(0.0, noise).unwrap();
        let count = (corners[corners.len() - 1].0 * 200.0) as usize;
        let mut force = 0.0;
        (0..=count)
            .map(|k| {
                let t = k as f64 / 200.0;
                let next = corners.iter().position(|corner| corner.0 >= t).unwrap().max(1);
                let ((t0, y0), (t1, y1)) = (corners[next - 1], corners[next]);
                let wanted = y0 + (y1 - y0) * (t - t0) / (t1 - t0);
                force += (wanted - force) * if lag > 0.0 { 0.005 / lag } else { 1.0 };
                (t, force + normal.sample(&mut random))
            })
            .unzip()
    }

    /// To 1 N at 1.96 N/s, held, half unloaded, held.
    const PROGRAMME: [(f64, f64); 5] =
        [(0.0, 0.0), (0.51, 1.0), (10.01, 1.0), (10.265, 0.5), (19.765, 0.5)];

    #[test]
    fn both_holds_are_found_and_nothing_else_whatever_the_noise_and_the_controller() {
        for lag in [0.0, 0.03] {
            for noise in [0.0, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2] {
                for seed in 0..8 {
                    let (time, force) = followed(&PROGRAMME, lag, noise, seed);
                    let found = levels(&time, &force);
                    let told: Vec<(f64, f64)> =
                        found.iter().map(|r| (time[r.start], time[r.end - 1])).collect();
                    assert_eq!(found.len(), 2, "{lag} {noise} {seed}: {told:?}");
                    for ((from, to), (start, end)) in
                        told.iter().zip([(0.51, 10.01), (10.265, 19.765)])
                    {
                        // Never before the ramp ended, and soon after the controller arrived.
                        let soon = start - 0.02 <= *from && *from <= start + 0.1 + 6.0 * lag;
                        assert!(soon, "{lag} {noise} {seed}: {told:?}");
                        assert!((to - end).abs() < 0.1, "{lag} {noise} {seed}: {told:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_force_that_was_filtered_is_not_cut_to_pieces_by_the_noise_left_in_it() {
        for noise in [1e-3, 1e-2, 4e-2] {
            for seed in 0..8 {
                let (time, raw) = followed(&PROGRAMME, 0.03, noise, seed);
                // Two low passes of first order one way and back: some 5 Hz.
                let pass = |values: Vec<f64>| -> Vec<f64> {
                    let mut level = values[0];
                    let mut passed: Vec<f64> = values
                        .into_iter()
                        .map(|value| {
                            level += 0.15 * (value - level);
                            level
                        })
                        .collect();
                    passed.reverse();
                    passed
                };
                let force = pass(pass(raw));
                let found = levels(&time, &force);
                let told: Vec<(f64, f64)> =
                    found.iter().map(|r| (time[r.start], time[r.end - 1])).collect();
                assert_eq!(found.len(), 2, "{noise} {seed}: {told:?}");
                assert!(told.iter().all(|(from, to)| to - from > 9.0), "{noise} {seed}: {told:?}");
            }
        }
    }

    #[test]
    fn where_a_controller_overshoots_it_holds_nothing() {
        // Down to 0.47 N, where it turns back slowly to 0.5 N.
        let time: Vec<f64> = (0..3000).map(|k| 0.005 * f64::from(k)).collect();
        let at = |t: &f64| match *t {
            t if t < 0.5 => 2.0 * t,
            t if t < 5.0 => 1.0,
            t if t < 5.25 => 1.0 - 2.12 * (t - 5.0),
            t => 0.5 - 0.03 * (-(t - 5.25) / 0.15).exp(),
        };
        let force: Vec<f64> = time.iter().map(at).collect();
        let found = levels(&time, &force);
        let told: Vec<f64> = found.iter().map(|range| time[range.start]).collect();
        assert!(found.len() == 2 && (5.25..5.6).contains(&told[1]), "{told:?}");
    }

    #[test]
    fn a_slow_ramp_and_a_wave_hold_nothing() {
        let slow = [(0.0, 0.0), (40.0, 3.7), (49.5, 3.7), (60.0, 2.7), (69.5, 2.7)];
        let (time, force) = followed(&slow, 0.03, 5e-3, 3);
        let found = levels(&time, &force);
        let told: Vec<f64> = found.iter().map(|r| time[r.start]).collect();
        assert!(found.len() == 2 && (told[0] - 40.0).abs() < 0.7, "{told:?}");
        let wave: Vec<f64> = time.iter().map(|t| 2.0 - 1.5 * (0.7 * t).cos()).collect();
        assert!(levels(&time, &wave).is_empty());
    }

    #[test]
    fn holds_of_a_few_samples_are_found_where_nothing_scatters() {
        let time: Vec<f64> = (0..30).map(f64::from).collect();
        let force: Vec<f64> = time.iter().map(|t| (t * 1.0).min(5.0)).collect();
        assert_eq!(levels(&time, &force), iter::once(5..30).collect::<Vec<_>>());
    }
}
