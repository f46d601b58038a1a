//! What every base law promises: energy, closed forms, parameters that come back.

use palpate::fit::data::Data;
use palpate::fit::whole_motion::fit;
use palpate::model::laws::FAMILIES;
use palpate::model::{
    BaseLaw, Deformation, Elastic, ElasticLaw, Family, Gauge, Kernel, LawOption, Model, Motion,
    Separation,
};
use palpate::trace::{Column, DISPLACEMENT, FORCE, Trace, write};
use palpate_tests::{palpate, press};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use serde_json::Value;

/// Samples per second of the random motions.
const RATE: f64 = 400.0;

/// A law with parameters of a soft specimen.
fn example(family: &'static Family) -> (BaseLaw, Vec<f64>) {
    let law = BaseLaw::new(family, 2, Separation::Clamp);
    let values = match family.name {
        "kelvin-voigt" => vec![0.4, 0.05],
        "maxwell" => vec![0.4, 0.3],
        "generalized-maxwell" => vec![0.2, 0.15, 0.1, 0.03, 0.2],
        "fung" => vec![0.1, 0.8, 0.26, 0.24, 4.0, 0.5],
        "latency" => vec![0.1, 0.8, 0.4, 0.7],
        "latency-power" => vec![0.1, 0.8, 0.3, 0.4, 3.0],
        "creep" => vec![0.06, 0.8, -0.2, -0.15, 3.0, 0.4],
        other => panic!("{other} has no example"),
    };
    (law, values)
}

/// Fung's law with other kernels and with laws of the stretch, for a specimen 20 mm long.
fn variants() -> Vec<(BaseLaw, Vec<f64>)> {
    let fung = BaseLaw::fung(2, Separation::Clamp);
    let rubber = |law, deformation| Elastic::stretch(law, Gauge { length_mm: 20.0, deformation });
    let pulled = |law| rubber(law, Deformation::Tension);
    vec![
        (fung.with(Elastic::POWER, Kernel::POWER_LAW), vec![0.1, 0.8, 0.6, 0.15]),
        (fung.with(Elastic::POWER, Kernel::STRETCHED), vec![0.1, 0.8, 0.6, 0.5, 0.4]),
        (fung.with(Elastic::POWER, Kernel::NONE), vec![0.1, 0.8]),
        (
            fung.with(pulled(ElasticLaw::NEO_HOOKE), Kernel::EXPONENTIALS),
            vec![2.0, 0.26, 0.24, 4.0, 0.5],
        ),
        (
            fung.with(pulled(ElasticLaw::MOONEY_RIVLIN), Kernel::POWER_LAW),
            vec![0.8, 0.4, 0.6, 0.15],
        ),
        (fung.with(pulled(ElasticLaw::OGDEN), Kernel::STRETCHED), vec![2.0, 5.0, 0.5, 0.5, 0.4]),
        (fung.with(pulled(ElasticLaw::GENT), Kernel::NONE), vec![2.0, 0.6]),
        (
            fung.with(rubber(ElasticLaw::GENT, Deformation::Shear), Kernel::POWER_LAW),
            vec![2.0, 0.2, 0.7, 0.2],
        ),
        (
            fung.with(rubber(ElasticLaw::OGDEN, Deformation::Compression), Kernel::POWER_LAW),
            vec![2.0, -3.0, 0.4, 0.2],
        ),
    ]
}

/// A motion at random: ramps of any speed with holds, that begins and ends off the specimen.
fn wander(random: &mut ChaCha8Rng) -> Motion<'static> {
    let (mut x, mut at) = (vec![-0.2], -0.2);
    for _ in 0..random.random_range(3..9) {
        let to = random.random_range(-0.2..6.0);
        let speed = 60f64.powf(random.random_range(0.0..1.0));
        ramp(&mut x, &mut at, to, speed);
        if random.random_bool(0.6) {
            x.extend(std::iter::repeat_n(at, random.random_range(1..400)));
        }
    }
    ramp(&mut x, &mut at, -0.2, 20.0);
    let time: Vec<f64> = (0..x.len()).map(|k| k as f64 / RATE).collect();
    Motion { time: time.into(), displacement: x.into(), rest_before: None }
}

