//! A displacement that goes in stairs beside a signal that does not: it was recorded more slowly and held in between, or rounded to
//! coarse steps. A law takes every step as a sudden press; joined, they are the motion again.

use super::control::range;
use super::{DISPLACEMENT, Trace, noise};

/// How the displacement of a trace goes in stairs.
#[derive(Clone, Debug, PartialEq)]
pub struct Stairs {
    /// Name of the trace.
    pub trace: String,
    /// Why.
    pub cause: Cause,
    /// The usual step, mm.
    pub step_mm: f64,
    /// Samples that the displacement usually stays for where it moves.
    pub samples: f64,
}

/// Why a displacement goes in stairs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// It was recorded more slowly than the signal, each value held until the next.
    Held,
    /// It was rounded to multiples of the step.
    Rounded,
}

/// Fewest steps that show why there are any.
const MIN_STEPS: usize = 8;
/// Samples that a displacement stays for at least, in the middle, where it goes in stairs.
const MIN_SAMPLES: usize = 3;
/// How many times more often the signal changes.
const MORE_OFTEN: usize = 3;
/// Part of the steps, or of their distances, that are as the cause has them.
const MOST: f64 = 0.9;
/// Part of the step by which a rounded one may differ from a multiple of it.
const TOLERANCE: f64 = 0.02;
/// Factor within which the traces of a set have the same time between steps, or the same least step.
const ALIKE: f64 = 1.1;
/// Distances, in usual ones, up to which they count: a long one is a hold.
const NEAR: f64 = 5.0;
/// Part of the time that a value stays which the steps to it and from it take where it does not stay for long.
const LONG: f64 = 0.75;
/// Part of the noise of the signal from which half a step matters in it.
const MATTERS: f64 = 0.25;
/// Standard deviation of a value that is anywhere within a step, over the step.
const SPREAD: f64 = 0.289;

/// The traces of a set whose displacement goes in stairs beside a signal that does not, where that is felt in the signal.
#[must_use]
pub fn stairs(traces: &[Trace], signal: &str) -> Vec<Stairs> {
    let steps = |trace| Steps::of(trace, signal).map(|steps| (trace, steps));
    let known: Vec<(&Trace, Steps)> = traces.iter().filter_map(steps).collect();
    let Some(cause) = cause(&known) else { return Vec::new() };
    // Where one trace shows it, all were recorded so.
    if !known.iter().any(|(trace, steps)| matters(trace, signal, steps)) {
        return Vec::new();
    }
    let of = |(trace, steps): &(&Trace, Steps)| {
        let samples = if cause == Cause::Held { steps.period() } else { steps.usual() as f64 };
        Stairs { trace: trace.label(), cause, step_mm: steps.step(), samples }
    };
    known.iter().map(of).collect()
}

/// Why the displacements of a set go in stairs: one set, one way of recording. At a single speed both look alike.
fn cause(known: &[(&Trace, Steps)]) -> Option<Cause> {
    let seconds = known.iter().map(|(trace, steps)| steps.seconds(trace));
    let least = known.iter().map(|(_, steps)| steps.least());
    let all = |are: fn(&Steps) -> bool| known.iter().all(|(_, steps)| are(steps));
    if all(Steps::are_in_time) && alike(seconds) {
        Some(Cause::Held)
    } else if all(Steps::are_in_size) && alike(least) {
        Some(Cause::Rounded)
    } else {
        None
    }
}

/// The displacement of a trace without stairs: straight lines between the samples at which it steps.
pub fn join(trace: &mut Trace, stairs: &Stairs) {
    let Some(x) = trace.displacement() else { return };
    let Some(steps) = Steps::of_motion(x) else { return };
    let knots = match stairs.cause {
        Cause::Held => held_knots(x, &steps.at, stairs.samples),
        Cause::Rounded => rounded_knots(x, &steps.at),
    };
    let joined = lines(&trace.time, &knots);
    trace.set_column(DISPLACEMENT, joined);
}

/// Where a quantity steps, and by how much.
pub(super) struct Steps {
    /// Samples at which it has another value than before.
    pub at: Vec<usize>,
    /// By how much, in its unit, without the sign.
    sizes: Vec<f64>,
}

impl Steps {
    /// Those of a quantity that stays for so many samples or more, in the middle, before it steps; none where it does not.
    pub fn of_values(values: &[f64], samples: usize) -> Option<Self> {
        if 2 * changes(values) > values.len() {
            return None;
        }
        let at: Vec<usize> = (1..values.len()).filter(|&k| values[k] != values[k - 1]).collect();
        let sizes = at.iter().map(|&k| (values[k] - values[k - 1]).abs()).collect();
        let steps = Self { at, sizes };
        (steps.at.len() >= MIN_STEPS && steps.usual() >= samples).then_some(steps)
    }

    fn of_motion(x: &[f64]) -> Option<Self> {
        Self::of_values(x, MIN_SAMPLES)
    }

    /// Those of a trace whose signal goes on while its displacement stays.
    fn of(trace: &Trace, signal: &str) -> Option<Self> {
        let steps = Self::of_motion(trace.displacement()?)?;
        let values = trace.column(signal)?;
        (changes(values) >= MORE_OFTEN * steps.at.len()).then_some(steps)
    }

