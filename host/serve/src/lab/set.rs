//! A data set as the Lab opens it: what can be read, and why the rest was left out.

use std::collections::HashMap;

use super::error::LabError;
use super::folder::Folder;
use palpate_trace::recorded::{Options, read_recording};
use palpate_trace::{Error, Trace, order, read};

/// The traces of a folder, in order of recording.
#[derive(Debug, Default)]
pub struct Set {
    /// Its name: the folder below that opened, empty for that itself.
    pub name: String,
    /// The traces that could be read.
    pub traces: Vec<Trace>,
    /// Files that were left out, each with why.
    pub left_out: Vec<(String, String)>,
}

impl Set {
    /// Reads every trace of a folder below that opened, or the stretches of a recording. One that cannot be read, or that a link leads to outside, is left out.
    ///
    /// # Errors
    /// When the folder itself is not there, or leads outside.
    pub fn read(folder: &Folder, name: &str) -> Result<Self, LabError> {
        let mut set = Self { name: name.into(), ..Self::default() };
        if Folder::is_recording(name) {
            set.traces = read_recording(&folder.existing(name)?, &Options::default())?.traces;
            return Ok(set);
        }
        let mut seen = HashMap::new();
        for file in folder.traces(name)? {
            let path = if name.is_empty() { file.clone() } else { format!("{name}/{file}") };
            let found = folder.existing(&path).and_then(|real| {
                if let Some(first) = seen.insert(real.clone(), file.clone()) {
                    return Err(LabError::Same(first));
                }
                // It goes by the name that it has in this folder.
                Ok(Trace { path: Some(folder.path(&path)), ..read(&real)? })
            });
            match found {
                Ok(trace) => set.traces.push(trace),
                Err(error) => set.left_out.push((file, error.to_string())),
            }
        }
        set.order();
        Ok(set)
    }

    /// Puts the traces into order. Of two that claim the same place the second is left out.
    fn order(&mut self) {
        while let Err(error) = order(&mut self.traces) {
            let Error::SameOrder { path, .. } = &error else { return };
            let Some(at) = self.traces.iter().position(|trace| trace.path.as_ref() == Some(path))
            else {
                return;
            };
            let label = self.traces.remove(at).label();
            self.left_out.push((label, error.to_string()));
        }
    }
}
