//! Ramps and holds of a motion.

use std::ops::Range;

use super::elapsed::elapsed;
use super::scatter::{self, NORMAL_MAD};

/// What happens in a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Before the first touch, resting or moving: displacement not above 0.
    Approach,
    /// Displacement grows.
    Load,
    /// Displacement rests on the specimen.
    Hold,
    /// Displacement falls.
    Unload,
    /// Off the specimen after a touch: displacement not above 0.
    After,
}

/// A stretch of a recording in which one thing happens. Segments follow each other without gap.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// What happens.
    pub kind: Kind,
    /// Its samples. A corner sample belongs to the hold.
    pub range: Range<usize>,
    /// Displacement of its first sample, mm.
    pub from_mm: f64,
    /// Displacement of its last sample, mm.
    pub to_mm: f64,
    /// Mean rate from the sample before its first (if there is one) to its last, mm/s.
    pub rate_mm_per_s: f64,
}

/// Movements below this part of the whole stroke are not told apart from rest.
const SMALLEST_MOVE: f64 = 0.004;
/// Deviations of the scatter within which samples count as the same.
const SAME_DEVIATIONS: f64 = 12.0;
/// A rest is a hold if it lasts this part of the time that the whole stroke takes at the fastest rate.
const SHORTEST_HOLD: f64 = 0.02;
/// Where the motion turns back, the same: the turning point of a sine is no hold.
const SHORTEST_TURN: f64 = 0.1;
/// There, a rest as long as this part of that time is a hold, a shorter one only if it is flat.
const LONG_HOLD: f64 = 0.3;
/// Flat is to have two samples of three within this part of the stroke.
const FLAT_SHARE: f64 = 3e-4;

/// Part of a hold's time at either end that may still move.
const END_SHARE: f64 = 0.1;
/// Samples of a hold that tell its own scatter.
const MIN_HOLD_SAMPLES: usize = 20;

/// Cuts a displacement, mm (positive into the specimen, 0 at the nominal touch), into segments.
///
/// Works on uneven sampling and on measured displacement: its scatter is taken from the data (second
/// differences), and moves of less than 12 deviations of it or 0.4 % of the stroke are rest.
/// Empty for fewer than two samples.
///
/// # Panics
/// If the two are not equally long.
#[must_use]
pub fn segments(time: &[f64], displacement: &[f64]) -> Vec<Segment> {
    assert_eq!(time.len(), displacement.len(), "one displacement for each time");
    if time.len() < 2 {
        return Vec::new();
    }
    let time = &elapsed(time)[..];
    let course = Course::new(time, displacement);
    let mut kinds = course.moves();
    course.mark_touches(&mut kinds);
    let stretches = stretches(&kinds).into_iter();
    stretches.map(|range| course.segment(kinds[range.start], range)).collect()
}

/// A displacement over time, with what counts as rest in it.
struct Course<'a> {
    time: &'a [f64],
    x: &'a [f64],
    /// Standard deviation of the scatter, mm.
    scatter: f64,
    /// Largest minus smallest displacement, mm.
    stroke: f64,
    /// Moves up to this are rest, mm.
    rest: f64,
    /// How far samples may lie off the polyline, mm.
    off: f64,
}

