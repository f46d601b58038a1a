//! Every law of the library, run over a data set that shows what it acts on.

use std::collections::BTreeSet;

use palpate_fit::data::Data;
use palpate_model::effects::{Count, Effect, LIBRARY, Law, Setting, Sign};
use palpate_model::{Act, Applied, BaseLaw, Chain, Elasticity, History, Separation};
use palpate_trace::{Column, DISPLACEMENT, FORCE, TANGENTIAL, TEMPERATURE, Trace};

const BASE: [f64; 6] = [0.28, 0.45, 0.26, 0.24, 4.2, 0.55];

const SAMPLES: usize = 1200;

/// Two cycles to this compression with a hold, in air that becomes warmer.
fn trace(amplitude: f64, start: f64) -> Trace {
    let time: Vec<f64> = (0..SAMPLES).map(|k| k as f64 * 0.005).collect();
    let x = |t: f64| match t % 3.0 {
        t if t < 0.3 => -0.5,
        t if t < 0.9 => -0.5 + (amplitude + 0.5) * (0.5 - 0.5 * ((t - 0.3) * 5.236).cos()),
        t if t < 1.9 => amplitude,
        t if t < 2.5 => amplitude - (amplitude + 0.5) * (t - 1.9) / 0.6,
        _ => -0.5,
    };
    let column = |name: &str, value: &dyn Fn(f64) -> f64| Column {
        name: name.into(),
        values: time.iter().map(|&t| value(t)).collect(),
    };
    let columns = vec![
        column(DISPLACEMENT, &x),
        column(FORCE, &|t| 0.2 * x(t).max(0.0).powf(1.4)),
        column(TEMPERATURE, &|t| 23.0 + 0.01 * (start + t)),
        column(TANGENTIAL, &|t| 0.3 + 0.1 * (2.0 * t).sin()),
    ];
    let mut trace = Trace { time, columns, ..Trace::default() };
    trace.head.name = Some(format!("{amplitude} mm"));
    trace.head.setup.start_s = Some(start);
    trace
}

/// Three traces of which the base law knows everything but a hum.
fn traces() -> Vec<Trace> {
    let mut traces = vec![trace(4.0, 0.0), trace(8.0, 20.0), trace(6.0, 60.0)];
    let base = Chain::new(BaseLaw::fung(2, Separation::Clamp));
    let force = run(&Data::of(&traces, FORCE).unwrap(), &base, &BASE);
    // A hum is there to be followed.
    let hum = |time: &f64| 0.001 * (std::f64::consts::TAU * 50.03 * time).sin();
    for (trace, force) in traces.iter_mut().zip(force.chunks(SAMPLES)) {
        let hums = trace.time.iter().map(hum);
        trace.columns[1].values = force.iter().zip(hums).map(|(force, hum)| force + hum).collect();
    }
    traces
}

/// A law with the data over which it runs.
struct Case<'a> {
    data: &'a Data<'a>,
    effect: &'static Effect,
    law: &'static Law,
}

impl Case<'_> {
    fn applied(&self) -> Applied {
        self.law.applied(self.effect, &self.data.setting())
    }

    /// The prediction of the base law with this one, all traces one after the other.
    fn predict(&self, separation: Separation, parameters: &[f64]) -> Vec<f64> {
        let base = Chain::new(BaseLaw::fung(2, separation));
        run(self.data, &base.with(self.applied()), &[&BASE[..], parameters].concat())
    }

    /// Strengths of one size, then these shapes.
    fn parameters(&self, size: f64, shapes: &[f64]) -> Vec<f64> {
        let mut parameters = vec![size; self.applied().strengths];
        parameters.extend(shapes);
        parameters
    }

    fn name(&self) -> String {
        format!("{} {}", self.effect.name, self.law.name)
    }
}

fn run(data: &Data, chain: &Chain, parameters: &[f64]) -> Vec<f64> {
    let mut history = History::default();
    let mut all = Vec::new();
    for piece in &data.pieces {
        let mut force = Vec::new();
        let scene = data.scene(piece);
        chain.run(parameters, &scene, &mut history, &mut Elasticity::default(), &mut force);
        all.extend(force);
    }
    all
}

