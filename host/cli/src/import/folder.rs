//! `palpate import FOLDER`: every recording in a folder, and every table in it, becomes a trace.

use std::fs;
use std::path::{Path, PathBuf};

use miette::miette;

use super::{Args, Failure, input, preview, report, stem, summary};
use crate::output::print;
use palpate_trace::files::plan::{Plan, TRACE};
use palpate_trace::files::write_whole;
use palpate_trace::{self as trace, Error, ImportError, Imported, Mapping, read_set};

/// A table of a file.
struct Table {
    file: PathBuf,
    part: Option<String>,
    /// What its trace and its mapping are called, without their endings.
    name: String,
}

/// What became of it.
enum Outcome {
    /// Traces, and what is to be said of each.
    Made(Vec<String>),
    /// The file is a trace, or several, as it stands.
    Own,
    /// The mapping lacks what the file does not say.
    Open(String),
}

/// Imports every table of every file in a folder by its mapping: that of the call, the one beside the traces, or the one that is
/// proposed where it leaves nothing open.
pub(super) fn import(folder: &Path, args: &Args) -> Result<(), Failure> {
    if args.part.is_some() {
        let words = "`--part` names a table of one file; of a folder every table is taken";
        return Err(Failure::Input(miette!("{words}")));
    }
    let into = args.output.clone().unwrap_or_else(|| default_folder(folder));
    let tables = tables(&files(folder)?);
    let (mut made, mut left) = (0, 0);
    for table in &tables {
        match table.outcome(&into, args) {
            Ok(Outcome::Made(said)) => {
                made += said.len();
                said.iter().for_each(|said| eprintln!("{said}"));
            }
            Ok(Outcome::Own) => eprintln!("{}: is a trace as it is", table.file.display()),
            Ok(Outcome::Open(said)) => {
                left += 1;
                eprintln!("! {said}");
            }
            Err(failure) => {
                left += 1;
                eprintln!("! {}", failure.words());
            }
        }
    }
    let shown = into.display();
    match (made, left) {
        (_, 0) if args.preview => Ok(()),
        (_, 0) => print(&format!("{made} traces in {shown}\n")),
        _ => Err(Failure::Input(miette!(
            "{left} of {} tables did not come in. Complete the mappings in {shown} that are named above and make the same call again.",
            tables.len()
        ))),
    }
}

/// `lab/` becomes `lab.traces` in the current folder.
fn default_folder(folder: &Path) -> PathBuf {
    let real = folder.canonicalize();
    let name = real.as_deref().unwrap_or(folder).file_name();
    let mut name = name.unwrap_or_default().to_os_string();
    name.push(".traces");
    name.into()
}

