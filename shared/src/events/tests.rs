use super::*;
use crate::adaptation::{Config as Filter, Relaxation, State as Adaptation};
use proptest::prelude::*;

const SILICONE: Relaxation = Relaxation { c1: 0.173, v1: 4.38, c2: 0.187, v2: 0.585 };
const INTERVAL_S: f64 = 1e-3;
const LSB: f64 = 1.0 / 256.0;

fn config() -> Config {
    Config::new(&Settings::DEFAULT, LSB, INTERVAL_S).unwrap()
}

/// What two gauges with these readings (µε, of a time in s) tell: kinds with the time at which they were told.
fn told(seconds: f64, readings: impl Fn(f64) -> [f64; 2]) -> Vec<(Kind, f64)> {
    let filter = Filter::new(&SILICONE, INTERVAL_S).unwrap();
    let counts = |t: f64| readings(t).map(|reading| (reading / LSB).round() as i32);
    let mut gauges = counts(0.0).map(Adaptation::at_rest);
    let mut state = State::at_rest(counts(0.0));
    let config = config();
    let mut found = Vec::new();
    for k in 0..(seconds / INTERVAL_S) as u32 {
        let t = f64::from(k) * INTERVAL_S;
        let now = counts(t);
        let outputs = [0, 1].map(|index| gauges[index].step(&filter, now[index]));
        if let Some(event) = state.step(&config, &outputs) {
            assert!(event.began_samples_ago <= k);
            found.push((event.kind, t));
        }
    }
    found
}

/// From 0 up to 1 between two times and back between two others.
fn press(t: f64, [down, held, up, off]: [f64; 4]) -> f64 {
    ((t - down) / (held - down)).min((off - t) / (off - up)).clamp(0.0, 1.0)
}

const PRESS: [f64; 4] = [1.0, 1.05, 3.0, 3.05];

#[test]
fn a_press_is_a_touch_and_a_release_whichever_way_it_drives_a_gauge() {
    for sign in [1.0, -1.0] {
        for resting in [0.0, 250.0] {
            let reading = |t| resting + sign * 1000.0 * press(t, PRESS);
            let found = told(5.0, |t| [reading(t), resting]);
            let [(Kind::Touch, touch), (Kind::Release, release)] = found[..] else {
                panic!("{found:?}")
            };
            assert!((1.0..1.01).contains(&touch), "{touch}");
            assert!((3.05..3.07).contains(&release), "{release}");
        }
    }
}

#[test]
fn a_gauge_too_weak_for_a_burst_of_its_own_lets_go_with_the_others() {
    // 14 µε come as a burst of 2.4 µε and go more slowly, as one of 1.8 µε.
    let weak = |t: f64| 14.0 * press(t, [1.0, 1.01, 2.9, 3.04]);
    let found = told(5.0, |t| [1000.0 * press(t, PRESS), weak(t)]);
    assert_eq!(found.iter().map(|it| it.0).collect::<Vec<_>>(), [Kind::Touch, Kind::Release]);
}

#[test]
fn a_pull_that_relieves_one_gauge_and_presses_another_is_no_release() {
    let pulled = |t: f64| press(t, [2.0, 2.3, 9.0, 9.1]);
    let found = told(5.0, |t| {
        let pressed = press(t, [1.0, 1.05, 9.0, 9.1]);
        [1000.0 * pressed - 1800.0 * pulled(t), 300.0 * pressed + 700.0 * pulled(t)]
    });
    assert_eq!(found.len(), 1, "{found:?}");
}

#[test]
fn less_than_half_let_go_is_no_release_and_the_rest_is_one() {
    let less = |t: f64| press(t, [2.0, 2.05, 9.0, 9.1]);
    let found =
        told(6.0, |t| [1000.0 * press(t, [1.0, 1.05, 4.0, 4.05]) * (1.0 - 0.4 * less(t)), 0.0]);
    let kinds: Vec<Kind> = found.iter().map(|it| it.0).collect();
    assert_eq!(kinds, [Kind::Touch, Kind::Release], "{found:?}");
    assert!(found[1].1 > 4.0);
}

#[test]
fn a_dent_that_creeps_back_is_no_touch() {
    // A third stays after the release and goes within a second.
    let reading = |t: f64| {
        let left = if t > 3.05 { (-(t - 3.05)).exp() / 3.0 } else { 1.0 / 3.0 };
        let held = press(t, PRESS);
        1000.0 * if t < 3.0 { held } else { held.max(left) }
    };
    let found = told(8.0, |t| [reading(t), 0.0]);
    assert_eq!(found.iter().map(|it| it.0).collect::<Vec<_>>(), [Kind::Touch, Kind::Release]);
}

#[test]
fn an_adhesive_contact_that_snaps_off_is_no_second_touch() {
    // Pressed, pulled, and off at once: what was below rest comes back to it, and by 1 µε beyond.
    let reading = |t: f64| {
        let pulled = if t < 3.5 { press(t, [3.05, 3.2, 9.0, 9.1]) } else { 0.0 };
        1000.0 * press(t, PRESS) - 400.0 * pulled + if t < 3.5 { 0.0 } else { 1.0 }
    };
    let found = told(8.0, |t| [reading(t), 0.0]);
    assert_eq!(found.iter().map(|it| it.0).collect::<Vec<_>>(), [Kind::Touch, Kind::Release]);
}

