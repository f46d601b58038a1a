//! What there is to choose from, whatever the traces.

use serde_json::{Value, json};

use palpate_diagnose::criticism::region::Region;
use palpate_model::effects::{Effect, LIBRARY};
use palpate_model::{EXPONENTS_N, Family, Kernel, MAX_TERMS, Separation, Stage, VARIABLES};

/// What a law is, for one who meets it for the first time.
const fn meaning(family: Family) -> &'static str {
    match family {
        Family::KelvinVoigt => "a spring and a damper side by side",
        Family::Maxwell => "a spring and a damper in a row",
        Family::GeneralizedMaxwell => "a spring beside springs with dampers",
        Family::Fung => {
            "an elastic response that stiffens, and relaxes as a sum of exponentials; a good first choice for soft materials"
        }
        Family::Latency => "the strain at the contact lags behind and settles at one rate",
        Family::LatencyPower => "the strain at the contact lags behind and settles by a power law",
        Family::Creep => "the compression settles late under a given force, solved for the force",
    }
}

/// What a law says.
const fn formula(family: Family) -> &'static str {
    match family {
        Family::KelvinVoigt => "F = k x + η x′",
        Family::Maxwell => "F′/k + F/η = x′",
        Family::GeneralizedMaxwell => "F = k0 x + Σ ki ∫ e^(−(ki/ηi)(t − s)) dx(s)",
        Family::Fung => "F = ∫ g(t − s) dN(x(s))",
        Family::Latency => "F = N(x) ε/x, ε′ = x′ − v1 (ε − c0 x)",
        Family::LatencyPower => "F = N(x) ε/x, ε′ = x′ − ν sgn(y) |y|^n, y = ε − c0 x",
        Family::Creep => "F = N(D), x = ∫ h(t − s) dD(s), h(t) = 1 + Σ ci e^(−vi t)",
    }
}

/// Laws with their options, regions, stages, what an expression may speak of, effects.
#[must_use]
pub fn choices() -> Value {
    let law = |family: Family| {
        json!({
            "name": family.name(),
            "meaning": meaning(family),
            "formula": formula(family),
            "terms": family.has_terms(),
            "segments": family.has_segments(),
            "exponent": family == Family::LatencyPower,
            "relaxation": family.has_kernel(),
            "bonded": family.can_be_bonded(),
        })
    };
    let formulas = |effect: &&Effect| {
        let laws = effect.laws.iter().map(|law| (law.name.to_owned(), law.formula.into()));
        (effect.name.to_owned(), Value::Object(laws.collect()))
    };
    let separations = [Separation::Clamp, Separation::Free, Separation::Bonded];
    json!({
        "laws": Family::ALL.map(law),
        "most_terms": MAX_TERMS,
        "relaxations": Kernel::ALL.map(Kernel::name),
        "exponents": [EXPONENTS_N.0, EXPONENTS_N.1],
        "separations": separations.map(Separation::name),
        "regions": Region::ALL.map(Region::name),
        "stages": Stage::ALL.map(Stage::name),
        "variables": VARIABLES.map(|(name, meaning)| json!({"name": name, "meaning": meaning})),
        "formulas": LIBRARY.iter().map(formulas).collect::<serde_json::Map<_, _>>(),
        "effects": LIBRARY.iter().map(|effect| effect.name).collect::<Vec<_>>(),
    })
}
