use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use super::Standing::{Agrees, Begins, Fails, Moves, NoHistory, Rests};
use super::*;
use palpate_model::{BaseLaw, Elastic, Kernel, Model, Relaxation, Separation};

const INTERVAL: f64 = 1e-3;
/// Course of the finger: rest, loading, hold of 3 s, unloading, recovery.
const COURSE: [(f64, f64, Region); 5] = [
    (1.0, 0.0, Region::Rest),
    (1.4, 900.0, Region::Loading),
    (4.4, 900.0, Region::Relaxation),
    (4.7, 0.0, Region::Unloading),
    (6.0, 0.0, Region::Recovery),
];

fn silicone() -> Relaxation {
    Relaxation::new(&[0.2, 0.15], &[6.0, 0.6])
}

fn law(relaxation: Relaxation) -> Law {
    Law { relaxation, left_out: Vec::new() }
}

/// A press of a material that relaxes like this, with an offset of the bridge and noise; regions come 0.1 s late.
fn press(material: &Relaxation, noise: f64, seed: u64) -> Vec<Sample> {
    let mut scatter = ChaCha8Rng::seed_from_u64(seed);
    let normal = Normal::new(0.0, noise).unwrap();
    let mut memory = Memory::rested(material.branches.len());
    let at = |time: f64| COURSE.iter().position(|leg| time < leg.0).unwrap_or(COURSE.len() - 1);
    (0..6_000)
        .map(|k| {
            let time = f64::from(k) * INTERVAL;
            let leg = at(time);
            let (begin, from) =
                if leg == 0 { (0.0, 0.0) } else { (COURSE[leg - 1].0, COURSE[leg - 1].1) };
            let (end, to, _) = COURSE[leg];
            let pressed = from + (to - from) * (time - begin) / (end - begin);
            let signal = memory.step(material, pressed, INTERVAL);
            let late = at(time - 0.1);
            Sample {
                time,
                signal: 31.0 + signal + normal.sample(&mut scatter),
                region: COURSE[late].2,
                entered_ago: Some(0.1).filter(|_| at(time - 0.1 - INTERVAL) != late),
            }
        })
        .collect()
}

/// The hold of a press, followed with a law, and what could be said in the middle of it.
fn held(law: Law, press: &[Sample]) -> (Option<Hold>, Standing) {
    let mut follower = Follower::new(law);
    let mut middle = NoHistory;
    let mut ended = None;
    for sample in press {
        ended = follower.take(*sample).or(ended);
        if (sample.time - 3.0).abs() < 0.5 * INTERVAL {
            middle = follower.standing();
        }
    }
    (ended, middle)
}

#[test]
fn the_right_law_foretells_the_hold_within_the_noise() {
    for seed in 0..20 {
        let (hold, middle) = held(law(silicone()), &press(&silicone(), 0.5, seed));
        let hold = hold.unwrap();
        assert_eq!((hold.failure, middle), (None, Agrees), "seed {seed}");
        let (residual, standard_error) = hold.residual.unwrap();
        assert!(residual.abs() < 5.0 * standard_error && standard_error < 0.3, "{residual}");
        assert!((hold.entered - 1.4).abs() < 2e-3 && (hold.to - 4.4).abs() < 2e-3);
    }
}

#[test]
fn a_law_that_relaxes_too_little_or_too_much_is_found_out_with_its_direction() {
    let press = press(&silicone(), 0.5, 1);
    for (shares, less) in [([0.2, 0.10], false), ([0.2, 0.20], true)] {
        let wrong = law(Relaxation::new(&shares, &[6.0, 0.6]));
        let (hold, middle) = held(wrong, &press);
        let failure = hold.unwrap().failure.unwrap();
        assert_eq!((failure.changes_less, middle), (less, Fails), "{failure:?}");
        assert!(failure.after < 1.0, "{failure:?}");
    }
    // The slow part alone: it is found in the part that the law has.
    let (hold, _) = held(law(Relaxation::new(&[0.35], &[6.0])), &press);
    assert_eq!(hold.unwrap().failure.unwrap().acting, Some(1.0 / 6.0));
}

