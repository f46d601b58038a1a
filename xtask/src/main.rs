//! Set-up, the whole check, generated recordings: `cargo xtask --help`.

mod check;
mod traces;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

#[derive(Parser)]
#[command(about = "Set-up, the whole check, generated recordings", bin_name = "cargo xtask")]
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
}

fn main() -> ExitCode {
    let outcome = match Arguments::parse().task {
        Task::Test => check::run(),
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
