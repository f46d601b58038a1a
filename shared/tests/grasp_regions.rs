//! The six regions on simulated grasps whose boundaries are known: with the displacement or the filter's elastic input as
//! motion, with noise, at several rates, for repeated, partial and stepwise grasps.

use palpate_shared::adaptation::{self, Relaxation};
use palpate_shared::phase::Region::{
    Loading, Preloading, Recovery, Relaxation as Held, Rest, Transition, Unloading,
};
use palpate_shared::phase::{Config, ConfigError, Region, RelaxationType, State, Thresholds};
use proptest::prelude::*;

const SUSHI: Relaxation = Relaxation { c1: 0.2472, v1: 3.981, c2: 0.2676, v2: 0.5325 };
/// LSB of the elastic strain at full displacement 1.0.
const FULL: f64 = 1_000_000.0;
const NOISE: f64 = 1_500.0;

/// (end of the piece in s, displacement there); straight lines between.
type Profile<'a> = &'a [(f64, f64)];

fn displacement(profile: Profile, t: f64) -> f64 {
    let (mut t0, mut x0) = (0.0, -0.1);
    for &(t1, x1) in profile {
        if t < t1 {
            return x0 + (x1 - x0) * (t - t0) / (t1 - t0);
        }
        (t0, x0) = (t1, x1);
    }
    x0
}

/// Displacement in LSB and force in LSB of a grasp with a quadratic elastic response, eq. 3.2 with q = 1; a parted surface
/// carries no force.
fn grasp(profile: Profile, rate_hz: f64, noise: f64) -> Vec<(i32, i32)> {
    let mut random = 0x2545_f491_4f6c_dd1d_u64;
    let mut noisy = |value: f64| {
        let sum: f64 = (0..12)
            .map(|_| {
                random ^= random << 13;
                random ^= random >> 7;
                random ^= random << 17;
                (random >> 11) as f64 / (1_u64 << 53) as f64
            })
            .sum();
        (value + noise * (sum - 6.0)) as i32
    };
    let interval = 1.0 / rate_hz;
    let (mut memory, mut before) = ([0.0_f64; 2], 0.0);
    let count = (profile.last().unwrap().0 * rate_hz) as u32;
    (0..count)
        .map(|i| {
            let x = displacement(profile, f64::from(i) * interval);
            let u = FULL * x.max(0.0).powi(2);
            for (y, (c, v)) in memory.iter_mut().zip([(SUSHI.c1, SUSHI.v1), (SUSHI.c2, SUSHI.v2)]) {
                let d = -(-v * interval).exp_m1();
                *y += -d * *y + c * d / (v * interval) * (u - before);
            }
            before = u;
            let force = (SUSHI.c0() * u + memory[0] + memory[1]).max(0.0);
            (noisy(FULL * x), noisy(force))
        })
        .collect()
}

fn thresholds() -> Thresholds {
    Thresholds {
        touch: 12_000,
        release: 6_000,
        peak_drop: 5_000,
        motion_step: 10_000,
        latent_dead_band: 5_000,
        smoothing_s: 0.01,
        dwell_s: 0.15,
        recovery_limit_s: 5.0,
    }
}

/// The regions in order with the second at which each was entered, put back by what the detector reports.
fn regions(samples: &[(i32, i32)], rate_hz: f64, elastic_as_motion: bool) -> Vec<(Region, f64)> {
    let filter = adaptation::Config::new(&SUSHI, 1.0 / rate_hz).unwrap();
    let config = Config::new(&thresholds(), 1.0 / rate_hz).unwrap();
    let mut adaptation = adaptation::State::at_rest(samples[0].1);
    let first = if elastic_as_motion { 0 } else { samples[0].0 };
    let mut phase = State::at_rest(first, samples[0].1);
    let mut found = Vec::new();
    for (i, &(x, s)) in samples.iter().enumerate() {
        let out = adaptation.step(&filter, s);
        let motion = if elastic_as_motion { out.elastic } else { x };
        let now = phase.step(&config, motion, s, out.latent());
        if let Some(ago) = now.entered_samples_ago {
            found.push((now.region, (i as f64 - f64::from(ago)) / rate_hz));
        }
    }
    found
}

