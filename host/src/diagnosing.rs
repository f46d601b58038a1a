//! What a model lacks on a data set.

use palpate_diagnose::criticism::diagnose::{Diagnosis, diagnose_with};
use palpate_diagnose::criticism::explore::explored;
use palpate_diagnose::criticism::options::Options;
use palpate_fit::data::Data;
use palpate_fit::watch::Stage;
use palpate_model::effects::Effects;
use palpate_model::{Laws, Model};
#[cfg(feature = "report")]
use palpate_present::answers::DiagnosisAnswer;
#[cfg(feature = "report")]
use palpate_present::summary::{DiagnosisSummary, NextCommand};
use palpate_trace::units::printed;

use crate::work::Work;
use crate::{Cancel, DataSet, Error};

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
pub fn diagnose<'a>(model: &'a Model, set: &'a DataSet) -> Diagnosing<'a> {
    Diagnosing { model, set, options: Options::default(), work: Work::default() }
}

/// A diagnosis that is about to be made.
#[must_use = "nothing is diagnosed before `run`"]
pub struct Diagnosing<'a> {
    model: &'a Model,
    set: &'a DataSet,
    options: Options,
    work: Work<'a>,
}

impl<'a> Diagnosing<'a> {
    /// Tries these effects instead of those of the library; laws of one's own in the model file are tried beside them.
    pub fn effects(mut self, effects: Effects) -> Self {
        self.options.effects = effects;
        self
    }

    /// The base laws that the model may name, instead of those of the library.
    pub fn laws(mut self, laws: Laws) -> Self {
        self.options.laws = laws;
        self
    }

    /// Chance of naming anything where nothing is missing, above 0 and below 1; 0.01 if not given.
    pub fn false_alarms(mut self, chance: f64) -> Self {
        self.options.false_alarms = chance;
        self
    }

    /// Most effects that are added, at least 1; 3 if not given.
    pub fn max_effects(mut self, count: usize) -> Self {
        self.options.max_effects = count;
        self
    }

    /// Seed of the resamplings of the data; 13 if not given.
    pub fn seed(mut self, seed: u64) -> Self {
        self.options.seed = seed;
        self
    }

    /// Tells how far the work has come, ten times a second, from a thread of its own.
    pub fn on_progress(mut self, tell: impl FnMut(Stage) + Send + 'a) -> Self {
        self.work.tell = Some(Box::new(tell));
        self
    }

    /// Lets another thread end the work.
    pub fn cancel(mut self, cancel: &Cancel) -> Self {
        self.work.cancel = Some(cancel.clone());
        self
    }

    /// Makes it.
    ///
    /// # Errors
    /// When the model, the traces or the options cannot be used, or the work was cancelled.
    pub fn run(self) -> Result<Found, Error> {
        let (model, set, options) = (self.model, self.set, self.options);
        let traces = set.traces();
        self.work.run(|| {
            let diagnosis = diagnose_with(model, traces, &options)?;
            let data = Data::of_model(model, traces)?
                .with_effects(&options.effects)
                .with_laws(&options.laws);
            let unit = printed(&model.base.signal);
            let climbed = !diagnosis.found.steps.is_empty();
            let better = climbed.then(|| explored(model, &diagnosis, &data, unit));
            Ok(Found { set: set.clone(), model: model.clone(), options, diagnosis, better })
        })?
    }
}

/// What a model lacks on a data set.
#[derive(Clone, Debug)]
pub struct Found {
    #[cfg_attr(not(feature = "report"), allow(dead_code, reason = "what the answer rests on"))]
    set: DataSet,
    #[cfg_attr(not(feature = "report"), allow(dead_code, reason = "what the answer rests on"))]
    model: Model,
    #[cfg_attr(not(feature = "report"), allow(dead_code, reason = "what the answer rests on"))]
    options: Options,
    diagnosis: Diagnosis,
    better: Option<Model>,
}

impl Found {
    /// The answer in one word.
    #[must_use]
    pub const fn verdict(&self) -> palpate_diagnose::criticism::diagnose::Verdict {
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

    /// The diagnosis as `palpate diagnose --json` prints it.
    ///
    /// # Panics
    /// Never: model and data set have gone together before.
    #[must_use]
    #[cfg(feature = "report")]
    pub fn answer(&self) -> DiagnosisAnswer {
        let Options { effects, laws, .. } = &self.options;
        let data = Data::of_model(&self.model, self.set.traces());
        let data = data.expect("this model was diagnosed on these traces");
        let data = data.with_effects(effects).with_laws(laws);
        let next = NextCommand { model: "model.toml".into(), traces: "traces".into() };
        DiagnosisAnswer::from(&DiagnosisSummary::new(&self.diagnosis, &data, next))
    }

    /// All that was found: the ladder of errors, rivals with their evidence, what is left.
    #[must_use]
    pub const fn diagnosis(&self) -> &Diagnosis {
        &self.diagnosis
    }
}
