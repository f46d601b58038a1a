//! A survey for programs that link the library: of this process, or with rows that are made in others, on any machine that
//! sees the same files by the same names.
//!
//! Who calls opens the folder of the results, takes task after task from it, has each of them worked off by whatever engine
//! there is, and gives the rows back in any order. The folder is the one that the command fills: either goes on with what the
//! other left.

use std::collections::{HashSet, VecDeque};
use std::io::{self, Write};
use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Parser;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::fleet::wrong;
use super::{Question, Survey};
use crate::answer::Answer;
use crate::ask::refused;
use crate::{Arguments, Command, Failure, output};
use palpate_survey::results::Results;
use palpate_survey::row::{Said, Status};
use palpate_survey::{Group, Row, Worked};

/// A call of `palpate survey` that asks groups something.
pub struct Call {
    words: Vec<String>,
    question: Question,
}

impl Call {
    /// The call of these words, which stand after `palpate survey`.
    ///
    /// # Errors
    /// As the command; and when the words ask no group anything, as `report` does.
    pub fn new(words: &[String]) -> Result<Self, Failure> {
        let words: Vec<String> = ["survey".into()].iter().chain(words).cloned().collect();
        let all = ["palpate".to_owned()].into_iter().chain(words.iter().cloned());
        let arguments = Arguments::try_parse_from(all).map_err(|error| refused(&error))?;
        let Command::Survey(args) = arguments.command else {
            return Err(Failure::Input(miette::miette!("this is no call of `palpate survey`")));
        };
        let call = Self { words, question: args.question };
        call.survey().map(drop)?;
        Ok(call)
    }

    fn survey(&self) -> Result<Survey<'_>, Failure> {
        self.question.survey()
    }

    /// Asks every group that has no row yet, in this process.
    ///
    /// # Errors
    /// As the command, and when the work is asked to end.
    pub fn ask(&self) -> Result<(), Failure> {
        self.survey()?.ask(&self.words)
    }

    /// Opens the folder of the results for rows that are made elsewhere.
    ///
    /// # Errors
    /// As the command.
    pub fn open(&self) -> Result<Open, Failure> {
        self.opened(self.survey()?.begin(&self.words)?)
    }

    /// The same where the files are seen elsewhere alone: with what tasks of [`Call::look`] gave for each, in their order.
    ///
    /// # Errors
    /// As the command, and when that is not what was given.
    pub fn open_of(&self, files: &[String]) -> Result<Open, Failure> {
        let contents = |text: &String| serde_json::from_str(text).map_err(Failure::work);
        let files = files.iter().map(contents).collect::<Result<_, _>>()?;
        self.opened(self.survey()?.begin_of(&self.words, files)?)
    }

    /// What was given as data.
    ///
    /// # Errors
    /// When a name is no Unicode.
    pub fn data(&self) -> Result<Vec<String>, Failure> {
        let survey = self.survey()?;
        let text = |path: &PathBuf| path.to_str().map(str::to_owned);
        let data = survey.data().iter().map(text).collect::<Option<_>>();
        data.ok_or_else(|| Failure::Input(miette::miette!("the name of a file is no Unicode")))
    }

    /// A task for [`work`] that asks nothing yet: what each of these files holds, as it is seen where the task is worked off.
    ///
    /// # Errors
    /// When the name of a file is no Unicode.
    pub fn look(&self, files: Vec<PathBuf>) -> Result<String, Failure> {
        let (version, words) = (env!("CARGO_PKG_VERSION").to_owned(), self.words.clone());
        serde_json::to_string(&Look { version, words, files }).map_err(Failure::input)
    }

    fn opened(&self, results: Results) -> Result<Open, Failure> {
        let survey = self.survey()?;
        let missing = results.missing().into();
        let options = survey.options(&self.words)?;
        let folder = std::env::current_dir().map_err(Failure::work)?;
        let (words, handed_out) = (self.words.clone(), HashSet::new());
        Ok(Open { words, options, folder, results, missing, handed_out })
    }

    /// What all rows say.
    ///
    /// # Errors
    /// When the results cannot be read.
    pub fn found(&self) -> Result<Box<dyn Answer>, Failure> {
        Ok(Box::new(self.survey()?.found()?))
    }

    /// Prints what all rows say and writes the report, as the command does at its end.
    ///
    /// # Errors
    /// As the command.
    pub fn tell(&self) -> Result<(), Failure> {
        let all = ["palpate"].into_iter().chain(self.words.iter().map(String::as_str));
        output::remember_call(&all.map(Into::into).collect::<Vec<_>>());
        self.survey()?.tell()
    }
}

