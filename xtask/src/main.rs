//! Set-up, the whole check, generated recordings and pages: `cargo xtask --help`.

mod check;
mod effects;
mod traces;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

#[derive(Parser)]
#[command(
    about = "Set-up, the whole check, generated recordings and pages",
    bin_name = "cargo xtask"
)]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Set up what the tests need, then run format, lints, all tests and the documentation.
    Test,
    /// Write the bundled recordings of tests/traces/ anew; the same bytes on every run.
    Traces,
    /// Write the pages of docs/effects/ anew, from the library's own declarations.
    Effects,
}

fn main() -> ExitCode {
    let outcome = match Arguments::parse().task {
        Task::Test => check::run(),
        Task::Effects => effects::write_all(),
        Task::Traces => traces::write_all(),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(report) => {
            eprintln!("error: {report}");
            ExitCode::FAILURE
        }
    }
}
