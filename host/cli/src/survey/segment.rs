//! `palpate survey segment`.

use super::asking::Asking;
use super::fleet::{Fleet, Survey};
use crate::{Failure, segment};
use palpate_survey::row::Asked;

/// Cut the grasps of each group into their regions, as `palpate segment` does.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  palpate survey segment lab/ --by finger --names '{finger}-*.csv' -o work")]
pub struct Args {
    #[command(flatten)]
    fleet: Fleet,
}

/// To cut the grasps of each group.
pub fn survey(args: &Args) -> Result<Survey<'_>, Failure> {
    let ask = |_: &_, traces| segment::ask(traces);
    Ok(Survey::new(&args.fleet, Asking::new(Asked::Segment, ask)))
}
