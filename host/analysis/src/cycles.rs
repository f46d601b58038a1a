//! The six regions of a grasp, cycle by cycle: points, forces, work (3.4.1, Fig. 3.10, 4.4.3).

use std::ops::RangeInclusive;

use shared::phase::{Region, RelaxationType};

use super::pull_off::{PullOff, Sampled, pull_off};
use crate::decomposition::{DecompositionError, decompose, default_relaxation};
use crate::regions::{Regions, RegionsError, Stretch, regions, touch_level};
use palpate_fit::slope::{acceleration, velocity};
use palpate_model::Motion;
use palpate_trace::{Control, DISPLACEMENT, FORCE, SignalError, Trace, control, gaps, noise};

/// Share of the stroke by which the ends of a cycle may lie apart for it to count as closed.
const CLOSED: f64 = 0.02;
/// Standard errors of the noise above which an energy is told from zero.
const SIGNIFICANT_ENERGY: f64 = 2.0;
/// Standard deviation of normal scatter whose median absolute value is 1.
const NORMAL_MAD: f64 = 1.482_602_218_505_602;

/// A point of Fig. 3.10.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// `O`, `A`, …; from the second hold of a cycle on with its number: `C2`. Where the specimen adheres,
    /// `Z` is where the force passes zero and `P` the largest pull.
    pub name: String,
    /// Sample of the trace.
    pub sample: usize,
    /// Time, s.
    pub time_s: f64,
    /// Displacement, mm.
    pub displacement_mm: f64,
    /// Force, N.
    pub force_n: f64,
}

/// A stretch of one region within a cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// The region.
    pub region: Region,
    /// In a hold, the type of relaxation or creep.
    pub relaxation: RelaxationType,
    /// Its samples, from its first to the first of what follows; a hold ends at its own last sample, and a
    /// loading that turns back at the turn: what moves beyond them belongs to the unloading.
    pub samples: RangeInclusive<usize>,
    /// Whether the specimen pulls: the part of an unloading beyond zero force.
    pub pulls: bool,
    /// ∫F dx over it, mJ: positive where work goes into the specimen.
    pub work_mj: f64,
}

/// Which way a cycle goes round in the plane of force over displacement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// Force is higher on the way in: energy is dissipated.
    Clockwise,
    /// Force is higher on the way out: the specimen would give more than it took.
    Counterclockwise,
    /// The two ways are not told apart by more than noise.
    Neither,
}

/// One way in and back.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    /// From 1.
    pub number: usize,
    /// Its points, in order.
    pub points: Vec<Point>,
    /// Its regions, in order.
    pub pieces: Vec<Piece>,
    /// Work of the pieces that put work in, mJ.
    pub work_in_mj: f64,
    /// Work of the pieces that gave it back, mJ, positive.
    pub work_out_mj: f64,
    /// Standard error of their difference from the noise of the force, mJ.
    pub work_error_mj: f64,
    /// Whether it ends at the displacement at which it began, within 2 % of its stroke. Where it
    /// does not, the difference of the works is stored as well as dissipated.
    pub closed: bool,
    /// Sample of its largest force, by size.
    pub peak: usize,
    /// Largest force by size, with its sign, N.
    pub peak_force_n: f64,
    /// How the contact came off; none where the specimen does not adhere.
    pub pull_off: Option<PullOff>,
}

impl Cycle {
    /// Work in less work out, mJ.
    #[must_use]
    pub fn dissipated_mj(&self) -> f64 {
        self.work_in_mj - self.work_out_mj
    }

    /// Which way it goes round.
    #[must_use]
    pub fn turn(&self) -> Turn {
        match self.dissipated_mj() {
            lost if lost > SIGNIFICANT_ENERGY * self.work_error_mj => Turn::Clockwise,
            lost if lost < -SIGNIFICANT_ENERGY * self.work_error_mj => Turn::Counterclockwise,
            _ => Turn::Neither,
        }
    }
}

/// What moving the sensor's own mass adds to the force (3.3.4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    /// Moving mass, g.
    pub mass_g: f64,
    /// Largest acceleration by size, mm/s², as the samples show it.
    pub acceleration_mm_per_s2: f64,
    /// Acceleration that the scatter of the displacement alone would show, mm/s².
    pub scatter_mm_per_s2: f64,
    /// Mass times acceleration, N.
    pub force_n: f64,
    /// What it is compared with, N: the resolution of the force channel, else its noise.
    pub resolution_n: f64,
    /// Whether that is the resolution that the head gives.
    pub resolution_told: bool,
    /// As a share of the largest force.
    pub share_of_peak: f64,
}

