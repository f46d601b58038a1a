//! `palpate explore`.

use std::path::PathBuf;

use serde_json::Value;

use super::diagnose::next;
use super::output::{Output, print_json, print_sections, write_report};
use super::preparation::Prepare;
use super::{Failure, progress};
use crate::criticism::change::{Worse, worse};
use crate::criticism::diagnose::{Diagnosis, diagnose};
use crate::criticism::explore::{explored, rungs};
use crate::files::plan::MODEL;
use crate::fit::data::Data;
use crate::model::Model;
use crate::summary::{DiagnosisSummary, unit_of};

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
    prepare: Prepare,
    #[command(flatten)]
    result: Output,
}

/// Explores and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut files = args.result.files(args.traces.iter().chain([&args.model]))?;
    if let Some(path) = &args.output {
        files.writes(path, &MODEL)?;
    }
    let model = Model::read(&args.model).map_err(Failure::input)?;
    let (traces, preparation) = args.prepare.read(&args.traces, &model.base.signal)?;
    let diagnosis = progress::watched("climbing the ladder", || diagnose(&model, &traces))?
        .map_err(Failure::input)?;
    let data = Data::of_model(&model, &traces).map_err(Failure::input)?;
    let summary =
        DiagnosisSummary::new(&diagnosis, &data, next(&args.model, &args.traces, &args.prepare));
    if let Some(worse) = lower(&diagnosis) {
        return Err(Failure::Work(miette::miette!("{worse}; the model stays as it was")));
    }
    if let Some(path) = &args.output {
        let better = explored(&model, &diagnosis, &data, unit_of(&diagnosis.signal));
        better.write(path).map_err(Failure::work)?;
        eprintln!("model: {}", path.display());
    }
    if let Some(path) = &args.result.report {
        let title = "From the first model to the last";
        write_report(
            path,
            title,
            &diagnosis.signal,
            data.labels.clone(),
            preparation.before(summary.sections()),
        )?;
    }
    if args.result.json {
        let mut answer = preparation.within(summary.json());
        answer["model"] =
            args.output.as_ref().map_or(Value::Null, |path| path.display().to_string().into());
        print_json(&answer)
    } else {
        print_sections(&preparation.before(summary.exploration(args.output.as_deref())))
    }
}

/// Whether the model at the top of the ladder is worse than the one that was given.
fn lower(diagnosis: &Diagnosis) -> Option<Worse> {
    let rungs = rungs(diagnosis);
    let (first, last) = rungs.first().zip(rungs.last())?;
    worse(first, last, unit_of(&diagnosis.signal))
}
