//! What can be tried on a data set: the effects of the library that it can show, and laws of one's own.

use super::{Effect, EffectError, Setting, Sign, applied};
use crate::{Applied, StoredEffect};

/// An effect that can be tried, with its laws as they would stand in a chain.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Name of the effect.
    pub name: String,
    /// Its laws.
    pub forms: Vec<Form>,
    /// What the data set lacks for it to be seen; none where it has all.
    pub missing: Option<&'static str>,
}

/// One law of a candidate.
#[derive(Clone, Debug)]
pub struct Form {
    /// The law in a chain.
    pub applied: Applied,
    /// Size of each strength at which the effect is small but clear.
    pub typical: f64,
    /// Whether the strength may only be positive.
    pub positive: bool,
    /// Starting values of its shapes.
    pub grid: Vec<Vec<f64>>,
}

/// Every candidate for a data set, in the order of its effects, own laws last.
///
/// # Errors
/// When a law of one's own is not what it can be, or two effects have one name.
pub fn candidates(setting: &Setting, own: &[StoredEffect]) -> Result<Vec<Candidate>, EffectError> {
    if let Some(name) = setting.effects.twice() {
        return Err(EffectError::Taken(name.into()));
    }
    let declared = setting.effects.iter().map(|effect: &Effect| {
        let form = |law: &super::Law| Form {
            applied: law.applied(effect, setting),
            typical: (law.strength.typical)(&setting.scales),
            positive: law.strength.sign != Sign::Either,
            grid: law.grid(&setting.scales),
        };
        Ok(Candidate {
            name: effect.name.into(),
            forms: effect.laws_on(&setting.scales).map(form).collect(),
            missing: effect.needs.missing(setting),
        })
    });
    declared.chain(own.iter().map(|stored| own_candidate(stored, setting))).collect()
}

/// A law of one's own: its strength is tried at a hundredth of its range, or at one where it has none.
fn own_candidate(stored: &StoredEffect, setting: &Setting) -> Result<Candidate, EffectError> {
    let (effect, values) = applied(stored, setting)?;
    let strength = &effect.parameters[0];
    let range = strength.upper - strength.lower;
    let size = if range.is_finite() { 0.01 * range } else { 1.0 };
    let typical = if strength.upper > 0.0 { size } else { -size };
    let form = Form {
        typical: if values[0] == 0.0 { typical } else { values[0] },
        positive: strength.lower >= 0.0,
        grid: vec![values[1..].to_vec()],
        applied: effect,
    };
    Ok(Candidate { name: stored.name.clone(), forms: vec![form], missing: None })
}
