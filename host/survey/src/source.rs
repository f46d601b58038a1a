//! Which traces there are, and which belong together.

use std::collections::{HashMap, HashSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use serde::{Deserialize, Serialize};

use super::group::{Group, Place};
use super::manifest;
use super::names::Names;
use palpate_trace::recording;
use palpate_trace::{self as trace, Head, many, read_head};

/// The key that is a trace by itself.
pub const TRACE: &str = "trace";
/// The key that is the folder of a file.
pub const FOLDER: &str = "folder";

/// What traces are grouped by.
///
/// A key is, whatever is found first: a column of a Parquet file with many traces, a folder `key=value` on the way to the
/// file, a part of the file's name, a key of the head (`finger`, or `specimen.batch`). `trace` is each trace by itself, `folder`
/// the folder that it lies in.
#[derive(Clone, Debug)]
pub struct By {
    /// The keys.
    pub keys: Vec<String>,
    /// Where keys stand in the names of files.
    pub names: Option<Names>,
    /// The column that says of which trace a row of a Parquet file is.
    pub id: String,
}

/// A file that is read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Input {
    /// The file, as it was named.
    pub path: PathBuf,
    /// Its size, bytes.
    pub bytes: u64,
    /// When it was last changed, ns since 1970.
    pub modified_ns: u128,
}

/// What a file holds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Contents {
    /// The file.
    pub input: Input,
    /// Its traces, each with the value of each key; none of them where the file does not say where it belongs.
    pub traces: Vec<(Option<Key>, Place)>,
}

/// The value of each key that traces are grouped by.
type Key = Vec<Option<String>>;

/// All files of a survey, and their traces in groups.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    /// The files.
    pub inputs: Vec<Input>,
    /// The groups, in order of their first trace.
    pub groups: Vec<Group>,
}

/// Why the traces of a survey are not known.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum SourceError {
    #[error("{}: cannot be read: {source}. Check the name and the permissions.", path.display())]
    Open { path: PathBuf, source: io::Error },
    #[error(transparent)]
    Trace(#[from] trace::Error),
    #[error("{}: no traces in it (.csv, .parquet)", .0.display())]
    Empty(PathBuf),
    #[error("{}: is named twice", .0.display())]
    Twice(PathBuf),
    #[error(
        "{}: nothing gives its `{key}`: no column, no folder `{key}=…`, nothing in its name (--names), no key of its head",
        path.display()
    )]
    NoKey { path: PathBuf, key: String },
}

impl Sources {
    /// Finds the traces in files and folders, and what they are grouped by. Of a trace in a file of its own at most the head
    /// is read. A file whose head cannot be read is a group of its own, without keys.
    ///
    /// # Errors
    /// When a file or folder cannot be read, is empty or named twice, or nothing tells a key of a trace.
    pub fn find<P: AsRef<Path>>(data: &[P], by: &By) -> Result<Self, SourceError> {
        let mut files = Vec::new();
        for path in data {
            let path = path.as_ref();
            let known = files.len();
            walk(path, true, &mut files)?;
            if files.len() == known {
                return Err(SourceError::Empty(path.into()));
            }
        }
        Self::of(files.iter().map(|file| Contents::of(file, by)), by)
    }

    /// The groups of files whose contents are known, in their order.
    ///
    /// # Errors
    /// When the contents of a file are not known, or it is named twice.
    pub fn of(
        files: impl Iterator<Item = Result<Contents, SourceError>>,
        by: &By,
    ) -> Result<Self, SourceError> {
        let mut sources = Self::default();
        let mut seen = HashSet::new();
        let mut known = HashMap::new();
        for contents in files {
            let Contents { input, traces } = contents?;
            let file = &input.path;
            if !seen.insert(file.canonicalize().unwrap_or_else(|_| file.clone())) {
                return Err(SourceError::Twice(input.path));
            }
            for (key, place) in traces {
                match key {
                    Some(key) => sources.add(key, place, &mut known),
                    None => sources.alone(&input.path, place, by),
                }
            }
            sources.inputs.push(input);
        }
        Ok(sources)
    }

    fn add(&mut self, key: Key, place: Place, known: &mut HashMap<Key, usize>) {
        let next = self.groups.len();
        let at = *known.entry(key.clone()).or_insert(next);
        if at == next {
            self.groups.push(Group { number: next as u64, key, places: Vec::new() });
        }
        self.groups[at].places.push(place);
    }

