//! The `palpate` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    palpate::cli::run()
}
