//! The folder that a survey fills: its manifest, the list of what was read, one file a part, and journals of parts under way.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File, TryLockError};
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

use serde_json::{Map, Value};

use super::group::Group;
use super::journal::Journal;
use super::manifest::{self, Inputs, Manifest, Part};
use super::part;
use super::row::{Asked, Row, Worked};
use super::source::{Input, Sources};
use palpate_trace::files::write_whole;

pub use super::manifest::{Manifest as About, NAME as MANIFEST};

/// Number of groups in a part.
pub const GROUPS_IN_A_PART: u64 = 1000;
/// Folder of what was found.
pub const FOUND: &str = "groups";
/// Folder of what it cost.
pub const WORKED: &str = "work";
/// Folder of journals.
const UNFINISHED: &str = "unfinished";
/// List of what was read.
const INPUTS: &str = "inputs.csv";
/// Where the traces of each group are, one line a group.
const PLACES: &str = "places.jsonl";
/// Locked while a survey writes into the folder.
const LOCK: &str = ".lock";

/// What a survey is to do.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What is asked.
    pub asked: Asked,
    /// What the traces are grouped by.
    pub by: Vec<String>,
    /// Every option that the rows depend on, by its name.
    pub options: Map<String, Value>,
    /// The command.
    pub command: String,
    /// The seeds of what is random in the answers.
    pub seeds: BTreeMap<String, u64>,
    /// What is read.
    pub sources: Sources,
}

/// Why results cannot be written or read.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum ResultsError {
    #[error("{}: is not empty and holds no survey. Choose another folder.", .0.display())]
    NotEmpty(PathBuf),
    #[error(
        "{}: was made {difference}. Choose another folder, or begin anew with --force.",
        folder.display()
    )]
    Other { folder: PathBuf, difference: String },
    #[error(
        "{}: was made from other files: {what}. Choose another folder, or begin anew with --force.",
        folder.display()
    )]
    OtherInputs { folder: PathBuf, what: String },
    #[error("{}: another survey is writing here. Wait for it, or choose another folder.", .0.display())]
    Busy(PathBuf),
    #[error("{}: {what}", path.display())]
    Damaged { path: PathBuf, what: String },
    #[error("a key cannot be called `{0}`: the table has a column of that name")]
    Reserved(String),
    #[error("{}: {source}", path.display())]
    Io { path: PathBuf, source: io::Error },
}

impl ResultsError {
    fn io(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Io { path, source }
    }
}

/// A folder of results that is being filled.
pub struct Results {
    folder: PathBuf,
    manifest: Manifest,
    groups: Vec<Group>,
    finished: BTreeSet<u64>,
    open: BTreeMap<u64, Open>,
    _lock: File,
}

/// A part under way.
struct Open {
    journal: Journal,
    rows: BTreeMap<u64, (Row, Worked)>,
}

impl Results {
    /// Begins a folder, or goes on with one of the same survey; `anew` begins again what is there.
    ///
    /// # Errors
    /// When the folder holds anything else, or what was made otherwise; see [`ResultsError`].
    pub fn begin(folder: &Path, plan: Plan, anew: bool) -> Result<Self, ResultsError> {
        if let Some(key) = plan.by.iter().find(|key| part::RESERVED.contains(&key.as_str())) {
            return Err(ResultsError::Reserved(key.clone()));
        }
        let there = manifest::is_there(folder);
        if !there && !is_free(folder) {
            return Err(ResultsError::NotEmpty(folder.into()));
        }
        for inner in [FOUND, WORKED, UNFINISHED] {
            let path = folder.join(inner);
            fs::create_dir_all(&path).map_err(ResultsError::io(&path))?;
        }
        let lock = lock(folder)?;
        let mut manifest = manifest_of(&plan);
        let list = list_of(&plan.sources.inputs);
        if there && !anew {
            check_same(folder, &manifest, &list)?;
        } else {
            clear(folder)?;
            write(&folder.join(INPUTS), list.as_bytes())?;
            write_places(&folder.join(PLACES), &plan.sources.groups)?;
        }
        manifest.parts = finished(folder, &manifest);
        let finished = manifest.parts.iter().filter_map(|part| number_of(&part.file)).collect();
        let open = BTreeMap::new();
        let groups = plan.sources.groups;
        let mut results =
            Self { folder: folder.into(), manifest, groups, finished, open, _lock: lock };
        results.take_up()?;
        results.tell()?;
        Ok(results)
    }

