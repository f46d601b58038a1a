//! Files that were dropped on the page: kept in a new folder in the one opened, and read from there.
//!
//! What is no trace as it is, a foreign recording, lies in `foreign/` of that folder, with the mapping by which it was imported.

use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::{Value, json};

use super::error::LabError;
use super::folder::Folder;
use super::session::Session;
use palpate_model::Model;
use palpate_trace::recording;
use palpate_trace::{self as trace, Imported, Mapping, has_extension};

/// Name of the folder of what was dropped; the second has a number.
const NAME: &str = "dropped";
/// Where foreign recordings lie in it.
const FOREIGN: &str = "foreign";
/// Most that one session takes: files, and bytes of all together.
const MOST_FILES: usize = 1_000;
const MOST_BYTES: u64 = 1 << 30;
/// Letters of a name.
const MAX_NAME_LETTERS: usize = 100;
/// Rows that a preview shows.
const PREVIEW_ROWS: usize = 5;

/// What was dropped in a session.
#[derive(Debug, Default)]
pub struct Dropped {
    /// Names of its folders in the one opened.
    folders: Vec<String>,
    files: usize,
    bytes: u64,
}

/// How a foreign recording becomes a trace.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Import {
    /// The folder that it was dropped into.
    pub set: String,
    /// Its name.
    pub file: String,
    /// The mapping file's text.
    pub mapping: String,
    /// Whether to write the trace; else what it would be is only told.
    pub keep: bool,
}

impl Session {
    /// Takes a file into a folder that was made for it, or into that of files dropped before; tells what it is and where it lies.
    ///
    /// # Errors
    /// When the folder is not one of them, it is too much, or it cannot be written.
    pub fn drop_file(&mut self, name: &str, into: &str, bytes: &[u8]) -> Result<Value, LabError> {
        let folder = self.folder()?.clone();
        let dropped = self.dropped();
        dropped.count(bytes.len() as u64)?;
        let set = if into.is_empty() { dropped.begin(&folder)? } else { dropped.known(into)? };
        let name = plain(name);
        let path = write_new(&folder.to_write(&format!("{set}/{name}"))?, bytes)?;
        let told = |kind: &str, path: &Path| {
            let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            json!({ "set": set, "file": file, "kind": kind })
        };
        let is = |extension| has_extension(&path, extension);
        if is(recording::EXTENSION) {
            return Ok(told("recording", &path));
        }
        if is("toml") && Model::read(&path).is_ok() {
            return Ok(told("model", &path));
        }
        if is("csv") || is("parquet") {
            match trace::read(&path) {
                Ok(_) => return Ok(told("trace", &path)),
                // Then it may be foreign; a mapping says how it is meant.
                Err(error) => tracing::info!("{}: {error}", path.display()),
            }
        }
        let path = put_aside(&folder, &set, &path)?;
        let mut told = told("foreign", &path);
        match trace::suggest(&path, None) {
            Ok(mapping) => told["mapping"] = mapping.into(),
            Err(error) => told["why"] = in_folder(&folder, &error.to_string()).into(),
        }
        Ok(told)
    }

    /// Tells what a mapping makes of a foreign recording, or writes the trace and keeps the mapping beside the recording.
    ///
    /// # Errors
    /// When the recording is not there, the mapping is wrong or does not fit, or the trace cannot be written.
    pub fn import(&mut self, import: &Import) -> Result<Value, LabError> {
        let folder = self.folder()?.clone();
        let set = self.dropped().known(&import.set)?;
        let file = plain(&import.file);
        let path = folder.existing(&format!("{set}/{FOREIGN}/{file}"))?;
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let fault =
            |error: trace::ImportError| LabError::Law(in_folder(&folder, &error.to_string()));
        let map_name = format!("{set}/{FOREIGN}/{stem}.map.toml");
        let mapping = Mapping::parse(&folder.path(&map_name), &import.mapping).map_err(fault)?;
        let tests = trace::import_tests(std::slice::from_ref(&path), &mapping).map_err(fault)?;
        let mut told = preview(&tests);
        if import.keep {
            let trace = free(&folder.to_write(&format!("{set}/{stem}.trace.csv"))?);
            let places: Vec<PathBuf> =
                trace::places(&trace, tests.len()).iter().map(|place| free(place)).collect();
            for (test, place) in tests.iter().zip(&places) {
                trace::write(place, &test.trace)?;
            }
            let map = write_new(&folder.to_write(&map_name)?, import.mapping.as_bytes())?;
            let name =
                |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            told["file"] = places.first().map_or_else(String::new, |place| name(place)).into();
            told["command"] = format!(
                "palpate import {} --map {} -o {}",
                folder.shown(&format!("{set}/{FOREIGN}/{file}")),
                folder.shown(&format!("{set}/{FOREIGN}/{}", name(&map))),
                folder.shown(&format!("{set}/{}", name(&trace))),
            )
            .into();
        }
        Ok(told)
    }
}

