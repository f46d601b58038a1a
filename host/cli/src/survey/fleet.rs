//! What every survey needs: which traces, grouped by what, and where the results go.

use std::collections::BTreeMap;
use std::io;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::thread;

use serde_json::{Map, Value};

use super::asking::Asking;
use super::call;
use super::report::Found;
use crate::output::{Output, command_of};
use crate::{Failure, progress};
use palpate_fit::watch;
use palpate_model::Model;
use palpate_survey::results::{About, Plan, Results, ResultsError};
use palpate_survey::run::{Question, run};
use palpate_survey::{By, Contents, Group, Names, Row, SourceError, Sources, Worked};
use palpate_trace::many;

/// Which traces, grouped by what, and where the results go.
#[derive(clap::Args)]
pub struct Fleet {
    /// Traces, recordings, Parquet files with many traces, or folders of these, however deep
    #[arg(required = true, value_name = "DATA")]
    data: Vec<PathBuf>,
    /// What traces are grouped by: keys, with commas between them
    #[arg(long, required = true, value_name = "KEY,...", value_delimiter = ',')]
    by: Vec<String>,
    /// Keys in the names of files, counted from the end of the path: {finger} is one, * anything
    #[arg(long, value_name = "PATTERN")]
    names: Option<Names>,
    /// The column of a Parquet file that says of which trace a row is
    #[arg(long, value_name = "COLUMN", default_value = "trace_id")]
    trace_id: String,
    /// What columns of a Parquet file with many traces are called in a trace; a list has a column for each of its places
    #[arg(long, value_name = "COLUMN=NAME,...", value_delimiter = ',', value_parser = called)]
    columns: Vec<(String, String)>,
    /// Folder of the results: a new one, or one of the same survey, which goes on
    #[arg(short, long, required = true, value_name = "DIR")]
    output: PathBuf,
    /// Groups at a time [default: one for each processor]
    #[arg(short, long, value_name = "N")]
    jobs: Option<NonZeroUsize>,
    #[command(flatten)]
    result: Output,
}

/// A model file that is asked about.
pub struct Given<'a> {
    path: &'a Path,
    contents: String,
}

impl<'a> Given<'a> {
    /// A model and where it is.
    pub fn new(path: &'a Path, model: &Model) -> Result<Self, Failure> {
        let contents = model.to_toml();
        let contents = contents.map_err(|why| Failure::Work(miette::miette!("{why}")))?;
        Ok(Self { path, contents })
    }
}

/// A question to every group.
pub struct Survey<'a> {
    fleet: &'a Fleet,
    given: Option<Given<'a>>,
    seeds: BTreeMap<String, u64>,
    question: Asking<'a>,
}

impl<'a> Survey<'a> {
    /// A question that depends on no model and no seed.
    pub fn new(fleet: &'a Fleet, question: Asking<'a>) -> Self {
        Self { fleet, given: None, seeds: BTreeMap::new(), question }
    }

    /// The same where rows depend on a model.
    pub fn of(self, given: Option<Given<'a>>) -> Self {
        Self { given, ..self }
    }

    /// The same where rows depend on seeds, each by what it is for.
    pub fn with<const COUNT: usize>(self, seeds: [(&str, u64); COUNT]) -> Self {
        let seeds = seeds.map(|(name, seed)| (name.to_owned(), seed)).into();
        Self { seeds, ..self }
    }

    /// Asks every group that has no row yet. `words` are those of the call, the name of the program apart.
    pub fn ask(&self, words: &[String]) -> Result<(), Failure> {
        let mut results = self.begin(words)?;
        let missing = results.missing();
        let wait = progress::bar(missing.len(), "groups");
        watch::stage("groups", missing.len());
        let watch = watch::current();
        let mut failed = None;
        let done = self.rows(missing.into_iter(), self.fleet.jobs(), |row, worked| {
            wait.inc(1);
            watch.iter().for_each(|watch| watch.done());
            results.add(row, worked).map_err(|error| {
                failed = Some(error);
                io::Error::other("the results cannot be kept")
            })
        });
        wait.finish_and_clear();
        match failed {
            Some(error) => Err(wrong(error)),
            None => done.map_err(Failure::work),
        }
    }

