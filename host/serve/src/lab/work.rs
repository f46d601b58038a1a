//! Doing what is asked for, with the functions that the command line calls.

use std::path::Path;
use std::sync::Arc;

use serde_json::{Value, json};

use super::closer::closer_json;
use super::drawing::Drawing;
use super::error::LabError;
use super::folder::Folder;
use super::forecast::candidates;
use super::set::Set;
use super::surveyed::{surveyed, take_group};
use super::task::{FitTask, HideTask, MOTION, Task};
use palpate_diagnose::criticism::change::{self, Change};
use palpate_diagnose::criticism::compare::{Comparison, compared};
use palpate_diagnose::criticism::diagnose::{Diagnosis, diagnose};
use palpate_diagnose::criticism::explore::explored;
use palpate_diagnose::criticism::leftover::Leftover;
use palpate_diagnose::criticism::next_motion::{RigFile, propose};
use palpate_diagnose::criticism::noise::noise_of;
use palpate_diagnose::discover::{self, Outcome as Found};
use palpate_diagnose::practice::{self, Choice, check_empty, hide, write_set};
use palpate_fit::data::Data;
use palpate_fit::whole_motion;
use palpate_model::Model;
use palpate_present::answers::{
    self, ChangeAnswer, ComparisonAnswer, DiagnosisAnswer, DiscoveryAnswer, FitAnswer,
    NextMotionAnswer, PracticeAnswer, TruthAnswer,
};
use palpate_present::summary::{
    DiagnosisSummary, DiscoverySummary, FitSummary, NextCommand, Preparation, Refit, change_report,
    compare_report, motion_file, next_motion_section, no_motion, unit_of,
};
use palpate_report::{Origin, Page, Section};
use palpate_trace::{Trace, write_to};

/// All that a piece of work needs, by itself.
#[derive(Clone)]
pub struct Bench {
    /// The folder that was opened.
    pub folder: Option<Folder>,
    /// The traces chosen.
    pub traces: Arc<Vec<Trace>>,
    /// The model at hand.
    pub model: Option<Arc<Model>>,
    /// The column that a fit takes.
    pub signal: String,
    /// Model and traces as commands name them.
    pub next: NextCommand,
    /// The command that does the same.
    pub command: String,
    /// Name of the model file that it writes, in the folder that was opened.
    pub written: String,
    /// The model to put beside the one at hand, and its file.
    pub other: Option<(Arc<Model>, String)>,
    /// The folder of a practice set, below that opened, and its seed.
    pub practice: (String, u64),
}

