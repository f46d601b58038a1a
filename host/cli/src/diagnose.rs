//! `palpate diagnose`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value;

use super::answer::{Answer, labels};
use super::output::{Output, write_file};
use super::preparation::Prepare;
use super::published::Published;
use super::{Failure, progress};
use palpate_diagnose::criticism::diagnose::{Diagnosis, diagnose};
use palpate_diagnose::criticism::next_motion::{Informing, Proposed, RigFile, inform, propose};
use palpate_fit::data::Data;
use palpate_model::Model;
use palpate_present::answers::{self, DiagnosisAnswer, NextMotionAnswer};
use palpate_present::summary::{
    DiagnosisSummary, NextCommand, Preparation, informing_file, informing_section, motion_file,
    next_motion_section, no_motion,
};
use palpate_report::{Section, pdf};
use palpate_trace::files::plan::{COMPUTED, FIGURE, Plan};
use palpate_trace::{Trace, has_extension, read_set, write};

/// What is done, for those who wait.
const DOING: &str = "looking for what is missing";

/// Say which physical effect a model lacks, with the evidence.
#[derive(clap::Args)]
#[command(after_help = "\
Refits the model, screens every effect of the library (and laws of your own, `[[candidate]]` in the
model file), refits with the best few, and names the missing one, a set that these traces cannot
distinguish, or none. `palpate add` puts it into the model.

Examples:
  palpate diagnose --model model.toml traces/
  palpate diagnose --model model.toml traces/ --report diagnosis.html
  palpate diagnose --model model.toml traces/ --figure figure.svg
  palpate diagnose --model model.toml traces/ --json | jq .verdict
  palpate diagnose --model model.toml traces/ --next motion.csv --rig rig.toml
  palpate diagnose --model model.toml traces/ --next motion.csv --for v1,v2")]
pub struct Args {
    /// The model
    #[arg(long, value_name = "MODEL.toml")]
    model: PathBuf,
    /// Traces, or folders of traces: one data set
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    /// Write the motion that would best distinguish what these traces do not, with what each effect predicts for it
    #[arg(long, value_name = "MOTION.csv")]
    next: Option<PathBuf>,
    /// Limits of the rig for it [default: what the traces did]
    #[arg(long, value_name = "RIG.toml", requires = "next")]
    rig: Option<PathBuf>,
    /// Write instead the motion after which these parameters are known best: names with commas between them, or all
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', requires = "next")]
    r#for: Vec<String>,
    #[command(flatten)]
    published: Published,
    #[command(flatten)]
    figure: Figure,
    #[command(flatten)]
    prepare: Prepare,
    #[command(flatten)]
    result: Output,
}

/// One figure of all for a paper.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct Figure {
    /// Also write one figure for a paper: the worst trace before, the verdict, the same trace after. A PDF is printed by
    /// Chromium, Chrome or Edge
    #[arg(long, value_name = "FILE.svg|FILE.pdf")]
    figure: Option<PathBuf>,
}

impl Figure {
    /// Plans its file.
    pub fn plan(&self, files: &mut Plan) -> Result<(), Failure> {
        self.figure.as_ref().map_or(Ok(()), |path| Ok(files.writes(path, &FIGURE)?))
    }

    /// Writes it where one is asked for, and says where it is.
    pub fn write(&self, found: &Diagnosed) -> Result<(), Failure> {
        let Some(path) = &self.figure else { return Ok(()) };
        let sheet = found.with(|summary, _| summary.paper_figure())?;
        if has_extension(path, "pdf") {
            write_file(path, &pdf(&sheet).map_err(Failure::work)?)?;
        } else {
            write_file(path, sheet.svg.as_bytes())?;
        }
        eprintln!("figure: {}", path.display());
        Ok(())
    }
}

/// Diagnoses and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    let read =
        args.traces.iter().chain([&args.model]).chain(&args.rig).chain(&args.published.files);
    let mut files = args.result.files(read)?;
    if let Some(path) = &args.next {
        files.writes(path, &COMPUTED)?;
    }
    args.figure.plan(&mut files)?;
    let limits = args.rig.as_deref().map(RigFile::read).transpose().map_err(Failure::input)?;
    let (model, traces, next) = inputs(&args.model, &args.traces, &args.published, &args.prepare)?;
    let mut found = diagnosed(&args.prepare, model, traces, next, DOING)?;
    if let Some(path) = &args.next {
        found.propose(path, &limits.unwrap_or_default(), &args.r#for)?;
    }
    args.result.show(&found)?;
    args.figure.write(&found)
}