    /// The groups that have no row yet, in order.
    #[must_use]
    pub fn missing(&self) -> Vec<Group> {
        let has_row = |group: &&Group| {
            let part = group.number / GROUPS_IN_A_PART;
            let known = |open: &Open| open.rows.contains_key(&group.number);
            self.finished.contains(&part) || self.open.get(&part).is_some_and(known)
        };
        self.groups.iter().filter(|group| !has_row(group)).cloned().collect()
    }

    /// Keeps a row: when this returns it survives the end of the process.
    ///
    /// # Errors
    /// What the file system answers.
    pub fn add(&mut self, row: Row, worked: Worked) -> Result<(), ResultsError> {
        let part = row.group / GROUPS_IN_A_PART;
        if !self.open.contains_key(&part) {
            let (journal, _) = self.journal(part)?;
            self.open.insert(part, Open { journal, rows: BTreeMap::new() });
        }
        let path = self.folder.join(UNFINISHED);
        if let Some(open) = self.open.get_mut(&part) {
            open.journal.add(&row, worked).map_err(ResultsError::io(&path))?;
            open.rows.insert(row.group, (row, worked));
        }
        self.finish(part)
    }

    /// What the folder is the result of.
    #[must_use]
    pub fn about(&self) -> &Manifest {
        &self.manifest
    }

    /// Takes up what an earlier run left of parts under way.
    fn take_up(&mut self) -> Result<(), ResultsError> {
        for part in 0..self.groups.len().div_ceil(GROUPS_IN_A_PART as usize) as u64 {
            let path = self.folder.join(UNFINISHED).join(journal_name(part));
            if self.finished.contains(&part) {
                // Its row of the last run came between the part and the end of its journal.
                let _ = fs::remove_file(&path);
            } else if path.exists() {
                let (journal, rows) = self.journal(part)?;
                let own = |(row, _): &(Row, Worked)| {
                    let group = self.groups.get(row.group as usize);
                    row.group / GROUPS_IN_A_PART == part
                        && group.is_some_and(|group| group.key == row.key)
                };
                let rows = rows.into_iter().filter(own).map(|pair| (pair.0.group, pair)).collect();
                self.open.insert(part, Open { journal, rows });
                self.finish(part)?;
            }
        }
        Ok(())
    }

    /// Puts a part in its place if all its rows are there.
    fn finish(&mut self, part: u64) -> Result<(), ResultsError> {
        let first = part * GROUPS_IN_A_PART;
        let count = (self.groups.len() as u64 - first).min(GROUPS_IN_A_PART);
        let is_whole = self.open.get(&part).is_some_and(|open| open.rows.len() as u64 == count);
        let Some(open) = is_whole.then(|| self.open.remove(&part)).flatten() else {
            return Ok(());
        };
        let (rows, worked): (Vec<Row>, Vec<(u64, Worked)>) =
            open.rows.into_values().map(|(row, worked)| (row.clone(), (row.group, worked))).unzip();
        let (found, cost) = (self.folder.join(FOUND), self.folder.join(WORKED));
        let bytes = |path: &Path, made: Result<Vec<u8>, parquet::errors::ParquetError>| {
            made.map_err(|error| ResultsError::Damaged {
                path: path.into(),
                what: error.to_string(),
            })
        };
        // The part counts as finished once what was found lies in its place.
        let path = cost.join(part_name(part));
        write(&path, &bytes(&path, part::worked_bytes(&worked))?)?;
        let path = found.join(part_name(part));
        let table = bytes(&path, part::found_bytes(&self.manifest.by, &rows))?;
        write(&path, &table)?;
        let journal = self.folder.join(UNFINISHED).join(journal_name(part));
        open.journal.finish().map_err(ResultsError::io(&journal))?;
        self.finished.insert(part);
        let file = format!("{FOUND}/{}", part_name(part));
        self.manifest.parts.push(Part { file, groups: count, bytes: table.len() as u64 });
        self.manifest.parts.sort_by(|a, b| a.file.cmp(&b.file));
        self.tell()
    }

