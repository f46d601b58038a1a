//! `palpate hide`.

use std::path::{Path, PathBuf};

use super::output::{Output, print_json, print_sections, write_report};
use super::{Failure, progress};
use crate::practice::{Choice, check_empty, hide, open, seed_from_clock, write_set};
use crate::report::Section;
use crate::summary::{practice_json, practice_sections, trace_panels, truth_json, truth_sections};
use crate::trace::Trace;

/// Make a practice data set with a hidden effect; the truth goes to a sealed file.
#[derive(clap::Args)]
#[command(after_help = "\
Ten traces of a random made-up specimen: three amplitudes at three speeds and one of repeated cycles,
at 200 Hz, in air that wanders, with correlated noise. Each effect is so strong that the base law,
refitted, leaves SIZE times the noise. Without a name, effects are drawn from the library.

Examples:
  palpate hide -o practice/                 one effect, nobody knows which
  palpate hide --any 2 --seed 7 -o two/     two, the same on every run
  palpate hide mullins --size 0.5 -o faint/
  palpate hide --open practice/             what it was")]
pub struct Args {
    /// Effects to hide
    effects: Vec<String>,
    /// Hide so many effects drawn from the library [default: 1, without a name]
    #[arg(long, value_name = "N", conflicts_with = "effects", value_parser = clap::value_parser!(u8).range(1..=5))]
    any: Option<u8>,
    /// Seed of everything random [default: from the clock; it is printed]
    #[arg(long)]
    seed: Option<u64>,
    /// Misfit that each effect leaves, over the noise
    #[arg(long, value_name = "SIZE", default_value_t = 1.0)]
    size: f64,
    /// Folder to make; must be new or empty
    #[arg(short, long, value_name = "DIR", required_unless_present = "open")]
    output: Option<PathBuf>,
    /// Show what is hidden in a folder
    #[arg(long, value_name = "DIR", conflicts_with_all = ["effects", "any", "seed", "size", "output"])]
    open: Option<PathBuf>,
    #[command(flatten)]
    result: Output,
}

/// Makes a practice set, or opens one.
pub fn run(args: &Args) -> Result<(), Failure> {
    match (&args.open, &args.output) {
        (Some(folder), _) => reveal(folder, &args.result),
        (None, Some(folder)) => make(args, folder),
        (None, None) => {
            Err(Failure::Input(miette::miette!("name a folder with -o, or --open one")))
        }
    }
}

fn make(args: &Args, folder: &Path) -> Result<(), Failure> {
    args.result.files([""; 0])?;
    check_empty(folder).map_err(Failure::input)?;
    let choice = match (args.any, args.effects.is_empty()) {
        (Some(count), _) => Choice::Any(count.into()),
        (None, true) => Choice::Any(1),
        (None, false) => Choice::Named(args.effects.clone()),
    };
    let wait = progress::spinner("recording");
    let practice = hide(&choice, args.size, args.seed.unwrap_or_else(seed_from_clock));
    wait.finish_and_clear();
    let practice = practice.map_err(Failure::input)?;
    write_set(folder, &practice).map_err(Failure::work)?;
    let shown = folder.display().to_string();
    let sections = practice_sections(&practice, &shown);
    if let Some(path) = &args.result.report {
        let mut drawn = Section::new("The traces");
        for trace in &practice.traces {
            drawn = drawn.figure(trace_panels(trace), "");
        }
        let mut all = sections.clone();
        all.push(drawn);
        let names = practice.traces.iter().map(Trace::label).collect();
        write_report(path, "A practice set", "what is in it is for you to find", names, all)?;
    }
    if args.result.json {
        print_json(&practice_json(&practice, &shown))
    } else {
        print_sections(&sections)
    }
}

fn reveal(folder: &Path, result: &Output) -> Result<(), Failure> {
    result.files([folder])?;
    let truth = open(folder).map_err(Failure::input)?;
    let sections = truth_sections(&truth);
    if let Some(path) = &result.report {
        let names = vec![folder.display().to_string()];
        write_report(path, "The truth of a practice set", "", names, sections.clone())?;
    }
    if result.json { print_json(&truth_json(&truth)) } else { print_sections(&sections) }
}