/// A folder of results that waits for rows. No other survey writes into it while this is there.
pub struct Open {
    words: Vec<String>,
    options: Map<String, Value>,
    folder: PathBuf,
    results: Results,
    missing: VecDeque<Group>,
    /// Numbers of the groups that are in a task and have no row yet.
    handed_out: HashSet<u64>,
}

/// Some groups, with all that their rows depend on besides files.
#[derive(Serialize, Deserialize)]
struct Task {
    /// Version of palpate.
    version: String,
    /// The words of the call.
    words: Vec<String>,
    /// The options that they meant where the survey was called, the text of the model among them.
    options: Map<String, Value>,
    /// The folder of the call, from which the names of files count.
    folder: PathBuf,
    /// How often the first group was tried before.
    tried: u64,
    groups: Vec<Group>,
}

/// Files whose contents a survey has to know.
#[derive(Serialize, Deserialize)]
struct Look {
    version: String,
    words: Vec<String>,
    files: Vec<PathBuf>,
}

impl Open {
    /// Number of groups that are in no task yet.
    #[must_use]
    pub fn left(&self) -> usize {
        self.missing.len()
    }

    /// The next task of at most so many groups, as JSON; none where all are in one. It is to be worked off in its `folder`.
    ///
    /// # Errors
    /// When the name of a file is no Unicode.
    pub fn next_task(&mut self, most: usize) -> Result<Option<String>, Failure> {
        let count = most.min(self.missing.len());
        let groups: Vec<Group> = self.missing.drain(..count).collect();
        self.handed_out.extend(groups.iter().map(|group| group.number));
        let (words, options) = (self.words.clone(), self.options.clone());
        let (version, folder) = (env!("CARGO_PKG_VERSION").to_owned(), self.folder.clone());
        text(&Task { version, words, options, folder, tried: 0, groups })
    }

    /// Keeps a row that [`work`] or [`gave_up`] gave: when this returns it survives the end of the process. False, and nothing is
    /// kept, where the group has a row already or is in no task: an engine may do a task twice. Either way with what it cost.
    ///
    /// # Errors
    /// When it is no row, and what the file system answers.
    pub fn keep(&mut self, row: &str) -> Result<(bool, Worked), Failure> {
        let (row, worked): (Row, Worked) = serde_json::from_str(row).map_err(Failure::work)?;
        let is_new = self.handed_out.remove(&row.group);
        if is_new {
            self.results.add(row, worked).map_err(wrong)?;
        }
        Ok((is_new, worked))
    }
}

/// What a worker is given.
#[derive(Deserialize)]
#[serde(untagged)]
enum Part {
    Groups(Task),
    Files(Look),
}

/// Works off a task on one thread: a row of each group in their order, or what each file holds, on a line of its own, as soon as
/// it is there.
///
/// # Errors
/// When the task was made by another version of palpate or with another text of the model than is read here, a file that is
/// looked into tells no key of a trace, and what `out` answers. What is wrong with a group is in its row.
pub fn work(task: &str, out: impl Write + Send) -> Result<(), Failure> {
    match serde_json::from_str(task).map_err(Failure::input)? {
        Part::Groups(task) => rows(task, out),
        Part::Files(look) => contents(&look, out),
    }
}