/// A recording cut into cycles and regions.
#[derive(Clone, Debug)]
pub struct Segmentation {
    /// Which quantity was controlled.
    pub control: Control,
    /// Whether the head says so; else the data do.
    pub control_told: bool,
    /// The cycles, in order.
    pub cycles: Vec<Cycle>,
    /// The regions, sample by sample.
    pub regions: Regions,
    /// Standard deviation of the noise of the force, N; 0 where it cannot be told.
    pub force_noise_n: f64,
    /// The inertia check, where the head says what mass moved.
    pub inertia: Option<Inertia>,
}

/// Why a recording cannot be segmented.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum SegmentError {
    #[error(
        "{trace} has no column `{column}`: regions with their work need displacement_mm and force_N. \
         `palpate decompose` finds regions from a single signal."
    )]
    NoColumn { trace: String, column: &'static str },
    #[error(transparent)]
    Signal(#[from] SignalError),
    #[error(transparent)]
    Decomposition(#[from] DecompositionError),
    #[error(transparent)]
    Regions(#[from] RegionsError),
    #[error(
        "{trace}: no touch is found in it: the force never rises out of its noise while the indenter moves"
    )]
    NoCycle { trace: String },
}

/// Finds the cycles of a recording with their regions, points and work.
///
/// # Errors
/// Without displacement or force, when the force never changes, and when nothing is touched.
pub fn segment(trace: &Trace) -> Result<Segmentation, SegmentError> {
    let column = |name: &'static str| {
        trace
            .column(name)
            .ok_or_else(|| SegmentError::NoColumn { trace: trace.label(), column: name })
    };
    column(DISPLACEMENT)?;
    column(FORCE)?;
    trace.changing(FORCE)?;
    trace.changing(DISPLACEMENT)?;
    let channel = decompose(trace, FORCE, &default_relaxation(), || {})?;
    let regions = regions(trace, &channel)?;
    let force_noise_n = noise(trace, FORCE).map_or(0.0, |noise| noise.standard_deviation);
    let groups = groups(regions.stretches());
    let ends = groups.iter().skip(1).map(|next| next[0].range.start).chain([trace.len()]);
    let cycles: Vec<Cycle> = groups
        .iter()
        .zip(ends)
        .filter_map(|(group, end)| Path::of(trace)?.cycle(group, end, force_noise_n))
        .enumerate()
        .map(|(index, cycle)| Cycle { number: index + 1, ..cycle })
        .collect();
    if cycles.is_empty() {
        return Err(SegmentError::NoCycle { trace: trace.label() });
    }
    let inertia = inertia(trace, &regions, &cycles, force_noise_n);
    Ok(Segmentation {
        control: control(trace),
        control_told: trace.head.control.is_some(),
        cycles,
        regions,
        force_noise_n,
        inertia,
    })
}

/// The stretches of each cycle: a new one begins where the indenter comes in after it went out.
fn groups(stretches: Vec<Stretch>) -> Vec<Vec<Stretch>> {
    let mut found: Vec<Vec<Stretch>> = Vec::new();
    let mut out = true;
    for stretch in stretches {
        let comes_in = matches!(stretch.region, Region::Preloading | Region::Loading);
        if found.is_empty() && stretch.region != Region::Rest || out && comes_in {
            found.push(Vec::new());
        }
        match stretch.region {
            Region::Rest => {
                out = true;
                continue;
            }
            Region::Unloading | Region::Recovery => out = true,
            Region::Preloading | Region::Loading => out = false,
            Region::Transition | Region::Relaxation => {}
        }
        if let Some(cycle) = found.last_mut() {
            cycle.push(stretch);
        }
    }
    // The indenter that comes near but never touches makes no cycle.
    let touches = |cycle: &Vec<Stretch>| cycle.iter().any(|s| s.region != Region::Preloading);
    found.into_iter().filter(touches).collect()
}

/// A recording as a path in the plane of force over displacement.
struct Path<'a> {
    time: &'a [f64],
    x: &'a [f64],
    force: &'a [f64],
    /// For each sample, whether a gap in time lies before it.
    gap_before: Vec<bool>,
}

