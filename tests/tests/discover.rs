//! A formula is found for what no effect of the library explains, on data from the generator in `src/hidden`, which shares no
//! physics with the library and no grammar with the search.

use std::f64::consts::TAU;
use std::time::Instant;

use palpate::answers::{self, DiscoveryAnswer};
use palpate::discover::formula::Formula;
use palpate::discover::{Discovery, Outcome, discover};
use palpate::fit::data::Data;
use palpate::fit::whole_motion::fit;
use palpate::model::{BaseLaw, Model, Separation};
use palpate::summary::{DiscoverySummary, NextCommand, Preparation};
use palpate::trace::{Column, DISPLACEMENT, FORCE, Trace};
use palpate_tests::follows_schema;
use palpate_tests::held_press::{force, times};
use palpate_tests::hidden::laws::{OUTSIDE, OUTSIDE_MORE};
use palpate_tests::hidden::{DataSet, Day, LawKind, NoiseKind, Scenario, generate};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const LAW: BaseLaw = BaseLaw::fung(2, Separation::Clamp);

fn set(seed: u64, hidden: &[(&str, LawKind)], r: f64) -> DataSet {
    let hidden = hidden.iter().map(|(effect, kind)| ((*effect).to_owned(), *kind)).collect();
    generate(&Scenario { seed, hidden, r, noise: NoiseKind::Correlated, day: Day::Usual })
}

/// The same with one sample in so many: nearly as clear, and searched in as small a part of the time.
fn thinned_set(part: usize, seed: u64, hidden: &[(&str, LawKind)], r: f64) -> DataSet {
    let mut set = set(seed, hidden, r);
    for trace in &mut set.traces {
        let columns = trace.columns.iter_mut().map(|column| &mut column.values);
        for values in columns.chain([&mut trace.time]) {
            *values = values.iter().step_by(part).copied().collect();
        }
    }
    set
}

/// Fits the base law and looks for a formula.
fn ask(set: &DataSet) -> Discovery {
    ask_of(&set.traces, set.truth.signal)
}

/// The same of the traces of a test.
fn ask_of(traces: &[Trace], signal: &str) -> Discovery {
    let base = fit(LAW, &Data::of(traces, signal).unwrap()).unwrap();
    let model = Model::of(&LAW, signal, &base.values, &base.standard_errors);
    discover(&model, traces, "N").unwrap()
}

/// The formulas that were found.
fn formulas(discovery: &Discovery) -> &[Formula] {
    let Outcome::Formulas(formulas) = &discovery.outcome else {
        panic!("{:?}", discovery.outcome);
    };
    formulas
}

/// Error on traces left out of the last model, over the noise that the generator added.
fn held_out(discovery: &Discovery, set: &DataSet) -> f64 {
    let last = discovery.ladder.last().and_then(|rung| rung.heldout_rms);
    last.expect("several traces") / set.truth.noise_rms
}

/// The answer for programs.
fn printed(discovery: &Discovery, set: &DataSet) -> serde_json::Value {
    let labels: Vec<String> = set.traces.iter().map(Trace::label).collect();
    let next = NextCommand { model: "model.toml".into(), traces: "set".into() };
    let summary = DiscoverySummary::new(discovery, &labels, next, None);
    let preparation = Preparation::of(&set.traces, set.truth.signal);
    answers::json(&preparation.with(DiscoveryAnswer::from(&summary)))
}

#[test]
fn the_teeth_of_a_drive_are_a_wave_over_the_displacement() {
    // A wave of a millimetre at 60 mm/s still has four samples.
    let set = thinned_set(2, 31, &[("cogging", LawKind::Outside)], 1.0);
    let discovery = ask(&set);
    let formula = &formulas(&discovery)[0];
    assert_eq!((formula.term.shape.name, formula.term.quantity.symbol), ("periodic in", "x"));
    assert!(held_out(&discovery, &set) < 1.15, "{:?}", discovery.ladder);
    follows_schema("discover", &printed(&discovery, &set));
}