impl<'a> Course<'a> {
    fn new(time: &'a [f64], x: &'a [f64]) -> Self {
        let differences: Vec<f64> = scatter::second_differences(time, x).collect();
        let scatter = scatter::median(differences.iter().map(|d| d.abs()).collect()).unwrap_or(0.0)
            * NORMAL_MAD;
        let (low, high) = x
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)));
        let stroke = high - low;
        let rest = (SAME_DEVIATIONS * scatter).max(SMALLEST_MOVE * stroke);
        let off = (0.5 * SAME_DEVIATIONS * scatter).max(0.25 * SMALLEST_MOVE * stroke);
        Self { time, x, scatter, stroke, rest, off }
    }

    /// What each sample does: load, hold or unload.
    fn moves(&self) -> Vec<Kind> {
        let corners = self.corners();
        let mut kinds = vec![Kind::Hold; self.x.len()];
        for pair in corners.windows(2) {
            let step = self.x[pair[1]] - self.x[pair[0]];
            if step.abs() > self.rest {
                let kind = if step > 0.0 { Kind::Load } else { Kind::Unload };
                kinds[pair[0] + 1..=pair[1]].fill(kind);
            }
        }
        // The first sample does what the second does.
        kinds[0] = kinds[1];
        let fastest = self.fastest(&corners);
        for hold in rests(&kinds) {
            let lasts = self.time[hold.end - 1] - self.time[hold.start.saturating_sub(1)];
            let part = lasts * fastest / self.stroke;
            let beside = [hold.start.checked_sub(1), Some(hold.end)];
            let [before, after] = beside.map(|i| i.and_then(|i| kinds.get(i)));
            let holds = match before != after {
                false => part >= SHORTEST_HOLD,
                true if part < LONG_HOLD => part >= SHORTEST_TURN && self.is_flat(hold.clone()),
                true => true,
            };
            if !holds {
                self.dissolve(&mut kinds, hold);
            }
        }
        for hold in rests(&kinds) {
            self.fit_plateau(&mut kinds, hold);
        }
        kinds
    }

    /// Corners of the polyline that stays within `off` of every sample (Douglas and Peucker, with
    /// distances along the displacement).
    fn corners(&self) -> Vec<usize> {
        let mut keep = vec![false; self.x.len()];
        let mut open = vec![(0, self.x.len() - 1)];
        while let Some((from, to)) = open.pop() {
            keep[from] = true;
            keep[to] = true;
            let rate = (self.x[to] - self.x[from]) / (self.time[to] - self.time[from]);
            let off = |i: usize| {
                (self.x[i] - self.x[from] - rate * (self.time[i] - self.time[from])).abs()
            };
            let farthest = (from + 1..to).max_by(|&a, &b| off(a).total_cmp(&off(b)));
            if let Some(corner) = farthest.filter(|&corner| off(corner) > self.off) {
                open.push((from, corner));
                open.push((corner, to));
            }
        }
        (0..keep.len()).filter(|&i| keep[i]).collect()
    }

    /// Fastest rate of any piece of the polyline that moves, mm/s.
    fn fastest(&self, corners: &[usize]) -> f64 {
        let rate = |pair: &[usize]| {
            let step = (self.x[pair[1]] - self.x[pair[0]]).abs();
            let lasts = self.time[pair[1]] - self.time[pair[0]];
            if step > self.rest { step / lasts } else { 0.0 }
        };
        corners.windows(2).map(rate).fold(0.0, f64::max)
    }

    /// Whether two of three samples are at one level.
    fn is_flat(&self, rest: Range<usize>) -> bool {
        let inside = &self.x[rest];
        let level = scatter::median(inside.to_vec()).unwrap_or(0.0);
        let band = (6.0 * self.scatter).max(FLAT_SHARE * self.stroke);
        let on = inside.iter().filter(|&x| (x - level).abs() <= band).count();
        3 * on >= 2 * inside.len()
    }

    /// Gives the samples of a rest that is too short to be a hold to the moves beside it; between a
    /// load and an unload they part at the turning point.
    fn dissolve(&self, kinds: &mut [Kind], rest: Range<usize>) {
        let before = rest.start.checked_sub(1).map(|i| kinds[i]);
        let after = kinds.get(rest.end).copied();
        let (first, second) = match (before, after) {
            (Some(before), Some(after)) => (before, after),
            (Some(only), None) | (None, Some(only)) => (only, only),
            (None, None) => return,
        };
        let up = first == Kind::Load;
        let turn = rest.clone().max_by(|&a, &b| {
            let order = self.x[a].total_cmp(&self.x[b]);
            if up { order } else { order.reverse() }
        });
        let turn = turn.unwrap_or(rest.start);
        kinds[rest.start..=turn].fill(first);
        kinds[turn + 1..rest.end].fill(second);
    }

    /// Moves the ends of a hold to where the displacement reaches and leaves its level.
    fn fit_plateau(&self, kinds: &mut [Kind], hold: Range<usize>) {
        let inside = &self.x[hold.clone()];
        let level = scatter::median(inside.to_vec()).unwrap_or(0.0);
        let spread = scatter::median(inside.iter().map(|x| (x - level).abs()).collect());
        let spread = spread.unwrap_or(0.0) * NORMAL_MAD;
        // A motion that was recorded in steps scatters more than its holds do; a hold that drifts by the last digit does not
        // scatter at all, and is off its level all the same.
        let (own, inner) = match hold.len() >= MIN_HOLD_SAMPLES {
            true => {
                let own = scatter::scatter(&self.time[hold.clone()], inside);
                (own.min(self.scatter), self.inner(&hold, level))
            }
            false => (self.scatter, 0.0),
        };
        let band = (6.0 * spread).max(4.0 * own).max(1.5 * inner).max(1e-5 * self.stroke);
        let band = band.min(self.rest);
        let on = |i: &usize| (self.x[*i] - level).abs() <= band;
        let (Some(mut start), Some(last)) =
            (hold.clone().find(|i| on(i)), hold.clone().rev().find(|i| on(i)))
        else {
            return;
        };
        let mut end = last + 1;
        let moving = |i: &usize| kinds[*i] != Kind::Hold;
        start -= (0..start).rev().take_while(|i| on(i) && moving(i)).count();
        end += (end..self.x.len()).take_while(|i| on(i) && moving(i)).count();
        let before = hold.start.checked_sub(1).map(|i| kinds[i]);
        let after = kinds.get(hold.end).copied();
        if let Some(before) = before {
            kinds[hold.start.min(start)..start].fill(before);
        } else {
            start = hold.start;
        }
        if let Some(after) = after {
            kinds[end..hold.end.max(end)].fill(after);
        } else {
            end = hold.end;
        }
        kinds[start..end].fill(Kind::Hold);
    }

    /// How far off its level a hold is between its ends: all but one sample in twenty are nearer.
    fn inner(&self, hold: &Range<usize>, level: f64) -> f64 {
        let time = &self.time[hold.clone()];
        let (first, last) = (time[0], time[time.len() - 1]);
        let end = END_SHARE * (last - first);
        let within = |k: &usize| self.time[*k] >= first + end && self.time[*k] <= last - end;
        let mut off: Vec<f64> =
            hold.clone().filter(within).map(|k| (self.x[k] - level).abs()).collect();
        off.sort_by(f64::total_cmp);
        off.get(off.len() * 19 / 20).copied().unwrap_or(0.0)
    }

    /// Marks what lies before the first touch and between and after touches.
    fn mark_touches(&self, kinds: &mut [Kind]) {
        let touching = |i: usize| self.x[i] > self.rest;
        let mut off = Kind::Approach;
        let mut at = 0;
        while at < self.x.len() {
            // Off the specimen until well above 0; the touch itself is after the last sample at 0.
            let press = (at..self.x.len()).find(|&i| touching(i)).unwrap_or(self.x.len());
            let touch = (at..press).rev().find(|&i| self.x[i] <= 0.0).map_or(at, |i| i + 1);
            let touch = if press == self.x.len() { press } else { touch };
            kinds[at..touch].fill(off);
            // Rest that scatters about 0 is no hold: its last samples begin the load.
            if touch > at {
                let rest = (touch..press).take_while(|&i| kinds[i] == Kind::Hold).count();
                kinds[touch..touch + rest].fill(Kind::Load);
            }
            at = (press..self.x.len()).find(|&i| self.x[i] <= 0.0).unwrap_or(self.x.len());
            off = Kind::After;
            while at < self.x.len() && kinds[at - 1] == Kind::Hold && !touching(at - 1) {
                at -= 1;
            }
        }
    }

    fn segment(&self, kind: Kind, range: Range<usize>) -> Segment {
        let (first, last) = (range.start.saturating_sub(1), range.end - 1);
        let lasts = self.time[last] - self.time[first];
        let step = self.x[last] - self.x[first];
        Segment {
            kind,
            from_mm: self.x[range.start],
            to_mm: self.x[last],
            rate_mm_per_s: if lasts > 0.0 { step / lasts } else { 0.0 },
            range,
        }
    }
}

