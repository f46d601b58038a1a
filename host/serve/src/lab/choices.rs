//! What there is to choose from, whatever the traces.

use serde_json::{Value, json};

use palpate_diagnose::criticism::region::Region;
use palpate_model::effects::{Effect, LIBRARY};
use palpate_model::kernel::KERNELS;
use palpate_model::laws::FAMILIES;
use palpate_model::{EXPONENTS_N, Family, LawOption, MAX_TERMS, Separation, Stage, VARIABLES};

/// Laws with their options, regions, stages, what an expression may speak of, effects.
#[must_use]
pub fn choices() -> Value {
    let law = |family: &&Family| {
        json!({
            "name": family.name,
            "meaning": family.meaning,
            "formula": family.formula,
            "drawing": family.drawing,
            "terms": family.takes(LawOption::Terms),
            "segments": family.takes(LawOption::Segments),
            "exponent": family.takes(LawOption::Exponent),
            "relaxation": family.takes(LawOption::Relaxation),
            "bonded": family.takes(LawOption::Bonded),
        })
    };
    let formulas = |effect: &&Effect| {
        let laws = effect.laws.iter().map(|law| (law.name.to_owned(), law.formula.into()));
        (effect.name.to_owned(), Value::Object(laws.collect()))
    };
    let separations = [Separation::Clamp, Separation::Free, Separation::Bonded];
    json!({
        "laws": FAMILIES.iter().map(law).collect::<Vec<_>>(),
        "most_terms": MAX_TERMS,
        "relaxations": KERNELS.iter().map(|kernel| kernel.name).collect::<Vec<_>>(),
        "exponents": [EXPONENTS_N.0, EXPONENTS_N.1],
        "separations": separations.map(Separation::name),
        "regions": Region::ALL.map(Region::name),
        "stages": Stage::ALL.map(Stage::name),
        "variables": VARIABLES.map(|(name, meaning)| json!({"name": name, "meaning": meaning})),
        "formulas": LIBRARY.iter().map(formulas).collect::<serde_json::Map<_, _>>(),
        "effects": LIBRARY.iter().map(|effect| effect.name).collect::<Vec<_>>(),
    })
}