impl Dropped {
    /// A new folder.
    fn begin(&mut self, folder: &Folder) -> Result<String, LabError> {
        for number in 1_u32.. {
            let name = if number == 1 { NAME.to_owned() } else { format!("{NAME}-{number}") };
            let path = folder.to_write(&name)?;
            match std::fs::create_dir(&path) {
                Ok(()) => {
                    self.folders.push(name.clone());
                    return Ok(name);
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                Err(source) => return Err(LabError::Io { path, source }),
            }
        }
        Err(LabError::BrokeOff)
    }

    /// A folder that this session made.
    fn known(&self, name: &str) -> Result<String, LabError> {
        let known = self.folders.iter().find(|known| *known == name);
        known
            .cloned()
            .ok_or_else(|| LabError::Unknown { what: "folder of dropped files", name: name.into() })
    }

    fn count(&mut self, bytes: u64) -> Result<(), LabError> {
        if self.files >= MOST_FILES || self.bytes + bytes > MOST_BYTES {
            return Err(LabError::Law(format!(
                "that is too much for one session: at most {MOST_FILES} files and 1 GiB; put them into a folder and open that with `palpate serve`"
            )));
        }
        self.files += 1;
        self.bytes += bytes;
        Ok(())
    }
}

/// The last part of a name in letters that mean the same in every system.
fn plain(name: &str) -> String {
    let last = name.rsplit(['/', '\\']).next().unwrap_or_default();
    let fit = |c: char| if c.is_alphanumeric() || matches!(c, '.' | '-' | '_') { c } else { '_' };
    let fitting: Vec<char> = last.trim_start_matches('.').chars().map(fit).collect();
    // The end of a long name says what it is.
    let name: String = fitting[fitting.len().saturating_sub(MAX_NAME_LETTERS)..].iter().collect();
    if name.trim_matches('.').is_empty() { "file".into() } else { name }
}

/// A name that is free: this one, or one with a number.
fn free(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let (stem, rest) = name.split_once('.').unwrap_or((&name, ""));
    let numbered = |number: usize| {
        let dot = if rest.is_empty() { "" } else { "." };
        path.with_file_name(format!("{stem}-{number}{dot}{rest}"))
    };
    let taken = |path: &PathBuf| path.symlink_metadata().is_ok();
    let all = std::iter::once(path.to_owned()).chain((2..=MOST_FILES + 2).map(numbered));
    all.into_iter().find(|path| !taken(path)).unwrap_or_else(|| path.to_owned())
}

/// Writes a file that is not there yet; where it came to lie.
fn write_new(path: &Path, bytes: &[u8]) -> Result<PathBuf, LabError> {
    let path = free(path);
    let failed = |source| LabError::Io { path: path.clone(), source };
    let mut file = OpenOptions::new().write(true).create_new(true).open(&path).map_err(failed)?;
    if let Err(source) = file.write_all(bytes) {
        // Half a file is of no use.
        let _ = std::fs::remove_file(&path);
        return Err(failed(source));
    }
    Ok(path)
}

/// Puts a file among the foreign ones of its folder.
fn put_aside(folder: &Folder, set: &str, path: &Path) -> Result<PathBuf, LabError> {
    let beside = folder.to_write(&format!("{set}/{FOREIGN}"))?;
    let failed = |source| LabError::Io { path: path.into(), source };
    match std::fs::create_dir(&beside) {
        Err(error) if error.kind() != ErrorKind::AlreadyExists => return Err(failed(error)),
        _ => {}
    }
    let to = free(&beside.join(path.file_name().unwrap_or_default()));
    std::fs::rename(path, &to).map_err(failed)?;
    Ok(to)
}

/// An error without the place of the folder on this computer.
fn in_folder(folder: &Folder, error: &str) -> String {
    let root = folder.path("").display().to_string();
    error.replace(root.as_str(), "").trim_start_matches('/').to_owned()
}

/// What a mapping makes of a recording: of all its tests, and what the first one looks like.
fn preview(tests: &[Imported]) -> Value {
    let Some(Imported { trace, columns, dropped, .. }) = tests.first() else { return Value::Null };
    let sum = |count: fn(&Imported) -> usize| tests.iter().map(count).sum::<usize>();
    let cells = |row: usize| -> Vec<f64> {
        let values = trace.columns.iter().map(|column| column.values[row]);
        std::iter::once(trace.time[row]).chain(values).collect()
    };
    let names: Vec<&str> = std::iter::once(trace::TIME)
        .chain(trace.columns.iter().map(|column| column.name.as_str()))
        .collect();
    json!({
        "tests": tests.len(),
        "rows": sum(|test| test.rows),
        "samples": sum(|test| test.trace.len()),
        "merged": sum(|test| test.merged),
        "missing": sum(|test| test.missing),
        "uncovered": sum(|test| test.uncovered),
        "gaps": sum(|test| trace::gaps(&test.trace.time).len()),
        "columns": columns.iter().map(|(from, to)| json!({ "from": from, "to": to })).collect::<Vec<_>>(),
        "left_out": dropped.iter().map(|(name, why)| json!({ "name": name, "why": why })).collect::<Vec<_>>(),
        "names": names,
        "head": (0..PREVIEW_ROWS.min(trace.len())).map(cells).collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn session(folder: &Path) -> Session {
        Session::open(folder, None).unwrap()
    }

    #[test]
    fn names_stay_in_their_folder_and_mean_the_same_everywhere() {
        for (given, kept) in [
            ("press.csv", "press.csv"),
            ("../../etc/passwd", "passwd"),
            ("C:\\data\\a b.csv", "a_b.csv"),
            (".hidden", "hidden"),
            ("..", "file"),
            ("", "file"),
            ("a\u{0}b;c.csv", "a_b_c.csv"),
        ] {
            assert_eq!(plain(given), kept, "{given:?}");
        }
        assert_eq!(plain(&format!("{}.csv", "x".repeat(300))).len(), MAX_NAME_LETTERS);
    }

    #[test]
    fn what_is_dropped_lies_in_a_new_folder_and_nothing_is_written_over() {
        let place = tempfile::tempdir().unwrap();
        std::fs::create_dir(place.path().join(NAME)).unwrap();
        std::fs::write(place.path().join(NAME).join("mine.csv"), "mine").unwrap();
        let mut session = session(place.path());
        let trace = b"time_s,force_N\n0,1\n1,2\n2,3\n";
        let told = session.drop_file("mine.csv", "", trace).unwrap();
        assert_eq!(told, json!({"set": "dropped-2", "file": "mine.csv", "kind": "trace"}));
        let told = session.drop_file("mine.csv", "dropped-2", trace).unwrap();
        assert_eq!(told["file"], "mine-2.csv");
        assert_eq!(std::fs::read_to_string(place.path().join("dropped/mine.csv")).unwrap(), "mine");
        for other in ["dropped", "..", "/tmp", "dropped-2/foreign"] {
            assert!(session.drop_file("a.csv", other, trace).is_err(), "{other}");
        }
    }

    #[test]
    fn a_foreign_file_is_previewed_and_imported_by_its_mapping() {
        let place = tempfile::tempdir().unwrap();
        let mut session = session(place.path());
        let text = "Zeit;Kraft\ns;N\n0,0;1,5\n0,1;2,5\n0,2;3,5\n0,3;4,5\n";
        let told = session.drop_file("lab.csv", "", text.as_bytes()).unwrap();
        assert_eq!((&told["kind"], &told["file"]), (&json!("foreign"), &json!("lab.csv")));
        let mapping = told["mapping"].as_str().unwrap().to_owned();
        let mut import =
            Import { set: "dropped".into(), file: "lab.csv".into(), mapping, keep: false };
        let seen = session.import(&import).unwrap();
        assert_eq!((&seen["samples"], seen.get("file")), (&json!(4), None), "{seen}");
        import.keep = true;
        let kept = session.import(&import).unwrap();
        assert_eq!(kept["file"], "lab.trace.csv");
        assert!(place.path().join("dropped/foreign/lab.map.toml").is_file());
        assert!(trace::read(&place.path().join("dropped/lab.trace.csv")).is_ok());
        import.mapping = "palpate-map = 1\n[table]\nheader_line = x\n".into();
        let error = session.import(&import).unwrap_err().to_string();
        assert!(!error.contains(&place.path().display().to_string()), "{error}");
        import.file = "../../secret.csv".into();
        assert!(session.import(&import).is_err());
    }

    #[test]
    fn every_test_of_a_dropped_file_becomes_a_trace() {
        let place = tempfile::tempdir().unwrap();
        let mut session = session(place.path());
        let text = "Time (s),Force (N)\n0,1\n1,2\n2,3\n3,NaN\n0,5\n1,6\n2,7\n3,8\n4,9\n5,9\n6,9\n";
        let told = session.drop_file("all.csv", "", text.as_bytes()).unwrap();
        let mapping = told["mapping"].as_str().unwrap().to_owned();
        let set = "dropped".to_owned();
        let import = Import { set, file: "all.csv".into(), mapping, keep: true };
        let kept = session.import(&import).unwrap();
        assert_eq!((&kept["tests"], &kept["missing"]), (&json!(2), &json!(1)), "{kept}");
        assert_eq!((&kept["samples"], &kept["file"]), (&json!(10), &json!("all-1.trace.csv")));
        let second = trace::read(&place.path().join("dropped/all-2.trace.csv")).unwrap();
        assert_eq!(second.force().unwrap()[0], 5.0);
    }

    #[test]
    fn a_session_takes_so_many_bytes_and_no_more() {
        let mut dropped = Dropped { bytes: MOST_BYTES - 10, ..Dropped::default() };
        assert!(dropped.count(10).is_ok());
        assert!(dropped.count(1).unwrap_err().to_string().contains("1 GiB"));
    }
}
