//! `palpate diagnose`.

use std::path::{Path, PathBuf};

use super::output::{Output, print_json, print_sections, write_report};
use super::preparation::Prepare;
use super::{Failure, progress};
use crate::criticism::diagnose::diagnose;
use crate::fit::data::Data;
use crate::model::Model;
use crate::summary::{DiagnosisSummary, NextCommand};

/// Say which physical effect a model lacks, with the evidence.
#[derive(clap::Args)]
#[command(after_help = "\
Refits the model, screens every effect of the library (and laws of your own, `[[candidate]]` in the
model file), refits with the best few, and names the missing one, a set that these traces cannot
tell apart, or none. `palpate add` puts it into the model.

Examples:
  palpate diagnose --model model.toml traces/
  palpate diagnose --model model.toml traces/ --report diagnosis.html
  palpate diagnose --model model.toml traces/ --json | jq .verdict")]
pub struct Args {
    /// The model
    #[arg(long, value_name = "MODEL.toml")]
    model: PathBuf,
    /// Traces, or folders of traces: one data set
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    #[command(flatten)]
    prepare: Prepare,
    #[command(flatten)]
    result: Output,
}

/// Diagnoses and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.result.files(args.traces.iter().chain([&args.model]))?;
    let model = Model::read(&args.model).map_err(Failure::input)?;
    let (traces, preparation) = args.prepare.read(&args.traces, &model.base.signal)?;
    let diagnosis = progress::watched("looking for what is missing", || diagnose(&model, &traces))?
        .map_err(Failure::input)?;
    let data = Data::of_model(&model, &traces).map_err(Failure::input)?;
    let summary =
        DiagnosisSummary::new(&diagnosis, &data, next(&args.model, &args.traces, &args.prepare));
    if let Some(path) = &args.result.report {
        let title = "What the model lacks";
        write_report(
            path,
            title,
            &diagnosis.signal,
            data.labels.clone(),
            preparation.before(summary.sections()),
        )?;
    }
    if args.result.json {
        print_json(&preparation.within(summary.json()))
    } else {
        print_sections(&preparation.before(summary.in_short()))
    }
}

/// Model and traces as they were named.
pub fn next(model: &Path, traces: &[PathBuf], prepare: &Prepare) -> NextCommand {
    let names: Vec<String> = traces.iter().map(|path| path.display().to_string()).collect();
    NextCommand { model: model.display().to_string(), traces: names.join(" ") + &prepare.flags() }
}