/// What a piece of work gives.
#[derive(Default)]
pub struct Outcome {
    /// The answer, as `--json` gives it on the command line.
    pub answer: Value,
    /// The report, as `--report` writes it: what it is of, and the page.
    pub report: Option<(&'static str, String)>,
    /// A new model.
    pub model: Option<Model>,
    /// The model at hand, or the new one, beside the traces.
    pub compared: Option<Compared>,
    /// Another model beside the same traces.
    pub beside: Option<Beside>,
    /// What the model lacks, with the candidates.
    pub diagnosis: Option<(Diagnosis, Value)>,
    /// The traces of a folder, by its name.
    pub set: Option<Set>,
    /// What the rows of a survey say.
    pub survey: Option<Value>,
}

/// A model beside the traces, as it is told and drawn.
pub struct Compared {
    /// What is impossible in its traces.
    pub preparation: Preparation,
    /// Where it fails; without the samples, which the drawings have.
    pub comparison: Comparison,
    /// Every trace.
    pub drawings: Vec<Drawing>,
    /// Every trace, looked at more closely.
    pub closer: Vec<Value>,
}

/// Another model beside the same traces.
pub struct Beside {
    /// Its file.
    pub file: String,
    /// The model.
    pub model: Arc<Model>,
    /// How it does.
    pub compared: Compared,
    /// The command that says the same.
    pub command: String,
}

impl Compared {
    fn new(left: Leftover, traces: &[Trace]) -> Self {
        let preparation = Preparation::of(traces, &left.comparison.signal);
        let indices = || 0..left.comparison.labels.len();
        let drawing = |trace| Drawing::of_residuals(&left.residuals, trace);
        let drawings = indices().map(drawing).collect();
        let closer = indices().map(|trace| closer_json(&left, trace)).collect();
        Self { comparison: left.comparison, preparation, drawings, closer }
    }
}

/// Does what is asked for.
///
/// # Errors
/// What the command would say.
pub fn run(task: &Task, bench: &Bench) -> Result<Outcome, LabError> {
    let model = || bench.model.as_deref().ok_or(LabError::NoModel);
    match task {
        Task::Fit(fit) => bench.fit(fit),
        Task::Compare => bench.compare(model()?),
        Task::Diagnose => bench.diagnose(model()?, false),
        Task::Explore => bench.diagnose(model()?, true),
        Task::Discover => bench.discover(model()?),
        Task::Motion => bench.motion(model()?),
        Task::Add { effect, law } => {
            let change = change::add(model()?, effect, law.as_deref(), &bench.traces)?;
            bench.changed(change)
        }
        Task::Drop { effect } => bench.changed(change::drop(model()?, effect, &bench.traces)?),
        Task::Beside(_) => bench.beside(model()?),
        Task::Hide(hide) => bench.hide(hide),
        Task::Survey(name) => {
            let survey = surveyed(bench.folder.as_ref().ok_or(LabError::NoFolder)?, name)?;
            Ok(Outcome { survey: Some(survey), ..Outcome::default() })
        }
        Task::Group { survey, group } => {
            let folder = bench.folder.as_ref().ok_or(LabError::NoFolder)?;
            bench.open(&take_group(folder, survey, *group)?)
        }
        Task::Open(set) => bench.open(set),
    }
}

impl Bench {
    fn fit(&self, task: &FitTask) -> Result<Outcome, LabError> {
        let laws = task.choice()?.laws()?;
        let data = Data::of(&self.traces, &self.signal)?.with_separation(task.separation);
        let fits =
            laws.iter().map(|&law| whole_motion::fit(law, &data)).collect::<Result<Vec<_>, _>>()?;
        let best =
            fits.iter().min_by(|a, b| a.bic().total_cmp(&b.bic())).ok_or(LabError::NoModel)?;
        let noise = noise_of(&data, &self.traces);
        let deviation = noise.map(|noise| noise.standard_deviation);
        let best = &best.clone().allowing_for_misfit(&data, deviation);
        let several = self.traces.len() > 1;
        let held_out = if several { whole_motion::held_out(best, &data) } else { Vec::new() };
        let summary = FitSummary {
            fit: best,
            data: &data,
            signal: &self.signal,
            noise,
            held_out: &held_out,
            candidates: &fits,
        };
        let model = summary.model();
        let mut preparation = Preparation::of(&self.traces, &self.signal);
        if !preparation.outliers.is_empty() {
            preparation.refit = Refit::of(best, &self.traces, &self.signal);
        }
        let sections = preparation.before(summary.sections());
        Ok(Outcome {
            answer: answers::json(&preparation.with(FitAnswer::from(&summary))),
            report: Some(("fit", self.page("A fit over whole motions", sections))),
            compared: Some(self.compared(&model)?),
            model: Some(model),
            ..Outcome::default()
        })
    }

    /// How a model does, with all that is drawn of it.
    fn compared(&self, model: &Model) -> Result<Compared, LabError> {
        let data = Data::of_model(model, &self.traces)?;
        Ok(Compared::new(compared(model, &self.traces, &data)?, &self.traces))
    }

