//! `palpate hide`.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::answer::{Answer, labels};
use super::output::{Output, print_json, print_sections, write_report};
use super::{Failure, progress, simulate};
use palpate_diagnose::practice::{
    Choice, Practice, check_empty, hide, open, record, seed_from_clock, write_set,
};
use palpate_present::answers::{self, PracticeAnswer, PracticeRecording, TruthAnswer};
use palpate_present::summary::{practice_sections, trace_panels, truth_sections};
use palpate_report::Section;
use palpate_trace::files::plan::COMPUTED;
use palpate_trace::{read_set, write};

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
  palpate hide --record motion.csv -o practice/   one more recording of the same specimen
  palpate hide --open practice/             what it was")]
pub struct Args {
    #[command(flatten)]
    options: Options,
    /// Record this motion too, on the specimen of the practice set in the folder
    #[arg(long, value_name = "MOTION.csv", conflicts_with_all = ["open", "effects", "any", "seed", "size"], requires = "output")]
    record: Option<PathBuf>,
    /// Folder to make; must be new or empty, but for --record
    #[arg(short, long, value_name = "DIR", required_unless_present = "open")]
    output: Option<PathBuf>,
    /// Show what is hidden in a folder
    #[arg(long, value_name = "DIR", conflicts_with_all = ["effects", "any", "seed", "size", "output"])]
    open: Option<PathBuf>,
    #[command(flatten)]
    result: Output,
}

/// What is hidden.
#[derive(clap::Args)]
pub struct Options {
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
}

/// Makes a practice set, or opens one.
pub fn run(args: &Args) -> Result<(), Failure> {
    match (&args.open, &args.output, &args.record) {
        (Some(folder), ..) => reveal(folder, &args.result),
        (None, Some(folder), Some(motion)) => record_into(folder, motion, &args.result),
        (None, Some(folder), None) => make(args, folder),
        (None, None, _) => {
            Err(Failure::Input(miette::miette!("name a folder with -o, or --open one")))
        }
    }
}

fn make(args: &Args, folder: &Path) -> Result<(), Failure> {
    args.result.files([""; 0])?;
    check_empty(folder).map_err(Failure::input)?;
    let practice = ask(&args.options)?;
    write_set(folder, &practice).map_err(Failure::work)?;
    args.result.show(&Hidden { practice: &practice, folder: folder.display().to_string() })
}

/// Adds a recording of a motion to a practice set.
fn record_into(folder: &Path, path: &Path, result: &Output) -> Result<(), Failure> {
    let truth = open(folder).map_err(Failure::input)?;
    let traces = read_set(&[folder]).map_err(Failure::input)?;
    let motion = simulate::motion(path)?;
    let trace = record(&truth, &traces, &motion).map_err(Failure::input)?;
    let output = folder.join(trace.label());
    // The folder is read, and the recording is to lie in it: the next diagnosis takes both.
    result.files([path])?.writes(&output, &COMPUTED)?;
    write(&output, &trace).map_err(Failure::work)?;
    let recorded = output.display().to_string();
    let words = format!("Recorded {} s after the traces that were there.", trace.duration());
    let section =
        Section::new("One more recording").paragraph(words).figure(trace_panels(&trace), "");
    eprintln!("trace: {recorded}");
    let json = || answers::json(&PracticeRecording::of(&trace, &output));
    result.give("One more recording", "", vec![recorded.clone()], &[section], json)
}

/// Makes a practice set.
pub fn ask(options: &Options) -> Result<Practice, Failure> {
    let choice = match (options.any, options.effects.is_empty()) {
        (Some(count), _) => Choice::Any(count.into()),
        (None, true) => Choice::Any(1),
        (None, false) => Choice::Named(options.effects.clone()),
    };
    let wait = progress::spinner("recording");
    let practice = hide(&choice, options.size, options.seed.unwrap_or_else(seed_from_clock));
    wait.finish_and_clear();
    practice.map_err(Failure::input)
}

/// A practice set in its folder.
struct Hidden<'a> {
    practice: &'a Practice,
    folder: String,
}

impl Answer for Hidden<'_> {
    fn title(&self) -> &'static str {
        "A practice set"
    }

    fn subtitle(&self) -> String {
        "what is in it is for you to find".into()
    }

    fn inputs(&self) -> Vec<String> {
        labels(&self.practice.traces)
    }

    fn json(&self) -> Value {
        answers::json(&PracticeAnswer::of(self.practice, &self.folder))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        let traces = self.practice.traces.iter();
        let drawn = traces
            .fold(Section::new("The traces"), |drawn, trace| drawn.figure(trace_panels(trace), ""));
        let mut sections = self.in_short()?;
        sections.push(drawn);
        Ok(sections)
    }

    fn in_short(&self) -> Result<Vec<Section>, Failure> {
        Ok(practice_sections(self.practice, &self.folder))
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
    if result.json {
        print_json(&answers::json(&TruthAnswer::from(&truth)))
    } else {
        print_sections(&sections)
    }
}
