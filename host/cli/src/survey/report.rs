//! `palpate survey report`.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::fleet::{asked_of, wrong};
use crate::Failure;
use crate::answer::Answer;
use crate::output::Output;
use palpate_present::answers::{self, SurveyAnswer};
use palpate_present::summary::survey_sections;
use palpate_report::Section;
use palpate_survey::overview::Overview;
use palpate_survey::results::{About, about, read_rows};

/// What all rows of a survey say together.
#[derive(clap::Args)]
#[command(after_help = "\
Reports the distribution of every estimate, what lies far out, which effect is missing in how many groups
and, with a key such as `date`, since when and how estimates drift; and what failed, with its reason.

Examples:
  palpate survey report results --report fleet.html
  palpate survey report results --json | jq '.missing'")]
pub struct Args {
    /// Folder of the results
    #[arg(value_name = "RESULTS")]
    results: PathBuf,
    #[command(flatten)]
    result: Output,
}

/// Prints what all rows say.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.result.files([&args.results])?;
    args.result.show(&Found::read(&args.results)?)
}

/// What all rows of a folder say.
pub struct Found {
    about: About,
    overview: Overview,
    folder: String,
}

impl Found {
    /// Reads the rows of the parts that are finished.
    pub fn read(folder: &Path) -> Result<Self, Failure> {
        let about = about(folder).map_err(wrong)?;
        let mut overview = Overview::new(&about);
        read_rows(folder, &about, |row, worked| overview.add(&row, worked)).map_err(wrong)?;
        overview.finish();
        Ok(Self { about, overview, folder: folder.display().to_string() })
    }
}

impl Answer for Found {
    fn title(&self) -> &'static str {
        "A survey"
    }

    fn subtitle(&self) -> String {
        asked_of(&self.about)
    }

    fn inputs(&self) -> Vec<String> {
        vec![self.folder.clone()]
    }

    fn json(&self) -> Value {
        answers::json(&SurveyAnswer::of(&self.about, &self.overview, &self.folder))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        Ok(survey_sections(&self.about, &self.overview, &self.folder))
    }
}
