//! `palpate compare`.

use std::path::PathBuf;
use std::sync::Arc;

use serde_json::Value;

use super::answer::{Answer, labels};
use super::output::Output;
use super::preparation::Prepare;
use super::{Failure, progress};
use palpate_diagnose::criticism::compare::{Comparison, compare};
use palpate_diagnose::criticism::residuals::Residuals;
use palpate_fit::data::Data;
use palpate_model::Model;
use palpate_present::answers::{self, ComparisonAnswer};
use palpate_present::summary::{Preparation, compare_report, compare_sections};
use palpate_report::Section;
use palpate_trace::{Trace, read_set};

/// Compare a model with measurements, and see where it fails.
#[derive(clap::Args)]
#[command(after_help = "\
Counts the error in every region of every trace (approach, loading, early and late hold, unloading,
after) against the noise, and says what it depends on. The report draws it all.

Examples:
  palpate compare model.toml traces/
  palpate compare model.toml traces/ --report compare.html
  palpate compare model.toml traces/ --json | jq .in_words")]
pub struct Args {
    /// The model
    model: PathBuf,
    /// Traces, or folders of traces: one data set
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    #[command(flatten)]
    prepare: Prepare,
    #[command(flatten)]
    result: Output,
}

/// Compares and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.result.files(args.traces.iter().chain([&args.model]))?;
    let model = Model::read(&args.model).map_err(Failure::input)?;
    let traces = Arc::new(read_set(&args.traces).map_err(Failure::input)?);
    args.result.show(&*ask(&args.prepare, model, traces)?)
}

/// Compares a model with traces in memory.
pub fn ask(
    prepare: &Prepare,
    model: Model,
    traces: Arc<Vec<Trace>>,
) -> Result<Box<dyn Answer>, Failure> {
    let (traces, preparation) = prepare.take(traces, &model.base.signal)?;
    let wait = progress::spinner("comparing");
    let comparison = compare(&model, &traces).map_err(Failure::input)?;
    wait.finish_and_clear();
    Ok(Box::new(Compared { traces, preparation, model, comparison }))
}

/// A model against measurements.
struct Compared {
    traces: Arc<Vec<Trace>>,
    preparation: Preparation,
    model: Model,
    comparison: Comparison,
}

impl Answer for Compared {
    fn title(&self) -> &'static str {
        "Model against measurement"
    }

    fn subtitle(&self) -> String {
        self.comparison.signal.clone()
    }

    fn inputs(&self) -> Vec<String> {
        labels(&self.traces)
    }

    fn json(&self) -> Value {
        answers::json(&self.preparation.with(ComparisonAnswer::from(&self.comparison)))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        let Self { model, comparison, traces, .. } = self;
        let data = Data::of_model(model, traces).map_err(Failure::input)?;
        let left = Residuals::of(model, &data).map_err(Failure::input)?;
        Ok(self.preparation.before(compare_report(model, comparison, &left, traces)))
    }

    fn in_short(&self) -> Result<Vec<Section>, Failure> {
        let sections = compare_sections(&self.model, &self.comparison, &self.traces);
        Ok(self.preparation.before(sections))
    }
}
