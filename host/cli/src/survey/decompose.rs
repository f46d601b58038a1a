//! `palpate survey decompose`.

use std::path::PathBuf;

use super::asking::Asking;
use super::fleet::{Fleet, Given, Survey};
use crate::answer::Answer;
use crate::{Failure, decompose};
use palpate_model::Model;
use palpate_survey::row::Asked;

/// Split the signals of each group into fast and slow adapting parts, as `palpate decompose` does.
#[derive(clap::Args)]
#[command(after_help = "\
The rows report when each region of the grasp begins and ends in each signal; `palpate decompose -o` writes
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

/// To split the signals of each group.
pub fn survey(args: &Args) -> Result<Survey<'_>, Failure> {
    let model = args.model.as_deref().map(Model::read).transpose().map_err(Failure::input)?;
    let given = match args.model.as_deref().zip(model.as_ref()) {
        Some((path, model)) => Some(Given::new(path, model)?),
        None => None,
    };
    let ask = move |_: &_, traces| {
        let found = decompose::ask(&args.options, model.as_ref(), traces)?;
        Ok(Box::new(found) as Box<dyn Answer>)
    };
    Ok(Survey::new(&args.fleet, Asking::new(Asked::Decompose, ask)).of(given))
}