#[test]
fn it_is_the_same_upside_down_and_for_any_size_of_the_noise() {
    for noise in [0.05, 5.0] {
        let mut press = press(&silicone(), noise, 4);
        press.iter_mut().for_each(|sample| sample.signal *= -0.4);
        assert_eq!(held(law(silicone()), &press).1, Agrees, "{noise}");
        let wrong = law(Relaxation::new(&[0.2, 0.30], &[6.0, 0.6]));
        let failure = held(wrong, &press).0.unwrap().failure.unwrap();
        assert!(failure.changes_less && failure.residual < 0.0, "{failure:?}");
    }
}

#[test]
fn without_a_rest_before_or_over_a_gap_nothing_is_foretold() {
    let press = press(&silicone(), 0.5, 1);
    assert_eq!(held(law(silicone()), &press[1_500..]), (None, NoHistory));
    let mut with_gap = press.clone();
    with_gap.drain(1_200..1_350);
    assert_eq!(held(law(silicone()), &with_gap), (None, NoHistory));
}

#[test]
fn a_finger_that_moves_is_not_foretold_and_a_known_end_ends_the_hold() {
    let press = press(&silicone(), 0.5, 1);
    let mut follower = Follower::new(law(silicone()));
    let mut standings = Vec::new();
    for sample in &press[..3_000] {
        let _ = follower.take(*sample);
        if standings.last() != Some(&follower.standing()) {
            standings.push(follower.standing());
        }
    }
    assert_eq!(standings, [Rests, Moves, Begins, Agrees]);
    assert!(follower.begin().is_some());
    assert_eq!(follower.standing(), NoHistory);
}

#[test]
fn a_law_is_taken_from_a_model_where_its_hold_follows_from_the_signal() {
    let fung = BaseLaw::fung(2, Separation::Free);
    let values = [0.07, 0.9, 0.25, 0.26, 4.0, 0.5];
    let mut model = Model::of(&fung, "force_N", &values, &[None; 6]);
    let found = Law::of(&model).unwrap();
    assert_eq!(found.relaxation, Relaxation::new(&[0.25, 0.26], &[4.0, 0.5]));
    assert_eq!(found.formula(), "g(t) = 0.490 + 0.250 e^(−4.00 t) + 0.260 e^(−0.500 t)");
    let effect = |name: &str| toml::from_str(&format!("name = \"{name}\"\n")).unwrap();
    model.effects = vec![effect("drift")];
    assert_eq!(Law::of(&model).unwrap().left_out, ["drift"]);
    model.effects = vec![effect("slow-relaxation")];
    assert_eq!(Law::of(&model), Err(LawError::Effect("slow-relaxation".into())));
    let power = BaseLaw::fung(1, Separation::Clamp).with(Elastic::POWER, Kernel::POWER_LAW);
    let values = vec![0.5; power.count()];
    let model = Model::of(&power, "force_N", &values, &vec![None; values.len()]);
    assert!(matches!(Law::of(&model), Err(LawError::Form { .. })));
}

#[test]
fn a_bridge_that_never_rests_is_foretold_once_what_was_before_is_forgotten() {
    // Presses over and over, of a gauge whose offset counts as contact.
    let once = press(&silicone(), 0.5, 7);
    let presses = (0..4).flat_map(|again| {
        once.iter().map(move |sample| Sample {
            time: sample.time + 6.0 * f64::from(again),
            region: if sample.region == Region::Rest { Region::Recovery } else { sample.region },
            ..*sample
        })
    });
    let mut follower = Follower::new(law(silicone()));
    let holds: Vec<Hold> = presses.filter_map(|sample| follower.take(sample)).collect();
    // 8 / (0.6 / s) are 13.3 s: the third press of six seconds each.
    assert_eq!(holds.len(), 2);
    assert!(holds.iter().all(|hold| hold.entered > 13.0));
}
