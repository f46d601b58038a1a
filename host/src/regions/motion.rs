//! Regions from the recorded motion.

use std::ops::Range;

use shared::phase::{Region, RelaxationType};

use super::{Regions, SETTLED, SMALLEST, TOUCH, contact, deviation};
use crate::decomposition::Channel;
use crate::trace::{DISPLACEMENT, Kind, Segment, Trace, segments};

/// Samples before and after over which a signal is averaged before it is compared with a level.
const REACH: usize = 2;
/// Share of the way out that still counts as standing, when the beginning of an approach is looked for.
const STANDING: f64 = 0.01;

/// The regions of a recording whose displacement, mm, is known.
pub(super) fn regions(trace: &Trace, displacement: &[f64], channel: &Channel) -> Regions {
    let region = places(trace, displacement, displacement, channel);
    let settled = SETTLED * deviation(trace, &channel.signal);
    let relaxation = relaxation(channel, &region, settled);
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
    over_holds(&mut relaxation, &region, &smooth(displacement), |first, last| {
        type_of(last - first, band)
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
    let touching = touches(&smooth(signal), noise);
    let moves = segments(&trace.time, controlled);
    let mut region = vec![Region::Rest; trace.len()];
    let mut touched = false;
    for (index, segment) in moves.iter().enumerate() {
        let presses_next = moves[index + 1..].iter().any(|later| later.kind == Kind::Load);
        for sample in segment.range.clone() {
            touched |= touching[sample];
            region[sample] = of_sample(segment.kind, touching[sample], touched);
        }
        match segment.kind {
            Kind::Load => mark_transition(&mut region, &segment.range, signal, noise),
            Kind::Approach | Kind::After if presses_next => {
                let begin = last_standing(segment, displacement);
                region[begin..segment.range.end].fill(Region::Preloading);
            }
            _ => {}
        }
    }
    let settled = SETTLED * deviation(trace, &channel.signal);
    end_recovery(&mut region, &channel.latent, settled);
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

/// Mean over the samples around each.
fn smooth(values: &[f64]) -> Vec<f64> {
    (0..values.len())
        .map(|k| {
            let around = &values[k.saturating_sub(REACH)..(k + REACH + 1).min(values.len())];
            around.iter().sum::<f64>() / around.len() as f64
        })
        .collect()
}

/// The largest value by size, with its sign.
fn largest_of(values: &[f64]) -> f64 {
    let larger = |most: f64, value: f64| if value.abs() > most.abs() { value } else { most };
    values.iter().copied().fold(0.0, larger)
}

/// Contact at each sample: made above a level, lost below half of it.
fn touches(signal: &[f64], noise: f64) -> Vec<bool> {
    let largest = largest_of(signal);
    let level = (TOUCH * noise).max(SMALLEST * largest.abs());
    let mut touching = false;
    signal
        .iter()
        .map(|value| {
            let pressed = value * largest.signum();
            touching = pressed > if touching { 0.5 * level } else { level };
            touching
        })
        .collect()
}

/// BC: what is left of a loading after its largest signal, where the signal falls by more than noise.
fn mark_transition(region: &mut [Region], range: &Range<usize>, signal: &[f64], noise: f64) {
    // Averaged within the loading: what the hold brings must not pull its end down.
    let sizes = smooth(&signal[range.clone()].iter().map(|value| value.abs()).collect::<Vec<_>>());
    let Some(peak) = (0..sizes.len()).max_by(|&a, &b| sizes[a].total_cmp(&sizes[b])) else {
        return;
    };
    // A difference of two means of five samples.
    let told = SETTLED * noise * (2.0 / (2 * REACH + 1) as f64).sqrt();
    if sizes[peak] - sizes[sizes.len() - 1] <= told || sizes.len() - peak <= REACH {
        return;
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
fn relaxation(channel: &Channel, region: &[Region], settled: f64) -> Vec<RelaxationType> {
    let largest = channel.input.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let band = settled.max(SMALLEST / 2.0 * largest);
    // A tension recorded as negative numbers relaxes upwards.
    let latent = channel.latent.iter().zip(&channel.input);
    let mut found: Vec<RelaxationType> =
        latent.map(|(latent, input)| type_of(latent * input.signum(), band)).collect();
    // In a hold the sign is that of the recording: a force that crosses zero after unloading still rises.
    let sense = largest_of(&channel.input).signum();
    over_holds(&mut found, region, &smooth(&channel.input), |first, last| {
        type_of((first - last) * sense, band)
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

/// Gives every hold one type, from the first and the last value of a signal in it.
fn over_holds(
    found: &mut [RelaxationType],
    region: &[Region],
    signal: &[f64],
    of: impl Fn(f64, f64) -> RelaxationType,
) {
    let mut begin = 0;
    while begin < region.len() {
        let same = |other: &Region| *other != region[begin];
        let end = region[begin..].iter().position(same).map_or(region.len(), |n| begin + n);
        if region[begin] == Region::Relaxation {
            found[begin..end].fill(of(signal[begin], signal[end - 1]));
        }
        begin = end;
    }
}

/// A recovery is over when the latent part stays within its band to the end of the stretch.
fn end_recovery(region: &mut [Region], latent: &[f64], settled: f64) {
    let latent = smooth(latent);
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
    use crate::model::{BaseLaw, Motion, Separation};
    use crate::regions;
    use crate::trace::{Column, FORCE};

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