fn ramp(x: &mut Vec<f64>, at: &mut f64, to: f64, speed: f64) {
    let count = ((to - *at).abs() / speed * RATE).ceil().max(1.0);
    let from = *at;
    x.extend((1..=count as usize).map(|k| from + (to - from) * k as f64 / count));
    *at = to;
}

/// Work done on the specimen, ∫ F dx, mJ, and the work of the loadings alone.
fn work(x: &[f64], force: &[f64]) -> (f64, f64) {
    let each = x.windows(2).zip(force.windows(2)).map(|(x, f)| 0.5 * (f[0] + f[1]) * (x[1] - x[0]));
    each.fold((0.0, 0.0), |(all, loading), work| (all + work, loading + work.max(0.0)))
}

/// The least part of the work of loading that a law keeps, over random motions.
fn least_dissipation(force: impl Fn(&Motion) -> Vec<f64>, motions: usize) -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let part = |motion: Motion| {
        let force = force(&motion);
        let (all, loading) = work(&motion.displacement, &force);
        if loading > 0.0 { all / loading } else { 0.0 }
    };
    (0..motions).map(|_| part(wander(&mut random))).fold(f64::INFINITY, f64::min)
}

#[test]
fn no_law_gives_back_more_energy_than_it_took_over_a_thousand_motions() {
    for &family in FAMILIES {
        for separation in [Separation::Clamp, Separation::Free, Separation::Bonded] {
            if separation == Separation::Bonded && !family.takes(LawOption::Bonded) {
                continue;
            }
            let (law, values) = example(family);
            let law = BaseLaw { separation, ..law };
            let alone =
                |motion: &Motion| law.predict(&values, std::slice::from_ref(motion)).remove(0);
            let least = least_dissipation(alone, 1000);
            // The trapezoid over samples is off by less than this.
            assert!(least > -1e-3, "{} {}: {least}", family.name, separation.name());
        }
    }
}

#[test]
fn no_kernel_and_no_law_of_the_stretch_gives_back_more_energy_than_it_took() {
    for (law, values) in variants() {
        let law = BaseLaw { separation: Separation::Bonded, ..law };
        let alone = |motion: &Motion| law.predict(&values, std::slice::from_ref(motion)).remove(0);
        let least = least_dissipation(alone, 200);
        assert!(least > -1e-3, "{}: {least}", law.in_words());
    }
}

#[test]
fn a_law_whose_relaxation_goes_the_wrong_way_makes_energy() {
    // 4.4.3: if the force fell in the hold after an unloading (and rose after a loading), loops would
    // run the other way round. That is Fung's law with a share of the wrong sign.
    let law = BaseLaw::new(Family::FUNG, 1, Separation::Bonded);
    let wrong = |motion: &Motion| {
        law.predict(&[0.1, 0.8, -0.3, 4.0], std::slice::from_ref(motion)).remove(0)
    };
    assert!(least_dissipation(wrong, 1000) < -0.05);
}

/// A press with a hold and a slow release, and the force of a law.
fn record(law: &BaseLaw, values: &[f64]) -> Vec<Trace> {
    [(4.0, 30.0), (6.0, 5.0), (5.0, 12.0)]
        .into_iter()
        .map(|(deep, speed)| {
            let (mut x, mut at) = (vec![-0.2], -0.2);
            ramp(&mut x, &mut at, deep, speed);
            x.extend(std::iter::repeat_n(at, 1600));
            ramp(&mut x, &mut at, 0.4 * deep, speed);
            x.extend(std::iter::repeat_n(at, 800));
            ramp(&mut x, &mut at, -0.2, speed);
            let x: Vec<f64> = x.into_iter().step_by(2).collect();
            let time: Vec<f64> = (0..x.len()).map(|k| 2.0 * k as f64 / RATE).collect();
            let motion = Motion {
                time: time.clone().into(),
                displacement: x.clone().into(),
                rest_before: None,
            };
            let force = law.predict(values, &[motion]).remove(0);
            let column = |name: &str, values| Column { name: name.into(), values };
            let columns = vec![column(DISPLACEMENT, x), column(FORCE, force)];
            Trace { time, columns, ..Trace::default() }
        })
        .collect()
}

