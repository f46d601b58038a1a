//! What a diagnosis is asked for.

use palpate_fit::data::{Data, DataError};
use palpate_model::effects::Effects;
use palpate_model::{Laws, Model};
use palpate_trace::Trace;

use super::diagnose::DiagnoseError;

/// What a diagnosis is asked for, beyond a model and its data.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// The effects that are tried, beside laws of one's own in the model file.
    pub effects: Effects,
    /// The base laws that the model may name.
    pub laws: Laws,
    /// Chance of naming anything where nothing is missing, over all steps; above 0, below 1.
    pub false_alarms: f64,
    /// Most effects that are added, at least 1.
    pub max_effects: usize,
    /// Seed of the resamplings of the data that tell which effect would be named on others like them.
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        let (effects, laws) = (Effects::library(), Laws::library());
        Self { effects, laws, false_alarms: 0.01, max_effects: 3, seed: 13 }
    }
}

impl Options {
    /// The traces as a model of them sees them, with the effects and laws asked for.
    ///
    /// # Errors
    /// As [`Data::of_model`].
    pub fn data<'a>(&self, model: &Model, traces: &'a [Trace]) -> Result<Data<'a>, DataError> {
        let data = Data::of_model(model, traces)?;
        Ok(data.with_effects(&self.effects).with_laws(&self.laws))
    }

    /// # Errors
    /// [`DiagnoseError::Options`], with what it may be.
    pub(super) fn check(&self) -> Result<(), DiagnoseError> {
        let wrong = |words: &str| Err(DiagnoseError::Options(words.into()));
        if !(self.false_alarms > 0.0 && self.false_alarms < 1.0) {
            return wrong("the chance of a false alarm lies between 0 and 1");
        }
        if self.max_effects == 0 {
            return wrong("a diagnosis adds at least one effect");
        }
        Ok(())
    }
}