#[test]
fn what_goes_on_after_each_stop_is_a_wave_that_dies_away() {
    let set = thinned_set(8, 42, &[("swing-out", LawKind::Beyond)], 2.0);
    let discovery = ask(&set);
    let term = &formulas(&discovery)[0].term;
    let told = (term.shape.name, term.quantity.name);
    assert_eq!(told, ("dying wave over", "time since the motion stopped"));
}

/// A belt that stretches with the speed and recovers: its fit needs more steps than most.
#[test]
fn a_law_whose_fit_takes_many_steps_is_fitted_to_its_end() {
    let set = set((1 << 40) ^ (55 << 10), &[("belt", LawKind::Beyond)], 2.0);
    let discovery = ask(&set);
    let term = &formulas(&discovery)[0].term;
    assert_eq!((term.shape.name, term.quantity.symbol), ("behind", "v"));
    assert!(held_out(&discovery, &set) < 1.15, "{:?}", discovery.ladder);
}

/// The value of a parameter of the hidden effect.
fn hidden_parameter(set: &DataSet, name: &str) -> f64 {
    let mut parameters = set.truth.hidden[0].parameters.iter();
    parameters.find(|(own, _)| *own == name).expect("a parameter of this name").1
}

/// Thixotropy: motion wears the structure off, rest builds it up again.
#[test]
fn a_structure_that_motion_wears_off_is_found_with_how_it_recovers() {
    let set = thinned_set(2, (1 << 40) ^ (58 << 10), &[("thixotropy", LawKind::Beyond)], 2.0);
    let discovery = ask(&set);
    let formula = &formulas(&discovery)[0];
    let told = (formula.term.shape.name, formula.term.quantity.symbol);
    assert_eq!(told, ("worn by", "abs(v)"));
    let truth = hidden_parameter(&set, "tau_s");
    let recovers = formula.law.parameters["time"].value;
    assert!((recovers / truth - 1.0).abs() < 0.25, "{recovers} for {truth}");
    assert!(held_out(&discovery, &set) < 1.1, "{:?}", discovery.ladder);
}

/// A tip that sticks the more the longer it has lain, as it leaves.
#[test]
fn what_grows_with_a_second_quantity_is_told_with_its_power() {
    let set = thinned_set(2, (1 << 40) ^ (44 << 10), &[("dwelling-tack", LawKind::Beyond)], 4.0);
    let discovery = ask(&set);
    let varies = |it: &Formula| it.term.varies.is_some_and(|by| by.symbol == "since(x)");
    let formula = formulas(&discovery).iter().find(|it| varies(it)).expect("a power of the time");
    assert!(formula.law.parameters["power"].value > 0.0, "{:?}", formula.law);
    assert!(formula.law.expression.as_ref().unwrap().ends_with(")^power"));
    assert!(held_out(&discovery, &set) < 1.15, "{:?}", discovery.ladder);
}

/// A converter that errs by less than a step between its codes.
#[test]
fn what_jumps_in_each_period_is_a_sawtooth() {
    let set = thinned_set(4, (1 << 40) ^ (20 << 10), &[("staircase", LawKind::Beyond)], 4.0);
    let discovery = ask(&set);
    let sawtooth = |it: &Formula| it.term.shape.name == "sawtooth in";
    let formula = formulas(&discovery).iter().find(|it| sawtooth(it)).expect("a sawtooth");
    let truth = hidden_parameter(&set, "step_N");
    let period = formula.law.parameters["period"].value;
    assert!((period / truth - 1.0).abs() < 0.02, "{period} for {truth}");
}