#[test]
fn every_law_finds_the_parameters_that_its_force_was_made_with() {
    for (law, values) in FAMILIES.iter().map(|family| example(family)).chain(variants()) {
        let traces = record(&law, &values);
        let found = fit(law, &Data::of(&traces, FORCE).unwrap()).unwrap();
        for ((found, wanted), parameter) in found.values.iter().zip(&values).zip(law.parameters()) {
            let off = (found - wanted).abs() / wanted.abs();
            assert!(off < 1e-3, "{} {}: {found} for {wanted}", law.in_words(), parameter.name);
        }
    }
}

#[test]
fn one_exponential_of_relaxation_is_one_of_creep() {
    // g = c0 + c1 e^(−v t) and h = 1 − c1 e^(−c0 v t) are one material (linear, k = c0 p).
    let fung = BaseLaw::new(Family::FUNG, 1, Separation::Bonded);
    let creep = BaseLaw::new(Family::CREEP, 1, Separation::Clamp);
    let (mut x, mut at) = (vec![0.0], 0.0);
    ramp(&mut x, &mut at, 5.0, 1.0);
    x.extend(std::iter::repeat_n(at, 4000));
    let time: Vec<f64> = (0..x.len()).map(|k| k as f64 / RATE).collect();
    let motion = Motion { time: time.into(), displacement: x.into(), rest_before: None };
    let motion = std::slice::from_ref(&motion);
    let relaxed = fung.predict(&[0.5, 0.0, 0.4, 0.8], motion).remove(0);
    let crept = creep.predict(&[0.3, 0.0, -0.4, 0.48], motion).remove(0);
    for (a, b) in relaxed.iter().zip(&crept) {
        assert!((a - b).abs() < 1e-6, "{a} and {b}");
    }
}

#[test]
fn a_maxwell_element_under_a_steady_speed_follows_its_differential_equation() {
    // F'/k + F/η = v: F = η v (1 − e^(−k t/η)) (eq. 2.4).
    let law = BaseLaw::new(Family::MAXWELL, 1, Separation::Clamp);
    let time: Vec<f64> = (0..=800).map(|k| f64::from(k) / RATE).collect();
    let x: Vec<f64> = time.iter().map(|t| 3.0 * t).collect();
    let motion = Motion { time: time.clone().into(), displacement: x.into(), rest_before: None };
    let force = law.predict(&[0.4, 0.3], &[motion]).remove(0);
    for (t, force) in time.iter().zip(&force) {
        assert!((force - 0.3 * 3.0 * (1.0 - (-0.4 * t / 0.3).exp())).abs() < 1e-9);
    }
}

/// Standard deviation of the noise of the recordings with friction, N.
const NOISE: f64 = 0.005;
/// Friction at the contact, N.
const FRICTION: f64 = 0.04;

/// Presses of a specimen of this law whose contact rubs with this force, N, as files of a folder.
fn record_files(folder: &std::path::Path, (law, values): &(BaseLaw, Vec<f64>), friction: f64) {
    let motions: Vec<Motion> = [3.0, 6.0]
        .iter()
        .flat_map(|&deep| [6.0, 40.0].map(|speed| press(deep, speed, 1.5)))
        .collect();
    let force = law.predict(values, &motions);
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let normal = Normal::new(0.0, NOISE).unwrap();
    for (number, (motion, force)) in motions.into_iter().zip(force).enumerate() {
        let x = motion.displacement.into_owned();
        let rubs = |k: usize| {
            let speed = (x[k] - x[k.saturating_sub(1)]) * 200.0;
            if force[k] > 0.0 { friction * (speed / 0.2).tanh() } else { 0.0 }
        };
        let measured = (0..x.len()).map(|k| force[k] + rubs(k) + normal.sample(&mut random));
        let columns = vec![
            Column { name: FORCE.into(), values: measured.collect() },
            Column { name: DISPLACEMENT.into(), values: x.clone() },
        ];
        let trace = Trace { time: motion.time.into_owned(), columns, ..Trace::default() };
        write(&folder.join(format!("take-{number}.csv")), &trace).unwrap();
    }
}

