//! `palpate survey report`.

use std::path::{Path, PathBuf};

use super::fleet::wrong;
use crate::cli::Failure;
use crate::cli::output::Output;
use crate::summary::{survey_json, survey_sections};
use crate::survey::overview::Overview;
use crate::survey::results::{about, read_rows};

/// What all rows of a survey say together.
#[derive(clap::Args)]
#[command(after_help = "\
Tells the distribution of every estimate, what lies far out, which effect is missing in how many groups
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

/// Tells what all rows say.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.result.files([&args.results])?;
    tell(&args.results, &args.result)
}

/// Tells what the rows of a folder say.
pub fn tell(folder: &Path, result: &Output) -> Result<(), Failure> {
    let about = about(folder).map_err(wrong)?;
    let mut overview = Overview::new(&about);
    read_rows(folder, &about, |row, worked| overview.add(&row, worked)).map_err(wrong)?;
    overview.finish();
    let name = folder.display().to_string();
    let sections = survey_sections(&about, &overview, &name);
    let subtitle = format!("{} by {}", about.asked.word(), about.by.join(", "));
    let json = || survey_json(&about, &overview, &name);
    result.give("A survey", &subtitle, vec![name.clone()], &sections, json)
}
