//! `palpate diagnose`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value;

use super::answer::{Answer, labels};
use super::output::Output;
use super::preparation::Prepare;
use super::{Failure, progress};
use crate::criticism::diagnose::{Diagnosis, diagnose};
use crate::fit::data::Data;
use crate::model::Model;
use crate::report::Section;
use crate::summary::{DiagnosisSummary, NextCommand, Preparation};
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
    prepare: Prepare,
    #[command(flatten)]
    result: Output,
}

/// Diagnoses and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.result.files(args.traces.iter().chain([&args.model]))?;
    let model = Model::read(&args.model).map_err(Failure::input)?;
    let traces = Arc::new(read_set(&args.traces).map_err(Failure::input)?);
    let next = next(&args.model, &args.traces, &args.prepare);
    args.result.show(&*ask(&args.prepare, model, traces, next)?)
}

/// Says what a model lacks beside traces in memory; the next commands name both as `next` says.
pub fn ask(
    prepare: &Prepare,
    model: Model,
    traces: Arc<Vec<Trace>>,
    next: NextCommand,
) -> Result<Box<dyn Answer>, Failure> {
    let doing = "looking for what is missing";
    Ok(Box::new(diagnosed(prepare, model, traces, next, doing)?))
}

/// The same, as both commands need it that diagnose.
pub(super) fn diagnosed(
    prepare: &Prepare,
    model: Model,
    traces: Arc<Vec<Trace>>,
    next: NextCommand,
    doing: &str,
) -> Result<Diagnosed, Failure> {
    let (traces, preparation) = prepare.take(traces, &model.base.signal)?;
    let diagnosis =
        progress::watched(doing, || diagnose(&model, &traces))?.map_err(Failure::input)?;
    let found = Diagnosed { traces, preparation, model, diagnosis, next };
    found.with(|_, _| ())?;
    Ok(found)
}

/// What a model lacks.
pub(super) struct Diagnosed {
    traces: Arc<Vec<Trace>>,
    preparation: Preparation,
    pub model: Model,
    pub diagnosis: Diagnosis,
    next: NextCommand,
}

impl Diagnosed {
    /// Lays the diagnosis beside its data.
    pub fn with<T>(&self, tell: impl FnOnce(&DiagnosisSummary, &Data) -> T) -> Result<T, Failure> {
        let data = Data::of_model(&self.model, &self.traces).map_err(Failure::input)?;
        Ok(tell(&DiagnosisSummary::new(&self.diagnosis, &data, self.next.clone()), &data))
    }

    /// Sections with what was found in the traces before them.
    pub fn before(&self, sections: Vec<Section>) -> Vec<Section> {
        self.preparation.before(sections)
    }
}

impl Answer for Diagnosed {
    fn title(&self) -> &'static str {
        "What the model lacks"
    }

    fn subtitle(&self) -> String {
        self.diagnosis.signal.clone()
    }

    fn inputs(&self) -> Vec<String> {
        labels(&self.traces)
    }

    fn json(&self) -> Value {
        let json = self.with(|summary, _| summary.json());
        self.preparation.within(json.expect("these traces were diagnosed"))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        self.with(|summary, _| self.before(summary.sections()))
    }

    fn in_short(&self) -> Result<Vec<Section>, Failure> {
        self.with(|summary, _| self.before(summary.in_short()))
    }
}

/// Model and traces as they were named.
pub fn next(model: &Path, traces: &[PathBuf], prepare: &Prepare) -> NextCommand {
    let names: Vec<String> = traces.iter().map(|path| path.display().to_string()).collect();
    NextCommand { model: model.display().to_string(), traces: names.join(" ") + &prepare.flags() }
}