/// What the command prints as JSON.
fn told(folder: &std::path::Path, arguments: &[&str]) -> Value {
    let output = palpate().current_dir(folder).args(arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {said}");
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn friction_is_found_and_added_whatever_the_base_law() {
    for &family in FAMILIES {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path();
        std::fs::create_dir(folder.join("traces")).unwrap();
        record_files(&folder.join("traces"), &example(family), FRICTION);
        let name = family.name;
        told(folder, &["fit", name, "traces", "-o", "model.toml", "--json"]);
        let compared = told(folder, &["compare", "model.toml", "traces", "--json"]);
        assert_eq!(compared["only_noise"], false, "{name}");
        let answer = told(folder, &["diagnose", "--model", "model.toml", "--json", "traces"]);
        let set: Vec<&str> = answer["steps"][0]["credible_set"]
            .as_array()
            .unwrap_or_else(|| panic!("{name}: {answer:#}"))
            .iter()
            .filter_map(Value::as_str)
            .collect();
        assert!(set.contains(&"coulomb-friction"), "{name}: {set:?}");
        let change = told(
            folder,
            &["add", "coulomb-friction", "model.toml", "traces", "--json", "-o", "better.toml"],
        );
        let rms = |at: &str| change[at].as_f64().unwrap();
        let (before, after) = (rms("rms_before"), rms("rms_after"));
        assert!(after < 1.5 * NOISE && after < 0.65 * before, "{name}: {before} {after}");
        let ladder = std::fs::read_to_string(folder.join("better.toml")).unwrap();
        assert!(ladder.contains(&format!("add = \"{name}\"")), "{ladder}");
    }
}

#[test]
fn every_law_is_ranked_and_the_one_that_made_the_traces_comes_first() {
    let place = tempfile::tempdir().unwrap();
    record_files(place.path(), &example(Family::FUNG), 0.0);
    let ranking = told(place.path(), &["fit", "--all", ".", "--json"]);
    let laws = ranking["laws"].as_array().unwrap();
    // Every family, and Fung's law with the three other kernels: the heads say no gauge length.
    assert_eq!(laws.len(), FAMILIES.len() + 3);
    assert_eq!((&laws[0]["law"], &laws[0]["relaxation"]), (&"fung".into(), &"exponentials".into()));
    let held_out: Vec<f64> = laws.iter().map(|law| law["heldout_rms"].as_f64().unwrap()).collect();
    assert!(held_out.is_sorted(), "{held_out:?}");
    // Chapter 3's argument: what belongs to the material moves less between set-ups.
    let moves = |name: &str| {
        let law = laws.iter().find(|law| law["law"] == name).unwrap();
        law["deviation_between_setups"].as_f64().unwrap()
    };
    assert!(
        moves("fung") < 0.2 && moves("maxwell") > 0.2,
        "{} {}",
        moves("fung"),
        moves("maxwell")
    );
}

#[test]
fn options_of_another_law_are_refused_in_words() {
    for (arguments, word) in [
        (["fit", "fung", "x.csv", "--segments", "8"], "latency models"),
        (["fit", "latency", "x.csv", "--exponent", "3"], "latency-power"),
        (["fit", "creep", "x.csv", "--separation", "bonded"], "cannot be bonded"),
        (["fit", "latency", "x.csv", "--relaxation", "power-law"], "is for `fung`"),
        (["fit", "maxwel", "x.csv", "--terms", "2"], "known: kelvin-voigt"),
    ] {
        let output = palpate().args(arguments).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        // The trace does not exist: the law and its options are looked at first.
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(word), "{arguments:?}: {said}");
    }
}

#[test]
fn rubber_in_tension_goes_through_every_command() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    std::fs::create_dir(folder.join("traces")).unwrap();
    let (law, values) = variants().remove(5);
    let law = BaseLaw { separation: Separation::Bonded, ..law };
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let normal = Normal::new(0.0, NOISE).unwrap();
    let mut traces = record(&law, &values);
    for (number, trace) in traces.iter_mut().enumerate() {
        let force = trace.force().unwrap().iter().map(|f| f + normal.sample(&mut random)).collect();
        trace.set_column(FORCE, force);
        trace.head.setup.other.insert("mode".into(), "tension".into());
        write(&folder.join(format!("traces/pull-{number}.csv")), trace).unwrap();
    }
    let call = ["fit", "fung", "traces", "--elastic", "ogden", "--separation", "bonded"];
    let output = palpate().current_dir(folder).args(call).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("no height_mm"), "{output:?}");
    for (number, trace) in traces.iter_mut().enumerate() {
        trace.head.specimen.height_mm = Some(20.0);
        write(&folder.join(format!("traces/pull-{number}.csv")), trace).unwrap();
    }
    let more = ["--relaxation", "stretched", "-o", "model.toml", "--json"];
    let fit = told(folder, &[&call[..], &more[..]].concat());
    let alpha = &fit["parameters"]["alpha"];
    let (value, error) =
        (alpha["value"].as_f64().unwrap(), alpha["standard_error"].as_f64().unwrap());
    assert!((value - 5.0).abs() < 4.0 * error && error < 0.5, "{value} ± {error}");
    assert!(fit["residual_rms"].as_f64().unwrap() < 1.05 * NOISE, "{fit:#}");
    told(folder, &["compare", "model.toml", "traces", "--json"]);
    let answer = told(folder, &["diagnose", "--model", "model.toml", "--json", "traces"]);
    assert!(answer["verdict"].is_string(), "{answer:#}");
    // The same specimen where the grips rub.
    std::fs::create_dir(folder.join("rubbed")).unwrap();
    for (number, trace) in traces.iter().enumerate() {
        let x = trace.displacement().unwrap();
        let speed = |k: usize| (x[k] - x[k.saturating_sub(1)]) * 0.5 * RATE;
        let rubs = |(k, f): (usize, &f64)| f + FRICTION * (speed(k) / 0.2).tanh();
        let mut rubbed = trace.clone();
        rubbed.set_column(FORCE, trace.force().unwrap().iter().enumerate().map(rubs).collect());
        write(&folder.join(format!("rubbed/pull-{number}.csv")), &rubbed).unwrap();
    }
    let call = ["add", "coulomb-friction", "model.toml", "rubbed", "--json", "-o", "more.toml"];
    let change = told(folder, &call);
    assert!(change["rms_after"].as_f64().unwrap() < 1.5 * NOISE, "{change:#}");
    let motion = ["simulate", "model.toml", "--motion", "traces/pull-0.csv", "-o", "again.csv"];
    palpate().current_dir(folder).args(motion).assert().success();
    let again = palpate::trace::read(&folder.join("again.csv")).unwrap();
    let off = again.force().unwrap().iter().zip(traces[0].force().unwrap());
    let rms = (off.map(|(a, b)| (a - b).powi(2)).sum::<f64>() / again.time.len() as f64).sqrt();
    assert!(rms < 1.1 * NOISE, "{rms}");
    // A specimen of another length is not this one.
    traces[0].head.specimen.height_mm = Some(30.0);
    write(&folder.join("other.csv"), &traces[0]).unwrap();
    let output =
        palpate().current_dir(folder).args(["compare", "model.toml", "other.csv"]).output();
    let output = output.unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(
        String::from_utf8_lossy(&output.stderr).contains("gauge length of 30 mm"),
        "{output:?}"
    );
}

