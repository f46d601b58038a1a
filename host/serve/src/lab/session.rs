//! What the page shows: traces, models, answers, and the way back.

mod told;

use std::path::Path;
use std::sync::Arc;

use serde_json::{Map, Value, json};
use shared::adaptation::Relaxation;

use super::drawing::Drawing;
use super::dropped::Dropped;
use super::error::LabError;
use super::folder::Folder;
use super::forecast::Forecast;
use super::job::Job;
use super::own_law::OwnLaw;
use super::set::Set;
use super::spans::Spans;
use super::surveyed::group_folder;
use super::task::{Names, Other, Task};
use super::work::{Bench, Beside, Compared, Outcome};
use palpate_analysis::decomposition::relaxation_of;
use palpate_diagnose::criticism::diagnose::Diagnosis;
use palpate_diagnose::practice::seed_from_clock;
use palpate_model::Model;
use palpate_present::summary::NextCommand;
use palpate_trace::files::plan::MODEL;
use palpate_trace::files::quoted;
use palpate_trace::{DISPLACEMENT, FORCE, Trace};

/// Models that a session keeps, to go back to.
const MAX_VERSIONS: usize = 100;

/// A model with how it came about.
struct Version {
    model: Arc<Model>,
    /// Its file, as a command takes it.
    file: String,
    /// Name of that file in the folder that was opened; none of one that lies elsewhere.
    name: Option<String>,
    /// Whether that file holds it.
    saved: bool,
    /// The command that makes it; none for a model that was opened.
    command: Option<String>,
    /// What was done, in a few words.
    said: String,
}

/// What is known of the model at hand beside the traces chosen.
#[derive(Default)]
struct Known {
    compared: Option<Compared>,
    /// The traces without a model, as far as they were looked at.
    measured: Vec<Option<Drawing>>,
    beside: Option<Beside>,
    diagnosis: Option<Diagnosis>,
    forecast: Option<Forecast>,
    /// Answers by the name of the task: `fit`, `diagnosis`, `change`, with `candidates` beside.
    answers: Map<String, Value>,
    /// The last report of each kind.
    reports: Vec<(&'static str, String)>,
}

/// A session at one folder.
#[derive(Default)]
pub struct Session {
    folder: Option<Folder>,
    /// The folder of the data set below that opened; empty for that itself.
    set: String,
    /// Every trace of the data set, in order of recording.
    traces: Arc<Vec<Trace>>,
    /// Files of it that were left out, each with why.
    left_out: Vec<(String, String)>,
    /// Which of them are taken.
    chosen: Vec<bool>,
    /// Those that are taken, and their regions.
    taken: Arc<Vec<Trace>>,
    spans: Vec<Spans>,
    signal: String,
    /// The models, the one at hand last.
    versions: Vec<Version>,
    known: Known,
    job: Option<Job>,
    /// Why the last task gave no outcome.
    failed: Option<String>,
    dropped: Dropped,
    /// What the rows of a survey say, and its folder.
    survey: Option<Value>,
}

impl Session {
    /// A session without a folder.
    #[must_use]
    pub fn empty() -> Self {
        Self { signal: FORCE.into(), ..Self::default() }
    }

    /// Opens a folder, its traces if it has any, and a model file, which may lie elsewhere. Traces that cannot be read are
    /// left out, and [`Session::left_out`] tells them.
    ///
    /// # Errors
    /// When the folder is not there, or the model cannot be read.
    pub fn open(folder: &Path, model: Option<&Path>) -> Result<Self, LabError> {
        let mut session = Self { folder: Some(Folder::open(folder)?), ..Self::empty() };
        let sets = session.folder()?.sets()?;
        if let Some(set) = sets.first() {
            let set = Set::read(session.folder()?, set)?;
            session.take_set(set);
        }
        if let Some(path) = model {
            session.take_model(Model::read(path)?, quoted(&path.display().to_string()), None);
            session.look()?;
        }
        Ok(session)
    }