    /// A file that does not say where it belongs.
    fn alone(&mut self, file: &Path, place: Place, by: &By) {
        let number = self.groups.len() as u64;
        let value = |key: &String| from_path(file, key, by.names.as_ref());
        let key = by.keys.iter().map(value).collect();
        self.groups.push(Group { number, key, places: vec![place] });
    }
}

impl Contents {
    /// What one file holds.
    ///
    /// # Errors
    /// When it cannot be read, or nothing tells a key of a trace.
    pub fn of(file: &Path, by: &By) -> Result<Self, SourceError> {
        let about =
            fs::metadata(file).map_err(|source| SourceError::Open { path: file.into(), source })?;
        let modified = about.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok());
        let modified_ns = modified.map_or(0, |since| since.as_nanos());
        let input = Input { path: file.into(), bytes: about.len(), modified_ns };
        Ok(Self { input, traces: traces(file, by)? })
    }
}

/// The traces of one file with their keys.
fn traces(file: &Path, by: &By) -> Result<Vec<(Option<Key>, Place)>, SourceError> {
    let alone = || Ok(vec![(None, Place::File(file.into()))]);
    if trace::has_extension(file, "parquet") {
        match many::columns(file) {
            Ok(columns) if columns.contains(&by.id) => return many_traces(file, &columns, by),
            Ok(_) => {}
            // What is no Parquet is a row with its reason.
            Err(_) => return alone(),
        }
    }
    let mut head = None;
    let mut key = Vec::new();
    for name in &by.keys {
        if let Some(value) = from_path(file, name, by.names.as_ref()) {
            key.push(Some(value));
            continue;
        }
        let head = match &mut head {
            Some(head) => head,
            none => match head_of(file) {
                Ok(read) => none.insert(read),
                Err(_) => return alone(),
            },
        };
        let value = from_head(head, name);
        let missing = || SourceError::NoKey { path: file.into(), key: name.clone() };
        key.push(Some(value.ok_or_else(missing)?));
    }
    Ok(vec![(Some(key), Place::File(file.into()))])
}

/// The traces of a file that holds many.
fn many_traces(
    file: &Path,
    columns: &[String],
    by: &By,
) -> Result<Vec<(Option<Key>, Place)>, SourceError> {
    let inside: Vec<&str> = by
        .keys
        .iter()
        .map(String::as_str)
        .filter(|key| columns.iter().any(|column| column == key))
        .collect();
    let head = head_of(file)?;
    let mut outside = HashMap::new();
    for key in by.keys.iter().filter(|key| !inside.contains(&key.as_str()) && *key != TRACE) {
        let value = from_path(file, key, by.names.as_ref()).or_else(|| from_head(&head, key));
        let missing = || SourceError::NoKey { path: file.into(), key: key.clone() };
        outside.insert(key.as_str(), value.ok_or_else(missing)?);
    }
    let of_run = |run: many::Run| {
        let value = |key: &String| {
            let column = inside.iter().position(|name| name == key);
            let column = column.map(|column| run.keys[column].to_string());
            let own = || outside.get(key.as_str()).cloned();
            column.or_else(own).or_else(|| Some(run.id.to_string()))
        };
        let key = by.keys.iter().map(value).collect();
        let (first, rows) = (run.first, run.rows);
        (Some(key), Place::Rows { path: file.into(), id: run.id.to_string(), first, rows })
    };
    Ok(many::runs(file, &by.id, &inside)?.into_iter().map(of_run).collect())
}

/// The files of a folder and of the folders in it, by name; what is hidden or the result of a survey is passed over.
fn walk(path: &Path, named: bool, files: &mut Vec<PathBuf>) -> Result<(), SourceError> {
    let open = |source| SourceError::Open { path: path.into(), source };
    if !fs::metadata(path).map_err(open)?.is_dir() {
        let data = ["csv", "parquet"].iter().any(|known| trace::has_extension(path, known));
        if named || data {
            files.push(path.into());
        }
        return Ok(());
    }
    if manifest::is_there(path) {
        return Ok(());
    }
    let entries = fs::read_dir(path).map_err(open)?;
    let mut inside: Vec<PathBuf> =
        entries.map(|entry| Ok(entry?.path())).collect::<io::Result<_>>().map_err(open)?;
    inside.retain(|path| {
        path.file_name().is_some_and(|name| !name.to_string_lossy().starts_with('.'))
    });
    inside.sort();
    inside.iter().try_for_each(|path| walk(path, false, files))
}

/// The head of a file; that of a recording says nothing of this kind.
fn head_of(file: &Path) -> Result<toml::Table, trace::Error> {
    let head = match trace::has_extension(file, recording::EXTENSION) {
        true => Head::default(),
        false => read_head(file)?,
    };
    Ok(toml::Table::try_from(head).unwrap_or_default())
}

