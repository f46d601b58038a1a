//! The folder that was opened, and nothing outside it.

use std::path::{Component, Path, PathBuf};

use super::error::LabError;
use palpate_survey::results::MANIFEST;
use palpate_trace::files::{followed, quoted};
use palpate_trace::has_extension;
use palpate_trace::recording::EXTENSION;

/// A folder with the name under which it was opened.
#[derive(Clone, Debug)]
pub struct Folder {
    /// As it was named, for commands.
    named: PathBuf,
    /// Where it really is.
    root: PathBuf,
}

impl Folder {
    /// Opens a folder.
    ///
    /// # Errors
    /// When it is not there.
    pub fn open(named: &Path) -> Result<Self, LabError> {
        let failed = |source| LabError::Io { path: named.into(), source };
        let root = named.canonicalize().map_err(failed)?;
        std::fs::read_dir(&root).map_err(failed)?;
        Ok(Self { named: named.into(), root })
    }

    /// A name as a path below the folder: of plain parts only.
    fn plain(&self, name: &str) -> Result<PathBuf, LabError> {
        let outside = || LabError::Outside(name.into());
        let path = Path::new(name);
        let plain = path.components().all(|part| matches!(part, Component::Normal(_)));
        if plain { Ok(self.root.join(path)) } else { Err(outside()) }
    }

    /// A file or folder that is there, by its name relative to this one.
    ///
    /// # Errors
    /// When it is not there, or leads outside, also by a link.
    pub fn existing(&self, name: &str) -> Result<PathBuf, LabError> {
        let path = self.plain(name)?;
        let real = path.canonicalize().map_err(|source| LabError::Io { path, source })?;
        if real.starts_with(&self.root) { Ok(real) } else { Err(LabError::Outside(name.into())) }
    }

    /// Where a file of this name lies, whether it is there or not.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.root.join(name)
    }

    /// Where a file of this name is to be written, in a folder that is there.
    ///
    /// # Errors
    /// When the name leads outside, also by a link, or names nothing.
    pub fn to_write(&self, name: &str) -> Result<PathBuf, LabError> {
        let path = self.plain(name)?;
        let outside = || LabError::Outside(name.into());
        let (parent, file) = path.parent().zip(path.file_name()).ok_or_else(outside)?;
        let failed = |source| LabError::Io { path: parent.into(), source };
        let parent = parent.canonicalize().map_err(failed)?;
        let path = parent.join(file);
        let inside = |path: &Path| path.starts_with(&self.root) && path != self.root;
        // A link that is there leads to where it is written.
        let target =
            followed(&path).map_err(|source| LabError::Io { path: path.clone(), source })?;
        let target = match (target.parent().map(Path::canonicalize), target.file_name()) {
            (Some(Ok(folder)), Some(name)) => folder.join(name),
            _ => return Err(outside()),
        };
        if inside(&path) && inside(&target) { Ok(target) } else { Err(outside()) }
    }

    /// A name as a command takes it.
    #[must_use]
    pub fn shown(&self, name: &str) -> String {
        let path = if name.is_empty() { self.named.clone() } else { self.named.join(name) };
        quoted(&path.display().to_string())
    }

    /// The trace files of a folder below, by name.
    ///
    /// # Errors
    /// When it is not there or leads outside.
    pub fn traces(&self, set: &str) -> Result<Vec<String>, LabError> {
        self.files(set, &["csv", "parquet"])
    }

    /// The model files of this folder, by name.
    ///
    /// # Errors
    /// When the folder is gone.
    pub fn models(&self) -> Result<Vec<String>, LabError> {
        let mut models = self.files("", &["toml"])?;
        models.retain(|name| !name.ends_with(".map.toml"));
        Ok(models)
    }

    /// Whether a name is that of a recording: a data set of its own, its stretches.
    #[must_use]
    pub fn is_recording(name: &str) -> bool {
        has_extension(Path::new(name), EXTENSION)
    }

    /// This folder, as an empty name, and the folders in it, where they hold traces; then the recordings in it.
    ///
    /// # Errors
    /// When the folder is gone.
    pub fn sets(&self) -> Result<Vec<String>, LabError> {
        // The tables of a survey are no traces.
        let surveys = self.surveys()?;
        let holds = |name: &String| {
            !surveys.contains(name) && self.traces(name).is_ok_and(|traces| !traces.is_empty())
        };
        let mut sets: Vec<String> = self
            .entries("")?
            .into_iter()
            .filter(|name| self.existing(name).is_ok_and(|path| path.is_dir()))
            .collect();
        sets.insert(0, String::new());
        sets.retain(holds);
        sets.extend(self.files("", &[EXTENSION])?);
        Ok(sets)
    }

    /// The results of surveys: this folder, as an empty name, and the folders in it, where they hold any.
    ///
    /// # Errors
    /// When the folder is gone.
    pub fn surveys(&self) -> Result<Vec<String>, LabError> {
        let mut folders = self.entries("")?;
        folders.insert(0, String::new());
        let holds =
            |name: &String| self.existing(name).is_ok_and(|path| path.join(MANIFEST).is_file());
        folders.retain(holds);
        Ok(folders)
    }

    fn files(&self, folder: &str, extensions: &[&str]) -> Result<Vec<String>, LabError> {
        let wanted = |name: &String| {
            let extension = Path::new(name).extension().and_then(|found| found.to_str());
            extension.is_some_and(|found| extensions.iter().any(|e| found.eq_ignore_ascii_case(e)))
        };
        Ok(self.entries(folder)?.into_iter().filter(wanted).collect())
    }

    /// Names in a folder below, in order; hidden ones and those that are no text are left out.
    fn entries(&self, folder: &str) -> Result<Vec<String>, LabError> {
        let path = self.existing(folder)?;
        let failed = |source| LabError::Io { path: path.clone(), source };
        let mut names = Vec::new();
        for entry in std::fs::read_dir(&path).map_err(failed)? {
            let name = entry.map_err(failed)?.file_name();
            names.extend(name.to_str().filter(|name| !name.starts_with('.')).map(str::to_owned));
        }
        names.sort();
        Ok(names)
    }
}
