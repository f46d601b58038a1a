//! Regions from the recorded motion.

use std::ops::Range;

use shared::phase::{Region, RelaxationType};

use super::{Regions, SETTLED, SMALLEST, TOUCH, contact, deviation};
use crate::decomposition::Channel;
use palpate_trace::{DISPLACEMENT, Kind, Segment, Trace, segments};

/// Samples before and after over which a signal is averaged before it is compared with a level.
const REACH: usize = 2;
/// A neighbour counts in that average if it is no farther than this many of the shorter one of the
/// two intervals beside the sample.
const NEIGHBOUR_INTERVALS: f64 = 2.5;
/// Part of a hold's time at either end over which its signal is averaged.
const END: f64 = 0.1;
/// A pull ends because the indenter leaves if it then moves at this part of its mean speed at least.
const LEAVING: f64 = 0.1;
/// Share of the way out that still counts as standing, when the beginning of an approach is looked for.
const STANDING: f64 = 0.01;

/// The regions of a recording whose displacement, mm, is known.
pub(super) fn regions(trace: &Trace, displacement: &[f64], channel: &Channel) -> Regions {
    let region = places(trace, displacement, displacement, channel);
    let settled = SETTLED * deviation(trace, &channel.signal);
    let relaxation = relaxation(&trace.time, channel, &region, settled);
    Regions { region, relaxation }
}

/// The regions of a recording whose force, N, was controlled: holds are those of the force, and creep
/// is told from the displacement, mm.
pub(super) fn force_controlled(
    trace: &Trace,
    displacement: &[f64],
    force: &[f64],
    channel: &Channel,
) -> Regions {
    let region = places(trace, displacement, force, channel);
    let largest = displacement.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let band = (SETTLED * deviation(trace, DISPLACEMENT)).max(SMALLEST / 2.0 * largest);
    let mut relaxation = vec![RelaxationType::None; trace.len()];
    over_holds(&mut relaxation, &region, (&trace.time, displacement), |change, samples| {
        type_of(change, band * samples)
    });
    Regions { region, relaxation }
}

/// The region of each sample; holds are those of the controlled quantity.
fn places(
    trace: &Trace,
    displacement: &[f64],
    controlled: &[f64],
    channel: &Channel,
) -> Vec<Region> {
    let (name, signal) = contact(trace, channel);
    let noise = deviation(trace, name);
    let smoothed = smooth(&trace.time, signal);
    let moves = segments(&trace.time, controlled);
    let mut loads = vec![false; trace.len()];
    for segment in moves.iter().filter(|segment| segment.kind == Kind::Load) {
        loads[segment.range.clone()].fill(true);
    }
    let sense = pressing(&smoothed, |k| loads[k]);
    let level = touch_level(noise, largest_of(&smoothed));
    let touching = touches(&smoothed, level, sense);
    let pulls = pulls(trace, displacement, &smoothed, (level, sense), &moves);
    let mut region = vec![Region::Rest; trace.len()];
    let mut touched = false;
    for (index, segment) in moves.iter().enumerate() {
        let presses_next = moves[index + 1..].iter().any(|later| later.kind == Kind::Load);
        for sample in segment.range.clone() {
            touched |= touching[sample];
            region[sample] = match segment.kind {
                Kind::Unload | Kind::After if pulls[sample] => Region::Unloading,
                kind => of_sample(kind, touching[sample] || pulls[sample], touched),
            };
        }
        match segment.kind {
            Kind::Load => {
                let holds = moves.get(index + 1).is_some_and(|next| next.kind == Kind::Hold);
                mark_transition(&mut region, &segment.range, signal, noise, holds);
            }
            Kind::Approach | Kind::After if presses_next => {
                let begin = last_standing(segment, displacement);
                region[begin..segment.range.end].fill(Region::Preloading);
            }
            _ => {}
        }
    }
    let settled = SETTLED * deviation(trace, &channel.signal);
    end_recovery(&mut region, &smooth(&trace.time, &channel.latent), settled);
    region
}

