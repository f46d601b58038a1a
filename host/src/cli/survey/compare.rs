//! `palpate survey compare`.

use std::path::PathBuf;

use serde_json::json;

use super::asking::Asking;
use super::fleet::{Fleet, Given};
use crate::cli::preparation::Prepare;
use crate::cli::{Failure, compare};
use crate::criticism::dependence;
use crate::model::Model;
use crate::survey::row::Asked;

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

/// Compares each group.
pub fn run(args: &Args) -> Result<(), Failure> {
    let model = Model::read(&args.model).map_err(Failure::input)?;
    let ask = |_: &_, traces| compare::ask(&args.prepare, model.clone(), traces);
    let given = Given { path: &args.model, model: &model };
    let seeds = [("dependence".to_owned(), json!(dependence::SEED))].into_iter().collect();
    args.fleet.ask(Some(&given), seeds, &Asking::new(Asked::Compare, ask))
}