fn rows(task: Task, mut out: impl Write + Send) -> Result<(), Failure> {
    let Task { version, words, options, mut tried, groups, .. } = task;
    let call = called(&version, &words)?;
    let survey = call.survey()?;
    if survey.options(&words)? != options {
        return Err(Failure::Input(miette::miette!(
            "this worker reads another model by that name than the survey was called with"
        )));
    }
    let done = |row, mut worked: Worked| {
        worked.attempts += std::mem::take(&mut tried);
        writeln!(out, "{}", line(&row, worked)?)?;
        out.flush()
    };
    survey.rows(groups.into_iter(), NonZeroUsize::MIN, done).map_err(Failure::work)
}

fn contents(look: &Look, mut out: impl Write) -> Result<(), Failure> {
    let call = called(&look.version, &look.words)?;
    let survey = call.survey()?;
    look.files.iter().try_for_each(|file| {
        let contents = serde_json::to_string(&survey.contents(file)?).map_err(Failure::input)?;
        writeln!(out, "{contents}").and_then(|()| out.flush()).map_err(Failure::work)
    })
}

/// The call that a worker has a part of.
fn called(version: &str, words: &[String]) -> Result<Call, Failure> {
    let here = env!("CARGO_PKG_VERSION");
    if version != here {
        return Err(Failure::Input(miette::miette!(
            "the survey was called with palpate {version}, this worker has {here}"
        )));
    }
    Call::new(words.get(1..).unwrap_or_default())
}

/// A task without the groups whose rows are there, and how often the first of those left was tried; none where none is left.
///
/// # Errors
/// When this is no task.
pub fn rest(task: &str, rows: usize, tried: u64) -> Result<Option<String>, Failure> {
    let mut task = read(task)?;
    task.groups.drain(..rows.min(task.groups.len()));
    task.tried = tried;
    text(&task)
}

/// The row of the first group of a task that ended every process that tried it.
///
/// # Errors
/// When this is no task with a group.
pub fn gave_up(task: &str, attempts: u64, why: &str) -> Result<String, Failure> {
    let task = read(task)?;
    let group = task.groups.into_iter().next();
    let group = group.ok_or_else(|| Failure::Input(miette::miette!("a task without a group")))?;
    let row = Row {
        group: group.number,
        key: group.key,
        status: Status::Failed,
        reason: Some(format!("gave up {attempts} times: {why}")),
        traces: 0,
        samples: 0,
        said: Said::default(),
    };
    line(&row, Worked { seconds: 0.0, attempts }).map_err(Failure::work)
}

fn read(task: &str) -> Result<Task, Failure> {
    serde_json::from_str(task).map_err(Failure::input)
}

/// A task as JSON; none without a group.
fn text(task: &Task) -> Result<Option<String>, Failure> {
    if task.groups.is_empty() {
        return Ok(None);
    }
    serde_json::to_string(task).map(Some).map_err(Failure::input)
}