fn of_sample(kind: Kind, touching: bool, touched: bool) -> Region {
    match (kind, touching) {
        (Kind::Load, true) => Region::Loading,
        (Kind::Load, false) => Region::Preloading,
        (Kind::Hold, true) => Region::Relaxation,
        (Kind::Unload, true) => Region::Unloading,
        (Kind::Approach, _) => Region::Rest,
        (Kind::Hold | Kind::Unload | Kind::After, _) if touched => Region::Recovery,
        (Kind::Hold | Kind::Unload | Kind::After, _) => Region::Rest,
    }
}

/// Mean over the samples around each that belong to the same sampling: where a coarse clock meets a fine
/// one, nothing is averaged over the coarse interval.
fn smooth(time: &[f64], values: &[f64]) -> Vec<f64> {
    let mean = |k: usize| {
        let beside = [k.checked_sub(1), Some(k + 1)].into_iter().flatten();
        let intervals = beside.filter_map(|j| Some((time.get(j)? - time[k]).abs()));
        let near = NEIGHBOUR_INTERVALS * intervals.fold(f64::INFINITY, f64::min);
        let around = k.saturating_sub(REACH)..(k + REACH + 1).min(values.len());
        let (sum, count) = around
            .filter(|&j| j == k || (time[j] - time[k]).abs() <= near)
            .fold((0.0, 0.0), |(sum, count), j| (sum + values[j], count + 1.0));
        sum / count
    };
    (0..values.len()).map(mean).collect()
}

/// The largest value by size, with its sign.
fn largest_of(values: &[f64]) -> f64 {
    let larger = |most: f64, value: f64| if value.abs() > most.abs() { value } else { most };
    values.iter().copied().fold(0.0, larger)
}

/// The sign of a signal while it is pressed, told from where the motion goes in: a pull may be larger.
fn pressing(signal: &[f64], goes_in: impl Fn(usize) -> bool) -> f64 {
    let inside: Vec<f64> = (0..signal.len()).filter(|&k| goes_in(k)).map(|k| signal[k]).collect();
    largest_of(if inside.is_empty() { signal } else { &inside }).signum()
}

/// The signal above which there is contact; it is lost below half of it.
pub(super) fn touch_level(noise: f64, largest: f64) -> f64 {
    (TOUCH * noise).max(SMALLEST * largest.abs())
}

/// Contact at each sample: made above a level, lost below half of it.
fn touches(signal: &[f64], level: f64, sense: f64) -> Vec<bool> {
    let mut touching = false;
    signal
        .iter()
        .map(|value| {
            let pressed = value * sense;
            touching = pressed > if touching { 0.5 * level } else { level };
            touching
        })
        .collect()
}

/// Whether the specimen adheres at each sample: from where pressing ends on the way out to where the pull
/// has gone. A pull that is still there when the indenter stands again is that of a specimen which is
/// clamped or has not recovered.
fn pulls(
    trace: &Trace,
    displacement: &[f64],
    signal: &[f64],
    (level, sense): (f64, f64),
    moves: &[Segment],
) -> Vec<bool> {
    let mut found = vec![false; trace.len()];
    let pull = |k: usize| -signal[k] * sense;
    let out = |kind: Kind| !matches!(kind, Kind::Load | Kind::Approach);
    for way in moves.chunk_by(|a, b| out(a.kind) && out(b.kind)).filter(|way| out(way[0].kind)) {
        let way = way[0].range.start..way[way.len() - 1].range.end;
        let Some(most) = way.clone().max_by(|&a, &b| pull(a).total_cmp(&pull(b))) else { continue };
        if pull(most) <= level {
            continue;
        }
        let pressed = (way.start..most).rev().find(|&k| pull(k) < -0.5 * level);
        let begin = pressed.map_or(way.start, |k| k + 1);
        let Some(end) = (most..way.end).find(|&k| pull(k) < 0.5 * level) else { continue };
        let speed = |from: usize, to: usize| {
            (displacement[from] - displacement[to]) / (trace.time[to] - trace.time[from])
        };
        let before = begin.saturating_sub(1);
        let leaving = before < most && speed(most, end) >= LEAVING * speed(before, most).max(0.0);
        if leaving && displacement[end] < displacement[most] {
            found[begin..end].fill(true);
        }
    }
    found
}