    /// Puts a model on top of the others; the oldest beyond [`MAX_VERSIONS`] is forgotten.
    fn remember(&mut self, version: Version) {
        self.versions.push(version);
        let beyond = self.versions.len().saturating_sub(MAX_VERSIONS);
        self.versions.drain(..beyond);
    }

    pub(super) fn folder(&self) -> Result<&Folder, LabError> {
        self.folder.as_ref().ok_or(LabError::NoFolder)
    }

    /// What was dropped on the page so far.
    pub(super) const fn dropped(&mut self) -> &mut Dropped {
        &mut self.dropped
    }

    fn model(&self) -> Result<&Arc<Model>, LabError> {
        self.versions.last().map(|version| &version.model).ok_or(LabError::NoModel)
    }

    /// Sets another data set to be read: a folder below that opened.
    ///
    /// # Errors
    /// When it leads outside, is not there, or something is at work.
    pub fn choose_set(&mut self, set: &str) -> Result<(), LabError> {
        self.check_idle()?;
        self.folder()?.existing(set)?;
        self.start(Task::Open(set.into()))
    }

    /// Files of the data set that were left out, each with why.
    #[must_use]
    pub fn left_out(&self) -> &[(String, String)] {
        &self.left_out
    }

    fn take_set(&mut self, set: Set) {
        self.chosen = vec![true; set.traces.len()];
        self.traces = Arc::new(set.traces);
        self.left_out = set.left_out;
        self.taken = self.traces.clone();
        self.spans = Spans::of_set(&self.taken);
        self.set = set.name;
        if !self.signals().contains(&self.signal) {
            self.signal = self.signals().into_iter().next().unwrap_or_else(|| FORCE.into());
        }
        self.forget();
    }

    /// Takes the traces of these numbers, and compares anew.
    ///
    /// # Errors
    /// When there is no such trace, none is left, or something is at work.
    pub fn choose_traces(&mut self, numbers: &[usize]) -> Result<(), LabError> {
        self.check_idle()?;
        let unknown = |name: &usize| LabError::Unknown { what: "trace", name: name.to_string() };
        if let Some(beyond) = numbers.iter().find(|number| **number >= self.traces.len()) {
            return Err(unknown(beyond));
        }
        if numbers.is_empty() {
            return Err(LabError::NoTraces);
        }
        self.chosen = (0..self.traces.len()).map(|k| numbers.contains(&k)).collect();
        self.taken = if self.chosen.iter().all(|chosen| *chosen) {
            self.traces.clone()
        } else {
            let taken = self.traces.iter().zip(&self.chosen).filter(|(_, chosen)| **chosen);
            Arc::new(taken.map(|(trace, _)| trace.clone()).collect())
        };
        self.spans = Spans::of_set(&self.taken);
        self.forget();
        self.look()
    }

    /// Takes the column that the next fit fits.
    ///
    /// # Errors
    /// When not every trace has it.
    pub fn choose_signal(&mut self, signal: &str) -> Result<(), LabError> {
        if !self.signals().iter().any(|known| known == signal) {
            return Err(LabError::Unknown { what: "column", name: signal.into() });
        }
        self.signal = signal.into();
        if self.versions.is_empty() {
            self.forget();
        }
        Ok(())
    }

    /// Opens a model file of the folder.
    ///
    /// # Errors
    /// When it leads outside or is no model, or something is at work.
    pub fn open_model(&mut self, name: &str) -> Result<(), LabError> {
        self.check_idle()?;
        let folder = self.folder()?;
        let (model, file) = (Model::read(&folder.existing(name)?)?, folder.shown(name));
        self.take_model(model, file, Some(name.into()));
        self.look()
    }

    fn take_model(&mut self, model: Model, file: String, name: Option<String>) {
        let said = format!("opened {file}");
        self.signal.clone_from(&model.base.signal);
        let model = Arc::new(model);
        self.remember(Version { model, file, name, saved: true, command: None, said });
        self.forget();
    }