fn assert_regions(profile: Profile, expected: &[(Region, f64)], tolerance_s: f64) {
    for rate_hz in [200.0, 1000.0, 4000.0] {
        for noise in [0.0, NOISE] {
            for elastic_as_motion in [false, true] {
                let found = regions(&grasp(profile, rate_hz, noise), rate_hz, elastic_as_motion);
                let case = format!(
                    "{rate_hz} Hz, noise {noise}, elastic {elastic_as_motion}: {found:.3?}\nexpected {expected:.3?}"
                );
                let names = |list: &[(Region, f64)]| -> Vec<Region> {
                    list.iter().map(|(region, _)| *region).collect()
                };
                assert_eq!(names(&found), names(expected), "{case}");
                for ((region, at), (_, want)) in found.iter().zip(expected) {
                    // How long the material takes to settle is not a boundary of the motion, and the elastic input does
                    // not move before touch.
                    let free = *region == Rest || (*region == Preloading && elastic_as_motion);
                    if !free {
                        assert!((at - want).abs() <= tolerance_s, "{region:?}: {case}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_press_held_and_released_shows_its_regions_where_they_were() {
    // Touch at 0.3 s; contact at 0.36 s; stops at 0.9 s; retreats at 4.0 s; parts on the way back.
    let profile =
        [(0.24, -0.1), (0.3, 0.0), (0.9, 1.0), (4.0, 1.0), (4.6, 0.0), (4.66, -0.1), (12.0, -0.1)];
    let expected = [
        (Preloading, 0.24),
        (Loading, 0.367),
        (Held, 0.9),
        (Unloading, 4.0),
        (Recovery, 4.21),
        (Rest, 9.0),
    ];
    assert_regions(&profile, &expected, 0.012);
}

#[test]
fn a_partial_release_that_is_held_returns_to_relaxation_and_a_further_press_to_loading() {
    let profile = [
        (0.3, 0.0),
        (0.9, 1.0),
        (2.0, 1.0),
        (2.2, 0.8),
        (4.0, 0.8),
        (4.2, 1.0),
        (6.0, 1.0),
        (6.6, 0.0),
        (6.7, -0.1),
        (14.0, -0.1),
    ];
    let expected = [
        (Preloading, 0.0),
        (Loading, 0.367),
        (Held, 0.9),
        (Unloading, 2.0),
        (Held, 2.2),
        (Loading, 4.0),
        (Held, 4.2),
        (Unloading, 6.0),
        (Recovery, 6.207),
        (Rest, 11.0),
    ];
    assert_regions(&profile, &expected, 0.012);
}

#[test]
fn a_motion_that_slows_down_before_it_stops_has_a_transition() {
    // From 0.9 s the motion crawls, slower than the material relaxes, until 1.5 s.
    let profile =
        [(0.3, 0.0), (0.9, 1.0), (1.5, 1.04), (4.0, 1.04), (4.6, 0.0), (4.7, -0.1), (12.0, -0.1)];
    let expected = [
        (Preloading, 0.24),
        (Loading, 0.367),
        (Transition, 0.9),
        (Held, 1.5),
        (Unloading, 4.0),
        (Recovery, 4.21),
        (Rest, 9.0),
    ];
    let slow = Thresholds { motion_step: 4_000, peak_drop: 3_000, ..thresholds() };
    let rate_hz = 1000.0;
    let config = Config::new(&slow, 1.0 / rate_hz).unwrap();
    let samples = grasp(&profile, rate_hz, 100.0);
    let mut phase = State::at_rest(samples[0].0, samples[0].1);
    let mut found = Vec::new();
    for (i, &(x, s)) in samples.iter().enumerate() {
        let now = phase.step(&config, x, s, 0);
        found.extend(
            now.entered_samples_ago.map(|ago| (now.region, (i as f64 - f64::from(ago)) / rate_hz)),
        );
    }
    assert_eq!(found.len(), expected.len(), "{found:.3?}");
    for ((region, at), (name, want)) in found.iter().zip(&expected) {
        assert_eq!(region, name, "{found:.3?}");
        assert!((at - want).abs() < 0.06 || *name == Rest || *name == Preloading, "{found:.3?}");
    }
}

#[test]
fn every_cycle_of_a_repeated_grasp_is_found() {
    let mut profile = vec![(0.5, -0.1)];
    for cycle in 0..5 {
        let start = 0.5 + 8.0 * f64::from(cycle);
        profile.extend(
            [(0.66, 1.0), (2.66, 1.0), (3.32, -0.1), (8.0, -0.1)].map(|(t, x)| (start + t, x)),
        );
    }
    let one = [Preloading, Loading, Held, Unloading, Recovery, Rest];
    for (rate_hz, elastic) in [(200.0, false), (200.0, true), (2000.0, false), (2000.0, true)] {
        let found = regions(&grasp(&profile, rate_hz, NOISE), rate_hz, elastic);
        let names: Vec<Region> = found.iter().map(|(region, _)| *region).collect();
        assert_eq!(names, one.repeat(5), "{rate_hz} Hz, elastic {elastic}: {found:.2?}");
    }
}

/// Regions of a gauge with the elastic input as motion, whichever way pressing moves it.
fn regions_of_gauge(samples: &[i32], rate_hz: f64) -> Vec<(Region, RelaxationType, f64)> {
    let filter = adaptation::Config::new(&SUSHI, 1.0 / rate_hz).unwrap();
    let config = Config::new(&thresholds(), 1.0 / rate_hz).unwrap();
    let mut adaptation = adaptation::State::at_rest(samples[0]);
    let mut phase = State::of_either_sense(0, samples[0]);
    let mut found = Vec::new();
    for (i, &s) in samples.iter().enumerate() {
        let out = adaptation.step(&filter, s);
        let now = phase.step(&config, out.elastic, s, out.latent());
        if let Some(ago) = now.entered_samples_ago {
            found.push((now.region, now.relaxation, (i as f64 - f64::from(ago)) / rate_hz));
        }
    }
    found
}

#[test]
fn a_gauge_that_is_stretched_passes_through_the_regions_of_one_that_is_compressed() {
    let profile = [
        (1.0, -0.1),
        (1.6, 1.0),
        (3.0, 1.0),
        (3.2, 0.7),
        (5.0, 0.7),
        (5.4, -0.1),
        (14.0, -0.1),
        (14.1, 1.0),
        (16.0, 1.0),
        (16.4, -0.1),
        (24.0, -0.1),
    ];
    for rate_hz in [200.0, 1000.0, 4000.0] {
        for noise in [0.0, NOISE] {
            let pressed: Vec<i32> =
                grasp(&profile, rate_hz, noise).into_iter().map(|(_, signal)| signal).collect();
            let stretched: Vec<i32> = pressed.iter().map(|signal| -signal).collect();
            let compressed = regions_of_gauge(&pressed, rate_hz);
            let case = format!("{rate_hz} Hz, noise {noise}: {compressed:.3?}");
            let names: Vec<Region> = compressed.iter().map(|(region, ..)| *region).collect();
            let one = [Preloading, Loading, Held, Unloading, Recovery, Rest];
            assert_eq!(names[..4], one[..4], "{case}");
            assert_eq!(names[names.len() - 6..], one, "{case}");
            let found = regions_of_gauge(&stretched, rate_hz);
            assert_eq!(found.len(), compressed.len(), "{case}\n{found:.3?}");
            for (stretched, compressed) in found.iter().zip(&compressed) {
                assert_eq!((stretched.0, stretched.1), (compressed.0, compressed.1), "{case}");
                assert!((stretched.2 - compressed.2).abs() < 0.012, "{case}\n{found:.3?}");
            }
        }
    }
}

/// The strain of a gauge in silicone that is pressed, held and released every 8 s: it undershoots when it is released.
fn pressed_again_and_again(cycles: u32, rate_hz: f64) -> Vec<f64> {
    let interval = 1.0 / rate_hz;
    let (mut memory, mut before) = ([0.0_f64; 2], 0.0);
    let press = |t: f64| {
        let t = t % 8.0;
        (t / 0.4).min(1.0) - ((t - 3.0) / 0.3).clamp(0.0, 1.0)
    };
    (0..(f64::from(cycles) * 8.0 * rate_hz) as u32)
        .map(|i| {
            let u = press(f64::from(i) * interval);
            for (y, (c, v)) in memory.iter_mut().zip([(SUSHI.c1, SUSHI.v1), (SUSHI.c2, SUSHI.v2)]) {
                let d = -(-v * interval).exp_m1();
                *y += -d * *y + c * d / (v * interval) * (u - before);
            }
            before = u;
            FULL * (SUSHI.c0() * u + memory[0] + memory[1])
        })
        .collect()
}

#[test]
fn a_stream_that_begins_while_a_gauge_is_pressed_finds_its_regions_whichever_way_it_lies() {
    let rate_hz = 1000.0;
    let strain = pressed_again_and_again(4, rate_hz);
    for way in [1.0, -1.0] {
        for from_s in [0.2, 1.0, 2.5] {
            let begun = (from_s * rate_hz) as usize;
            let seen: Vec<i32> = strain[begun..].iter().map(|s| (way * s) as i32).collect();
            let found = regions_of_gauge(&seen, rate_hz);
            let case = format!("{way} from {from_s} s: {found:.2?}");
            let at = |time_s: f64| {
                found.iter().rev().find(|(.., entered)| entered + from_s <= time_s).map(|f| f.0)
            };
            // What relaxes from before the first sample looks like a motion to the filter, so the first hold may not be told.
            for cycle in 1..4 {
                let time_s = |t: f64| 8.0 * f64::from(cycle) + t;
                assert_eq!(at(time_s(0.3)), Some(Loading), "{cycle}: {case}");
                assert_eq!(at(time_s(2.5)), Some(Held), "{cycle}: {case}");
                assert_eq!(at(time_s(4.0)), Some(Recovery), "{cycle}: {case}");
            }
        }
    }
}

#[test]
fn a_gauge_taken_for_one_that_is_stretched_is_right_again_with_the_next_press() {
    let rate_hz = 1000.0;
    let strain = pressed_again_and_again(3, rate_hz);
    for way in [1.0, -1.0] {
        // A bridge that nobody tared reads more than touch the other way at rest.
        let still = std::iter::repeat_n(0.0, 1_000).chain(strain.iter().copied());
        let seen: Vec<i32> = still.map(|s| (way * (s - 20_000.0)) as i32).collect();
        let found = regions_of_gauge(&seen, rate_hz);
        for cycle in 0..3 {
            let held_s = 1.0 + 8.0 * f64::from(cycle) + 2.0;
            let held = found.iter().rev().find(|(.., entered)| *entered <= held_s).map(|f| f.0);
            assert_eq!(held, Some(Held), "{way}: {found:.2?}");
        }
    }
}

#[test]
fn a_signal_that_recovers_through_the_touch_level_without_a_motion_is_no_second_touch() {
    let rate_hz = 1000.0;
    let strain = pressed_again_and_again(3, rate_hz);
    for offset in [15_000.0, 40_000.0] {
        let seen: Vec<i32> = strain.iter().map(|s| (s + offset) as i32).collect();
        let found = regions_of_gauge(&seen, rate_hz);
        let touches = found.iter().filter(|(region, ..)| *region == Loading).count();
        assert_eq!(touches, 3, "{offset}: {found:.2?}");
        // Nor does the next grasp begin while the last one recovers: it begins with its motion, every 8 s.
        for (_, _, entered) in found.iter().filter(|(region, ..)| *region == Loading) {
            let into_press_s = (entered + 0.05) % 8.0;
            assert!(into_press_s < 0.3, "{offset}: {found:.2?}");
        }
    }
    // Nor when it has settled: only a motion, or a rise out of rest, begins the next grasp.
    let mut rested = pressed_again_and_again(1, rate_hz);
    rested.extend(std::iter::repeat_n(0.0, 20_000));
    let seen: Vec<i32> = rested.iter().map(|s| (s + 40_000.0) as i32).collect();
    let found = regions_of_gauge(&seen, rate_hz);
    assert_eq!(found.last().unwrap().0, Rest, "{found:.2?}");
}

/// A gauge whose silicone, let go, springs back through the gauge and settles from there: pressed for 6 s, or pressed again while
/// it still recovers.
fn springs_back(rate_hz: f64, pressed_again: bool) -> Vec<i32> {
    let course = |t: f64| {
        let press = (t / 0.5).min(1.0) - ((t - 6.0) / 0.3).clamp(0.0, 1.0);
        let free = t - 6.3;
        let springs = (free / 0.15).clamp(0.0, 1.0) * (-free.max(0.0) / 2.0).exp();
        let again = ((free - 4.0) / 0.3).clamp(0.0, 1.0) - ((free - 6.0) / 0.3).clamp(0.0, 1.0);
        0.8 * press + 0.12 * springs + if pressed_again { 0.25 * again } else { 0.0 }
    };
    let samples = (20.0 * rate_hz) as u32;
    (0..samples).map(|i| (FULL * course(f64::from(i) / rate_hz)) as i32).collect()
}

#[test]
fn silicone_that_springs_back_is_no_second_touch_and_a_press_in_recovery_is_one() {
    for rate_hz in [200.0, 1000.0, 4000.0] {
        for way in [1, -1] {
            for (pressed_again, touches) in [(false, 1), (true, 2)] {
                let seen: Vec<i32> =
                    springs_back(rate_hz, pressed_again).iter().map(|s| way * s).collect();
                let found = regions_of_gauge(&seen, rate_hz);
                let loaded: Vec<f64> = found
                    .iter()
                    .filter(|(region, ..)| *region == Loading)
                    .map(|(.., entered)| *entered)
                    .collect();
                let case = format!("{rate_hz} Hz, {way}: {found:.2?}");
                assert_eq!(loaded.len(), touches, "{case}");
                assert!(loaded.iter().all(|at| *at < 0.1 || (10.2..10.5).contains(at)), "{case}");
            }
        }
    }
}

#[test]
fn a_gauge_that_drifts_or_undershoots_below_zero_is_not_taken_for_one_that_is_stretched() {
    let rate_hz = 1000.0;
    let drift: Vec<i32> = (0..60_000).map(|i| -i).collect();
    assert_eq!(regions_of_gauge(&drift, rate_hz), []);
    // Released fast, it comes back from below zero; the next press is one again.
    let course = |i: i32| match i % 8_000 {
        0..500 => 0.0,
        500..2_000 => 1.0,
        _ => -0.2 * (-f64::from(i % 8_000 - 2_000) / 1_000.0).exp(),
    };
    let signal: Vec<i32> = (0..32_000).map(|i| (FULL * course(i)) as i32).collect();
    let names: Vec<Region> =
        regions_of_gauge(&signal, rate_hz).iter().map(|(region, ..)| *region).collect();
    assert_eq!(names.iter().filter(|region| **region == Loading).count(), 4, "{names:?}");
}

#[test]
fn noise_alone_is_rest() {
    for rate_hz in [200.0, 1000.0, 4000.0] {
        for elastic in [false, true] {
            let found = regions(&grasp(&[(60.0, -0.1)], rate_hz, NOISE), rate_hz, elastic);
            assert_eq!(found, [], "{rate_hz} Hz, elastic {elastic}");
        }
    }
}

#[test]
fn the_sign_of_the_latent_part_is_the_type_of_relaxation() {
    assert_eq!(RelaxationType::of(11, 10), RelaxationType::TypeI);
    assert_eq!(RelaxationType::of(-11, 10), RelaxationType::TypeII);
    assert_eq!(RelaxationType::of(-10, 10), RelaxationType::None);
    assert_eq!(RelaxationType::of(i32::MIN, i32::MIN), RelaxationType::TypeII);
}

#[test]
fn thresholds_out_of_range_are_refused_by_name() {
    let refused = |t: Thresholds| Config::new(&t, 0.005).unwrap_err();
    let level = refused(Thresholds { motion_step: 0, ..thresholds() });
    assert_eq!(level, ConfigError::Level { name: "motion_step", value: 0 });
    let hysteresis = refused(Thresholds { release: 12_000, ..thresholds() });
    assert_eq!(hysteresis, ConfigError::Hysteresis { touch: 12_000, release: 12_000 });
    let time = refused(Thresholds { dwell_s: -1.0, ..thresholds() });
    assert_eq!(time, ConfigError::Time { name: "dwell_s", value: -1.0 });
    assert_eq!(Config::new(&thresholds(), 0.0), Err(ConfigError::Interval(0.0)));
}

/// Section 3.4.1 read as a graph.
fn may_follow(before: Region, after: Region) -> bool {
    match before {
        Rest => after == Preloading,
        Preloading => matches!(after, Loading | Rest),
        Loading => matches!(after, Transition | Held | Unloading),
        Transition => matches!(after, Held | Unloading | Recovery),
        Held => matches!(after, Loading | Unloading | Recovery),
        Unloading => matches!(after, Held | Loading | Recovery),
        Recovery => matches!(after, Preloading | Rest),
    }
}

proptest! {
    #[test]
    fn any_input_passes_through_the_regions_in_order_and_boundaries_never_cross(
        samples in prop::collection::vec((any::<i32>(), any::<i32>(), any::<i32>(), 1_u8..60), 1..60),
        smoothing_s in 0.0..0.1_f64,
        either in any::<bool>(),
    ) {
        let config = Config::new(&Thresholds { smoothing_s, ..thresholds() }, 0.005).unwrap();
        let begin = if either { State::of_either_sense } else { State::at_rest };
        let mut state = begin(samples[0].0, samples[0].1);
        let (mut region, mut entered, mut now) = (Rest, i64::MIN, 0_i64);
        for (motion, signal, latent, repeats) in samples {
            for _ in 0..repeats {
                now += 1;
                let phase = state.step(&config, motion, signal, latent);
                if let Some(ago) = phase.entered_samples_ago {
                    prop_assert!(may_follow(region, phase.region), "{:?} to {:?}", region, phase.region);
                    // Rest is dated by the clock; all other boundaries share the delay of smoothing.
                    if phase.region != Rest && region != Rest {
                        prop_assert!(now - i64::from(ago) >= entered);
                    }
                    entered = now - i64::from(ago);
                }
                region = phase.region;
            }
        }
    }
}
