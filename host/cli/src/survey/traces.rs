//! `palpate survey traces`.

use std::fs;
use std::path::PathBuf;

use super::fleet::wrong;
use crate::Failure;
use crate::output::{Force, cannot_write};
use palpate_report::number::counted;
use palpate_survey::results::{about, group};
use palpate_survey::{Group, apart};
use palpate_trace::files::plan::{Plan, TRACE};
use palpate_trace::write;

/// The traces of one group, as a folder for the other commands and the Lab.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  palpate survey traces results 17 -o group-17
  palpate serve group-17 --open")]
pub struct Args {
    /// Folder of the results
    #[arg(value_name = "RESULTS")]
    results: PathBuf,
    /// Number of the group, as its row has it
    #[arg(value_name = "GROUP")]
    group: u64,
    /// Folder for the traces
    #[arg(short, long, required = true, value_name = "DIR")]
    output: PathBuf,
    #[command(flatten)]
    over: Force,
}

/// Writes the traces of a group.
pub fn run(args: &Args) -> Result<(), Failure> {
    let about = about(&args.results).map_err(wrong)?;
    let group = group(&args.results, args.group).map_err(wrong)?;
    let traces = apart(&about, &group).map_err(Failure::input)?;
    let mut files = Plan::reading([&args.results], args.over.into());
    let mut named = Vec::new();
    for (name, trace) in &traces {
        let path = args.output.join(name);
        files.writes(&path, &TRACE)?;
        named.push((path, trace));
    }
    fs::create_dir_all(&args.output).map_err(|source| cannot_write(&args.output, source))?;
    for (path, trace) in named {
        write(&path, trace).map_err(Failure::work)?;
    }
    tell(&group, &about.by, &args.output, traces.len());
    Ok(())
}

fn tell(group: &Group, by: &[String], folder: &std::path::Path, traces: usize) {
    eprintln!("{}: {} in {}", group.in_words(by), counted(traces, "trace"), folder.display());
}
