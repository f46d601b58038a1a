//! `palpate survey compare`.

use std::path::PathBuf;

use super::asking::Asking;
use super::fleet::{Fleet, Given, Survey};
use crate::preparation::Prepare;
use crate::{Failure, compare};
use palpate_diagnose::criticism::dependence;
use palpate_model::Model;
use palpate_survey::row::Asked;

/// Compare a model with each group, as `palpate compare` does.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  palpate survey compare model.toml lab/ --by finger,date -o errors")]
pub struct Args {
    /// The model
    #[arg(value_name = "MODEL.toml")]
    model: PathBuf,
    #[command(flatten)]
    fleet: Fleet,
    #[command(flatten)]
    prepare: Prepare,
}

/// To compare each group.
pub fn survey(args: &Args) -> Result<Survey<'_>, Failure> {
    let model = Model::read(&args.model).map_err(Failure::input)?;
    let given = Given::new(&args.model, &model)?;
    let seeds = [("dependence", dependence::SEED)];
    let ask = move |_: &_, traces| compare::ask(&args.prepare, model.clone(), traces);
    Ok(Survey::new(&args.fleet, Asking::new(Asked::Compare, ask)).of(Some(given)).with(seeds))
}