    /// Samples between neighbouring steps.
    pub fn distances(&self) -> impl Iterator<Item = usize> {
        self.at.windows(2).map(|pair| pair[1] - pair[0])
    }

    /// The middle one of the distances.
    fn usual(&self) -> usize {
        let mut distances: Vec<usize> = self.distances().collect();
        distances.sort_unstable();
        distances.get(distances.len() / 2).copied().unwrap_or(0)
    }

    /// Mean of the distances that are about the usual one.
    pub fn period(&self) -> f64 {
        let usual = self.usual();
        let near = self.distances().filter(|length| (2 * length).abs_diff(2 * usual) <= usual);
        let (sum, count) = near.fold((0, 0), |(sum, count), length| (sum + length, count + 1));
        sum as f64 / f64::from(count)
    }

    /// The period, s, in the trace that steps so.
    pub fn seconds(&self, trace: &Trace) -> f64 {
        self.period() * trace.duration() / trace.len() as f64
    }

    /// The middle one of the sizes, mm.
    fn step(&self) -> f64 {
        let mut sizes = self.sizes.clone();
        sizes.sort_by(f64::total_cmp);
        sizes[sizes.len() / 2]
    }

    /// The least of the sizes, mm.
    fn least(&self) -> f64 {
        self.sizes.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Whether they come at multiples of a time.
    pub fn are_in_time(&self) -> bool {
        let period = self.period();
        let near = self.distances().filter(|length| *length as f64 <= NEAR * period);
        mostly(near, |length| {
            let count = (length as f64 / period).round();
            count > 0.0 && (length as f64 - count * period).abs() <= 1.0
        })
    }

    /// Whether most are about the least: it is rounded, and goes on to the next value.
    pub fn are_single(&self) -> bool {
        let least = self.least();
        mostly(self.sizes.iter(), |size| *size < 1.5 * least)
    }

    /// Whether they are multiples of the least.
    fn are_in_size(&self) -> bool {
        let least = self.least();
        mostly(self.sizes.iter(), |size| {
            let count = (size / least).round();
            (size - count * least).abs() <= TOLERANCE * least
        })
    }
}

/// Whether the traces of a set have about the same value.
pub(super) fn alike(values: impl Iterator<Item = f64> + Clone) -> bool {
    values.clone().fold(0.0, f64::max) < ALIKE * values.fold(f64::INFINITY, f64::min)
}

/// How often a value differs from the one before.
fn changes(values: &[f64]) -> usize {
    values.windows(2).filter(|pair| pair[0] != pair[1]).count()
}

/// Whether it is so of most.
pub(super) fn mostly<T>(all: impl Iterator<Item = T>, is_so: impl Fn(T) -> bool) -> bool {
    let (good, count) = all.fold((0.0, 0.0), |(good, count), one| {
        (good + f64::from(u8::from(is_so(one))), count + 1.0)
    });
    good >= MOST * count
}

/// Whether the signal would show where in a step the displacement is.
fn matters(trace: &Trace, signal: &str, steps: &Steps) -> bool {
    let (Some(x), Some(values)) = (trace.displacement(), trace.column(signal)) else {
        return false;
    };
    let felt = SPREAD * steps.step() * range(values) / range(x);
    noise(trace, signal).map_or(true, |noise| felt > MATTERS * noise.standard_deviation)
}

/// A place in samples, and the displacement there, mm.
type Knot = (f64, f64);

/// A held value is that at its first sample; one that stays for longer than usual is left as late as usual.
fn held_knots(x: &[f64], at: &[usize], period: f64) -> Vec<Knot> {
    let mut knots = vec![(0.0, x[0])];
    for &k in at {
        let (last, value) = knots[knots.len() - 1];
        if k as f64 - last > 1.5 * period {
            knots.push((k as f64 - period, value));
        }
        knots.push((k as f64, x[k]));
    }
    knots.push(((x.len() - 1) as f64, x[x.len() - 1]));
    knots
}

/// A rounded value is half-way between two where it steps. Where it stays for long, or turns, it is reached and left as fast as the
/// steps beside it come.
fn rounded_knots(x: &[f64], at: &[usize]) -> Vec<Knot> {
    let end = (x.len() - 1) as f64;
    let inner = at.iter().map(|&k| k as f64 - 0.5);
    let places: Vec<f64> = std::iter::once(0.0).chain(inner).chain([end]).collect();
    let lengths: Vec<f64> = places.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let values: Vec<f64> = std::iter::once(x[0]).chain(at.iter().map(|&k| x[k])).collect();
    let half = |a: usize, b: usize| 0.5 * lengths[a].min(lengths[b]);
    let last = values.len() - 1;
    let mut knots = vec![(0.0, x[0])];
    for run in 0..=last {
        let (from, to, value) = (places[run], places[run + 1], values[run]);
        let came = if run > 0 { half(run - 1, run) } else { 0.0 };
        let goes = if run < last { half(run, run + 1) } else { 0.0 };
        let ends = run == 0 || run == last;
        let stays = ends
            || came + goes < LONG * lengths[run]
            || (value - values[run - 1]) * (values[run + 1] - value) < 0.0;
        if stays {
            push(&mut knots, (from + came, value));
            push(&mut knots, (to - goes, value));
        }
        if run < last {
            push(&mut knots, (to, 0.5 * (value + values[run + 1])));
        }
    }
    knots
}

/// Puts a knot at the end where it comes after the last.
fn push(knots: &mut Vec<Knot>, knot: Knot) {
    if knots.last().is_none_or(|last| knot.0 > last.0) {
        knots.push(knot);
    }
}

/// Straight lines between the knots, at every sample.
fn lines(time: &[f64], knots: &[Knot]) -> Vec<f64> {
    // Knots between samples lie in their time as in their number.
    let when = |place: f64| {
        let k = (place as usize).min(time.len() - 1);
        let next = (k + 1).min(time.len() - 1);
        time[k] + (place - k as f64) * (time[next] - time[k])
    };
    let mut next = 1;
    let value = |(k, t): (usize, &f64)| {
        while next + 1 < knots.len() && knots[next].0 < k as f64 {
            next += 1;
        }
        let ((from, low), (to, high)) = (knots[next - 1], knots[next]);
        let (from, to) = (when(from), when(to));
        let part = if to > from { ((t - from) / (to - from)).clamp(0.0, 1.0) } else { 1.0 };
        low + part * (high - low)
    };
    time.iter().enumerate().map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FORCE;

    const RATE: f64 = 500.0;

    /// A press to 5 mm with a hold, at this speed, mm/s.
    fn motion(speed: f64) -> impl Fn(f64) -> f64 {
        move |t| {
            (speed * (t - 1.0)).min(5.0 - speed * (t - 1.0 - 5.0 / speed - 2.0)).clamp(0.0, 5.0)
        }
    }

    fn trace(speed: f64, seen: impl Fn(f64) -> f64) -> Trace {
        let time: Vec<f64> = (0..4000).map(|k| f64::from(k) / RATE).collect();
        let noise = |k: usize| 1e-3 * ((k * 7919 % 101) as f64 - 50.0) / 50.0;
        let force = time.iter().enumerate().map(|(k, &t)| motion(speed)(t) + noise(k)).collect();
        let x = time.iter().map(|&t| seen(t)).collect();
        let mut trace = Trace { time, ..Trace::default() };
        trace.set_column(FORCE, force);
        trace.set_column(DISPLACEMENT, x);
        trace
    }

    /// Root mean square of the displacement's error, mm, as it is and joined.
    fn errors(mut traces: Vec<(f64, Trace)>, cause: Cause) -> Vec<[f64; 2]> {
        let all: Vec<Trace> = traces.iter().map(|(_, trace)| trace.clone()).collect();
        let found = stairs(&all, FORCE);
        assert_eq!(found.len(), all.len());
        assert!(found.iter().all(|it| it.cause == cause), "{found:?}");
        let error = |speed: f64, trace: &Trace| {
            let x = trace.displacement().unwrap();
            let off = trace.time.iter().zip(x).map(|(&t, x)| (x - motion(speed)(t)).powi(2));
            (off.sum::<f64>() / x.len() as f64).sqrt()
        };
        let each = traces.iter_mut().zip(&found).map(|((speed, trace), stairs)| {
            let before = error(*speed, trace);
            join(trace, stairs);
            [before, error(*speed, trace)]
        });
        each.collect()
    }

    #[test]
    fn a_displacement_that_was_held_is_joined_where_it_was_recorded() {
        for hz in [10.0, 30.0, 50.0] {
            let held =
                |speed: f64| trace(speed, move |t| motion(speed)((t * hz + 1e-9).floor() / hz));
            let traces = vec![(5.0, held(5.0)), (7.3, held(7.3))];
            for [before, after] in errors(traces, Cause::Held) {
                assert!(after < 0.25 * before, "{hz} Hz: {before} to {after}");
            }
        }
    }

    #[test]
    fn a_displacement_that_was_rounded_is_joined_between_its_steps() {
        let rounded = |speed: f64| trace(speed, move |t| (motion(speed)(t) / 0.2).round() * 0.2);
        let traces = vec![(3.0, rounded(3.0)), (7.3, rounded(7.3))];
        for [before, after] in errors(traces, Cause::Rounded) {
            assert!(after < 0.25 * before, "{before} to {after}");
        }
    }

    #[test]
    fn what_was_recorded_with_the_signal_goes_in_no_stairs() {
        let fine = trace(5.0, motion(5.0));
        let rounded = trace(5.0, |t| (motion(5.0)(t) / 1e-4).round() * 1e-4);
        assert_eq!(stairs(&[fine, rounded], FORCE), []);
        // Nor where the signal was held too.
        let mut slow = trace(5.0, |t| motion(5.0)((10.0 * t).floor() / 10.0));
        let force: Vec<f64> = slow.displacement().unwrap().iter().map(|x| 2.0 * x).collect();
        slow.set_column(FORCE, force);
        assert_eq!(stairs(&[slow], FORCE), []);
    }
}