impl<'a> Path<'a> {
    fn of(trace: &'a Trace) -> Option<Self> {
        let mut gap_before = vec![false; trace.len()];
        for gap in gaps(&trace.time) {
            gap_before[gap.index] = true;
        }
        Some(Self {
            time: &trace.time,
            x: trace.displacement()?,
            force: trace.force()?,
            gap_before,
        })
    }

    /// ∫F dx between two samples, mJ (N mm), by the trapezoidal rule, nothing across gaps.
    fn work(&self, samples: &RangeInclusive<usize>) -> f64 {
        (samples.start() + 1..=*samples.end())
            .filter(|&k| !self.gap_before[k])
            .map(|k| 0.5 * (self.force[k] + self.force[k - 1]) * (self.x[k] - self.x[k - 1]))
            .sum()
    }

    /// Standard error of the work that independent noise of the force makes, mJ.
    fn work_error(&self, samples: &RangeInclusive<usize>, noise: f64) -> f64 {
        let (first, last) = (*samples.start(), *samples.end());
        let weight = |k: usize| 0.5 * (self.x[(k + 1).min(last)] - self.x[k.max(first + 1) - 1]);
        noise * (first..=last).map(|k| weight(k).powi(2)).sum::<f64>().sqrt()
    }

    /// The cycle of a group of stretches; the next one begins at `end`.
    fn cycle(&self, group: &[Stretch], end: usize, noise: f64) -> Option<Cycle> {
        let first = group.first()?.range.start;
        let whole = first..=group.last()?.range.end.min(self.time.len() - 1);
        let size = |k: &usize| self.force[*k].abs();
        let peak = whole.clone().max_by(|a, b| size(a).total_cmp(&size(b)))?;
        // A pull may be larger than the press before it.
        let loads = group.iter().filter(|stretch| stretch.region == Region::Loading);
        let pressed = loads.flat_map(|stretch| stretch.range.clone());
        let pressed = pressed.max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(peak);
        let pressed = self.force[pressed].signum();
        let pieces = self.pieces(group, touch_level(noise, self.force[peak]), pressed);
        let last = *pieces.last()?.samples.end();
        let sum = |sign: f64| pieces.iter().map(|piece| (sign * piece.work_mj).max(0.0)).sum();
        let (low, high) = extent(&self.x[whole.clone()]);
        let pull_off = pieces.iter().rfind(|piece| piece.pulls).and_then(|piece| {
            let path = Sampled { time: self.time, x: self.x, force: self.force };
            pull_off(&path, piece.samples.clone(), end, noise, pressed)
        });
        Some(Cycle {
            number: 0,
            points: self.points(&pieces, pull_off.as_ref()),
            work_in_mj: sum(1.0),
            work_out_mj: sum(-1.0),
            work_error_mj: self.work_error(&(first..=last), noise),
            closed: (self.x[last] - self.x[first]).abs() <= CLOSED * (high - low),
            peak,
            peak_force_n: self.force[peak],
            pieces,
            pull_off,
        })
    }

    /// The pieces of a group of stretches; an unloading is cut where a pull above the level begins, against
    /// the sign of the force `pressed`.
    fn pieces(&self, group: &[Stretch], level: f64, pressed: f64) -> Vec<Piece> {
        let mut found: Vec<Piece> = Vec::new();
        let mut begin = group.first().map_or(0, |stretch| stretch.range.start);
        for (index, stretch) in group.iter().enumerate() {
            let next = group.get(index + 1).map(|next| next.region);
            let turns = match stretch.region {
                Region::Relaxation => true,
                Region::Loading => next == Some(Region::Unloading),
                _ => false,
            };
            let end = (stretch.range.end - usize::from(turns)).min(self.time.len() - 1);
            let samples = begin.max(stretch.range.start.saturating_sub(1))..=end;
            begin = end;
            let pull = |k: &usize| -self.force[*k] * pressed;
            let pulls =
                stretch.region == Region::Unloading && samples.clone().any(|k| pull(&k) > level);
            let crossing = match pulls {
                true => {
                    samples.clone().rev().skip_while(|k| pull(k) <= level).find(|k| pull(k) <= 0.0)
                }
                false => None,
            };
            let mut push = |samples: RangeInclusive<usize>, pulls: bool| {
                let work_mj = self.work(&samples);
                let (region, relaxation) = (stretch.region, of_hold(stretch));
                found.push(Piece { region, relaxation, samples, pulls, work_mj });
            };
            match crossing.map(|zero| zero + 1) {
                Some(zero) if zero > *samples.start() => {
                    push(*samples.start()..=zero, false);
                    push(zero..=*samples.end(), true);
                }
                _ => push(samples, pulls),
            }
        }
        found
    }