/// A slow sine through all traces and the pauses between them, which `diagnose` tells by its frequency.
#[test]
fn a_swing_through_all_traces_is_a_wave_over_the_time_in_the_data_set() {
    // Not at 50 Hz: a hum of the mains would look as slow there.
    let set = thinned_set(3, 44, &[("sway", LawKind::OutsideMore)], 1.0);
    let discovery = ask(&set);
    let formula = &formulas(&discovery)[0];
    let told = (formula.term.shape.name, formula.term.quantity.symbol);
    assert_eq!(told, ("periodic in", "t_set"));
    let truth = 1.0 / set.truth.hidden[0].parameters[0].1;
    let period = formula.law.parameters["period"].value;
    assert!((period / truth - 1.0).abs() < 0.02, "{period} for {truth}");
}

/// A dome that snaps through, and back at a smaller compression.
#[test]
fn what_snaps_over_and_back_is_found_with_both_places() {
    let set = thinned_set(2, (1 << 40) ^ (14 << 10), &[("snap-through", LawKind::Beyond)], 2.0);
    let discovery = ask(&set);
    let formula = &formulas(&discovery)[0];
    let told = (formula.term.shape.name, formula.term.quantity.symbol);
    assert_eq!(told, ("switched at one", "x"));
    let value = |name: &str| formula.law.parameters[name].value;
    for (found, name) in
        [(value("place") + value("gap"), "x_1_mm"), (value("place") - value("gap"), "x_2_mm")]
    {
        let truth = hidden_parameter(&set, name);
        // At 60 mm/s there is a sample each 0.6 mm.
        assert!((found - truth).abs() < 0.6, "{name}: {found} for {truth}");
    }
    assert!(held_out(&discovery, &set) < 1.15, "{:?}", discovery.ladder);
}

/// A film between tip and specimen that resists near the touch only: nothing off the specimen.
#[test]
fn what_acts_near_the_touch_alone_is_nothing_off_the_specimen() {
    let set = thinned_set(2, (1 << 40) ^ (20 << 10), &[("splashed-film", LawKind::Beyond)], 2.0);
    let discovery = ask(&set);
    assert!(held_out(&discovery, &set) < 1.15, "{:?}", discovery.ladder);
    let term = &formulas(&discovery)[0].term;
    let told = (term.shape.name, term.quantity.symbol, term.factor.name);
    assert_eq!(told, ("decaying in contact with", "x", " times velocity and speed"));
}

/// A specimen that is the stiffer the faster it moves, either way.
#[test]
fn what_grows_with_the_speed_either_way_levels_off() {
    let set = thinned_set(2, (1 << 40) ^ (15 << 10), &[("stiff-when-fast", LawKind::Beyond)], 2.0);
    let discovery = ask(&set);
    let term = &formulas(&discovery)[0].term;
    let levels_off = ["saturating with", "decaying with"].contains(&term.shape.name);
    assert!(levels_off && term.quantity.symbol == "abs(v)", "{}", term.name());
    assert!(held_out(&discovery, &set) < 1.15, "{:?}", discovery.ladder);
}

/// A pump that runs through all traces.
#[test]
fn a_vibration_is_a_wave_over_the_time() {
    let mut set = thinned_set(2, 45, &[], 0.0);
    let size = 2.0 * set.truth.noise_rms;
    set.add_force(|time, _| size * (TAU * 9.7 * time).sin());
    let discovery = ask(&set);
    let formula = &formulas(&discovery)[0];
    assert_eq!((formula.term.shape.name, formula.term.quantity.symbol), ("periodic in", "t_set"));
    let period = formula.law.parameters["period"].value;
    assert!((9.7 * period - 1.0).abs() < 1e-3, "{period}");
    assert!(held_out(&discovery, &set) < 1.1, "{:?}", discovery.ladder);
}

/// A specimen that swells and shrinks over the session, once in two sessions to twice in one.
#[test]
fn a_slow_wave_over_the_session_is_found() {
    let set = thinned_set(4, (1 << 40) ^ (65 << 10), &[("swelling", LawKind::Beyond)], 4.0);
    let discovery = ask(&set);
    let formula = &formulas(&discovery)[0];
    assert_eq!((formula.term.shape.name, formula.term.quantity.symbol), ("periodic in", "t_set"));
    let truth = hidden_parameter(&set, "period_s");
    let period = formula.law.parameters["period"].value;
    assert!((period / truth - 1.0).abs() < 0.1, "{period} s for {truth}");
    assert!(held_out(&discovery, &set) < 1.1, "{:?}", discovery.ladder);
}