/// A press whose second gauge gives jolts of some µε at some times.
fn with_jolts(size: f64, at: &'static [f64]) -> Vec<(Kind, f64)> {
    told(6.0, |t| {
        let held = press(t, [1.0, 1.05, 5.0, 5.05]);
        let gone = at.iter().filter(|jolt| t >= **jolt).count() as f64;
        [1000.0 * held, held * (500.0 - size * gone)]
    })
}

#[test]
fn a_series_of_jolts_while_something_is_held_is_a_slip_and_one_knock_is_none() {
    let slips = |found: &[(Kind, f64)]| -> Vec<f64> {
        found.iter().filter(|it| it.0 == Kind::Slip).map(|it| it.1).collect()
    };
    let found = slips(&with_jolts(2.0, &[2.0, 2.06, 2.12, 2.18]));
    assert_eq!(found.len(), 1, "{found:?}");
    assert!((2.12..2.13).contains(&found[0]), "with the third jolt: {found:?}");
    for (size, at) in [
        (2.0, &[2.0][..]),
        // Too far apart, too close, too weak, too soon after the touch.
        (2.0, &[2.0, 2.2, 2.4]),
        (2.0, &[2.0, 2.005, 2.01]),
        (0.05, &[2.0, 2.06, 2.12]),
        (2.0, &[1.06, 1.09, 1.12]),
    ] {
        let found = with_jolts(size, at);
        assert!(slips(&found).is_empty(), "{size} {at:?}: {found:?}");
    }
}

#[test]
fn what_shakes_at_up_to_an_eighth_of_the_corner_is_no_slip() {
    for hertz in [1.0, 3.0, 8.0, 12.0] {
        let found = told(10.0, |t| {
            let shaking = (core::f64::consts::TAU * hertz * t).sin();
            [1000.0 * press(t, [1.0, 1.05, 9.0, 9.05]) * (1.0 + 0.2 * shaking), 0.0]
        });
        let kinds: Vec<Kind> = found.iter().map(|it| it.0).collect();
        assert_eq!(kinds, [Kind::Touch, Kind::Release], "{hertz} Hz: {found:?}");
    }
}

#[test]
fn what_comes_slowly_is_told_by_nothing() {
    let found = told(60.0, |t| [20.0 * press(t, [5.0, 25.0, 30.0, 50.0]), 0.0]);
    assert!(found.is_empty(), "{found:?}");
}

#[test]
fn settings_out_of_range_are_refused_by_name() {
    let refused = |settings: Settings| Config::new(&settings, LSB, INTERVAL_S).unwrap_err();
    let it = Settings::DEFAULT;
    assert!(matches!(
        refused(Settings { burst: 0.0, ..it }),
        ConfigError::Level { name: "burst", .. }
    ));
    assert!(matches!(
        refused(Settings { jolt: f64::NAN, ..it }),
        ConfigError::Level { name: "jolt", .. }
    ));
    assert_eq!(refused(Settings { jolts: 1, ..it }), ConfigError::Jolts(1));
    assert_eq!(refused(Settings { jolts: 9, ..it }), ConfigError::Jolts(9));
    assert!(matches!(refused(Settings { corner_hz: 251.0, ..it }), ConfigError::Corner { .. }));
    assert!(matches!(
        refused(Settings { settle_s: -1.0, ..it }),
        ConfigError::Time { name: "settle_s", .. }
    ));
    assert!(matches!(Config::new(&it, 0.0, INTERVAL_S), Err(ConfigError::Scale(_))));
    // Where no slip is sought, the corner is of no account.
    assert!(Config::new(&Settings { jolts: 0, corner_hz: 1e9, ..it }, LSB, 1.0).is_ok());
}

/// Whether the third of three jolts tells a slip, if the sample numbers have gone round since the second.
fn third_jolt_tells(after_a_round: bool) -> bool {
    let config = config();
    let mut state = State::at_rest([0]);
    let take = |state: &mut State<1>, fa: i32, samples: u32| {
        let mut events = (0..samples).filter_map(|_| state.take(&config, &[(256_000, fa)]));
        events.next().map(|event| event.kind)
    };
    assert_eq!(take(&mut state, 25_600, 20), Some(Kind::Touch));
    assert_eq!(take(&mut state, 0, 1_000), None);
    assert_eq!(take(&mut state, 100, 60), None);
    assert_eq!(take(&mut state, 0, 60), None);
    if after_a_round {
        let now = state.now;
        state.now = FORGETTING * 7 - 1;
        take(&mut state, 0, 1);
        state.now = now;
    }
    take(&mut state, 100, 60) == Some(Kind::Slip)
}

#[test]
fn jolts_of_a_round_of_sample_numbers_ago_make_no_slip() {
    assert!(third_jolt_tells(false));
    assert!(!third_jolt_tells(true));
}

proptest! {
    #[test]
    fn anything_at_all_is_taken_without_panic(
        samples in prop::collection::vec((any::<i32>(), any::<i32>()), 1..400),
        burst in 1e-3_f64..1e6,
        apart_s in 0.0_f64..0.1,
    ) {
        let settings = Settings { burst, jolt: burst, apart_s, ..Settings::DEFAULT };
        let config = Config::new(&settings, LSB, INTERVAL_S).unwrap();
        let mut state = State::at_rest([samples[0].0]);
        for (k, (signal, fa)) in samples.into_iter().enumerate() {
            let output = Output { signal, fa, equilibrium: signal, elastic: fa };
            if let Some(event) = state.step(&config, &[output]) {
                prop_assert!(event.began_samples_ago as usize <= k + 1);
            }
        }
    }
}
