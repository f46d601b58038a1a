//! Effects of several noises that the base law has taken on while it was alone: they are found none the less, and nothing beside them.

use palpate_tests::answer;
use palpate_tests::held_press::warnings_and_diagnosis;

/// The effect that is hidden in a practice set of this size, in noises, and seed, and those that are named.
fn named(effect: &str, size: &str, seed: &str) -> (String, Vec<String>) {
    let folder = tempfile::tempdir().expect("a folder");
    let hide = ["hide", effect, "--size", size, "--seed", seed, "-o", "set", "--json"];
    answer(folder.path(), &hide);
    let (_, found) = warnings_and_diagnosis(&folder.path().join("set"));
    let steps = found["steps"].as_array().expect("steps");
    let names = steps.iter().map(|step| step["effect"].as_str().unwrap_or_default().to_owned());
    (found["verdict"].as_str().unwrap_or_default().to_owned(), names.collect())
}

#[test]
fn a_lag_of_which_the_base_law_took_on_most_is_named_alone() {
    assert_eq!(named("sensor-lag", "10", "31"), ("named".into(), vec!["sensor-lag".into()]));
}

#[test]
fn a_mass_whose_other_law_ends_on_a_bound_is_named() {
    assert_eq!(named("inertia", "10", "31"), ("named".into(), vec!["inertia".into()]));
}

#[test]
fn a_slow_relaxation_whose_rate_the_base_law_took_is_named_alone() {
    let found = named("slow-relaxation", "4", "32");
    assert_eq!(found, ("named".into(), vec!["slow-relaxation".into()]));
}