    fn compare(&self, model: &Model) -> Result<Outcome, LabError> {
        let data = Data::of_model(model, &self.traces)?;
        let left = compared(model, &self.traces, &data)?;
        let preparation = Preparation::of(&self.traces, &model.base.signal);
        let sections = preparation.before(compare_report(
            model,
            &left.comparison,
            &left.residuals,
            &self.traces,
        ));
        Ok(Outcome {
            answer: answers::json(&preparation.with(ComparisonAnswer::from(&left.comparison))),
            report: Some(("compare", self.page("Model against measurement", sections))),
            compared: Some(Compared::new(left, &self.traces)),
            ..Outcome::default()
        })
    }

    /// Another model beside the same traces.
    fn beside(&self, model: &Model) -> Result<Outcome, LabError> {
        let (other, file) = self.other.clone().ok_or(LabError::NoModel)?;
        let (theirs, ours) = (&other.base.signal, &model.base.signal);
        if theirs != ours {
            let (theirs, ours) = (theirs.clone(), ours.clone());
            return Err(LabError::OtherSignal { other: file, theirs, ours });
        }
        let compared = self.compared(&other)?;
        let preparation = Preparation::of(&self.traces, ours);
        let answer = ComparisonAnswer::from(&compared.comparison);
        Ok(Outcome {
            answer: answers::json(&preparation.with(answer)),
            beside: Some(Beside { file, model: other, compared, command: self.command.clone() }),
            ..Outcome::default()
        })
    }

    /// The traces of a folder.
    fn open(&self, set: &str) -> Result<Outcome, LabError> {
        let opened = self.folder.as_ref().ok_or(LabError::NoFolder)?;
        let set = Set::read(opened, set)?;
        // Without a single trace the set that is open is of more use.
        match set.left_out.first() {
            Some((file, why)) if set.traces.is_empty() => {
                Err(LabError::Unread { file: file.clone(), why: why.clone() })
            }
            _ => Ok(Outcome { set: Some(set), ..Outcome::default() }),
        }
    }

    /// What the model lacks; with everything found added, where asked.
    fn diagnose(&self, model: &Model, climb: bool) -> Result<Outcome, LabError> {
        let diagnosis = diagnose(model, &self.traces)?;
        let data = Data::of_model(model, &self.traces)?;
        let summary = DiagnosisSummary::new(&diagnosis, &data, self.next.clone());
        let title = if climb { "From the first model to the last" } else { "What the model lacks" };
        let better = climb.then(|| explored(model, &diagnosis, &data, unit_of(&diagnosis.signal)));
        let left = compared(better.as_ref().unwrap_or(model), &self.traces, &data)?;
        // After a climb, what could be added to the first model says nothing of the last.
        let list = if climb { Value::Null } else { candidates(&diagnosis, &data, &left, model) };
        let preparation = Preparation::of(&self.traces, &model.base.signal);
        let mut answer = answers::json(&preparation.with(DiagnosisAnswer::from(&summary)));
        if let Some(folder) = self.folder.as_ref().filter(|_| climb) {
            answer["model"] = folder.shown(&self.written).into();
        }
        Ok(Outcome {
            answer,
            report: Some(("diagnosis", self.page(title, preparation.before(summary.sections())))),
            compared: Some(Compared::new(left, &self.traces)),
            model: better,
            diagnosis: Some((diagnosis, list)),
            ..Outcome::default()
        })
    }

    /// A formula for what the library does not explain; the model comes back with the formulas beside it.
    fn discover(&self, model: &Model) -> Result<Outcome, LabError> {
        let unit = unit_of(&model.base.signal);
        let discovery = discover::discover(model, &self.traces, unit)?;
        let labels: Vec<String> = self.traces.iter().map(Trace::label).collect();
        let file = self.folder.as_ref().map(|folder| folder.shown(&self.written));
        let summary = DiscoverySummary::new(&discovery, &labels, self.next.clone(), file);
        let preparation = Preparation::of(&self.traces, &model.base.signal);
        let data = Data::of_model(model, &self.traces)?;
        let found = matches!(discovery.outcome, Found::Formulas(_));
        let sections = preparation.before(summary.sections());
        Ok(Outcome {
            answer: answers::json(&preparation.with(DiscoveryAnswer::from(&summary))),
            report: Some(("discovery", self.page("A formula for what is missing", sections))),
            model: found.then(|| discovery.with_candidates(model, &data, unit)),
            ..Outcome::default()
        })
    }

