//! One file for each subcommand: parse, call, print.

pub mod import;

/// Why a command failed.
#[derive(Debug)]
pub enum Failure {
    /// The input or the call was wrong; exit status 2.
    Input(miette::Report),
    /// The work failed; exit status 1.
    Work(miette::Report),
}
