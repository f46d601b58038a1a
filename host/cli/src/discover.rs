//! `palpate discover`.

use std::path::PathBuf;
use std::sync::Arc;

use serde_json::Value;

use super::answer::{Answer, labels, write_model};
use super::diagnose::inputs;
use super::output::Output;
use super::preparation::Prepare;
use super::published::Published;
use super::{Failure, progress};
use palpate_diagnose::discover::{Discovery, discover};
use palpate_fit::data::Data;
use palpate_model::Model;
use palpate_present::answers::{self, DiscoveryAnswer};
use palpate_present::summary::{DiscoverySummary, NextCommand, Preparation, unit_of};
use palpate_report::Section;
use palpate_trace::Trace;
use palpate_trace::files::plan::MODEL;

/// Find a formula for what no effect of the library explains.
#[derive(clap::Args)]
#[command(after_help = "\
Diagnoses first. Where the library does not explain what is missing, every term of a grammar (shapes
over displacement, velocity, force, time, temperature and what they were before, at each stage of the
chain) is tried, and one to three are kept that lower the error on traces left out. They come as laws
of one's own, with their errors, what these traces do not distinguish from them, what they can come from, and
the experiment that would confirm it. `palpate add found-1` adds one.

Examples:
  palpate discover --model model.toml traces/
  palpate discover --model model.toml traces/ -o found.toml --report discovery.html
  palpate discover --model model.toml traces/ --json | jq .formulas[0].expression")]
pub struct Args {
    /// The model
    #[arg(long, value_name = "MODEL.toml")]
    model: PathBuf,
    /// Traces, or folders of traces: one data set
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    /// Write the model with the formulas as candidates
    #[arg(short, long, value_name = "FOUND.toml")]
    output: Option<PathBuf>,
    #[command(flatten)]
    published: Published,
    #[command(flatten)]
    prepare: Prepare,
    #[command(flatten)]
    result: Output,
}

/// Looks for formulas and prints them.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut files =
        args.result.files(args.traces.iter().chain([&args.model]).chain(&args.published.files))?;
    if let Some(path) = &args.output {
        files.writes(path, &MODEL)?;
    }
    let (model, traces, next) = inputs(&args.model, &args.traces, &args.published, &args.prepare)?;
    let found = discovered(&args.prepare, model, traces, next, args.output.clone())?;
    write_model(&found, args.output.as_deref())?;
    args.result.show(&found)
}

/// Looks for formulas of what a model lacks beside traces in memory; the next commands name both as `next` says.
pub fn ask(
    prepare: &Prepare,
    model: Model,
    traces: Arc<Vec<Trace>>,
    next: NextCommand,
) -> Result<Box<dyn Answer>, Failure> {
    Ok(Box::new(discovered(prepare, model, traces, next, None)?))
}

fn discovered(
    prepare: &Prepare,
    model: Model,
    traces: Arc<Vec<Trace>>,
    next: NextCommand,
    written: Option<PathBuf>,
) -> Result<Discovered, Failure> {
    let (traces, preparation) = prepare.take(traces, &model.base.signal)?;
    let unit = unit_of(&model.base.signal);
    let discovery = progress::watched("looking for a formula", || discover(&model, &traces, unit))?
        .map_err(Failure::input)?;
    let labels = labels(&traces);
    Ok(Discovered { traces, labels, preparation, model, discovery, next, written })
}

/// What was found of what a model lacks.
struct Discovered {
    traces: Arc<Vec<Trace>>,
    labels: Vec<String>,
    preparation: Preparation,
    model: Model,
    discovery: Discovery,
    next: NextCommand,
    /// The file of the model with the formulas as candidates.
    written: Option<PathBuf>,
}

impl Discovered {
    fn summary(&self) -> DiscoverySummary<'_> {
        let written = self.written.as_ref().map(|path| path.display().to_string());
        DiscoverySummary::new(&self.discovery, &self.labels, self.next.clone(), written)
    }
}

impl Answer for Discovered {
    fn title(&self) -> &'static str {
        "A formula for what is missing"
    }

    fn subtitle(&self) -> String {
        self.model.base.signal.clone()
    }

    fn inputs(&self) -> Vec<String> {
        self.labels.clone()
    }

    fn json(&self) -> Value {
        answers::json(&self.preparation.with(DiscoveryAnswer::from(&self.summary())))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        Ok(self.preparation.before(self.summary().sections()))
    }

    fn in_short(&self) -> Result<Vec<Section>, Failure> {
        Ok(self.preparation.before(self.summary().in_short()))
    }

    fn model(&self) -> Result<Option<Model>, Failure> {
        let data = Data::of_model(&self.model, &self.traces).map_err(Failure::input)?;
        let unit = unit_of(&self.model.base.signal);
        Ok(Some(self.discovery.with_candidates(&self.model, &data, unit)))
    }
}
