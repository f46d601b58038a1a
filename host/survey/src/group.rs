//! A group: traces of one specimen in one set-up, and where they are.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// Traces that are asked together.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Group {
    /// Its place in the survey, from 0.
    pub number: u64,
    /// The value of each key that traces are grouped by; none where the head of its file cannot be read.
    pub key: Vec<Option<String>>,
    /// Where its traces are, in order.
    pub places: Vec<Place>,
}

/// Where traces are.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Place {
    /// A file of its own: a trace, or a recording.
    File(PathBuf),
    /// Rows of a Parquet file with many traces.
    Rows {
        /// The file.
        path: PathBuf,
        /// What the trace is called there.
        id: String,
        /// Its first row, from 0.
        first: u64,
        /// Number of its rows.
        rows: u64,
    },
}

impl Group {
    /// Its keys in words: `finger 3, date 2026-11-02`.
    #[must_use]
    pub fn in_words(&self, by: &[String]) -> String {
        in_words(by, &self.key)
    }
}

/// Keys with their values, in words.
#[must_use]
pub fn in_words(by: &[String], key: &[Option<String>]) -> String {
    let pair = |(by, key): (&String, &Option<String>)| {
        let value = key.as_deref().unwrap_or("–");
        if by == "trace" || by == "folder" { value.to_owned() } else { format!("{by} {value}") }
    };
    by.iter().zip(key).map(pair).collect::<Vec<_>>().join(", ")
}