    /// The points between which the pieces lie. B is the end of the loading, or where the force
    /// is largest within it if a transition follows; then C begins the hold.
    fn points(&self, pieces: &[Piece], pull_off: Option<&PullOff>) -> Vec<Point> {
        let mut found = Vec::new();
        let mut holds = 0;
        for (index, piece) in pieces.iter().enumerate() {
            let (from, to) = (*piece.samples.start(), *piece.samples.end());
            let before = index.checked_sub(1).map(|before| pieces[before].region);
            let numbered = |letter: &str, hold: usize| match hold {
                1 => letter.to_owned(),
                more => format!("{letter}{more}"),
            };
            match piece.region {
                Region::Preloading => found.push(("O".to_owned(), from)),
                Region::Loading => {
                    if matches!(before, None | Some(Region::Preloading)) {
                        found.push(("A".to_owned(), from));
                    }
                    found.push((numbered("B", holds + 1), to));
                }
                Region::Relaxation => {
                    holds += 1;
                    found.push((numbered("C", holds), from));
                    found.push((numbered("D", holds), to));
                }
                Region::Unloading => {
                    if let Some(pull_off) = pull_off.filter(|_| piece.pulls) {
                        found.push(("Z".to_owned(), from));
                        found.push(("P".to_owned(), pull_off.sample));
                    }
                    if pieces.get(index + 1).is_none_or(|next| next.region == Region::Recovery) {
                        found.push(("E".to_owned(), to));
                    }
                }
                Region::Recovery => found.push(("F".to_owned(), to)),
                Region::Transition | Region::Rest => {}
            }
        }
        let point = |(name, sample): (String, usize)| Point {
            name,
            sample,
            time_s: self.time[sample],
            displacement_mm: self.x[sample],
            force_n: self.force[sample],
        };
        found.into_iter().map(point).collect()
    }
}

fn of_hold(stretch: &Stretch) -> RelaxationType {
    if stretch.region == Region::Relaxation { stretch.relaxation } else { RelaxationType::None }
}

fn extent(values: &[f64]) -> (f64, f64) {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    (low, values.iter().copied().fold(f64::NEG_INFINITY, f64::max))
}

