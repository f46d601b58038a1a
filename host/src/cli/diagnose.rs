//! `palpate diagnose`.

use std::path::PathBuf;

use super::output::{Output, print_json, print_sections, write_report};
use super::{Failure, progress};
use crate::criticism::diagnose::diagnose;
use crate::model::Model;
use crate::summary::{diagnosis_json, diagnosis_sections};
use crate::trace::{Trace, read_set};

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
    result: Output,
}

/// Diagnoses and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    let model = Model::read(&args.model).map_err(Failure::input)?;
    let traces = read_set(&args.traces).map_err(Failure::input)?;
    let wait = progress::spinner("looking for what is missing");
    let diagnosis = diagnose(&model, &traces).map_err(Failure::input)?;
    wait.finish_and_clear();
    if let Some(path) = &args.result.report {
        let names = traces.iter().map(Trace::label).collect();
        let sections = diagnosis_sections(&diagnosis);
        write_report(path, "What the model lacks", &diagnosis.signal, names, sections)?;
    }
    if args.result.json {
        print_json(&diagnosis_json(&diagnosis))
    } else {
        print_sections(&diagnosis_sections(&diagnosis))
    }
}