/// A model with the laws that are tried too, traces, and how the next commands call both.
pub(super) fn inputs(
    model: &Path,
    traces: &[PathBuf],
    published: &Published,
    prepare: &Prepare,
) -> Result<(Model, Arc<Vec<Trace>>, NextCommand), Failure> {
    let next = next(model, traces, &(prepare.flags() + &published.flags()));
    let model = published.beside(Model::read(model).map_err(Failure::input)?)?;
    let traces = Arc::new(read_set(traces).map_err(Failure::input)?);
    Ok((model, traces, next))
}

/// Says what a model lacks beside traces in memory; the next commands name both as `next` says.
pub fn ask(
    prepare: &Prepare,
    model: Model,
    traces: Arc<Vec<Trace>>,
    next: NextCommand,
) -> Result<Box<dyn Answer>, Failure> {
    Ok(Box::new(diagnosed(prepare, model, traces, next, DOING)?))
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
    let found = Diagnosed { traces, preparation, model, diagnosis, next, proposed: None };
    found.with(|_, _| ())?;
    Ok(found)
}

/// What a model lacks.
pub(super) struct Diagnosed {
    traces: Arc<Vec<Trace>>,
    pub preparation: Preparation,
    pub model: Model,
    pub diagnosis: Diagnosis,
    next: NextCommand,
    /// The next motion that was asked for, and its file.
    proposed: Option<(Next, PathBuf)>,
}

/// The next motion.
enum Next {
    /// To distinguish effects.
    Deciding(Proposed),
    /// To know parameters better.
    Informing(Informing),
}

impl Diagnosed {
    /// Lays the diagnosis beside its data.
    pub fn with<T>(&self, tell: impl FnOnce(&DiagnosisSummary, &Data) -> T) -> Result<T, Failure> {
        let data = Data::of_model(&self.model, &self.traces).map_err(Failure::input)?;
        Ok(tell(&DiagnosisSummary::new(&self.diagnosis, &data, self.next.clone()), &data))
    }

    /// The diagnosis for programs, with the motion that was asked for.
    pub fn answer(&self) -> DiagnosisAnswer {
        let found = self.with(|summary, _| DiagnosisAnswer::from(summary));
        let next_motion = self.proposed.as_ref().map(|(next, path)| match next {
            Next::Deciding(found) => NextMotionAnswer::of(found, path),
            Next::Informing(found) => NextMotionAnswer::informing(found, path),
        });
        DiagnosisAnswer { next_motion, ..found.expect("these traces were diagnosed") }
    }

    /// Looks for the motion that would decide, or that would tell most of the `wanted` parameters, and writes it where there is one.
    fn propose(&mut self, path: &Path, limits: &RigFile, wanted: &[String]) -> Result<(), Failure> {
        let Self { model, diagnosis, traces, .. } = self;
        let signal = &diagnosis.signal;
        let (next, file) = if wanted.is_empty() {
            let found = progress::watched("looking for a motion that decides", || {
                propose(model, diagnosis, traces, limits)
            })?;
            let found = found.map_err(Failure::input)?;
            let file = motion_file(&found, signal);
            (Next::Deciding(found), file)
        } else {
            let found = progress::watched("looking for a motion that tells most", || {
                inform(model, diagnosis, traces, limits, wanted)
            })?;
            let found = found.map_err(Failure::input)?;
            let file = informing_file(&found, signal);
            (Next::Informing(found), Some(file))
        };
        if let Some(trace) = file {
            write(path, &trace).map_err(Failure::work)?;
            eprintln!("motion: {}", path.display());
        }
        self.proposed = Some((next, path.into()));
        Ok(())
    }

    fn with_motion(&self, mut sections: Vec<Section>) -> Vec<Section> {
        let signal = &self.diagnosis.signal;
        sections.extend(self.proposed.as_ref().map(|(next, path)| match next {
            Next::Deciding(found) => next_motion_section(found, path, signal),
            Next::Informing(found) => informing_section(found, path, signal),
        }));
        sections
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
        answers::json(&self.preparation.with(self.answer()))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        self.with(|summary, _| self.with_motion(self.before(summary.sections())))
    }

    fn in_short(&self) -> Result<Vec<Section>, Failure> {
        self.with(|summary, _| self.with_motion(self.before(summary.in_short())))
    }

    fn failed(&self) -> Option<String> {
        let Some((Next::Deciding(proposed), path)) = &self.proposed else { return None };
        proposed.motion.is_none().then(|| {
            format!("{} was not written: {}", path.display(), no_motion(proposed, &self.diagnosis))
        })
    }
}

/// Model and traces as they were named.
pub fn next(model: &Path, traces: &[PathBuf], flags: &str) -> NextCommand {
    let names: Vec<String> = traces.iter().map(|path| path.display().to_string()).collect();
    NextCommand { model: model.display().to_string(), traces: names.join(" ") + flags }
}