/// Presses that begin in motion, by a drive with a wave of 0.8 mm, and that go 60 mm off the specimen.
#[test]
fn a_wave_is_found_where_the_tool_goes_far_off_the_specimen() {
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let time = times(1600, 200.0);
    let presses = [(4.0, 8.0), (5.0, 12.0), (6.0, 16.0), (6.5, 10.0), (7.0, 14.0), (8.0, 9.0)];
    let mut trace = |(deep, speed): (f64, f64)| {
        let motion = move |t: f64| (speed * (t - 1.5)).min(deep).min(deep - 30.0 * (t - 6.0));
        let mut measure = |(t, force): (&f64, f64)| {
            let drawn: f64 = StandardNormal.sample(&mut random);
            let wave = 0.05 * (TAU * motion(*t) / 0.8).sin();
            force + 0.02 * drawn + if motion(*t) > 0.0 { wave } else { 0.0 }
        };
        let force = time.iter().zip(force(&time, motion)).map(&mut measure).collect();
        let x = time.iter().map(|t| motion(*t)).collect();
        let column = |name: &str, values| Column { name: name.into(), values };
        let columns = vec![column(FORCE, force), column(DISPLACEMENT, x)];
        Trace { time: time.clone(), columns, ..Trace::default() }
    };
    let traces = presses.map(&mut trace);
    let discovery = ask_of(&traces, FORCE);
    let formula = &formulas(&discovery)[0];
    assert_eq!(formula.term.quantity.symbol, "x");
    let period = formula.law.parameters["period"].value;
    assert!((period - 0.8).abs() < 0.01, "{period}");
}

#[test]
fn no_formula_is_given_where_nothing_is_missing_or_the_library_explains_it() {
    let nothing = ask(&thinned_set(4, 3, &[], 0.0));
    assert!(matches!(nothing.outcome, Outcome::Adequate), "{:?}", nothing.outcome);
    let known = ask(&thinned_set(4, 11, &[("mullins", LawKind::Reference)], 0.5));
    assert!(matches!(known.outcome, Outcome::Library), "{:?}", known.outcome);
}

/// Prints how near the formulas come to the noise for every effect outside the library.
#[test]
#[ignore = "minutes; `cargo test -p palpate-tests --test discover -- --ignored --nocapture`"]
fn what_is_outside_the_library_gets_a_formula() {
    let laws = [(OUTSIDE, LawKind::Outside), (OUTSIDE_MORE, LawKind::OutsideMore)];
    for (effects, kind) in laws {
        for (index, (name, _)) in effects.iter().enumerate() {
            for (number, r) in [1.0, 2.0].into_iter().enumerate() {
                let set = set(700 + 10 * index as u64 + number as u64, &[(name, kind)], r);
                let began = Instant::now();
                let discovery = ask(&set);
                let found: Vec<&str> = match &discovery.outcome {
                    Outcome::Formulas(formulas) => {
                        formulas.iter().map(|it| it.term.candidate.name.as_str()).collect()
                    }
                    Outcome::Adequate => vec!["(adequate)"],
                    Outcome::Library => vec!["(library)"],
                    Outcome::Nothing => vec!["(nothing)"],
                };
                let rungs: Vec<f64> = discovery
                    .ladder
                    .iter()
                    .map(|rung| rung.heldout_rms.unwrap_or(f64::NAN) / set.truth.noise_rms)
                    .collect();
                println!(
                    "{name} R {r}: {found:?} held out / noise {rungs:.2?}, {:.0} s",
                    began.elapsed().as_secs_f64()
                );
            }
        }
    }
}