    /// Columns that can be fitted: those that every trace has, beside the displacement.
    fn signals(&self) -> Vec<String> {
        let Some(first) = self.traces.first() else { return Vec::new() };
        let everywhere = |name: &&str| self.traces.iter().all(|trace| trace.changing(name).is_ok());
        let names = first.columns.iter().map(|column| column.name.as_str());
        names.filter(|name| *name != DISPLACEMENT).filter(everywhere).map(str::to_owned).collect()
    }

    /// Forgets what was known of other traces or another model.
    fn forget(&mut self) {
        self.known = Known::default();
        self.failed = None;
    }

    /// Compares, if there is a model and traces.
    fn look(&mut self) -> Result<(), LabError> {
        if self.versions.is_empty() || self.traces.is_empty() {
            return Ok(());
        }
        self.start(Task::Compare)
    }

    /// Sets a task to work.
    ///
    /// # Errors
    /// When something is at work, or model, traces or folder are missing.
    pub fn start(&mut self, task: Task) -> Result<(), LabError> {
        self.check_idle()?;
        let mut task = task;
        if let Task::Hide(hide) = &mut task {
            // The seed is in the command, so that it makes the same set again.
            hide.seed.get_or_insert_with(seed_from_clock);
        }
        let practice = self.practice_name(&task)?;
        if self.taken.is_empty() && !task.needs_no_traces() {
            return Err(LabError::NoTraces);
        }
        if let Task::Fit(fit) = &task {
            fit.choice()?.laws()?;
        }
        let bench = Bench {
            folder: self.folder.clone(),
            traces: self.taken.clone(),
            model: self.versions.last().map(|version| version.model.clone()),
            signal: self.signal.clone(),
            next: NextCommand {
                model: self.versions.last().map_or_else(String::new, |v| v.file.clone()),
                traces: self.traces_named()?,
            },
            command: self.command(&task)?,
            written: self.next_file()?,
            other: self.other(&task)?,
            practice,
        };
        self.failed = None;
        self.job = Some(Job::new(task, bench));
        Ok(())
    }

    /// The command that does the same as a task.
    ///
    /// # Errors
    /// When it takes a model or a folder and there is none.
    pub fn command(&self, task: &Task) -> Result<String, LabError> {
        let (set, survey) = match task {
            Task::Open(set) | Task::Survey(set) => (set.clone(), String::new()),
            Task::Group { survey, group } => (group_folder(survey, *group), survey.clone()),
            _ => (self.practice_name(task)?.0, String::new()),
        };
        let names = Names {
            model: self.versions.last().map(|version| version.file.clone()),
            traces: self.traces_named()?,
            written: self.folder()?.shown(&self.next_file()?),
            signal: self.signal.clone(),
            other: self.other(task)?.map(|(_, file)| file),
            set: self.folder()?.shown(&set),
            survey: self.folder()?.shown(&survey),
        };
        task.command(&names)
    }

    /// The model that a task puts beside the one at hand, and its file.
    fn other(&self, task: &Task) -> Result<Option<(Arc<Model>, String)>, LabError> {
        let Task::Beside(other) = task else { return Ok(None) };
        let folder = self.folder()?;
        match other {
            Other::File(name) => {
                let model = Model::read(&folder.existing(name)?)?;
                Ok(Some((Arc::new(model), folder.shown(name))))
            }
            Other::Version(number) => {
                let unknown = || LabError::Unknown { what: "model", name: number.to_string() };
                let version = self.versions.get(*number).ok_or_else(unknown)?;
                Ok(Some((version.model.clone(), version.file.clone())))
            }
        }
    }

    fn practice_name(&self, task: &Task) -> Result<(String, u64), LabError> {
        let Task::Hide(hide) = task else { return Ok((String::new(), 0)) };
        let seed = hide.seed.unwrap_or_else(seed_from_clock);
        let sets = self.folder()?.sets()?;
        let mut free = (1..).map(|number| match number {
            1 => format!("practice-{seed}"),
            _ => format!("practice-{seed}-{number}"),
        });
        let name = free.find(|name| !sets.contains(name)).unwrap_or_default();
        Ok((name, seed))
    }

