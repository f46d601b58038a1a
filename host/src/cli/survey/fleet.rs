//! What every survey needs: which traces, grouped by what, and where the results go.

use std::io;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::thread;

use serde_json::{Map, Value};

use super::asking::Asking;
use super::call;
use crate::cli::output::{Output, command_line};
use crate::cli::{Failure, progress};
use crate::model::Model;
use crate::survey::results::{Plan, Results, ResultsError};
use crate::survey::run::{Question, run};
use crate::survey::{By, Names, Sources};

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
    /// Where it is.
    pub path: &'a Path,
    /// What is in it.
    pub model: &'a Model,
}

impl Fleet {
    /// Asks every group that has no row yet, and tells what all rows say. Rows depend on the model and on seeds where some are
    /// given.
    pub fn ask(
        &self,
        given: Option<&Given>,
        seeds: Map<String, Value>,
        question: &Asking,
    ) -> Result<(), Failure> {
        self.result.files(self.data.iter().map(PathBuf::as_path).chain(given.map(|it| it.path)))?;
        let by = By { keys: self.by.clone(), names: self.names.clone(), id: self.trace_id.clone() };
        let sources = Sources::find(&self.data, &by).map_err(Failure::input)?;
        let mut options = call::options()?;
        if let Some(given) = given {
            let contents =
                given.model.to_toml().map_err(|why| Failure::Work(miette::miette!("{why}")))?;
            options.insert("the model".into(), contents.into());
        }
        let asked = question.asked();
        let command = command_line();
        let plan = Plan { asked, by: by.keys.clone(), options, command, seeds, sources };
        let anew = self.result.over().allowed;
        let mut results = Results::begin(&self.output, plan, anew).map_err(wrong)?;
        self.fill(&mut results, &by, question)?;
        drop(results);
        super::report::tell(&self.output, &self.result)
    }

    /// Asks every group that has no row yet.
    fn fill(&self, results: &mut Results, by: &By, question: &Asking) -> Result<(), Failure> {
        let missing = results.missing();
        let wait = progress::bar(missing.len(), "groups");
        let names = by.keys.iter().cloned().chain([by.id.clone()]).collect();
        let processors = thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
        let jobs = self.jobs.unwrap_or(processors);
        let mut failed = None;
        let done = run(missing.into_iter(), names, question, jobs, |row, worked| {
            wait.inc(1);
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
}

/// What the file system refuses is no fault of the call.
pub fn wrong(error: ResultsError) -> Failure {
    match error {
        ResultsError::Io { .. } => Failure::work(error),
        _ => Failure::input(error),
    }
}
