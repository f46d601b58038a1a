//! `palpate dissertation`.

use std::path::PathBuf;

use super::output::{Force, print_json, print_sections, write_file, write_report};
use super::{Failure, progress};
use palpate_present::answers::{self, DissertationAnswer};
use palpate_present::dissertation::{Comparison, chapters};
use palpate_present::summary::{
    COMPARISONS_HEADER, comparisons_csv, dissertation_overview, dissertation_report,
};
use palpate_trace::files::plan::{Plan, REPORT, table};

/// Recompute every printed table, equation and figure of the dissertation.
#[derive(clap::Args)]
#[command(after_help = "\
Writes into the folder:
  report.html        every chapter: printed beside recomputed, figures redrawn, slips noted
  comparisons.csv    each printed figure, the same one recomputed, and what their agreement shows

Exit status 1 when a figure that should agree does not.

Examples:
  palpate dissertation -o dissertation/
  palpate dissertation -o dissertation/ --json | jq '.kinds'")]
pub struct Args {
    /// The folder to write into; made where it is not there
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Print one JSON object instead of tables
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    over: Force,
}

/// Computes, writes, prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    let (comparisons, report) =
        (args.output.join("comparisons.csv"), args.output.join("report.html"));
    let mut files = Plan::reading([""; 0], args.over.into());
    files.writes(&comparisons, &table(&[COMPARISONS_HEADER]))?;
    files.writes(&report, &REPORT)?;
    std::fs::create_dir_all(&args.output)
        .map_err(|source| super::output::cannot_write(&args.output, source))?;
    let wait = progress::spinner("recomputing every chapter");
    let chapters = chapters();
    wait.finish_and_clear();
    let chapters = chapters.map_err(Failure::work)?;
    write_file(&comparisons, comparisons_csv(&chapters).as_bytes())?;
    write_report(
        &report,
        "A dissertation recomputed",
        "Chia-Hung Dylan Tsai, Nonlinear Modeling on Viscoelastic Contact Interface",
        Vec::new(),
        dissertation_report(&chapters),
    )?;
    if args.json {
        print_json(&answers::json(&DissertationAnswer::of(&chapters)))?;
    } else {
        print_sections(&[dissertation_overview(&chapters)])?;
    }
    let missed =
        chapters.iter().flat_map(|chapter| &chapter.comparisons).flat_map(Comparison::missed);
    match missed.count() {
        0 => Ok(()),
        count => Err(Failure::Work(miette::miette!("{count} printed figures do not agree"))),
    }
}
