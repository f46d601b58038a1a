//! `palpate effects`: the library of effects, and whether a law of one's own keeps its promises.

use palpate_diagnose::promises::{Kept, Promise};
use palpate_model::effects::{Effect, LIBRARY, Law, Role, Shape, Sign, Strength};
use palpate_model::{Stage, StoredEffect};
use serde::Serialize;

use crate::summary::{how_many, needs};

/// Every effect of the library.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct LibraryAnswer {
    /// Version of this answer.
    pub palpate_effects: u32,
    /// The effects, in the order of the chain.
    pub effects: Vec<EffectAnswer>,
}

/// One effect of the library.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct EffectAnswer {
    /// Its name, in answers, model files and on the command line.
    pub name: &'static str,
    /// Where in the chain it acts.
    pub stage: StageAnswer,
    /// What happens physically.
    pub meaning: &'static str,
    /// What it leaves in the residual of a model that lacks it.
    pub signature: &'static str,
    /// Names of the effects that it can be mistaken for.
    pub confused_with: &'static [&'static str],
    /// The experiment that separates it from those.
    pub experiment: &'static str,
    /// Symbol of the quantity against which the residual is best looked at.
    pub against: &'static str,
    /// What a data set must have for it to be seen.
    pub needs: &'static str,
    /// Its laws, the reference form first.
    pub laws: Vec<LawAnswer>,
}

/// A stage of the chain from the commanded motion to the recorded number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum StageAnswer {
    /// What reaches the specimen is not what was commanded.
    Motion,
    /// The elastic response of the specimen.
    Elasticity,
    /// The time-dependence of the specimen.
    Relaxation,
    /// What happens where the indenter touches.
    Contact,
    /// The sensor and its electronics.
    Sensor,
}

/// One law of an effect.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct LawAnswer {
    /// Name of this form.
    pub name: &'static str,
    /// The law as a formula.
    pub formula: &'static str,
    /// The parameter at whose zero it vanishes.
    pub strength: StrengthAnswer,
    /// Its other parameters.
    pub shapes: Vec<ShapeAnswer>,
}

/// The parameter by which a law vanishes.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct StrengthAnswer {
    /// Its name.
    pub name: &'static str,
    /// Its unit, empty for a pure number.
    pub unit: &'static str,
    /// What it means.
    pub meaning: &'static str,
    /// The sign that physics allows.
    pub sign: SignAnswer,
    /// How many there are, such as `one` or `one for each trace`.
    pub how_many: String,
}

/// The sign of a strength.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum SignAnswer {
    /// Above zero only.
    Positive,
    /// Above or below zero.
    Either,
}

/// A parameter that gives a law its shape.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct ShapeAnswer {
    /// Its name.
    pub name: &'static str,
    /// Its unit, empty for a pure number.
    pub unit: &'static str,
    /// What it means.
    pub meaning: &'static str,
    /// Whether it is fitted, and not taken from the data.
    pub fitted: bool,
}

/// Whether a law of one's own keeps what every law of the library promises.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct ContractAnswer {
    /// Name of the law.
    pub name: String,
    /// Its expression; null where it has none.
    pub expression: Option<String>,
    /// The promises.
    pub promises: Vec<PromiseAnswer>,
}

/// One promise of a law.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct PromiseAnswer {
    /// What is promised.
    pub promise: &'static str,
    /// Whether it is kept.
    pub kept: KeptAnswer,
    /// Why it is not, or was not asked; empty where it is kept.
    pub because: String,
}

/// Whether a promise is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum KeptAnswer {
    /// It is kept.
    Yes,
    /// It is not kept.
    No,
    /// It was not asked.
    #[serde(rename = "not asked")]
    NotAsked,
}

impl LibraryAnswer {
    /// The library that comes with the program.
    #[must_use]
    pub fn whole() -> Self {
        let effects = LIBRARY.iter().copied().map(EffectAnswer::from).collect();
        Self { palpate_effects: 1, effects }
    }
}

impl From<&Effect> for EffectAnswer {
    fn from(effect: &Effect) -> Self {
        Self {
            name: effect.name,
            stage: effect.stage.into(),
            meaning: effect.meaning,
            signature: effect.signature,
            confused_with: effect.confused_with,
            experiment: effect.experiment,
            against: effect.against.symbol(),
            needs: needs(effect.needs),
            laws: effect.laws.iter().map(LawAnswer::from).collect(),
        }
    }
}

impl From<Stage> for StageAnswer {
    fn from(stage: Stage) -> Self {
        match stage {
            Stage::Motion => Self::Motion,
            Stage::Elasticity => Self::Elasticity,
            Stage::Relaxation => Self::Relaxation,
            Stage::Contact => Self::Contact,
            Stage::Sensor => Self::Sensor,
        }
    }
}

impl From<&Law> for LawAnswer {
    fn from(law: &Law) -> Self {
        let Strength { name, unit, meaning, sign, .. } = law.strength;
        let sign = match sign {
            Sign::Positive | Sign::Part => SignAnswer::Positive,
            Sign::Either => SignAnswer::Either,
        };
        Self {
            name: law.name,
            formula: law.formula,
            strength: StrengthAnswer { name, unit, meaning, sign, how_many: how_many(law) },
            shapes: law.shapes.iter().map(ShapeAnswer::from).collect(),
        }
    }
}

impl From<&Shape> for ShapeAnswer {
    fn from(shape: &Shape) -> Self {
        Self {
            name: shape.name,
            unit: shape.unit,
            meaning: shape.meaning,
            fitted: !matches!(shape.role, Role::Given),
        }
    }
}

impl ContractAnswer {
    /// The promises of a law.
    #[must_use]
    pub fn of(law: &StoredEffect, promises: &[Promise]) -> Self {
        Self {
            name: law.name.clone(),
            expression: law.expression.clone(),
            promises: promises.iter().map(PromiseAnswer::from).collect(),
        }
    }
}

impl From<&Promise> for PromiseAnswer {
    fn from(promise: &Promise) -> Self {
        let (kept, because) = match &promise.found {
            Kept::Yes => (KeptAnswer::Yes, String::new()),
            Kept::No(why) => (KeptAnswer::No, why.clone()),
            Kept::NotAsked(why) => (KeptAnswer::NotAsked, why.clone()),
        };
        Self { promise: promise.what, kept, because }
    }
}
