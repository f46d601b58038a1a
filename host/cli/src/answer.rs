//! What a command found, for whoever asked: a terminal, a report, or a program that links the library.

use std::path::Path;

use serde_json::Value;

use super::Failure;
use palpate_model::Model;
use palpate_report::Section;
use palpate_trace::Trace;

/// What a command found. Nothing of it is put into words before it is asked for.
pub trait Answer: Send + Sync {
    /// What it is of, as the title of a report.
    fn title(&self) -> &'static str;

    /// What stands below the title, such as the signal that was fitted; empty for nothing.
    fn subtitle(&self) -> String {
        String::new()
    }

    /// Names of the traces or files that it rests on.
    fn inputs(&self) -> Vec<String>;

    /// The JSON object of `--json`.
    fn json(&self) -> Value;

    /// All that a report shows.
    ///
    /// # Errors
    /// When something more is to be found out for it, and cannot be.
    fn sections(&self) -> Result<Vec<Section>, Failure>;

    /// What a terminal shows.
    ///
    /// # Errors
    /// As [`Answer::sections`].
    fn in_short(&self) -> Result<Vec<Section>, Failure> {
        self.sections()
    }

    /// What is to be said aside of the answer, one line each.
    fn remarks(&self) -> Vec<String> {
        Vec::new()
    }

    /// The model that came of it.
    ///
    /// # Errors
    /// When what was found makes no model.
    fn model(&self) -> Result<Option<Model>, Failure> {
        Ok(None)
    }

    /// The traces that came of it.
    fn traces(&self) -> Vec<Trace> {
        Vec::new()
    }

    /// Why the work failed although there is something to show of it.
    fn failed(&self) -> Option<String> {
        None
    }
}

/// Writes the model that came of it where one is asked for, and says where it is.
pub(super) fn write_model(found: &dyn Answer, output: Option<&Path>) -> Result<(), Failure> {
    if let Some(path) = output
        && let Some(model) = found.model()?
    {
        model.write(path).map_err(Failure::work)?;
        eprintln!("model: {}", path.display());
    }
    Ok(())
}

/// How traces are named in an answer.
pub(super) fn labels(traces: &[Trace]) -> Vec<String> {
    traces.iter().map(Trace::label).collect()
}
