//! The `palpate` command, for the tests to drive.

use std::process::ExitCode;

fn main() -> ExitCode {
    palpate::cli::run()
}