/// Does this with every law of the library.
fn with_every_law(test: impl Fn(&Case)) {
    let traces = traces();
    let data = Data::of(&traces, FORCE).unwrap();
    for effect in LIBRARY {
        assert_eq!(effect.needs.missing(&data.setting()), None, "{}", effect.name);
        for law in effect.laws {
            test(&Case { data: &data, effect, law });
        }
    }
}

#[test]
fn at_zero_strength_a_law_leaves_the_prediction_bit_for_bit() {
    with_every_law(|case| {
        for separation in [Separation::Clamp, Separation::Free, Separation::Bonded] {
            let bare = run(case.data, &Chain::new(BaseLaw::fung(2, separation)), &BASE);
            for shapes in case.law.grid(&case.data.scales()) {
                let found = case.predict(separation, &case.parameters(0.0, &shapes));
                assert_eq!(found, bare, "{} {shapes:?}", case.name());
            }
        }
    });
}

/// Their derivatives are taken from that.
#[test]
fn laws_that_only_add_add_the_same_to_every_force() {
    with_every_law(|case| {
        let typical = (case.law.strength.typical)(&case.data.scales());
        let shapes = &case.law.grid(&case.data.scales())[0];
        let bare = Chain::new(BaseLaw::fung(2, Separation::Clamp));
        let with = bare.with(case.applied());
        let added = |base: &[f64]| -> Vec<f64> {
            let own = [base, &case.parameters(typical, shapes)].concat();
            let (there, none) = (run(case.data, &with, &own), run(case.data, &bare, base));
            there.iter().zip(&none).map(|(there, none)| there - none).collect()
        };
        let twice = [&[2.0 * BASE[0]], &BASE[1..]].concat();
        let (once, twice) = (added(&BASE), added(&twice));
        let size = once.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let same = once.iter().zip(&twice).all(|(a, b)| (a - b).abs() <= 1e-9 * size);
        let adds = matches!(case.law.act, Act::Added(_));
        assert!(!adds || same && with.only_adds_to_force(), "{}", case.name());
    });
}

#[test]
fn at_its_typical_strength_a_law_is_felt_and_twice_the_same() {
    with_every_law(|case| {
        let scales = case.data.scales();
        let bare =
            case.predict(Separation::Clamp, &case.parameters(0.0, &case.law.grid(&scales)[0]));
        let typical = (case.law.strength.typical)(&scales);
        for shapes in case.law.grid(&scales) {
            let parameters = case.parameters(typical, &shapes);
            let found = case.predict(Separation::Clamp, &parameters);
            let square: f64 = found.iter().zip(&bare).map(|(a, b)| (a - b).powi(2)).sum();
            let part = (square / bare.len() as f64).sqrt() / scales.force;
            let felt = 1e-5..0.1;
            assert!(felt.contains(&part), "{} {shapes:?}: {part:e} of full force", case.name());
            assert_eq!(found, case.predict(Separation::Clamp, &parameters), "{}", case.name());
        }
    });
}

#[test]
fn within_its_bounds_a_law_gives_numbers() {
    with_every_law(|case| {
        let applied = case.applied();
        let (strengths, shapes) = applied.parameters.split_at(applied.strengths);
        let corners = shapes.iter().fold(vec![Vec::new()], |corners, shape| {
            let ends: BTreeSet<u64> = [shape.lower, shape.upper].map(f64::to_bits).into();
            let longer = |corner: &Vec<f64>| {
                let end = |&bits: &u64| [&corner[..], &[f64::from_bits(bits)]].concat();
                ends.iter().map(end).collect::<Vec<_>>()
            };
            corners.iter().flat_map(longer).collect()
        });
        for size in [strengths[0].lower, strengths[0].upper] {
            assert!(size.is_finite(), "{}", case.name());
            for shapes in &corners {
                for separation in [Separation::Clamp, Separation::Free] {
                    let found = case.predict(separation, &case.parameters(size, shapes));
                    let broken = found.iter().position(|force| !force.is_finite());
                    assert_eq!(broken, None, "{} {size} {shapes:?}", case.name());
                }
            }
        }
    });
}