    /// The motion that tells apart what these traces do not, with what each of the effects predicts for it.
    fn motion(&self, model: &Model) -> Result<Outcome, LabError> {
        let diagnosis = diagnose(model, &self.traces)?;
        let proposed = propose(model, &diagnosis, &self.traces, &RigFile::default())?;
        let file = Path::new(MOTION);
        let signal = &diagnosis.signal;
        let mut answer = answers::json(&NextMotionAnswer::of(&proposed, file));
        let Some(trace) = motion_file(&proposed, signal) else {
            answer["why"] = no_motion(&proposed, &diagnosis).into();
            return Ok(Outcome { answer, ..Outcome::default() });
        };
        let columns = trace
            .columns
            .iter()
            .map(|column| json!({ "name": column.name, "values": column.values }));
        answer["time_s"] = json!(trace.time);
        answer["columns"] = columns.collect();
        let mut csv = Vec::new();
        write_to(&mut csv, &trace).map_err(|source| LabError::Io { path: file.into(), source })?;
        answer["csv"] = String::from_utf8_lossy(&csv).into();
        let sections = vec![next_motion_section(&proposed, file, signal)];
        let report = self.page("The next experiment", sections);
        Ok(Outcome { answer, report: Some(("motion", report)), ..Outcome::default() })
    }

    fn changed(&self, change: Change) -> Result<Outcome, LabError> {
        let data = Data::of_model(&change.model, &self.traces)?;
        let left = compared(&change.model, &self.traces, &data)?;
        let page = self.page("A changed model", change_report(&change, &left));
        Ok(Outcome {
            answer: answers::json(&ChangeAnswer::from(&change)),
            report: Some(("change", page)),
            compared: Some(Compared::new(left, &self.traces)),
            model: Some(change.model),
            ..Outcome::default()
        })
    }

    fn hide(&self, task: &HideTask) -> Result<Outcome, LabError> {
        let opened = self.folder.as_ref().ok_or(LabError::NoFolder)?;
        let (name, seed) = &self.practice;
        let folder = opened.to_write(name)?;
        check_empty(&folder)?;
        let choice = match task.effects.is_empty() {
            true => Choice::Any(task.count()?),
            false => Choice::Named(task.effects.clone()),
        };
        let practice = hide(&choice, task.size.unwrap_or(1.0), *seed)?;
        if palpate_fit::watch::ended() {
            return Err(LabError::Cancelled);
        }
        write_set(&folder, &practice)?;
        Ok(Outcome {
            answer: answers::json(&PracticeAnswer::of(&practice, &opened.shown(name))),
            set: Some(Set::read(opened, name)?),
            ..Outcome::default()
        })
    }

    /// The page that `--report` writes.
    fn page(&self, title: &str, sections: Vec<Section>) -> String {
        let origin = Origin {
            program: concat!("palpate ", env!("CARGO_PKG_VERSION")).into(),
            command: self.command.clone(),
            inputs: self.traces.iter().map(Trace::label).collect(),
        };
        let signal = self.model.as_ref().map_or(&self.signal, |model| &model.base.signal);
        let mut page = Page::new(title, signal, origin);
        page.sections = sections;
        page.to_html()
    }
}

/// What is hidden in the practice set of a folder.
///
/// # Errors
/// When it is not one.
pub fn reveal(folder: &Path) -> Result<Value, LabError> {
    Ok(answers::json(&TruthAnswer::from(&practice::open(folder)?)))
}