/// The stretches that are holds, in order.
fn rests(kinds: &[Kind]) -> Vec<Range<usize>> {
    stretches(kinds).into_iter().filter(|stretch| kinds[stretch.start] == Kind::Hold).collect()
}

/// Stretches of one kind, in order.
fn stretches(kinds: &[Kind]) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut start = 0;
    for end in 1..=kinds.len() {
        if end == kinds.len() || kinds[end] != kinds[start] {
            found.push(start..end);
            start = end;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::Kind::{After, Approach, Hold, Load, Unload};
    use super::*;

    /// A motion through (time, displacement) corners, sampled and with scatter of that deviation.
    fn motion(corners: &[(f64, f64)], interval: f64, scatter: f64) -> (Vec<f64>, Vec<f64>) {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let count = (corners.last().unwrap().0 / interval).round() as usize;
        (0..=count)
            .map(|i| {
                let t = i as f64 * interval;
                let next = corners.iter().position(|corner| corner.0 >= t - 1e-12).unwrap().max(1);
                let ((t0, x0), (t1, x1)) = (corners[next - 1], corners[next]);
                // Twelve uniform numbers make a normal one, near enough.
                let normal: f64 = (0..12).map(|_| random.next_u32() as f64 / 2f64.powi(32)).sum();
                (t, x0 + (x1 - x0) * (t - t0) / (t1 - t0) + scatter * (normal - 6.0))
            })
            .unzip()
    }

    const PRESS: [(f64, f64); 7] =
        [(0.0, 0.0), (0.2, 0.0), (0.8, 12.0), (5.1, 12.0), (5.3, 8.0), (9.0, 8.0), (9.4, 0.0)];

    fn kinds(found: &[Segment]) -> Vec<Kind> {
        found.iter().map(|segment| segment.kind).collect()
    }

    #[test]
    fn a_press_with_a_partial_unload_falls_into_its_parts() {
        let mut corners = PRESS.to_vec();
        corners.push((10.0, 0.0));
        let (time, x) = motion(&corners, 0.005, 0.0);
        let found = segments(&time, &x);
        assert_eq!(kinds(&found), [Approach, Load, Hold, Unload, Hold, Unload, After]);
        assert_eq!(found[2].range, 160..1021, "corner samples belong to the hold");
        assert!((found[1].rate_mm_per_s - 20.0).abs() < 1e-9);
        assert!((found[3].rate_mm_per_s + 20.0).abs() < 1e-9);
        assert_eq!((found[2].from_mm, found[2].to_mm), (12.0, 12.0));
    }

    #[test]
    fn scatter_of_a_measured_displacement_moves_corners_by_little() {
        for scatter in [0.001, 0.01, 0.03] {
            let (time, x) = motion(&PRESS, 0.005, scatter);
            let found = segments(&time, &x);
            let on: Vec<_> = found.iter().filter(|s| !matches!(s.kind, Approach | After)).collect();
            let order: Vec<_> = on.iter().map(|segment| segment.kind).collect();
            assert_eq!(order, [Load, Hold, Unload, Hold, Unload], "scatter {scatter}: {found:?}");
            for (segment, corner) in on.iter().zip([40_i64, 160, 1021, 1060, 1801]) {
                let off = segment.range.start as i64 - corner;
                assert!(off.abs() <= 3, "scatter {scatter}: {:?} off by {off}", segment.kind);
            }
        }
    }

    #[test]
    fn slow_long_records_and_uneven_sampling_are_cut_the_same() {
        let (mut time, mut x) = motion(&[(0.0, 0.0), (240.0, 20.0), (40_000.0, 20.0)], 4.0, 2e-4);
        let thin = |i: usize| i < 100 || i.is_multiple_of(7);
        let keep: Vec<bool> = (0..time.len()).map(thin).collect();
        let mut kept = keep.iter();
        time.retain(|_| *kept.next().unwrap());
        let mut kept = keep.iter();
        x.retain(|_| *kept.next().unwrap());
        let found = segments(&time, &x);
        let holds: Vec<_> = found.iter().filter(|segment| segment.kind == Hold).collect();
        assert_eq!(holds.len(), 1, "{found:?}");
        assert_eq!(holds[0].range, 60..time.len());
    }

    #[test]
    fn a_sine_has_no_holds_and_a_second_press_is_no_approach() {
        let time: Vec<f64> = (0..4000).map(|i| f64::from(i) * 0.005).collect();
        let sine: Vec<f64> = time.iter().map(|t| 3.0 - 2.9 * (2.0 * t).cos()).collect();
        let found = segments(&time, &sine);
        assert!(found.iter().all(|segment| matches!(segment.kind, Load | Unload)), "{found:?}");
        let mut corners = PRESS.to_vec();
        corners.extend(PRESS.map(|(t, x)| (t + 9.6, x)));
        let (time, x) = motion(&corners, 0.005, 0.0);
        let found = kinds(&segments(&time, &x));
        assert_eq!(found.iter().filter(|&&kind| kind == Approach).count(), 1);
        assert_eq!(found.iter().filter(|&&kind| kind == Hold).count(), 4);
        assert_eq!(found[6], After);
    }
}