    /// The traces taken, as a command takes them: the folder where it is all of them.
    fn traces_named(&self) -> Result<String, LabError> {
        let folder = self.folder()?;
        if Folder::is_recording(&self.set) {
            // A command takes all stretches of a recording.
            return Ok(folder.shown(&self.set));
        }
        if self.left_out.is_empty() && self.chosen.iter().all(|chosen| *chosen) {
            return Ok(folder.shown(&self.set));
        }
        let file = |trace: &Trace| match self.set.as_str() {
            "" => folder.shown(&trace.label()),
            set => folder.shown(&format!("{set}/{}", trace.label())),
        };
        Ok(self.taken.iter().map(file).collect::<Vec<_>>().join(" "))
    }

    /// A model file that is not there yet.
    fn next_file(&self) -> Result<String, LabError> {
        let folder = self.folder()?;
        let there = folder.models()?;
        let taken = |name: &String| {
            there.contains(name) || self.versions.iter().any(|v| v.file == folder.shown(name))
        };
        let mut names = (1..).map(|number| format!("model-{number}.toml"));
        Ok(names.find(|name| !taken(name)).unwrap_or_default())
    }

    fn check_idle(&mut self) -> Result<(), LabError> {
        self.settle();
        if self.job.is_some() { Err(LabError::Busy) } else { Ok(()) }
    }

    /// Gives up what is at work; what was known stays.
    pub fn cancel(&mut self) {
        self.settle();
        if let Some(job) = self.job.take() {
            job.cancel();
            self.failed = Some(LabError::Cancelled.to_string());
        }
    }

    /// Takes in the outcome of a task that is done.
    pub fn settle(&mut self) {
        if !self.job.as_ref().is_some_and(Job::done) {
            return;
        }
        let Some(job) = self.job.take() else { return };
        let (task, command, written) =
            (job.task().clone(), job.command.clone(), job.written.clone());
        let taken = |outcome| self.take(&task, command, written, outcome);
        if let Err(error) = job.outcome().and_then(taken) {
            self.failed = Some(error.to_string());
        }
    }

    fn take(
        &mut self,
        task: &Task,
        command: String,
        written: String,
        outcome: Outcome,
    ) -> Result<(), LabError> {
        if let Some(set) = outcome.set {
            self.take_set(set);
            self.versions.clear();
            return Ok(());
        }
        if outcome.beside.is_some() {
            self.known.beside = outcome.beside;
            return Ok(());
        }
        if outcome.survey.is_some() {
            self.survey = outcome.survey;
            return Ok(());
        }
        if let Some(model) = outcome.model {
            let (file, name) = (self.folder()?.shown(&written), Some(written));
            let said = match task {
                Task::Fit(fit) => fit.law.clone(),
                Task::Add { effect, .. } => format!("+ {effect}"),
                Task::Drop { effect } => format!("− {effect}"),
                Task::Discover => "formulas".into(),
                _ => "explored".into(),
            };
            let (model, command) = (Arc::new(model), Some(command));
            self.remember(Version { model, file, name, saved: false, command, said });
            // Formulas wait beside the model: it predicts what it did.
            if *task != Task::Discover {
                self.known = Known::default();
            }
        }
        if outcome.compared.is_some() {
            self.known.compared = outcome.compared;
        }
        if let Some((diagnosis, candidates)) = outcome.diagnosis {
            self.known.answers.insert("candidates".into(), candidates);
            self.known.forecast = None;
            self.known.diagnosis = Some(diagnosis);
        }
        let name = match task {
            Task::Fit(_) => "fit",
            Task::Diagnose | Task::Explore => "diagnosis",
            Task::Add { .. } | Task::Drop { .. } => "change",
            Task::Discover => "discovery",
            Task::Motion => "motion",
            Task::Compare
            | Task::Beside(_)
            | Task::Hide(_)
            | Task::Open(_)
            | Task::Survey(_)
            | Task::Group { .. } => {
                self.keep(outcome.report);
                return Ok(());
            }
        };
        self.known.answers.insert(name.into(), outcome.answer);
        self.keep(outcome.report);
        Ok(())
    }

