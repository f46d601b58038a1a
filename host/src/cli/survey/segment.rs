//! `palpate survey segment`.

use super::asking::Asking;
use super::fleet::Fleet;
use crate::cli::{Failure, segment};
use crate::survey::row::Asked;

/// Cut the grasps of each group into their regions, as `palpate segment` does.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  palpate survey segment lab/ --by finger --names '{finger}-*.csv' -o work")]
pub struct Args {
    #[command(flatten)]
    fleet: Fleet,
}

/// Cuts the grasps of each group.
pub fn run(args: &Args) -> Result<(), Failure> {
    let ask = |_: &_, traces| segment::ask(traces);
    args.fleet.ask(None, Default::default(), &Asking::new(Asked::Segment, ask))
}
