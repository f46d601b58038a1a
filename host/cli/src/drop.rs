//! `palpate drop`.

use std::path::PathBuf;
use std::sync::Arc;

use super::add::{Changed, give};
use super::answer::Answer;
use super::output::Output;
use super::preparation::Prepare;
use super::{Failure, progress};
use palpate_diagnose::criticism::change;
use palpate_model::Model;
use palpate_trace::files::plan::MODEL;
use palpate_trace::{Trace, read_set};

/// Take an effect out of a model, refit, and see the error rise.
#[derive(clap::Args)]
#[command(after_help = "\
What remains is refitted rung by rung, in the order in which it was added. A law of your own stays in
the model file as `[[candidate]]`.

Examples:
  palpate drop mullins better.toml traces/ -o other.toml")]
pub struct Args {
    /// The effect
    name: String,
    /// The model
    model: PathBuf,
    /// Traces, or folders of traces: one data set
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    /// Write the model without the effect
    #[arg(short, long, value_name = "OTHER.toml")]
    output: Option<PathBuf>,
    #[command(flatten)]
    prepare: Prepare,
    #[command(flatten)]
    result: Output,
}

/// Takes the effect out, refits and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut files = args.result.files(args.traces.iter().chain([&args.model]))?;
    if let Some(path) = &args.output {
        files.writes(path, &MODEL)?;
    }
    let model = Model::read(&args.model).map_err(Failure::input)?;
    let traces = Arc::new(read_set(&args.traces).map_err(Failure::input)?);
    give(&*ask(&args.prepare, &args.name, &model, traces)?, args.output.as_deref(), &args.result)
}

/// Takes an effect out of a model and refits it to traces in memory.
pub fn ask(
    prepare: &Prepare,
    effect: &str,
    model: &Model,
    traces: Arc<Vec<Trace>>,
) -> Result<Box<dyn Answer>, Failure> {
    let (traces, _) = prepare.take(traces, &model.base.signal)?;
    let wait = progress::spinner("refitting");
    let change = change::drop(model, effect, &traces);
    wait.finish_and_clear();
    Ok(Box::new(Changed { change: change.map_err(Failure::input)?, traces }))
}
