//! `palpate survey fit`.

use super::asking::Asking;
use super::fleet::{Fleet, Survey};
use crate::{Failure, fit};
use palpate_survey::row::Asked;

/// Fit a contact model to each group, as `palpate fit` does.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  palpate survey fit fung lab/ --by specimen,finger -o results
  palpate survey fit fung grasps.parquet --by trace_id --terms auto -o results")]
pub struct Args {
    /// The base law; `palpate fit --help` lists them
    law: String,
    #[command(flatten)]
    fleet: Fleet,
    #[command(flatten)]
    options: fit::Options,
}

/// To fit each group.
pub fn survey(args: &Args) -> Result<Survey<'_>, Failure> {
    let law = Some(&args.law[..]);
    args.options.family(law)?;
    let ask = move |_: &_, traces| fit::ask(&args.options, law, traces);
    Ok(Survey::new(&args.fleet, Asking::new(Asked::Fit, ask)))
}
