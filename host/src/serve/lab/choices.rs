//! What there is to choose from, whatever the traces.

use serde_json::{Value, json};

use crate::criticism::region::Region;
use crate::effects::LIBRARY;
use crate::model::{EXPONENTS_N, Family, Kernel, MAX_TERMS, Separation, Stage, VARIABLES};

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

/// Laws with their options, regions, stages, what an expression may speak of, effects.
#[must_use]
pub fn choices() -> Value {
    let law = |family: Family| {
        json!({
            "name": family.name(),
            "meaning": meaning(family),
            "terms": family.has_terms(),
            "segments": family.has_segments(),
            "exponent": family == Family::LatencyPower,
            "relaxation": family.has_kernel(),
            "bonded": family.can_be_bonded(),
        })
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
        "effects": LIBRARY.iter().map(|effect| effect.name).collect::<Vec<_>>(),
    })
}