/// A model file of this law in a folder.
fn model_of(folder: &std::path::Path, (law, values): &(BaseLaw, Vec<f64>)) {
    let errors = vec![None; values.len()];
    Model::of(law, FORCE, values, &errors).write(&folder.join("model.toml")).unwrap();
}

/// Steps of the programme of forces.
const PROGRAMME: &str = "palpate-force-profile = 1
rate_hz = 200.0
loading_N_per_s = 1.0
[[step]]
to_N = 1.0
[[step]]
hold_s = 5.0
[[step]]
to_N = 0.4
[[step]]
hold_s = 5.0
";

#[test]
fn under_a_controlled_force_every_law_that_relaxes_creeps_both_ways() {
    for family in FAMILIES.iter().copied().filter(|family| *family != Family::KELVIN_VOIGT) {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path();
        model_of(folder, &example(family));
        std::fs::write(folder.join("force.toml"), PROGRAMME).unwrap();
        let call = ["simulate", "model.toml", "--force", "force.toml", "-o", "crept.csv"];
        palpate().current_dir(folder).args(call).assert().success();
        let trace = palpate::trace::read(&folder.join("crept.csv")).unwrap();
        let (x, force) = (trace.displacement().unwrap(), trace.force().unwrap());
        let at = |time: f64| (time * 200.0) as usize;
        assert!((force[at(3.0)] - 1.0).abs() < 0.02, "{}: {}", family.name, force[at(3.0)]);
        assert!(x[at(5.9)] > x[at(2.0)], "{}: Type I", family.name);
        // A Maxwell fluid flows on under any force; the others come back after a partial unloading.
        if family != Family::MAXWELL {
            assert!(x[at(11.0)] < x[at(7.2)], "{}: Type II", family.name);
        }
    }
}