#[test]
fn declarations_hold_together() {
    with_every_law(|case| {
        let (applied, scales) = (case.applied(), case.data.scales());
        let typical = (case.law.strength.typical)(&scales);
        for parameter in &applied.parameters[..applied.strengths] {
            assert!(parameter.lower <= 0.0 && typical > 0.0, "{}", case.name());
            assert!(typical <= parameter.upper, "{}: {}", case.name(), parameter.name);
            assert_eq!(parameter.lower < 0.0, case.law.strength.sign == Sign::Either);
        }
        for shape in case.law.shapes {
            let grid = (shape.grid)(&scales);
            assert!(grid.is_sorted() && !grid.is_empty(), "{}: {}", case.name(), shape.name);
            match shape.role.bounds(&scales) {
                None => assert_eq!(grid.len(), 1, "{}: {}", case.name(), shape.name),
                Some((lower, upper)) => {
                    let within = grid.iter().all(|value| (lower..=upper).contains(value));
                    assert!(within, "{}: {} {grid:?}", case.name(), shape.name);
                }
            }
        }
        let names: BTreeSet<_> = applied.parameters.iter().map(|p| p.name.as_ref()).collect();
        assert_eq!(names.len(), applied.parameters.len(), "{}", case.name());
        let texts = [case.law.formula, case.law.strength.meaning, case.effect.experiment];
        assert!(texts.iter().all(|text| !text.is_empty()), "{}", case.name());
    });
}

#[test]
fn the_library_knows_every_effect_in_the_order_of_the_chain() {
    const NAMES: [&str; 30] = [
        "contact-offset",
        "fixture-compliance",
        "backlash",
        "sync-delay",
        "elastic-stiffening",
        "mullins",
        "cyclic-softening",
        "permanent-set",
        "thermal-stiffness",
        "fast-mode",
        "slow-relaxation",
        "amplitude-dependent-relaxation",
        "time-temperature",
        "latency-law",
        "coulomb-friction",
        "load-friction",
        "viscous-drag",
        "rate-drag",
        "inertia",
        "adhesion",
        "zero-shift",
        "drift",
        "warm-up",
        "thermal-output",
        "gauge-nonlinearity",
        "saturation",
        "sensor-lag",
        "hysteresis",
        "mains-hum",
        "crosstalk",
    ];
    let names = LIBRARY.iter().map(|effect| effect.name);
    assert_eq!(names.filter(|name| NAMES.contains(name)).collect::<Vec<_>>(), NAMES);
    assert!(LIBRARY.is_sorted_by_key(|effect| effect.stage));
    for effect in LIBRARY {
        assert_eq!(effect.laws[0].name, "reference", "{}", effect.name);
        let laws: BTreeSet<_> = effect.laws.iter().map(|law| law.name).collect();
        assert_eq!(laws.len(), effect.laws.len(), "{}", effect.name);
        for other in effect.confused_with {
            assert!(NAMES.contains(other) && *other != effect.name, "{}: {other}", effect.name);
        }
    }
}

#[test]
fn strengths_are_named_by_trace_and_channel() {
    let setting =
        Setting { traces: vec!["a".into(), "b".into()], channels: vec!["c"], ..Setting::default() };
    let law = |effect: &str, count: fn(Count) -> bool| {
        let laws = palpate_model::effects::find(effect).unwrap().laws;
        laws.iter().find(|law| count(law.strength.count)).unwrap().strengths(&setting)
    };
    assert_eq!(law("zero-shift", |count| count == Count::Traces), ["zero[a]", "zero[b]"]);
    assert_eq!(law("crosstalk", |count| count == Count::Channels), ["leak[c]"]);
    assert_eq!(
        law("mains-hum", |count| matches!(count, Count::EachTrace(_))),
        ["sine[a]", "cosine[a]", "sine[b]", "cosine[b]"]
    );
}