    /// Finds the groups, and begins the folder of the results or goes on with it.
    pub fn begin(&self, words: &[String]) -> Result<Results, Failure> {
        self.begin_with(words, |by| Sources::find(&self.fleet.data, by))
    }

    /// Begins the folder of the results of files whose contents are known or goes on with it.
    pub fn begin_of(&self, words: &[String], files: Vec<Contents>) -> Result<Results, Failure> {
        self.begin_with(words, |by| Sources::of(files.into_iter().map(Ok), by))
    }

    fn begin_with(
        &self,
        words: &[String],
        find: impl FnOnce(&By) -> Result<Sources, SourceError>,
    ) -> Result<Results, Failure> {
        let Fleet { data, output, result, .. } = self.fleet;
        let read = data.iter().map(PathBuf::as_path);
        result.files(read.chain(self.given.iter().map(|given| given.path)))?;
        let by = self.fleet.by();
        let plan = Plan {
            asked: self.question.asked(),
            by: by.keys.clone(),
            options: self.options(words)?,
            command: command_of(words),
            seeds: self.seeds.clone(),
            sources: find(&by).map_err(Failure::input)?,
        };
        Results::begin(output, plan, result.over().allowed).map_err(wrong)
    }

    /// What was given as data.
    pub fn data(&self) -> &[PathBuf] {
        &self.fleet.data
    }

    /// What one file holds.
    pub fn contents(&self, file: &Path) -> Result<Contents, Failure> {
        Contents::of(file, &self.fleet.by()).map_err(Failure::input)
    }

    /// Every option that rows depend on, with its value.
    pub fn options(&self, words: &[String]) -> Result<Map<String, Value>, Failure> {
        let mut options = call::options(words)?;
        if let Some(given) = &self.given {
            options.insert("the model".into(), given.contents.clone().into());
        }
        Ok(options)
    }

    /// The rows of these groups, `jobs` of them at a time, each as soon as it is there.
    pub fn rows(
        &self,
        groups: impl Iterator<Item = Group> + Send,
        jobs: NonZeroUsize,
        done: impl FnMut(Row, Worked) -> io::Result<()> + Send,
    ) -> io::Result<()> {
        let By { keys, id, .. } = self.fleet.by();
        let beside = keys.into_iter().chain([id]).collect();
        let names = many::Names { beside, called: self.fleet.columns.clone() };
        run(groups, names, &self.question, jobs, done)
    }

    /// What all rows say.
    pub fn found(&self) -> Result<Found, Failure> {
        Found::read(&self.fleet.output)
    }

    /// Prints what all rows say as the call wants it.
    pub fn tell(&self) -> Result<(), Failure> {
        self.fleet.result.show(&self.found()?)
    }
}

impl Fleet {
    fn by(&self) -> By {
        By { keys: self.by.clone(), names: self.names.clone(), id: self.trace_id.clone() }
    }

    fn jobs(&self) -> NonZeroUsize {
        self.jobs.unwrap_or_else(|| thread::available_parallelism().unwrap_or(NonZeroUsize::MIN))
    }
}

/// The name of a column in a file and in a trace.
fn called(pair: &str) -> Result<(String, String), String> {
    let (from, to) = pair.split_once('=').ok_or("say COLUMN=NAME, as in timestamp=time_s")?;
    Ok((from.into(), to.into()))
}

/// What a survey asked, and by which keys: the line below the title of its reports.
pub fn asked_of(about: &About) -> String {
    format!("{} by {}", about.asked.word(), about.by.join(", "))
}

/// What the file system refuses is no fault of the call.
pub fn wrong(error: ResultsError) -> Failure {
    match error {
        ResultsError::Io { .. } => Failure::work(error),
        _ => Failure::input(error),
    }
}
