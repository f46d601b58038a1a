//! What a program is promised that brings laws of its own.

use palpate::criticism::diagnose::Verdict;
use palpate::model::{BaseLaw, Elastic, Separation};
use palpate::{DataSet, Kernel, Law};
use palpate_consumer::laws::{BALL, EXPONENTIAL, laws};
use palpate_consumer::{NOISE, effects, recorded};

const TISSUE: Elastic = Elastic { law: &EXPONENTIAL, gauge: None };

/// Presses of a soft tissue, on a drive whose teeth push with so many N.
fn tissue(teeth: f64) -> DataSet {
    let law = BaseLaw::fung(2, Separation::Clamp).with(TISSUE, Kernel::EXPONENTIALS);
    recorded(law, &[0.15, 0.35, 0.26, 0.24, 4.2, 0.55, teeth, 0.9])
}

#[test]
fn an_elastic_law_that_a_program_brings_is_ranked_first_where_it_is_the_law() {
    let set = tissue(0.0);
    let ranking = palpate::rank(&set).laws(laws()).run().unwrap();
    let best = &ranking.places[0];
    assert_eq!(best.fit.chain.base.short_name(), "fung, exponential");
    assert!((best.held_out.unwrap() / NOISE - 1.0).abs() < 0.05, "{:?}", best.held_out);
    let without = palpate::rank(&set).run().unwrap();
    assert!(without.places[0].held_out.unwrap() > 2.0 * NOISE);
}

#[test]
fn a_law_and_an_effect_of_a_program_are_both_named() {
    let set = tissue(0.05);
    let fit = palpate::fit(Law::fung().elastic(TISSUE), &set).run().unwrap();
    assert_eq!(fit.model().base.elastic.as_deref(), Some("exponential"));
    let ask = || palpate::diagnose(fit.model(), &set).effects(effects());
    let found = ask().laws(laws()).run().unwrap();
    assert_eq!((found.verdict(), &found.effects()[..]), (Verdict::Named, &["teeth"][..]));
    let parameters = &found.better().unwrap().base.parameters;
    assert!((parameters["alpha"].value - 0.35).abs() < 0.01, "{parameters:?}");
    let unknown = ask().run().unwrap_err().to_string();
    assert!(unknown.contains("unknown elastic response `exponential`"), "{unknown}");
}

#[test]
fn a_family_that_a_program_brings_is_fitted_and_ranked_first_where_it_is_the_law() {
    let values = [0.12, 0.4, 0.8, 0.0, 0.9];
    let set = recorded(BaseLaw::new(&BALL, 1, Separation::Clamp), &values);
    let fit = palpate::fit(Law::of(&BALL), &set).run().unwrap();
    for (found, true_value) in fit.fitted().values.iter().zip(values) {
        assert!((found / true_value - 1.0).abs() < 0.02, "{:?}", fit.fitted().values);
    }
    let ranking = palpate::rank(&set).laws(laws()).terms(1).run().unwrap();
    // Fung's law has it within it, with a parameter more.
    let names: Vec<&str> = ranking.places.iter().map(|place| place.fit.chain.base.name()).collect();
    assert!(names[..2].contains(&"ball"), "{names:?}");
}