fn line(row: &Row, worked: Worked) -> io::Result<String> {
    Ok(serde_json::to_string(&(row, worked))?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::path::Path;

    fn words(of: &str) -> Vec<String> {
        of.split(' ').map(str::to_owned).collect()
    }

    /// Five fingers, the third of which has no trace.
    fn lab(folder: &Path) -> String {
        let press = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/traces/press.csv");
        for finger in 1..=5 {
            let own = folder.join(format!("lab/finger={finger}"));
            fs::create_dir_all(&own).unwrap();
            if finger == 3 {
                fs::write(own.join("press.csv"), "no trace").unwrap();
            } else {
                fs::copy(&press, own.join("press.csv")).unwrap();
            }
        }
        folder.join("lab").display().to_string()
    }

    fn groups(results: &Path) -> Vec<u8> {
        fs::read(results.join("groups/part-00000.parquet")).unwrap()
    }

    #[test]
    fn rows_made_elsewhere_make_the_bytes_of_rows_made_here() {
        let folder = tempfile::tempdir().unwrap();
        let lab = lab(folder.path());
        let at = |name: &str| folder.path().join(name);
        let call = |out: &str| {
            let out = at(out).display().to_string();
            Call::new(&words(&format!("segment {lab} --by finger -o {out}"))).unwrap()
        };
        call("here").ask().unwrap();
        let apart = call("apart");
        let mut open = apart.open().unwrap();
        let tasks: Vec<_> = std::iter::from_fn(|| open.next_task(2).unwrap()).collect();
        assert_eq!((tasks.len(), open.left()), (3, 0));
        // The last comes first, and one group ended the process that tried it: the rest of its task is done by another.
        for task in tasks.iter().rev() {
            let mut rows = Vec::new();
            work(task, &mut rows).unwrap();
            let rows = String::from_utf8(rows).unwrap();
            let left = rest(task, 1, 1).unwrap();
            for row in rows.lines().take(if left.is_some() { 1 } else { 2 }) {
                assert!(open.keep(row).unwrap().0);
                assert!(!open.keep(row).unwrap().0, "it came twice");
            }
            let mut rows = Vec::new();
            left.map_or(Ok(()), |left| work(&left, &mut rows)).unwrap();
            String::from_utf8(rows)
                .unwrap()
                .lines()
                .for_each(|row| assert!(open.keep(row).unwrap().0));
        }
        drop(open);
        assert_eq!(groups(&at("apart")), groups(&at("here")));
        let json = apart.found().unwrap().json();
        assert_eq!((&json["done"], &json["refused"]), (&4.into(), &1.into()));
    }

    #[test]
    fn a_group_that_ends_its_process_is_a_row_that_says_so() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out").display().to_string();
        let call = format!("segment {} --by finger -o {out}", lab(folder.path()));
        let mut open = Call::new(&words(&call)).unwrap().open().unwrap();
        let task = open.next_task(9).unwrap().unwrap();
        let row = gave_up(&task, 2, "it was ended by signal 9").unwrap();
        let (row, worked): (Row, Worked) = serde_json::from_str(&row).unwrap();
        assert_eq!((row.group, row.key), (0, vec![Some("1".into())]));
        assert_eq!((row.status, worked.attempts), (Status::Failed, 2));
        assert_eq!(row.reason.as_deref(), Some("gave up 2 times: it was ended by signal 9"));
        assert!(rest(&task, 5, 0).unwrap().is_none());
    }

    #[test]
    fn what_a_worker_would_do_otherwise_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let (lab, out) = (lab(folder.path()), folder.path().join("out").display().to_string());
        let mut open = Call::new(&words(&format!("segment {lab} --by finger -o {out}")))
            .unwrap()
            .open()
            .unwrap();
        let task = open.next_task(9).unwrap().unwrap();
        let wrong = |from: &str, to: &str| {
            assert!(task.contains(from), "{task}");
            work(&task.replacen(from, to, 1), io::sink()).unwrap_err().words()
        };
        let version = env!("CARGO_PKG_VERSION");
        let said = wrong(&format!("\"version\":\"{version}\""), "\"version\":\"9\"");
        assert!(said.contains("palpate 9, this worker has"), "{said}");
        let said = wrong("\"--by\":\"finger\"", "\"--by\":\"trace\"");
        assert!(said.contains("another model"), "{said}");
        let mut empty: Value = serde_json::from_str(&task).unwrap();
        empty["words"] = serde_json::json!([]);
        assert!(work(&empty.to_string(), io::sink()).is_err() && work("{}", io::sink()).is_err());
        let asks_nothing = Call::new(&words("report results")).err().unwrap().words();
        assert!(asks_nothing.contains("asks no group"), "{asks_nothing}");
    }
}
