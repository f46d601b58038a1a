//! `palpate add`.

use std::path::{Path, PathBuf};

use super::output::{Output, print_json, print_sections, write_report};
use super::preparation::Prepare;
use super::{Failure, progress};
use crate::criticism::change::{self, Change, ChangeError};
use crate::criticism::compare::compare;
use crate::files::plan::MODEL;
use crate::model::Model;
use crate::summary::{change_json, change_report, change_sections};
use crate::trace::Trace;

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
    /// Take this law of the effect
    #[arg(long, value_name = "LAW")]
    law: Option<String>,
    /// Write the model with the effect
    #[arg(short, long, value_name = "BETTER.toml")]
    output: Option<PathBuf>,
    #[command(flatten)]
    prepare: Prepare,
    #[command(flatten)]
    result: Output,
}

/// Adds, refits and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut files = args.result.files(args.traces.iter().chain([&args.model]))?;
    if let Some(path) = &args.output {
        files.writes(path, &MODEL)?;
    }
    let model = Model::read(&args.model).map_err(Failure::input)?;
    let (traces, _) = args.prepare.read(&args.traces, &model.base.signal)?;
    let wait = progress::spinner("refitting");
    let change = change::add(&model, &args.name, args.law.as_deref(), &traces);
    wait.finish_and_clear();
    let change = change.map_err(|error| match error {
        ChangeError::Worse { .. } => Failure::work(error),
        _ => Failure::input(error),
    })?;
    give(&change, &traces, args.output.as_deref(), &args.result)
}

/// Writes the changed model, the report and the result.
pub fn give(
    change: &Change,
    traces: &[Trace],
    output: Option<&Path>,
    result: &Output,
) -> Result<(), Failure> {
    if let Some(path) = output {
        change.model.write(path).map_err(Failure::work)?;
    }
    if let Some(path) = &result.report {
        let comparison = compare(&change.model, traces).map_err(Failure::input)?;
        let sections = change_report(change, &comparison);
        let names = traces.iter().map(Trace::label).collect();
        write_report(path, "A changed model", &change.model.base.signal, names, sections)?;
    }
    if result.json {
        print_json(&change_json(change))?;
    } else {
        print_sections(&change_sections(change))?;
    }
    if change.fit.stop.converged() {
        Ok(())
    } else {
        Err(Failure::Work(miette::miette!("{}", change.fit.stop)))
    }
}
