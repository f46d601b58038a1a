//! `palpate discover`.

use std::path::PathBuf;
use std::sync::Arc;

use super::diagnose::next;
use super::output::{Output, print_json, print_sections, write_report};
use super::preparation::Prepare;
use super::{Failure, progress};
use crate::discover::discover;
use crate::files::plan::MODEL;
use crate::fit::data::Data;
use crate::model::Model;
use crate::summary::{DiscoverySummary, unit_of};
use crate::trace::{Trace, read_set};

/// Find a formula for what no effect of the library explains.
#[derive(clap::Args)]
#[command(after_help = "\
Diagnoses first. Where the library does not explain what is missing, every term of a grammar (shapes
over displacement, velocity, force, time, temperature and what they were before, at each stage of the
chain) is tried, and one to three are kept that lower the error on traces left out. They come as laws
of one's own, with their errors, what these traces do not tell from them, what they can come from, and
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
    prepare: Prepare,
    #[command(flatten)]
    result: Output,
}

/// Looks for formulas and prints them.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut files = args.result.files(args.traces.iter().chain([&args.model]))?;
    if let Some(path) = &args.output {
        files.writes(path, &MODEL)?;
    }
    let model = Model::read(&args.model).map_err(Failure::input)?;
    let signal = &model.base.signal;
    let traces = Arc::new(read_set(&args.traces).map_err(Failure::input)?);
    let (traces, preparation) = args.prepare.take(traces, signal)?;
    let unit = unit_of(signal);
    let discovery = progress::watched("looking for a formula", || discover(&model, &traces, unit))?
        .map_err(Failure::input)?;
    let labels: Vec<String> = traces.iter().map(Trace::label).collect();
    if let Some(path) = &args.output {
        let data = Data::of_model(&model, &traces).map_err(Failure::input)?;
        discovery.with_candidates(&model, &data, unit).write(path).map_err(Failure::work)?;
        eprintln!("model: {}", path.display());
    }
    let output = args.output.as_ref().map(|path| path.display().to_string());
    let summary =
        DiscoverySummary::new(&discovery, &labels, next(&args.model, &args.traces, &args.prepare));
    if let Some(path) = &args.result.report {
        let sections = preparation.before(summary.sections(output.as_deref()));
        write_report(path, "A formula for what is missing", signal, labels.clone(), sections)?;
    }
    if args.result.json {
        print_json(&preparation.within(summary.json()))
    } else {
        print_sections(&preparation.before(summary.in_short(output.as_deref())))
    }
}
