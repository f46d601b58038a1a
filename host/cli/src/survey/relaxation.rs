//! `palpate survey relaxation`.

use super::asking::Asking;
use super::fleet::{Fleet, Survey};
use crate::{Failure, relaxation};
use palpate_survey::row::Asked;

/// What the holds of each group show, as `palpate relaxation` reports it.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  palpate survey relaxation lab/ --by specimen -o holds")]
pub struct Args {
    #[command(flatten)]
    fleet: Fleet,
    #[command(flatten)]
    options: relaxation::Options,
}

/// To fit the holds of each group.
pub fn survey(args: &Args) -> Result<Survey<'_>, Failure> {
    let ask = |_: &_, traces| relaxation::ask(&args.options, traces);
    Ok(Survey::new(&args.fleet, Asking::new(Asked::Relaxation, ask)))
}