    fn keep(&mut self, report: Option<(&'static str, String)>) {
        if let Some((kind, page)) = report {
            self.known.reports.retain(|(known, _)| *known != kind);
            self.known.reports.push((kind, page));
        }
    }

    /// Puts a law of one's own beside the model, so that it can be tried: a candidate.
    ///
    /// # Errors
    /// When something is wrong with it, there is no model, or something is at work.
    pub fn add_candidate(&mut self, law: &OwnLaw) -> Result<(), LabError> {
        self.check_idle()?;
        if let Some(fault) = law.fault() {
            return Err(LabError::Law(fault["message"].as_str().unwrap_or_default().into()));
        }
        let stored = law.stored();
        let mut model = Model::clone(self.model()?);
        if model.effects.iter().any(|effect| effect.name == stored.name) {
            return Err(LabError::Law(format!("`{}` is in the model already", stored.name)));
        }
        model.candidates.retain(|own| own.name != stored.name);
        model.candidates.push(stored);
        let name = self.next_file()?;
        let (file, name) = (self.folder()?.shown(&name), Some(name));
        let (said, model) = (format!("law {}", law.name), Arc::new(model));
        // The model predicts what it did: what is known of it stays, but for what could be added.
        self.known.diagnosis = None;
        self.known.forecast = None;
        self.known.answers.clear();
        self.remember(Version { model, file, name, saved: false, command: None, said });
        Ok(())
    }

    /// Goes back to the model before, and compares it.
    ///
    /// # Errors
    /// When there is none, or something is at work.
    pub fn undo(&mut self) -> Result<(), LabError> {
        self.check_idle()?;
        if self.versions.len() < 2 {
            return Err(LabError::NothingToUndo);
        }
        self.versions.pop();
        self.forget();
        self.look()
    }

    /// Writes the model file, in the folder that was opened; under the name that the commands give it
    /// where none is given. Answers with that name.
    ///
    /// # Errors
    /// When there is no model, the name leads outside or ends otherwise than in `.toml`, or the file cannot
    /// be written.
    pub fn save(&mut self, name: Option<&str>) -> Result<Value, LabError> {
        self.settle();
        let folder = self.folder()?;
        let fresh = match name {
            Some(name) => name.to_owned(),
            None => self.own_name()?,
        };
        if Path::new(&fresh).extension().is_none_or(|extension| extension != "toml") {
            return Err(LabError::Law(format!("`{fresh}`: the name must end in .toml")));
        }
        let (path, shown) = (folder.to_write(&fresh)?, folder.shown(&fresh));
        if path.exists() && !MODEL.may_replace(&path) {
            return Err(LabError::Foreign(fresh));
        }
        self.model()?.write(&path)?;
        if let Some(version) = self.versions.last_mut() {
            (version.file, version.name, version.saved) = (shown.clone(), Some(fresh), true);
        }
        Ok(json!({"file": shown}))
    }

    /// The name of the model at hand; another where it was never written and a file has come to be there.
    fn own_name(&self) -> Result<String, LabError> {
        let there = self.folder()?.models()?;
        let free = |version: &&Version| {
            version.saved || version.name.as_ref().is_some_and(|name| !there.contains(name))
        };
        let own = self.versions.last().filter(free).and_then(|version| version.name.clone());
        own.map_or_else(|| self.next_file(), Ok)
    }

    /// The relaxation function of the model at hand, for the filter of a device.
    ///
    /// # Errors
    /// When there is no model, or a hold of it is not of one or two exponentials.
    pub fn relaxation(&mut self) -> Result<Value, LabError> {
        self.settle();
        let Relaxation { c1, v1, c2, v2 } = relaxation_of(self.model()?)?;
        Ok(json!({ "c1": c1, "v1": v1, "c2": c2, "v2": v2 }))
    }

    /// Takes the other model away.
    pub fn alone(&mut self) {
        self.settle();
        self.known.beside = None;
    }
}