/// A key that the way to a file tells.
fn from_path(file: &Path, key: &str, names: Option<&Names>) -> Option<String> {
    let folder = || file.parent().map(|folder| folder.display().to_string());
    let hive = || {
        let parts = file.parent()?.iter();
        let pair = |part: &std::ffi::OsStr| {
            let (name, value) = part.to_str()?.split_once('=')?;
            (name == key).then(|| value.to_owned())
        };
        parts.rev().find_map(pair)
    };
    match key {
        TRACE => Some(file.display().to_string()),
        FOLDER => folder(),
        _ => hive().or_else(|| names?.value(file, key).map(str::to_owned)),
    }
}

/// A key of a head: by its whole name, or alone at the top, in `[specimen]` or in `[setup]`.
fn from_head(head: &toml::Table, key: &str) -> Option<String> {
    let whole = || {
        let mut names = key.split('.');
        let first = head.get(names.next()?)?;
        names.try_fold(first, |table, name| table.get(name))
    };
    let within = |part: &str| head.get(part)?.get(key);
    match whole().or_else(|| within("specimen")).or_else(|| within("setup"))? {
        toml::Value::String(text) => Some(text.clone()),
        toml::Value::Table(_) | toml::Value::Array(_) => None,
        other => Some(other.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn by(keys: &[&str], names: Option<&str>) -> By {
        let keys = keys.iter().map(|&key| key.into()).collect();
        By { keys, names: names.map(|names| names.parse().unwrap()), id: "trace_id".into() }
    }

    fn write(folder: &Path, name: &str, head: &str) {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, format!("{head}time_s,force_N\n0,1\n1,2\n")).unwrap();
    }

    fn keys(sources: &Sources) -> Vec<(Vec<&str>, usize)> {
        sources
            .groups
            .iter()
            .map(|group| {
                (
                    group.key.iter().map(|k| k.as_deref().unwrap_or("?")).collect(),
                    group.places.len(),
                )
            })
            .collect()
    }

    #[test]
    fn keys_come_from_folders_names_and_heads() {
        let folder = tempfile::tempdir().unwrap();
        let head = "# [specimen]\n# batch = 7\n";
        write(folder.path(), "finger=3/a-monday.csv", head);
        write(folder.path(), "finger=3/b-monday.csv", head);
        write(folder.path(), "finger=4/a-tuesday.csv", head);
        write(folder.path(), ".hidden/c.csv", head);
        write(folder.path(), "finger=4/notes.txt", "");
        let found = Sources::find(&[folder.path()], &by(&["finger", "batch"], None)).unwrap();
        assert_eq!(keys(&found), [(vec!["3", "7"], 2), (vec!["4", "7"], 1)]);
        assert_eq!(found.inputs.len(), 3);
        let by_day = by(&["day", "specimen.batch"], Some("*-{day}.csv"));
        let found = Sources::find(&[folder.path()], &by_day).unwrap();
        assert_eq!(keys(&found), [(vec!["monday", "7"], 2), (vec!["tuesday", "7"], 1)]);
        let found = Sources::find(&[folder.path()], &by(&[TRACE], None)).unwrap();
        assert_eq!(found.groups.len(), 3);
        let error = Sources::find(&[folder.path()], &by(&["operator"], None)).unwrap_err();
        assert!(error.to_string().contains("nothing gives its `operator`"), "{error}");
    }

    #[test]
    fn a_file_whose_head_cannot_be_read_is_a_group_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), "a.csv", "# finger = 3\n");
        write(folder.path(), "b.csv", "# finger =\n");
        fs::write(folder.path().join("c.parquet"), "nothing of the kind").unwrap();
        let found = Sources::find(&[folder.path()], &by(&["finger"], None)).unwrap();
        assert_eq!(keys(&found), [(vec!["3"], 1), (vec!["?"], 1), (vec!["?"], 1)]);
    }

    #[test]
    fn nothing_is_surveyed_twice_and_an_empty_folder_is_told() {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), "a.csv", "");
        let twice = [folder.path().to_path_buf(), folder.path().join("a.csv")];
        let error = Sources::find(&twice, &by(&[TRACE], None)).unwrap_err();
        assert!(matches!(error, SourceError::Twice(_)), "{error}");
        let empty = tempfile::tempdir().unwrap();
        let error = Sources::find(&[empty.path()], &by(&[TRACE], None)).unwrap_err();
        assert!(matches!(error, SourceError::Empty(_)), "{error}");
    }
}
