//! `palpate device self-test`.

use miette::miette;

use super::{At, failed};
use crate::Failure;
use crate::output::{print_json, print_sections};
use palpate_link::device::answers::SelfTestAnswer;
use palpate_link::device::self_test;
use palpate_present::answers;
use palpate_present::summary::self_test_sections;

/// Test converter, bridges and rate.
#[derive(clap::Args)]
#[command(after_help = "\
Leave the fingertip alone while it is tested. A converter that can is tested without the gauges too: with its
inputs joined, and with a signal of its own. Exit status 1 if something is wrong.

Examples:
  palpate device self-test
  palpate device self-test --json")]
pub struct Args {
    #[command(flatten)]
    at: At,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

/// Tests and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    let (_, mut session) = args.at.open()?;
    session.quiet().map_err(failed)?;
    let tested = self_test::run(&mut session).map_err(failed)?;
    if args.json {
        print_json(&answers::json(&SelfTestAnswer::from(&tested)))?;
    } else {
        print_sections(&self_test_sections(&tested, session.settings().1))?;
    }
    match self_test::faults(&tested).len() {
        0 => Ok(()),
        1 => Err(Failure::Work(miette!("the self-test found a fault"))),
        faults => Err(Failure::Work(miette!("the self-test found {faults} faults"))),
    }
}
