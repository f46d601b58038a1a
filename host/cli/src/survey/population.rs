//! `palpate survey population`.

use std::path::PathBuf;

use serde_json::Value;

use super::fleet::{asked_of, wrong};
use crate::Failure;
use crate::answer::Answer;
use crate::output::Output;
use palpate_present::answers::{self, PopulationAnswer};
use palpate_present::summary::population_sections;
use palpate_report::Section;
use palpate_survey::population::{FEWEST, Population};
use palpate_survey::results::{About, about, read_rows};

/// What all specimens have in common, and how much they differ.
#[derive(clap::Args)]
#[command(after_help = "\
One model over all specimens of a survey of fits: the typical value of every parameter, which parameters
the specimens share and which vary, and how much beyond the errors of the fits (two stages, the second by
restricted maximum likelihood). With a key such as `date` the spread from specimen to specimen is told
from that between occasions. Of a survey of diagnoses: which effects the population has, in which part.

Examples:
  palpate survey population results
  palpate survey population results --json | jq '.parameters[] | select(.varies)'")]
pub struct Args {
    /// Folder of the results
    #[arg(value_name = "RESULTS")]
    results: PathBuf,
    #[command(flatten)]
    result: Output,
}

/// Tells what the population is.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.result.files([&args.results])?;
    let folder = &args.results;
    let about = about(folder).map_err(wrong)?;
    let mut rows = Vec::new();
    read_rows(folder, &about, |row, _| rows.push(row)).map_err(wrong)?;
    let population = Population::of(&about, &rows);
    if population.specimens < FEWEST {
        return Err(Failure::Input(miette::miette!(
            "{}: {} specimens with an answer; a population needs at least {FEWEST}",
            folder.display(),
            population.specimens
        )));
    }
    args.result.show(&Found { about, population, folder: folder.display().to_string() })
}

struct Found {
    about: About,
    population: Population,
    folder: String,
}

impl Answer for Found {
    fn title(&self) -> &'static str {
        "A population"
    }

    fn subtitle(&self) -> String {
        asked_of(&self.about)
    }

    fn inputs(&self) -> Vec<String> {
        vec![self.folder.clone()]
    }

    fn json(&self) -> Value {
        answers::json(&PopulationAnswer::of(&self.about, &self.population, &self.folder))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        Ok(population_sections(&self.population))
    }
}