/// The files of a folder by name, without hidden ones and without mappings, models and the like.
fn files(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let open = |source| input(&ImportError::File(Error::Open { path: folder.into(), source }));
    let hidden =
        |path: &Path| path.file_name().is_none_or(|name| name.to_string_lossy().starts_with('.'));
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(open)? {
        let path = entry.map_err(open)?.path();
        if path.is_file() && !hidden(&path) && !trace::has_extension(&path, "toml") {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// The tables of the files, each under a name of its own.
fn tables(files: &[PathBuf]) -> Vec<Table> {
    let mut found: Vec<Table> = Vec::new();
    for file in files {
        let parts = match trace::propose(file, None) {
            Err(ImportError::File(Error::WhichPart { present, .. })) => {
                present.into_iter().map(Some).collect()
            }
            _ => vec![None],
        };
        for part in parts {
            let name = free(file, part.as_deref(), &found);
            found.push(Table { file: file.clone(), part, name });
        }
    }
    found
}

/// `press` of `press.mat`, `press-mat` where another file has that name, and then with a number; behind it the name of the part.
fn free(file: &Path, part: Option<&str>, taken: &[Table]) -> String {
    let plain = |text: &str| -> String {
        let letter = |c: char| if c.is_alphanumeric() || c == '_' { c } else { '-' };
        text.chars().map(letter).collect::<String>().trim_matches('-').into()
    };
    let whole = plain(&file.file_name().unwrap_or_default().to_string_lossy());
    let part = part.map_or_else(String::new, |part| format!("-{}", plain(part)));
    let short = format!("{}{part}", stem(file).to_string_lossy());
    let numbered = (2..).map(|number| format!("{whole}{part}-{number}"));
    let mut names = [short.clone(), format!("{whole}{part}")].into_iter().chain(numbered);
    let is_free = |name: &String| taken.iter().all(|other| other.name != *name);
    names.find(is_free).unwrap_or(short)
}

impl Table {
    fn outcome(&self, into: &Path, args: &Args) -> Result<Outcome, Failure> {
        if self.part.is_none() && read_set(&[&self.file]).is_ok() {
            return Ok(Outcome::Own);
        }
        let mut mapping = match self.mapping(into, args)? {
            Ok(mapping) => args.adjusted(mapping),
            Err(open) => return Ok(Outcome::Open(open)),
        };
        mapping.table.part = self.part.clone().or(mapping.table.part);
        let file = std::slice::from_ref(&self.file);
        let tests = trace::import_tests(file, &mapping).map_err(|error| input(&error))?;
        let outputs = trace::places(&into.join(format!("{}.trace.csv", self.name)), tests.len());
        let placed = || tests.iter().zip(&outputs);
        if args.preview {
            for test in &tests {
                print(&format!("{}: {}", self.shown(), preview(test)))?;
            }
        } else {
            let new: Vec<_> = placed().filter(|(test, output)| !is_there(test, output)).collect();
            let read = [Some(&*self.file), self.file.parent()].into_iter().flatten();
            let mut plan = Plan::reading(read, args.over.into());
            new.iter().try_for_each(|(_, output)| plan.writes(output, &TRACE))?;
            for (test, output) in new {
                folder_for(output)?;
                trace::write(output, &test.trace).map_err(|error| Failure::Work(report(&error)))?;
            }
        }
        let said = |(test, output): (&Imported, &PathBuf)| {
            format!("{}: {}", self.shown(), summary(test, output))
        };
        Ok(Outcome::Made(placed().map(said).collect()))
    }

    /// The mapping, or what is to be done before there is one.
    fn mapping(&self, into: &Path, args: &Args) -> Result<Result<Mapping, String>, Failure> {
        let refused = |error: ImportError| input(&error);
        if let Some(map) = &args.map {
            return Mapping::read(map).map(Ok).map_err(refused);
        }
        let own = into.join(format!("{}.map.toml", self.name));
        let written = fs::read_to_string(&own).ok();
        let proposal = match (written.as_ref(), trace::propose(&self.file, self.part.as_deref())) {
            (_, Ok(proposal)) => proposal,
            (Some(text), Err(_)) => return Mapping::parse(&own, text).map(Ok).map_err(refused),
            (None, Err(error)) => return Err(refused(error)),
        };
        let open = !proposal.open.is_empty();
        match written {
            Some(text) if !open || text != proposal.text => {
                return Mapping::parse(&own, &text).map(Ok).map_err(refused);
            }
            None if !open => return proposal.mapping().map(Ok).map_err(refused),
            None if !args.preview => {
                folder_for(&own)?;
                let write = |out: &mut dyn std::io::Write| out.write_all(proposal.text.as_bytes());
                write_whole(&own, write).map_err(Failure::work)?;
            }
            _ => {}
        }
        let (what, own) = (proposal.open.join(", "), own.display());
        Ok(Err(format!("{}: the file does not say {what}; complete {own}", self.shown())))
    }

    /// What messages call it.
    fn shown(&self) -> String {
        let file = self.file.display();
        self.part.as_ref().map_or_else(|| file.to_string(), |part| format!("{file}, {part}"))
    }
}

/// Whether the file is this trace already.
fn is_there(found: &Imported, output: &Path) -> bool {
    trace::read(output).is_ok_and(|there| {
        (there.head, there.time, there.columns)
            == (found.trace.head.clone(), found.trace.time.clone(), found.trace.columns.clone())
    })
}

fn folder_for(file: &Path) -> Result<(), Failure> {
    file.parent().map_or(Ok(()), fs::create_dir_all).map_err(Failure::work)
}
