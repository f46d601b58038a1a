//! `palpate survey relaxation`.

use super::asking::Asking;
use super::fleet::Fleet;
use crate::cli::{Failure, relaxation};
use crate::survey::row::Asked;

/// What the holds of each group show, as `palpate relaxation` tells it.
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

/// Fits the holds of each group.
pub fn run(args: &Args) -> Result<(), Failure> {
    let ask = |_: &_, traces| relaxation::ask(&args.options, traces);
    args.fleet.ask(None, Default::default(), &Asking::new(Asked::Relaxation, ask))
}