    /// Brings the manifest up to date.
    fn tell(&mut self) -> Result<(), ResultsError> {
        let known: u64 = self.manifest.parts.iter().map(|part| part.groups).sum();
        self.manifest.finished = known == self.manifest.groups;
        let path = self.folder.join(manifest::NAME);
        let text = serde_json::to_string_pretty(&self.manifest)
            .map_err(|error| ResultsError::Io { path: path.clone(), source: error.into() })?;
        write(&path, (text + "\n").as_bytes())
    }

    fn journal(&self, part: u64) -> Result<(Journal, Vec<(Row, Worked)>), ResultsError> {
        let path = self.folder.join(UNFINISHED).join(journal_name(part));
        Journal::open(&path).map_err(ResultsError::io(&path))
    }
}

/// Whether a folder can be filled: it is empty or not there, or a survey was ended before it had a manifest.
fn is_free(folder: &Path) -> bool {
    let Ok(entries) = fs::read_dir(folder) else { return !folder.exists() };
    let ours = [FOUND, WORKED, UNFINISHED, INPUTS, PLACES, LOCK];
    entries.flatten().all(|entry| ours.iter().any(|name| entry.file_name() == *name))
}

/// Reads what a folder of results is of.
///
/// # Errors
/// When it holds no survey, or one of a newer version.
pub fn about(folder: &Path) -> Result<Manifest, ResultsError> {
    let path = folder.join(manifest::NAME);
    Manifest::read(folder).map_err(|what| ResultsError::Damaged { path, what })
}

/// Where the traces of a group are.
///
/// # Errors
/// When there is no such group, or the folder is damaged.
pub fn group(folder: &Path, number: u64) -> Result<Group, ResultsError> {
    let path = folder.join(PLACES);
    let file = File::open(&path).map_err(ResultsError::io(&path))?;
    let line = BufReader::new(file).lines().nth(number as usize);
    let damaged = |what: String| ResultsError::Damaged { path: path.clone(), what };
    let line = line.ok_or_else(|| damaged(format!("there is no group {number}")))?;
    let line = line.map_err(ResultsError::io(&path))?;
    serde_json::from_str(&line).map_err(|error| damaged(error.to_string()))
}

/// Reads the rows of the parts that are finished, in order, with what each cost; only one part is in memory at a time.
///
/// # Errors
/// When a part is missing or damaged.
pub fn read_rows(
    folder: &Path,
    about: &Manifest,
    mut each: impl FnMut(Row, Worked),
) -> Result<(), ResultsError> {
    for part in &about.parts {
        let number = number_of(&part.file).unwrap_or_default();
        let damaged = |path: &Path, what| ResultsError::Damaged { path: path.into(), what };
        let mut cost = BTreeMap::new();
        let path = folder.join(WORKED).join(part_name(number));
        part::read_work(&path, |group, worked| {
            cost.insert(group, worked);
        })
        .map_err(|what| damaged(&path, what))?;
        let path = folder.join(&part.file);
        part::read(&path, &about.by, |row| {
            let worked = cost.get(&row.group).copied();
            each(row, worked.unwrap_or(Worked { seconds: 0.0, attempts: 0 }));
        })
        .map_err(|what| damaged(&path, what))?;
    }
    Ok(())
}

fn manifest_of(plan: &Plan) -> Manifest {
    let inputs = &plan.sources.inputs;
    Manifest {
        palpate_survey: manifest::VERSION,
        version: env!("CARGO_PKG_VERSION").into(),
        asked: plan.asked,
        by: plan.by.clone(),
        options: plan.options.clone(),
        command: plan.command.clone(),
        seeds: plan.seeds.clone(),
        inputs: Inputs {
            list: INPUTS.into(),
            files: inputs.len() as u64,
            bytes: inputs.iter().map(|input| input.bytes).sum(),
        },
        groups: plan.sources.groups.len() as u64,
        groups_in_a_part: GROUPS_IN_A_PART,
        parts: Vec::new(),
        finished: false,
    }
}