/// BC: what is left of a loading from its largest signal on, where the signal falls by more than noise
/// until then; or, before a hold, where the largest force is among the last samples of the loading.
fn mark_transition(
    region: &mut [Region],
    range: &Range<usize>,
    signal: &[f64],
    noise: f64,
    holds: bool,
) {
    // Averaged within the loading: what the hold brings must not pull its end down.
    let sizes: Vec<f64> = signal[range.clone()].iter().map(|value| value.abs()).collect();
    let index: Vec<f64> = (0..sizes.len()).map(|k| k as f64).collect();
    let means = smooth(&index, &sizes);
    let largest =
        |values: &[f64]| (0..values.len()).max_by(|&a, &b| values[a].total_cmp(&values[b]));
    let Some(mut peak) = largest(&means) else { return };
    // A difference of two means of five samples.
    let told = SETTLED * noise * (2.0 / (2 * REACH + 1) as f64).sqrt();
    if means[peak] - means[means.len() - 1] <= told || means.len() - peak <= REACH {
        let last = sizes.len().saturating_sub(REACH);
        let after = signal.get(range.end).map_or(f64::INFINITY, |value| value.abs());
        peak = match largest(&sizes) {
            Some(highest) if holds && highest >= last && sizes[highest] > after => highest,
            _ => return,
        };
    }
    for region in &mut region[range.start + peak..range.end] {
        if *region == Region::Loading {
            *region = Region::Transition;
        }
    }
}

/// The last sample of a stretch off the specimen at which the indenter still stood furthest out.
fn last_standing(segment: &Segment, displacement: &[f64]) -> usize {
    let range = segment.range.clone();
    let least = displacement[range.clone()].iter().copied().fold(f64::INFINITY, f64::min);
    let way = displacement[range.end - 1] - least;
    let standing = |k: &usize| displacement[*k] <= least + STANDING * way;
    range.clone().rev().find(standing).unwrap_or(range.start)
}

/// The type at each sample: in a hold from what the signal did over the hold, which needs no
/// relaxation function; elsewhere from the latent part.
fn relaxation(
    time: &[f64],
    channel: &Channel,
    region: &[Region],
    settled: f64,
) -> Vec<RelaxationType> {
    let largest = channel.input.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let band = settled.max(SMALLEST / 2.0 * largest);
    // A tension recorded as negative numbers relaxes upwards.
    let latent = channel.latent.iter().zip(&channel.input);
    let mut found: Vec<RelaxationType> =
        latent.map(|(latent, input)| type_of(latent * input.signum(), band)).collect();
    // In a hold the sign is that of the recording: a force that crosses zero after unloading still rises.
    let sense = pressing(&channel.input, |k| region[k] == Region::Loading);
    over_holds(&mut found, region, (time, &channel.input), |change, samples| {
        type_of(-change * sense, band * samples)
    });
    found
}

/// The type of what is left to go, or was gone; none within the band.
fn type_of(excess: f64, band: f64) -> RelaxationType {
    match excess {
        excess if excess > band => RelaxationType::TypeI,
        excess if excess < -band => RelaxationType::TypeII,
        _ => RelaxationType::None,
    }
}

