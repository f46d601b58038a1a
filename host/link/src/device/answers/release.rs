//! Whether firmware and program go together, as the page reads it.

use serde::Serialize;

use crate::device::release::Verdict;
use crate::device::session::VERSION;

/// How the firmware's release is to the program's.
#[derive(Clone, Debug, Serialize)]
pub struct ReleaseAnswer {
    /// Whether they speak the same messages.
    pub speaks: bool,
    /// Version of the firmware.
    pub firmware: String,
    /// Version of the program.
    pub program: &'static str,
    /// How they are to each other, in a sentence.
    pub words: String,
    /// What to do, in a sentence.
    pub advice: String,
}

impl From<&Verdict> for ReleaseAnswer {
    fn from(verdict: &Verdict) -> Self {
        let Verdict { speaks, firmware, words, advice } = verdict.clone();
        Self { speaks, firmware, program: VERSION, words, advice }
    }
}
