//! A set-up that yields: the chain with it is the chain without it, on what is left of the motion.

use palpate_fit::data::Data;
use palpate_fit::whole_motion::predict;
use palpate_model::effects::candidates;
use palpate_model::{Act, BaseLaw, Chain, Family, Motion, Separation};
use palpate_trace::{DISPLACEMENT, FORCE, Trace};

/// A press, a hold and a release, 0.01 s and a little apart: times, s, and compressions, mm.
fn press(jitter: f64) -> (Vec<f64>, Vec<f64>) {
    let time: Vec<f64> =
        (0..400).map(|k| 0.01 * f64::from(k) + jitter * f64::from(k % 3)).collect();
    let x = time.iter().map(|t| (6.0 * t - 2.0).min(5.0).min(20.0 - 6.0 * t)).collect();
    (time, x)
}

fn trace(time: &[f64], x: &[f64]) -> Trace {
    let mut trace = Trace { time: time.to_vec(), ..Trace::default() };
    trace.set_column(DISPLACEMENT, x.to_vec());
    trace.set_column(FORCE, time.to_vec());
    trace
}

/// What a set-up leaves of a motion under these forces, N.
fn left(x: &[f64], force: &[f64], act: &Act, own: &[f64]) -> Vec<f64> {
    let Act::Yield(yields) = act else { panic!("no set-up that yields") };
    x.iter().zip(force).map(|(x, force)| x - yields(own, *force)).collect()
}

#[track_caller]
fn same(force: &[f64], again: &[f64], law: &str) {
    for (k, (a, b)) in force.iter().zip(again).enumerate() {
        assert!((a - b).abs() < 1e-8, "{law} {k}: {a} for {b}");
    }
}

#[test]
fn a_chain_that_yields_is_the_base_law_on_what_is_left_of_the_motion() {
    let (time, x) = press(1e-3);
    let traces = [trace(&time, &x)];
    let data = Data::of(&traces, FORCE).unwrap();
    let setting = data.setting();
    let candidates = candidates(&setting, &[]).unwrap();
    let fixture = candidates.iter().find(|c| c.name == "fixture-compliance").unwrap();
    for separation in [Separation::Clamp, Separation::Bonded, Separation::Free] {
        for law in [BaseLaw::fung(2, separation), BaseLaw::new(Family::LATENCY, 1, separation)] {
            let base = Chain::new(law);
            let parameters: Vec<f64> = vec![0.4, 0.6, 0.3, 0.2, 4.0, 0.5][..law.count()].to_vec();
            for form in &fixture.forms {
                let chain = base.with(form.applied.clone());
                let own = [vec![0.15], form.grid[0].clone()].concat();
                let all = [parameters.clone(), own.clone()].concat();
                let force = predict(&chain, &all, &data).remove(0);
                let left = left(&x, &force, &form.applied.act, &own);
                let motion = Motion {
                    time: time.clone().into(),
                    displacement: left.into(),
                    rest_before: None,
                };
                let again = law.predict(&parameters, &[motion]).remove(0);
                same(&force, &again, &form.applied.law);
            }
        }
    }
}

#[test]
fn a_chain_that_yields_beside_another_effect_is_that_chain_on_what_is_left_of_the_motion() {
    let (time, x) = press(0.0);
    let traces = [trace(&time, &x)];
    let data = Data::of(&traces, FORCE).unwrap();
    let candidates = candidates(&data.setting(), &[]).unwrap();
    let named = |name: &str| &candidates.iter().find(|c| c.name == name).unwrap().forms[0];
    let (stiffening, base) = (named("elastic-stiffening"), [0.4, 0.6, 0.3, 0.2, 4.0, 0.5]);
    let alone = Chain::new(BaseLaw::fung(2, Separation::Clamp)).with(stiffening.applied.clone());
    let mut own = vec![0.5 * stiffening.typical];
    own.extend(&stiffening.grid[0]);
    let parameters = [base.to_vec(), own].concat();
    for form in &candidates.iter().find(|c| c.name == "fixture-compliance").unwrap().forms {
        let strength = [vec![0.15], form.grid[0].clone()].concat();
        let all = [parameters.clone(), strength.clone()].concat();
        let force = predict(&alone.with(form.applied.clone()), &all, &data).remove(0);
        let left = [trace(&time, &left(&x, &force, &form.applied.act, &strength))];
        let again = predict(&alone, &parameters, &Data::of(&left, FORCE).unwrap()).remove(0);
        same(&force, &again, &form.applied.law);
    }
}