#[test]
fn the_nodes_inside_follow_the_contact() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    let (law, _) = example(Family::LATENCY_POWER);
    let law = BaseLaw { segments: Some(5), exponent: Some(3.0), ..law };
    model_of(folder, &(law, vec![0.1, 0.8, 0.4]));
    let press = palpate_tests::workspace().join("tests/traces/press.csv");
    palpate()
        .current_dir(folder)
        .args(["simulate", "model.toml", "--nodes", "-o", "nodes.csv", "--motion"])
        .arg(press)
        .assert()
        .success();
    let trace = palpate::trace::read(&folder.join("nodes.csv")).unwrap();
    let node = |number: usize| trace.column(&format!("node{number}_mm")).unwrap();
    for k in 0..trace.len() {
        let outer = trace.displacement().unwrap()[k].max(0.0);
        assert!(node(2)[k] <= outer.max(node(2)[k.saturating_sub(1)]) + 1e-9);
    }
    // Force and nodes of one file are of one specimen: F = N(x)/x ε1 with ε1 = x1 − x2 of m segments and
    // N(x) = 0.1/1.8 x^1.8.
    let (force, x) = (trace.force().unwrap(), trace.displacement().unwrap());
    for k in 0..trace.len() {
        if x[k] > 0.1 {
            let strain = x[k] - node(2)[k];
            let expected = (0.1 / 1.8 * x[k].powf(0.8) * strain).max(0.0);
            assert!((force[k] - expected).abs() < 1e-4, "{k}: {} N for {expected} N", force[k]);
        }
    }
    assert!(node(5).iter().copied().fold(0.0, f64::max) > 0.1);
}

#[test]
fn a_force_profile_that_cannot_be_is_refused_and_nothing_is_written() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    model_of(folder, &example(Family::CREEP));
    for (from, to, word) in [
        ("profile = 1", "profile = 3", "version 3"),
        ("to_N = 0.4", "to_N = -0.4", "not negative"),
        ("rate_hz = 200.0", "rate_hz = 200.0\nbandwidth_hz = 50.0", "a tenth"),
        ("hold_s = 5.0", "hold_s = 0.0", "above zero"),
        ("hold_s", "holds", "not a force profile"),
    ] {
        std::fs::write(folder.join("force.toml"), PROGRAMME.replacen(from, to, 1)).unwrap();
        let call = ["simulate", "model.toml", "--force", "force.toml", "-o", "crept.csv"];
        let output = palpate().current_dir(folder).args(call).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(word), "{said}");
        assert!(!folder.join("crept.csv").exists());
    }
}