/// Mass times the largest acceleration, beside what the force channel can tell.
fn inertia(trace: &Trace, regions: &Regions, cycles: &[Cycle], noise: f64) -> Option<Inertia> {
    let mass_g = trace.head.setup.moving_mass_g?;
    let motion = Motion::of(trace).ok()?;
    let accelerations = acceleration(&motion, &velocity(&motion));
    let size = |a: &f64| a.abs();
    let largest = accelerations.iter().map(size).fold(0.0, f64::max);
    let resting = accelerations.iter().zip(&regions.region);
    let mut resting: Vec<f64> = resting
        .filter(|(_, region)| matches!(region, Region::Rest | Region::Relaxation))
        .map(|(a, _)| a.abs())
        .collect();
    let middle = resting.len() / 2;
    let scatter = match resting.is_empty() {
        true => 0.0,
        false => NORMAL_MAD * *resting.select_nth_unstable_by(middle, f64::total_cmp).1,
    };
    let told = trace.head.setup.force_resolution_n.filter(|resolution| *resolution > 0.0);
    let force_n = mass_g * 1e-3 * largest * 1e-3;
    let peak = cycles.iter().map(|cycle| cycle.peak_force_n.abs()).fold(0.0, f64::max);
    Some(Inertia {
        mass_g,
        acceleration_mm_per_s2: largest,
        scatter_mm_per_s2: scatter,
        force_n,
        resolution_n: told.unwrap_or(noise),
        resolution_told: told.is_some(),
        share_of_peak: force_n / peak.max(f64::MIN_POSITIVE),
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use palpate_model::{BaseLaw, Separation};

    /// A Fung specimen pressed along corners of (time, displacement), sampled every `interval` s.
    fn pressed(corners: &[(f64, f64)], interval: f64, noise: f64) -> Trace {
        let last = corners[corners.len() - 1].0;
        let count = (last / interval).round() as usize;
        let time: Vec<f64> = (0..=count).map(|k| k as f64 * interval).collect();
        let at = |t: f64| {
            let next = corners.iter().position(|c| c.0 >= t - 1e-9).unwrap_or(1).max(1);
            let ((t0, x0), (t1, x1)) = (corners[next - 1], corners[next]);
            x0 + (x1 - x0) * (t - t0) / (t1 - t0)
        };
        let displacement: Vec<f64> = time.iter().map(|&t| at(t)).collect();
        let law = BaseLaw::fung(2, Separation::Clamp);
        let motion = Motion {
            time: (&time[..]).into(),
            displacement: (&displacement[..]).into(),
            rest_before: None,
        };
        let force = law.predict(&[0.5, 0.3, 0.25, 0.25, 4.0, 0.5], &[motion]).remove(0);
        let wobble = |k: usize| noise * ((k * 7919 % 101) as f64 / 29.0 - 1.74);
        let force = force.iter().enumerate().map(|(k, f)| f + wobble(k)).collect();
        let mut trace = Trace { time, ..Trace::default() };
        trace.set_column(DISPLACEMENT, displacement);
        trace.set_column(FORCE, force);
        trace
    }

    /// Off the specimen, to 8 mm, hold, and back; as often as asked.
    fn presses(times: usize) -> Vec<(f64, f64)> {
        let mut corners = vec![(0.0, -1.0), (0.5, -1.0)];
        for k in 0..times {
            let t = 0.5 + 6.0 * k as f64;
            corners.extend([(t + 0.9, 8.0), (t + 3.0, 8.0), (t + 3.9, -1.0), (t + 6.0, -1.0)]);
        }
        corners
    }

    fn names(cycle: &Cycle) -> Vec<&str> {
        cycle.points.iter().map(|point| point.name.as_str()).collect()
    }

    #[test]
    fn every_cycle_has_its_points_and_loses_energy() {
        for noise in [0.0, 0.02] {
            let found = segment(&pressed(&presses(3), 0.01, noise)).unwrap();
            assert_eq!(found.cycles.len(), 3);
            for cycle in &found.cycles {
                let names = names(cycle);
                assert_eq!(names[..6], ["O", "A", "B", "C", "D", "E"], "noise {noise}");
                assert_eq!(cycle.turn(), Turn::Clockwise);
                assert!(cycle.closed);
                let c = &cycle.points[3];
                assert!((c.displacement_mm - 8.0).abs() < 0.2, "{c:?}");
            }
        }
    }

    fn hold_of(cycle: &Cycle) -> &Piece {
        cycle.pieces.iter().find(|piece| piece.region == Region::Relaxation).unwrap()
    }

    fn point<'a>(cycle: &'a Cycle, name: &str) -> &'a Point {
        cycle.points.iter().find(|point| point.name == name).unwrap()
    }

    #[test]
    fn a_hold_between_sharp_corners_does_no_work_and_ends_where_the_motion_begins() {
        let trace = pressed(&presses(1), 0.005, 0.0);
        let found = segment(&trace).unwrap();
        let cycle = &found.cycles[0];
        let hold = hold_of(cycle);
        assert!(hold.work_mj.abs() < 1e-9, "{} mJ", hold.work_mj);
        let (c, d) = (point(cycle, "C"), point(cycle, "D"));
        assert!((c.time_s - 1.4).abs() < 1e-9 && (d.time_s - 3.5).abs() < 1e-9, "{c:?} {d:?}");
        assert!((d.displacement_mm - 8.0).abs() < 1e-9);
    }

    #[test]
    fn b_is_where_the_force_is_largest_if_it_falls_before_the_motion_ends() {
        // The last 5 µm are slow: the force relaxes faster than it grows.
        let corners =
            [(0.0, -1.0), (0.5, -1.0), (1.4, 8.0), (1.41, 8.005), (3.5, 8.005), (4.4, -1.0)];
        let found = segment(&pressed(&corners, 0.005, 0.0)).unwrap();
        let cycle = &found.cycles[0];
        let (b, c) = (point(cycle, "B"), point(cycle, "C"));
        assert!((b.time_s - 1.4).abs() < 1e-9 && (c.time_s - 1.41).abs() < 1e-9, "{b:?} {c:?}");
        assert_eq!(b.sample, cycle.peak);
        assert!(cycle.pieces.iter().any(|piece| piece.region == Region::Transition));
    }

    /// A pad that adheres, as a rheometer records it: in at 0.1 mm/s and held with 2 samples a second, out at
    /// `speed` mm/s with 100. The pull is 2 N at most, at −0.4 mm.
    fn pad(speed: f64) -> Trace {
        let (mut time, mut x) = (Vec::new(), Vec::new());
        for k in 0..=100 {
            let t = 0.5 * f64::from(k);
            time.push(t);
            x.push((0.1 * t - 2.0).min(1.0));
        }
        for k in 1..=(3.0 / speed * 100.0) as u32 {
            let t = 0.01 * f64::from(k);
            time.push(50.0 + t);
            x.push(1.0 - speed * t);
        }
        let law = BaseLaw::fung(2, Separation::Clamp);
        let motion =
            Motion { time: (&time[..]).into(), displacement: (&x[..]).into(), rest_before: None };
        let force = law.predict(&[4.0, 0.3, 0.2, 0.1, 1.0, 0.1], &[motion]).remove(0);
        let pull = |x: f64| 2.0 * (-((x + 0.4) / 0.25).powi(2)).exp();
        let noise = |k: usize| 0.002 * ((k * 7919 % 101) as f64 / 29.0 - 1.74);
        let force = (0..time.len())
            .map(|k| force[k] - if time[k] > 50.0 { pull(x[k]) } else { 0.0 } + noise(k))
            .collect();
        let mut trace = Trace { time, ..Trace::default() };
        trace.set_column(DISPLACEMENT, x);
        trace.set_column(FORCE, force);
        trace
    }

    #[test]
    fn whatever_the_clock_a_falling_hold_is_type_1_and_a_pull_belongs_to_the_contact() {
        for speed in [0.03, 0.3, 3.0] {
            let found = segment(&pad(speed)).unwrap();
            let cycle = &found.cycles[0];
            assert_eq!(hold_of(cycle).relaxation, RelaxationType::TypeI, "{speed} mm/s");
            assert_eq!(names(cycle)[..7], ["O", "A", "B", "C", "D", "Z", "P"], "{speed} mm/s");
            let e = point(cycle, "E");
            assert!((-1.05..-0.85).contains(&e.displacement_mm) && e.force_n > -0.05, "{e:?}");
            let pull = cycle.pull_off.unwrap();
            assert!((pull.force_n - 2.0).abs() < 0.01 && pull.zero_n.abs() < 0.002, "{pull:?}");
            assert!((pull.displacement_mm + 0.4).abs() < 0.04, "{pull:?}");
            assert!((pull.speed_mm_per_s / speed - 1.0).abs() < 0.01, "{pull:?}");
            assert_eq!(pull.separation_mm, e.displacement_mm);
            // What lies below zero of the same curve, summed in another way.
            let (x, force) = (found_column(speed, DISPLACEMENT), found_column(speed, FORCE));
            let area: f64 = (102..x.len())
                .map(|k| {
                    (x[k - 1] - x[k]) * 0.5 * ((-force[k]).max(0.0) + (-force[k - 1]).max(0.0))
                })
                .sum();
            assert!((pull.work_mj / area - 1.0).abs() < 0.02, "{} {area}", pull.work_mj);
        }
    }

    fn found_column(speed: f64, name: &str) -> Vec<f64> {
        pad(speed).column(name).unwrap().to_vec()
    }

    #[test]
    fn a_clamped_specimen_that_still_pulls_at_rest_has_no_pull_off() {
        let mut trace = pressed(&presses(2), 0.01, 0.0);
        let x = trace.displacement().unwrap().to_vec();
        let time = trace.time.clone();
        let law = BaseLaw::fung(2, Separation::Bonded);
        let motion =
            Motion { time: (&time[..]).into(), displacement: (&x[..]).into(), rest_before: None };
        let force = law.predict(&[0.5, 0.3, 0.25, 0.25, 4.0, 0.5], &[motion]).remove(0);
        trace.set_column(FORCE, force);
        let found = segment(&trace).unwrap();
        assert!(found.cycles.iter().all(|cycle| cycle.pull_off.is_none()));
    }

    #[test]
    fn a_staircase_is_one_cycle_and_its_holds_are_numbered() {
        let steps = [(0.0, -1.0), (0.5, -1.0), (1.0, 4.0), (3.0, 4.0), (3.5, 8.0), (6.0, 8.0)];
        let back = [(6.5, 4.0), (9.0, 4.0), (9.6, -1.0), (11.0, -1.0)];
        let corners: Vec<(f64, f64)> = steps.into_iter().chain(back).collect();
        let found = segment(&pressed(&corners, 0.01, 0.0)).unwrap();
        assert_eq!(found.cycles.len(), 1);
        let cycle = &found.cycles[0];
        assert_eq!(
            names(cycle)[..11],
            ["O", "A", "B", "C", "D", "B2", "C2", "D2", "C3", "D3", "E"]
        );
        let holds: Vec<_> =
            cycle.pieces.iter().filter(|p| p.region == Region::Relaxation).collect();
        use RelaxationType::{TypeI, TypeII};
        assert_eq!(holds.iter().map(|p| p.relaxation).collect::<Vec<_>>(), [TypeI, TypeI, TypeII]);
    }

    #[test]
    fn under_force_control_the_hold_is_that_of_the_force_and_it_creeps() {
        // The same law with the roles of force and displacement exchanged: creep.
        let time: Vec<f64> = (0..2000).map(|k| 0.01 * f64::from(k)).collect();
        let force: Vec<f64> = time
            .iter()
            .map(|t| match t {
                t if *t < 1.0 => 0.0,
                t if *t < 2.0 => 4.0 * (t - 1.0),
                t if *t < 12.0 => 4.0,
                t if *t < 13.0 => 4.0 * (13.0 - t),
                _ => 0.0,
            })
            .collect();
        let mut slow = 0.0;
        let displacement: Vec<f64> = (0..time.len())
            .map(|k| {
                slow += 0.01 * 0.5 * (force[k] - slow);
                0.8 * force[k] + 0.4 * slow
            })
            .collect();
        let mut trace = Trace { time, ..Trace::default() };
        trace.set_column(DISPLACEMENT, displacement);
        trace.set_column(FORCE, force);
        let found = segment(&trace).unwrap();
        assert_eq!((found.control, found.control_told), (Control::Force, false));
        let cycle = &found.cycles[0];
        let hold = cycle.pieces.iter().find(|piece| piece.region == Region::Relaxation).unwrap();
        assert_eq!(hold.relaxation, RelaxationType::TypeI);
        assert!((trace.time[*hold.samples.start()] - 2.0).abs() < 0.05);
        assert!((trace.time[*hold.samples.end()] - 12.0).abs() < 0.05);
        assert!(hold.work_mj > 0.0, "creep takes work");
        assert_eq!(cycle.turn(), Turn::Clockwise);
    }

    #[test]
    fn inertia_is_mass_times_acceleration() {
        let mut trace = pressed(&presses(1), 0.01, 0.0);
        assert_eq!(segment(&trace).unwrap().inertia, None);
        trace.head.setup.moving_mass_g = Some(14.0);
        trace.head.setup.force_resolution_n = Some(0.25);
        let found = segment(&trace).unwrap().inertia.unwrap();
        assert!((found.force_n - 14e-6 * found.acceleration_mm_per_s2).abs() < 1e-15);
        assert!(found.acceleration_mm_per_s2 > 400.0 && found.resolution_told);
    }

    #[test]
    fn what_is_missing_is_named() {
        let mut trace = pressed(&presses(1), 0.01, 0.0);
        trace.columns.retain(|column| column.name != FORCE);
        let error = segment(&trace).unwrap_err().to_string();
        assert!(error.contains("force_N"), "{error}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn the_pieces_share_out_the_work_of_the_whole_cycle(
            depth in 2.0f64..12.0, back in 0.5f64..3.0, interval in 0.004f64..0.02
        ) {
            let corners = [(0.0, -1.0), (0.5, -1.0), (1.3, depth), (3.0, depth), (3.0 + back, -1.0), (8.0, -1.0)];
            let trace = pressed(&corners, interval, 0.0);
            let found = segment(&trace).unwrap();
            for cycle in &found.cycles {
                let pieces: f64 = cycle.pieces.iter().map(|piece| piece.work_mj).sum();
                prop_assert!((pieces - cycle.dissipated_mj()).abs() < 1e-9);
                prop_assert!(cycle.dissipated_mj() >= 0.0);
            }
        }
    }
}
