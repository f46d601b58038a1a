//! `palpate survey decompose`.

use std::path::PathBuf;

use super::asking::Asking;
use super::fleet::{Fleet, Given};
use crate::cli::answer::Answer;
use crate::cli::{Failure, decompose};
use crate::model::Model;
use crate::survey::row::Asked;

/// Split the signals of each group into fast and slow adapting parts, as `palpate decompose` does.
#[derive(clap::Args)]
#[command(after_help = "\
The rows tell when each region of the grasp begins and ends in each signal; `palpate decompose -o` writes
the parts themselves.

Examples:
  palpate survey decompose lab/ --by finger -o regions")]
pub struct Args {
    #[command(flatten)]
    fleet: Fleet,
    /// Take the relaxation function from this model; without it, that of eq. 3.6 is taken
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,
    #[command(flatten)]
    options: decompose::Options,
}

/// Splits the signals of each group.
pub fn run(args: &Args) -> Result<(), Failure> {
    let model = args.model.as_deref().map(Model::read).transpose().map_err(Failure::input)?;
    let ask = |_: &_, traces| {
        let found = decompose::ask(&args.options, model.as_ref(), traces)?;
        Ok(Box::new(found) as Box<dyn Answer>)
    };
    let given =
        args.model.as_deref().zip(model.as_ref()).map(|(path, model)| Given { path, model });
    args.fleet.ask(given.as_ref(), Default::default(), &Asking::new(Asked::Decompose, ask))
}
