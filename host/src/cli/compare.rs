//! `palpate compare`.

use std::path::PathBuf;

use super::output::Output;
use super::preparation::Prepare;
use super::{Failure, progress};
use crate::criticism::compare::compare;
use crate::model::Model;
use crate::summary::{compare_json, compare_sections};
use crate::trace::Trace;

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
    let (traces, preparation) = args.prepare.read(&args.traces, &model.base.signal)?;
    let wait = progress::spinner("comparing");
    let comparison = compare(&model, &traces).map_err(Failure::input)?;
    wait.finish_and_clear();
    let sections = preparation.before(compare_sections(&model, &comparison, &traces));
    let names = traces.iter().map(Trace::label).collect();
    let json = || preparation.within(compare_json(&comparison));
    args.result.give("Model against measurement", &comparison.signal, names, &sections, json)
}