/// The list of what was read: name, size, time of the last change.
fn list_of(inputs: &[Input]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    // A writer into memory has no errors.
    let _ = writer.write_record(["path", "bytes", "modified_ns"]);
    for input in inputs {
        let path = input.path.display().to_string();
        let _ = writer.write_record([path, input.bytes.to_string(), input.modified_ns.to_string()]);
    }
    String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
}

/// Refuses to go on with what was made otherwise.
fn check_same(folder: &Path, here: &Manifest, list: &str) -> Result<(), ResultsError> {
    let there = about(folder)?;
    if let Some(difference) = there.difference(here) {
        return Err(ResultsError::Other { folder: folder.into(), difference });
    }
    let path = folder.join(INPUTS);
    let known = fs::read_to_string(&path).map_err(ResultsError::io(&path))?;
    if known == list {
        return Ok(());
    }
    let lines = |text: &str| text.lines().skip(1).map(str::to_owned).collect::<BTreeSet<_>>();
    let (known, given) = (lines(&known), lines(list));
    let first = given.difference(&known).next().or_else(|| known.difference(&given).next());
    let what = first.and_then(|line| Some(line.rsplitn(3, ',').nth(2)?.to_owned()));
    let what =
        what.map_or_else(|| "their order".into(), |file| format!("{file} is new, changed or gone"));
    Err(ResultsError::OtherInputs { folder: folder.into(), what })
}

/// Removes what an earlier survey left in the folder, and nothing else.
fn clear(folder: &Path) -> Result<(), ResultsError> {
    for name in [manifest::NAME, INPUTS, PLACES] {
        remove(&folder.join(name))?;
    }
    for inner in [FOUND, WORKED, UNFINISHED] {
        let path = folder.join(inner);
        for entry in fs::read_dir(&path).map_err(ResultsError::io(&path))? {
            let entry = entry.map_err(ResultsError::io(&path))?.path();
            let name = entry.file_name().and_then(|name| name.to_str()).unwrap_or_default();
            if number_of(name).is_some() {
                remove(&entry)?;
            }
        }
    }
    Ok(())
}

fn remove(path: &Path) -> Result<(), ResultsError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(ResultsError::io(path)(error)),
        _ => Ok(()),
    }
}

/// The parts that lie in their places.
fn finished(folder: &Path, manifest: &Manifest) -> Vec<Part> {
    let parts = manifest.groups.div_ceil(GROUPS_IN_A_PART);
    let part = |number| {
        let file = format!("{FOUND}/{}", part_name(number));
        let about = fs::metadata(folder.join(&file)).ok()?;
        fs::metadata(folder.join(WORKED).join(part_name(number))).ok()?;
        let groups = (manifest.groups - number * GROUPS_IN_A_PART).min(GROUPS_IN_A_PART);
        Some(Part { file, groups, bytes: about.len() })
    };
    (0..parts).filter_map(part).collect()
}

fn lock(folder: &Path) -> Result<File, ResultsError> {
    let path = folder.join(LOCK);
    let file = File::options().create(true).truncate(false).write(true).open(&path);
    let file = file.map_err(ResultsError::io(&path))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(ResultsError::Busy(folder.into())),
        Err(TryLockError::Error(error)) => Err(ResultsError::io(&path)(error)),
    }
}

fn part_name(part: u64) -> String {
    format!("part-{part:05}.parquet")
}

fn journal_name(part: u64) -> String {
    format!("part-{part:05}.jsonl")
}

/// The number of a part by the name of one of its files.
fn number_of(file: &str) -> Option<u64> {
    let name = file.rsplit('/').next()?.strip_prefix("part-")?;
    let (number, ending) = name.split_once('.')?;
    ["parquet", "jsonl"].contains(&ending).then(|| number.parse().ok())?
}

fn write_places(path: &Path, groups: &[Group]) -> Result<(), ResultsError> {
    let lines = |file: &mut dyn Write| {
        groups.iter().try_for_each(|group| {
            serde_json::to_writer(&mut *file, group)?;
            file.write_all(b"\n")
        })
    };
    write_whole(path, lines).map_err(ResultsError::io(path))
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), ResultsError> {
    write_whole(path, |file| file.write_all(bytes)).map_err(ResultsError::io(path))
}

#[cfg(test)]
mod tests;
