//! Figures that are held to a golden file, one per line, with a tolerance.

use std::fs;
use std::path::PathBuf;

use indexmap::IndexMap;
use miette::{IntoDiagnostic, WrapErr, bail};

use crate::check::workspace;

/// A figure may differ by so much of itself.
const TOLERANCE: f64 = 0.02;

/// The figures of one file, as they were and as they are.
pub struct Golden {
    path: PathBuf,
    before: IndexMap<String, f64>,
    now: IndexMap<String, f64>,
    update: bool,
}

impl Golden {
    /// The file of this name in `tests/golden/`; with `update` it is written anew instead of compared.
    pub fn open(name: &str, update: bool) -> miette::Result<Self> {
        let path = workspace().join("tests/golden").join(name);
        let text = if update { String::new() } else { read(&path)? };
        let before = text
            .lines()
            .filter_map(|line| line.rsplit_once(": "))
            .filter_map(|(name, figure)| Some((name.to_owned(), figure.parse().ok()?)))
            .collect();
        Ok(Self { path, before, now: IndexMap::new(), update })
    }

    /// Holds a figure to the file.
    pub fn hold(&mut self, name: &str, figure: f64) -> miette::Result<()> {
        self.now.insert(name.to_owned(), figure);
        if self.update {
            return Ok(());
        }
        let Some(before) = self.before.get(name) else {
            bail!(
                "{} has no figure `{name}`, which is {figure}; --update writes it",
                self.path.display()
            );
        };
        if (figure - before).abs() > TOLERANCE * before.abs() {
            bail!(
                "{name} is {figure}, {before} in {}: more than {} % away; --update accepts it",
                self.path.display(),
                100.0 * TOLERANCE
            );
        }
        Ok(())
    }

    /// Writes the file if it was to be updated.
    pub fn close(self) -> miette::Result<()> {
        if !self.update {
            return Ok(());
        }
        let text: String =
            self.now.iter().map(|(name, figure)| format!("{name}: {figure}\n")).collect();
        fs::write(&self.path, text).into_diagnostic()
    }
}

fn read(path: &PathBuf) -> miette::Result<String> {
    fs::read_to_string(path).into_diagnostic().wrap_err_with(|| path.display().to_string())
}
