//! What a program that links palpate is promised.

use std::sync::atomic::{AtomicUsize, Ordering};

use palpate::criticism::diagnose::Verdict;
use palpate::{Cancel, Error, Law};
use palpate_consumer::{NOISE, effects, specimen};

#[test]
fn an_effect_that_a_program_brings_is_named_and_its_model_is_known_to_whoever_brings_it() {
    let set = specimen();
    let fit = palpate::fit(Law::fung(), &set).run().unwrap();
    let found = palpate::diagnose(fit.model(), &set).effects(effects()).run().unwrap();
    assert_eq!((found.verdict(), &found.effects()[..]), (Verdict::Named, &["teeth"][..]));
    let better = found.better().unwrap();
    let pitch = better.effects[0].parameters["pitch"].value;
    assert!((pitch - 0.9).abs() < 0.02, "{pitch}");
    let rms = better.fit.as_ref().unwrap().residual_rms;
    assert!((rms / NOISE - 1.0).abs() < 0.05, "{rms}");
    let again = palpate::diagnose(better, &set).effects(effects()).run().unwrap();
    assert_eq!(again.verdict(), Verdict::Adequate);
    let unknown = palpate::diagnose(better, &set).run().unwrap_err();
    assert!(unknown.to_string().contains("no effect is called `teeth`"), "{unknown}");
}

#[test]
fn without_it_the_library_does_not_take_it_for_something_else() {
    let set = specimen();
    let fit = palpate::fit(Law::fung(), &set).run().unwrap();
    let found = palpate::diagnose(fit.model(), &set).run().unwrap();
    assert_eq!(found.verdict(), Verdict::Unknown, "{:?}", found.effects());
}

#[test]
fn two_effects_of_one_name_and_options_that_cannot_be_are_refused() {
    let set = specimen();
    let fit = palpate::fit(Law::fung(), &set).run().unwrap();
    let ask = || palpate::diagnose(fit.model(), &set);
    let refused = |asked: Result<palpate::Found, Error>| asked.unwrap_err().to_string();
    let twice = effects().with(&palpate_consumer::TEETH);
    assert!(refused(ask().effects(twice).run()).contains("`teeth`"));
    assert!(refused(ask().false_alarms(0.0).run()).contains("between 0 and 1"));
    assert!(refused(ask().max_effects(0).run()).contains("at least one"));
    let law = palpate::fit(Law::fung().terms(9), &set).run().unwrap_err();
    assert!(law.to_string().contains("1 to 4"), "{law}");
}

#[test]
fn work_tells_how_far_it_has_come_and_ends_when_it_is_asked_to() {
    let set = specimen();
    let told = AtomicUsize::new(0);
    let fit = palpate::fit(Law::fung(), &set).on_progress(|_| {
        told.fetch_add(1, Ordering::Relaxed);
    });
    let fit = fit.run().unwrap();
    let cancel = Cancel::default();
    let ended = palpate::diagnose(fit.model(), &set).cancel(&cancel);
    cancel.cancel();
    assert!(matches!(ended.run(), Err(Error::Cancelled)));
    let watched = palpate::diagnose(fit.model(), &set).on_progress(|stage| {
        assert!(stage.done <= stage.of && !stage.what.is_empty());
        told.fetch_add(1, Ordering::Relaxed);
    });
    watched.run().unwrap();
    assert!(told.load(Ordering::Relaxed) > 0);
}
