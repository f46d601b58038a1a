//! What a model lacks on a data set.

use palpate_diagnose::criticism::diagnose::{Diagnosis, Verdict, diagnose_with};
use palpate_diagnose::criticism::explore::explored;
use palpate_diagnose::criticism::options::Options;
use palpate_model::effects::Effects;
use palpate_model::{Laws, Model};
#[cfg(feature = "report")]
use palpate_present::answers::DiagnosisAnswer;
#[cfg(feature = "report")]
use palpate_present::summary::{DiagnosisSummary, NextCommand};
use palpate_trace::units::printed;

use crate::work::{Asked, Question};
use crate::{DataSet, Error};

/// Asks which physical effects a model lacks on a data set.
///
/// ```
/// # fn main() -> Result<(), palpate::Error> {
/// # let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/traces/press.csv");
/// let set = palpate::DataSet::read(folder)?;
/// let fit = palpate::fit(palpate::Law::fung(), &set).run()?;
/// let found = palpate::diagnose(fit.model(), &set).max_effects(1).run()?;
/// println!("{}: {:?}", found.verdict().word(), found.effects());
/// # Ok(())
/// # }
/// ```
pub fn diagnose<'a>(model: &'a Model, set: &'a DataSet) -> Asked<'a, Diagnosing<'a>> {
    Asked::new(Diagnosing { model, options: Options::default() }, set)
}

/// Which physical effects a model lacks.
pub struct Diagnosing<'a> {
    model: &'a Model,
    options: Options,
}

impl Asked<'_, Diagnosing<'_>> {
    /// Tries these effects instead of those of the library; laws of one's own in the model file are tried beside them.
    pub fn effects(mut self, effects: Effects) -> Self {
        self.question.options.effects = effects;
        self
    }

    /// The base laws that the model may name, instead of those of the library.
    pub fn laws(mut self, laws: Laws) -> Self {
        self.question.options.laws = laws;
        self
    }

    /// Chance of naming anything where nothing is missing, above 0 and below 1; 0.01 if not given.
    pub fn false_alarms(mut self, chance: f64) -> Self {
        self.question.options.false_alarms = chance;
        self
    }

    /// Most effects that are added, at least 1; 3 if not given.
    pub fn max_effects(mut self, count: usize) -> Self {
        self.question.options.max_effects = count;
        self
    }

    /// Seed of the resamplings of the data; 13 if not given.
    pub fn seed(mut self, seed: u64) -> Self {
        self.question.options.seed = seed;
        self
    }
}

impl Question for Diagnosing<'_> {
    type Answer = Found;

    fn of(self, set: &DataSet) -> Result<Found, Error> {
        let Self { model, options } = self;
        let diagnosis = diagnose_with(model, set.traces(), &options)?;
        let climbed = !diagnosis.found.steps.is_empty();
        let better = if climbed {
            let data = options.data(model, set.traces())?;
            Some(explored(model, &diagnosis, &data, printed(&model.base.signal)))
        } else {
            None
        };
        Ok(Found { set: set.clone(), model: model.clone(), diagnosis, better })
    }
}

/// What a model lacks on a data set.
#[derive(Clone, Debug)]
pub struct Found {
    set: DataSet,
    model: Model,
    diagnosis: Diagnosis,
    better: Option<Model>,
}

impl Found {
    /// The answer in one word.
    #[must_use]
    pub const fn verdict(&self) -> Verdict {
        self.diagnosis.verdict
    }

    /// Names of the effects found, in the order in which they were added.
    #[must_use]
    pub fn effects(&self) -> Vec<&str> {
        self.diagnosis.found.steps.iter().map(|step| &step.effect[..]).collect()
    }

    /// The model with the effects found; none where none was.
    #[must_use]
    pub const fn better(&self) -> Option<&Model> {
        self.better.as_ref()
    }

    /// The model that was diagnosed.
    #[must_use]
    pub const fn model(&self) -> &Model {
        &self.model
    }

    /// The data set on which it was diagnosed.
    #[must_use]
    pub const fn data_set(&self) -> &DataSet {
        &self.set
    }

    /// The diagnosis as `palpate diagnose --json` prints it.
    ///
    /// # Panics
    /// Never: model and data set have gone together before.
    #[must_use]
    #[cfg(feature = "report")]
    pub fn answer(&self) -> DiagnosisAnswer {
        let data = self.diagnosis.options.data(&self.model, self.set.traces());
        let data = data.expect("this model was diagnosed on these traces");
        let next = NextCommand { model: "model.toml".into(), traces: "traces".into() };
        DiagnosisAnswer::from(&DiagnosisSummary::new(&self.diagnosis, &data, next))
    }

    /// All that was found: the ladder of errors, rivals with their evidence, what is left.
    #[must_use]
    pub const fn diagnosis(&self) -> &Diagnosis {
        &self.diagnosis
    }
}
