//! A law of one's own, and what is wrong with it.

use indexmap::IndexMap;
use serde::Deserialize;
use serde_json::{Value, json};

use palpate_model::effects::{EffectError, Setting, applied};
use palpate_model::{Expression, Stage, StoredEffect, StoredParameter, VARIABLES};

/// A law as it is written on the page.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OwnLaw {
    /// Its name.
    pub name: String,
    /// Where in the chain it acts.
    pub stage: Stage,
    /// The law.
    pub expression: String,
    /// What it means.
    #[serde(default)]
    pub meaning: Option<String>,
    /// Its parameters, the strength first.
    pub parameters: Vec<OwnParameter>,
}

/// A parameter of a law of one's own.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OwnParameter {
    /// Its name.
    pub name: String,
    /// Where a fit starts, in `unit`.
    pub value: f64,
    /// Its unit; empty for a pure number.
    #[serde(default)]
    pub unit: String,
    /// Smallest value that a fit may give it.
    #[serde(default)]
    pub lower: Option<f64>,
    /// Largest value that a fit may give it.
    #[serde(default)]
    pub upper: Option<f64>,
}

impl OwnLaw {
    /// The law as it stands in a model file.
    #[must_use]
    pub fn stored(&self) -> StoredEffect {
        let parameter = |own: &OwnParameter| {
            let stored = StoredParameter {
                value: own.value,
                standard_error: None,
                unit: own.unit.clone(),
                lower: own.lower,
                upper: own.upper,
            };
            (own.name.clone(), stored)
        };
        StoredEffect {
            name: self.name.clone(),
            law: None,
            stage: Some(self.stage),
            expression: Some(self.expression.clone()),
            meaning: self.meaning.clone().filter(|meaning| !meaning.is_empty()),
            parameters: self.parameters.iter().map(parameter).collect::<IndexMap<_, _>>(),
        }
    }

    /// What is wrong with it, in words and where it can be told with the place in the expression, in
    /// characters; none where nothing is.
    #[must_use]
    pub fn fault(&self) -> Option<Value> {
        let words = |message: String| Some(json!({"message": message}));
        if self.name.is_empty() {
            return words("give the law a name".into());
        }
        if self.parameters.iter().any(|own| VARIABLES.iter().any(|(name, _)| own.name == *name)) {
            return words("a parameter has the name of a quantity that is known here".into());
        }
        let names: Vec<&str> = self.parameters.iter().map(|own| own.name.as_str()).collect();
        if let Err(fault) = Expression::parse(&self.expression, &names) {
            return Some(json!({"message": fault.message, "at": fault.at, "length": fault.length}));
        }
        let wrong: Option<EffectError> = applied(&self.stored(), &Setting::default()).err();
        wrong.and_then(|error| words(error.to_string()))
    }

    /// The lines that put it into a model file by hand.
    #[must_use]
    pub fn toml(&self) -> String {
        #[derive(serde::Serialize)]
        struct Candidates {
            candidate: Vec<StoredEffect>,
        }
        toml::to_string(&Candidates { candidate: vec![self.stored()] }).unwrap_or_default()
    }
}