/// Gives every hold one type, from how far a signal is at its end from where it was at its beginning, and
/// the deviation of that difference in those of one sample, at least 1. Nothing beside the hold counts.
fn over_holds(
    found: &mut [RelaxationType],
    region: &[Region],
    (time, signal): (&[f64], &[f64]),
    of: impl Fn(f64, f64) -> RelaxationType,
) {
    let mut begin = 0;
    while begin < region.len() {
        let same = |other: &Region| *other != region[begin];
        let end = region[begin..].iter().position(same).map_or(region.len(), |n| begin + n);
        if region[begin] == Region::Relaxation {
            let time = &time[begin..end];
            let part = END * (time[time.len() - 1] - time[0]);
            let first = time.partition_point(|t| *t <= time[0] + part);
            let last = time.partition_point(|t| *t < time[time.len() - 1] - part);
            let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
            let change = mean(&signal[begin + last..end]) - mean(&signal[begin..begin + first]);
            let samples = (1.0 / first as f64 + 1.0 / (time.len() - last) as f64).sqrt();
            found[begin..end].fill(of(change, samples.max(1.0)));
        }
        begin = end;
    }
}

/// A recovery is over when the latent part stays within its band to the end of the stretch.
fn end_recovery(region: &mut [Region], latent: &[f64], settled: f64) {
    let mut end = region.len();
    while end > 0 {
        let last = region[end - 1];
        let begin = region[..end].iter().rposition(|r| *r != last).map_or(0, |before| before + 1);
        if last == Region::Recovery {
            let busy = (begin..end).rev().find(|k| latent[*k].abs() > settled).unwrap_or(begin);
            region[busy + 1..end].fill(Region::Rest);
        }
        end = begin;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decomposition::{decompose, default_relaxation};
    use crate::regions;
    use palpate_model::{BaseLaw, Motion, Separation};
    use palpate_trace::{Column, FORCE};

    /// A staircase of three loadings and two partial unloadings, then release, with few and uneven
    /// samples: one a second in the ramps, one in six in the holds.
    fn staircase() -> Trace {
        let mut time = vec![0.0, 5.0, 10.0];
        let mut displacement = vec![-0.1, -0.1, -0.1];
        let mut at = -0.1;
        for to in [1.0, 2.0, 3.0, 2.0, 1.0, -0.1] {
            for step in 1..=20 {
                time.push(time[time.len() - 1] + 1.0);
                displacement.push(at + (to - at) * f64::from(step) / 20.0);
            }
            at = to;
            for _ in 0..20 {
                time.push(time[time.len() - 1] + 6.0);
                displacement.push(to);
            }
        }
        let law = BaseLaw::fung(2, Separation::Clamp);
        let motion = Motion {
            time: (&time[..]).into(),
            displacement: (&displacement[..]).into(),
            rest_before: None,
        };
        let force = law.predict(&[0.5, 0.3, 0.25, 0.25, 0.1, 0.02], &[motion]).remove(0);
        let column = |name: &str, values| Column { name: name.into(), values };
        let columns = vec![column(DISPLACEMENT, displacement), column(FORCE, force)];
        Trace { time, columns, ..Trace::default() }
    }

    #[test]
    fn a_coarse_and_uneven_staircase_has_all_its_regions() {
        let trace = staircase();
        let channel = decompose(&trace, FORCE, &default_relaxation(), || {}).unwrap();
        let found = regions::regions(&trace, &channel).unwrap();
        let seen: Vec<Region> = found.stretches().iter().map(|stretch| stretch.region).collect();
        use Region::*;
        let expected = [
            Rest, Preloading, Loading, Relaxation, Loading, Relaxation, Loading, Relaxation,
            Unloading, Relaxation, Unloading, Relaxation, Unloading, Recovery,
        ];
        assert_eq!(seen[..expected.len()], expected, "{seen:?}");
        // The filter's own rates are far too fast for this specimen, and the types are right all the same.
        let stretches = found.stretches();
        let holds = stretches.iter().filter(|stretch| stretch.region == Relaxation);
        let types: Vec<RelaxationType> = holds.map(|stretch| stretch.relaxation).collect();
        use RelaxationType::{TypeI, TypeII};
        assert_eq!(types, [TypeI, TypeI, TypeI, TypeII, TypeII]);
    }
}
