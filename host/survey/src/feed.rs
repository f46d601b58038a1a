//! The traces of one group after the other, read where they lie.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use super::group::{Group, Place};
use super::results::About;
use palpate_trace::many::{Names, Rows};
use palpate_trace::{self as trace, Trace, order, read_set};

/// Most files with many traces that are held open at a time.
const OPEN: usize = 16;

/// Reads groups. Files with many traces are read by one thread at a time and forward, so that no page is read twice while
/// the groups come in their order; files of one trace are read by as many as ask.
pub(super) struct Feed {
    /// What the columns of files with many traces are.
    names: Names,
    open: Mutex<Vec<(PathBuf, Rows)>>,
}

/// The traces of one group of a folder of results, each with a name for a file of its own.
///
/// # Errors
/// When they cannot be read.
pub fn apart(about: &About, group: &Group) -> Result<Vec<(String, Trace)>, trace::Error> {
    let option = |name| about.options.get(name).and_then(|value| value.as_str());
    let id = option("--trace-id").map(str::to_owned);
    let pair = |pair: &str| pair.split_once('=').map(|(from, to)| (from.into(), to.into()));
    let called =
        option("--columns").map_or(Vec::new(), |all| all.split(',').filter_map(pair).collect());
    // Where many lie in one file, names are columns and no part of a trace.
    let feed = Feed::new(Names { beside: about.by.iter().cloned().chain(id).collect(), called });
    let traces = Feed::whole(group, feed.rows(group)?)?;
    // One of many in a file has no name of its own yet.
    let name = |trace: &Trace| match trace.path {
        Some(_) => trace.label(),
        None => trace.label().replace(['/', '\\'], "-") + ".csv",
    };
    Ok(traces.into_iter().map(|trace| (name(&trace), trace)).collect())
}

impl Feed {
    /// A feed of traces, those in files with many of them with columns of these names.
    pub(super) fn new(names: Names) -> Self {
        Self { names, open: Mutex::default() }
    }

    /// What of a group lies in files with many traces; to be called in the order of the groups.
    pub(super) fn rows(&self, group: &Group) -> Result<Vec<Trace>, trace::Error> {
        let mut traces = Vec::new();
        for place in &group.places {
            if let Place::Rows { path, id, first, rows } = place {
                let mut open = self.open.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                traces.push(self.at(&mut open, path)?.trace(id, *first, *rows)?);
            }
        }
        Ok(traces)
    }

    /// All traces of a group in order of recording, as a single command would read them; `rows` is what [`Feed::rows`] gave.
    pub(super) fn whole(group: &Group, mut rows: Vec<Trace>) -> Result<Vec<Trace>, trace::Error> {
        let file = |place: &Place| match place {
            Place::File(path) => Some(path.clone()),
            Place::Rows { .. } => None,
        };
        let files: Vec<PathBuf> = group.places.iter().filter_map(file).collect();
        if files.is_empty() {
            order(&mut rows)?;
        } else {
            rows.extend(read_set(&files)?);
        }
        Ok(rows)
    }

    fn at<'a>(
        &self,
        open: &'a mut Vec<(PathBuf, Rows)>,
        path: &Path,
    ) -> Result<&'a mut Rows, trace::Error> {
        // The one that was used last stands last.
        let entry = match open.iter().position(|(known, _)| known == path) {
            Some(at) => open.remove(at),
            None => {
                if open.len() == OPEN {
                    open.remove(0);
                }
                (path.to_path_buf(), Rows::open(path, &self.names)?)
            }
        };
        open.push(entry);
        let last = open.len() - 1;
        Ok(&mut open[last].1)
    }
}
