//! `palpate explore`.

use std::path::PathBuf;
use std::sync::Arc;

use serde_json::Value;

use super::Failure;
use super::answer::{Answer, write_model};
use super::diagnose::{Diagnosed, Figure, diagnosed, inputs};
use super::output::Output;
use super::preparation::Prepare;
use super::published::Published;
use palpate_diagnose::criticism::change::{Worse, worse};
use palpate_diagnose::criticism::diagnose::Diagnosis;
use palpate_diagnose::criticism::explore::{explored, rungs};
use palpate_model::Model;
use palpate_present::answers::{self, ExplorationAnswer};
use palpate_present::summary::{NextCommand, unit_of};
use palpate_report::Section;
use palpate_trace::Trace;
use palpate_trace::files::plan::MODEL;

/// Add what is missing until only noise is left, or say that it does not know.
#[derive(clap::Args)]
#[command(after_help = "\
Diagnoses, adds the effect named, and goes on, until nothing more is missed. The ladder of errors
is printed rung by rung; the model at its top is written with -o.

Examples:
  palpate explore --model model.toml traces/
  palpate explore --model model.toml traces/ -o better.toml --report explore.html
  palpate explore --model model.toml traces/ --json | jq .steps[].effect")]
pub struct Args {
    /// The model to begin with
    #[arg(long, value_name = "MODEL.toml")]
    model: PathBuf,
    /// Traces, or folders of traces: one data set
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    /// Write the model with all effects found
    #[arg(short, long, value_name = "BETTER.toml")]
    output: Option<PathBuf>,
    #[command(flatten)]
    published: Published,
    #[command(flatten)]
    figure: Figure,
    #[command(flatten)]
    prepare: Prepare,
    #[command(flatten)]
    result: Output,
}

/// Explores and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut files =
        args.result.files(args.traces.iter().chain([&args.model]).chain(&args.published.files))?;
    if let Some(path) = &args.output {
        files.writes(path, &MODEL)?;
    }
    args.figure.plan(&mut files)?;
    let (model, traces, next) = inputs(&args.model, &args.traces, &args.published, &args.prepare)?;
    let found = explored_by(&args.prepare, model, traces, next, args.output.clone())?;
    write_model(&found, args.output.as_deref())?;
    args.result.show(&found)?;
    args.figure.write(&found.found)
}

/// Adds what is missing of a model beside traces in memory; the next commands name both as `next` says.
pub fn ask(
    prepare: &Prepare,
    model: Model,
    traces: Arc<Vec<Trace>>,
    next: NextCommand,
) -> Result<Box<dyn Answer>, Failure> {
    Ok(Box::new(explored_by(prepare, model, traces, next, None)?))
}

fn explored_by(
    prepare: &Prepare,
    model: Model,
    traces: Arc<Vec<Trace>>,
    next: NextCommand,
    written: Option<PathBuf>,
) -> Result<Explored, Failure> {
    let found = diagnosed(prepare, model, traces, next, "climbing the ladder")?;
    match lower(&found.diagnosis) {
        Some(worse) => Err(Failure::Work(miette::miette!("{worse}; the model stays as it was"))),
        None => Ok(Explored { found, written }),
    }
}

/// The way up the ladder.
struct Explored {
    found: Diagnosed,
    /// The file of the model at its top.
    written: Option<PathBuf>,
}

impl Answer for Explored {
    fn title(&self) -> &'static str {
        "From the first model to the last"
    }

    fn subtitle(&self) -> String {
        self.found.subtitle()
    }

    fn inputs(&self) -> Vec<String> {
        self.found.inputs()
    }

    fn json(&self) -> Value {
        let model = self.written.as_ref().map(|path| path.display().to_string());
        let answer = ExplorationAnswer { diagnosis: self.found.answer(), model };
        answers::json(&self.found.preparation.with(answer))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        self.found.sections()
    }

    fn in_short(&self) -> Result<Vec<Section>, Failure> {
        let written = self.written.as_deref();
        self.found.with(|summary, _| self.found.before(summary.exploration(written)))
    }

    fn model(&self) -> Result<Option<Model>, Failure> {
        let Diagnosed { model, diagnosis, .. } = &self.found;
        let unit = unit_of(&diagnosis.signal);
        self.found.with(|_, data| Some(explored(model, diagnosis, data, unit)))
    }
}

/// Whether the model at the top of the ladder is worse than the one that was given.
fn lower(diagnosis: &Diagnosis) -> Option<Worse> {
    let rungs = rungs(diagnosis);
    let (first, last) = rungs.first().zip(rungs.last())?;
    worse(first, last, unit_of(&diagnosis.signal))
}
