//! `palpate add`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value;

use super::answer::{Answer, labels};
use super::output::Output;
use super::preparation::Prepare;
use super::published::Published;
use super::{Failure, progress};
use palpate_diagnose::criticism::change::{self, Change, ChangeError};
use palpate_diagnose::criticism::compare::compared;
use palpate_fit::data::Data;
use palpate_model::Model;
use palpate_present::answers::{self, ChangeAnswer};
use palpate_present::summary::{change_report, change_sections};
use palpate_report::Section;
use palpate_trace::files::plan::MODEL;
use palpate_trace::{Trace, read_set};

/// Add an effect to a model, refit, and see the error fall.
#[derive(clap::Args)]
#[command(after_help = "\
NAME is an effect of the library (`palpate effects` lists them), or a law of your own that stands as
`[[candidate]]` in the model file. Everything is refitted, and the ladder in the model file gains a
rung: the error on the traces fitted and on each trace left out in turn. Where an effect has several
laws, the one with the least BIC is taken. Where the error rises, nothing is written, and the exit
status is 1.

Examples:
  palpate add mullins model.toml traces/ -o better.toml
  palpate add coulomb-friction model.toml traces/ --law presliding
  palpate add cogging model.toml traces/ -o better.toml --report ladder.html")]
pub struct Args {
    /// The effect
    name: String,
    /// The model
    model: PathBuf,
    /// Traces, or folders of traces: one data set
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    #[command(flatten)]
    options: Options,
    #[command(flatten)]
    published: Published,
    /// Write the model with the effect
    #[arg(short, long, value_name = "BETTER.toml")]
    output: Option<PathBuf>,
    #[command(flatten)]
    result: Output,
}

/// Which law is taken, and how the traces are.
#[derive(clap::Args)]
pub struct Options {
    /// Take this law of the effect
    #[arg(long, value_name = "LAW")]
    law: Option<String>,
    #[command(flatten)]
    prepare: Prepare,
}

/// Adds, refits and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut files =
        args.result.files(args.traces.iter().chain([&args.model]).chain(&args.published.files))?;
    if let Some(path) = &args.output {
        files.writes(path, &MODEL)?;
    }
    let model = args.published.beside(Model::read(&args.model).map_err(Failure::input)?)?;
    let traces = Arc::new(read_set(&args.traces).map_err(Failure::input)?);
    give(&*ask(&args.options, &args.name, &model, traces)?, args.output.as_deref(), &args.result)
}

/// Adds an effect to a model and refits it to traces in memory.
pub fn ask(
    options: &Options,
    effect: &str,
    model: &Model,
    traces: Arc<Vec<Trace>>,
) -> Result<Box<dyn Answer>, Failure> {
    let (traces, _) = options.prepare.take(traces, &model.base.signal)?;
    let wait = progress::spinner("refitting");
    let change = change::add(model, effect, options.law.as_deref(), &traces);
    wait.finish_and_clear();
    let change = change.map_err(|error| match error {
        ChangeError::Worse { .. } => Failure::work(error),
        _ => Failure::input(error),
    })?;
    Ok(Box::new(Changed { traces, change }))
}

/// A changed model.
pub(super) struct Changed {
    pub traces: Arc<Vec<Trace>>,
    pub change: Change,
}

impl Answer for Changed {
    fn title(&self) -> &'static str {
        "A changed model"
    }

    fn subtitle(&self) -> String {
        self.change.model.base.signal.clone()
    }

    fn inputs(&self) -> Vec<String> {
        labels(&self.traces)
    }

    fn json(&self) -> Value {
        answers::json(&ChangeAnswer::from(&self.change))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        let model = &self.change.model;
        let data = Data::of_model(model, &self.traces).map_err(Failure::input)?;
        let left = compared(model, &self.traces, &data).map_err(Failure::input)?;
        Ok(change_report(&self.change, &left))
    }

    fn in_short(&self) -> Result<Vec<Section>, Failure> {
        Ok(change_sections(&self.change))
    }

    fn model(&self) -> Result<Option<Model>, Failure> {
        Ok(Some(self.change.model.clone()))
    }

    fn failed(&self) -> Option<String> {
        let stop = &self.change.fit.stop;
        (!stop.converged()).then(|| stop.to_string())
    }
}

/// Writes the changed model, the report and the result.
pub(super) fn give(
    found: &dyn Answer,
    output: Option<&Path>,
    result: &Output,
) -> Result<(), Failure> {
    if let Some(path) = output
        && let Some(model) = found.model()?
    {
        model.write(path).map_err(Failure::work)?;
    }
    result.show(found)
}
