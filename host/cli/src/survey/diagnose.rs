//! `palpate survey diagnose`.

use std::path::PathBuf;

use super::asking::Asking;
use super::fleet::{Fleet, Given, Survey};
use crate::preparation::Prepare;
use crate::{Failure, diagnose};
use palpate_diagnose::criticism::options::Options;
use palpate_diagnose::criticism::{agreement, dependence, screen};
use palpate_model::Model;
use palpate_survey::row::Asked;
use palpate_survey::{Group, Place};

/// Say which physical effect a model lacks in each group, as `palpate diagnose` does.
#[derive(clap::Args)]
#[command(after_help = "\
The model is refitted to each group before anything is missed in it, so one model of the kind of specimen
does for all. With a key such as `date` the report says since when an effect is missing.

Examples:
  palpate survey diagnose --model model.toml lab/ --by finger,date -o missing --report missing.html")]
pub struct Args {
    /// The model
    #[arg(long, value_name = "MODEL.toml")]
    model: PathBuf,
    #[command(flatten)]
    fleet: Fleet,
    #[command(flatten)]
    prepare: Prepare,
}

/// To diagnose each group.
pub fn survey(args: &Args) -> Result<Survey<'_>, Failure> {
    let model = Model::read(&args.model).map_err(Failure::input)?;
    let given = Given::new(&args.model, &model)?;
    let ask = move |group: &Group, traces| {
        let next = diagnose::next(&args.model, &files(group), &args.prepare.flags());
        diagnose::ask(&args.prepare, model.clone(), traces, next)
    };
    let seeds = [
        ("null", screen::SEED),
        ("resampling", Options::default().seed),
        ("dependence", dependence::SEED),
        ("agreement", agreement::SEED),
    ];
    Ok(Survey::new(&args.fleet, Asking::new(Asked::Diagnose, ask)).of(Some(given)).with(seeds))
}

/// The files of a group, each once: what a single command would be given.
fn files(group: &Group) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = Vec::new();
    for place in &group.places {
        let (Place::File(path) | Place::Rows { path, .. }) = place;
        if files.last() != Some(path) {
            files.push(path.clone());
        }
    }
    files
}
