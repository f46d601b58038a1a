//! `palpate survey`: one file for each question, the rest here.

pub mod apart;
mod asking;
mod call;
mod compare;
mod decompose;
mod diagnose;
mod fit;
mod fleet;
mod population;
mod relaxation;
mod report;
mod segment;
mod traces;

use clap::Subcommand;

use super::{Failure, output};
use fleet::Survey;

/// Ask every group of a large data set, one row a group.
#[derive(clap::Args)]
#[command(after_help = "\
What is asked is what the single command answers, to the last bit; a group that fails is a row with its
reason. Results are a folder of Parquet files with a manifest; a survey that was interrupted goes on where
it was when the same command is called again.

Traces are grouped --by keys. A key is a column of a Parquet file with many traces, a folder `key=value`
on the way to a file, a part of its name (--names), or a key of its head (`finger`, `specimen.batch`);
`trace` is each trace by itself, `folder` the folder that it lies in.

Examples:
  palpate survey fit fung lab/ --by specimen,finger -o results
  palpate survey fit fung grasps.parquet --by trace_id -o results --report fleet.html
  palpate survey diagnose --model model.toml lab/ --by finger,date -o missing
  palpate survey segment lab/ --by finger --names '{finger}-*.csv' -o work
  palpate survey report results --report fleet.html
  palpate survey population results")]
pub struct Args {
    #[command(subcommand)]
    question: Question,
}

#[derive(Subcommand)]
enum Question {
    /// Fit a contact model to each group
    Fit(fit::Args),
    /// Compare a model with each group
    Compare(compare::Args),
    /// Say which physical effect a model lacks in each group
    Diagnose(diagnose::Args),
    /// Cut the grasps of each group into their regions
    Segment(segment::Args),
    /// What the holds of each group show
    Relaxation(relaxation::Args),
    /// Split the signals of each group into fast and slow adapting parts
    Decompose(decompose::Args),
    /// What all rows of a survey say together
    Report(report::Args),
    /// What all specimens have in common, and how much they differ
    Population(population::Args),
    /// The traces of one group, as a folder for the other commands and the Lab
    Traces(traces::Args),
}

/// Asks, or reports.
pub fn run(args: &Args) -> Result<(), Failure> {
    match &args.question {
        Question::Report(args) => report::run(args),
        Question::Population(args) => population::run(args),
        Question::Traces(args) => traces::run(args),
        question => {
            let survey = question.survey()?;
            survey.ask(output::called())?;
            survey.tell()
        }
    }
}

impl Question {
    /// What is asked of every group.
    fn survey(&self) -> Result<Survey<'_>, Failure> {
        match self {
            Self::Fit(args) => fit::survey(args),
            Self::Compare(args) => compare::survey(args),
            Self::Diagnose(args) => diagnose::survey(args),
            Self::Segment(args) => segment::survey(args),
            Self::Relaxation(args) => relaxation::survey(args),
            Self::Decompose(args) => decompose::survey(args),
            Self::Report(_) | Self::Population(_) | Self::Traces(_) => {
                Err(Failure::Input(miette::miette!("this command asks no group anything")))
            }
        }
    }
}
