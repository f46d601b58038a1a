//! `palpate demo`.

use std::path::PathBuf;

use super::output::{Force, print, print_sections, terminal, write_report};
use super::{Failure, progress};
use palpate_analysis::press::{Press, analyse};
use palpate_present::bundled::press;
use palpate_present::summary::{name_of, press_sections};
use palpate_report::Section;
use palpate_trace::Trace;
use palpate_trace::files::plan::{Kind, Plan, REPORT};

/// The recording, known by its name.
const TRACE: Kind = Kind {
    endings: &["csv"],
    marks: &["\n# name = \"made-up press of a fingertip with four gauges\"\n"],
};

/// Replay a bundled press through the device's filter, fit it, write a report.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  palpate demo                          writes palpate-demo.html here
  palpate demo --report /tmp/press.html
  palpate demo --trace press.csv        keeps the recording, to try other commands on")]
pub struct Args {
    /// Where to write the report
    #[arg(long, value_name = "FILE.html", default_value = "palpate-demo.html")]
    report: PathBuf,
    /// Also write the recording itself
    #[arg(long, value_name = "FILE.csv")]
    trace: Option<PathBuf>,
    #[command(flatten)]
    over: Force,
}

/// Runs the demo.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut files = Plan::reading([""; 0], args.over.into());
    files.writes(&args.report, &REPORT)?;
    if let Some(path) = &args.trace {
        files.writes(path, &TRACE)?;
    }
    let trace = press();
    if let Some(path) = &args.trace {
        palpate_trace::write(path, &trace).map_err(Failure::work)?;
        eprintln!("recording: {}", path.display());
    }
    let bar = progress::bar(trace.len() * trace.gauges().len(), "replaying four gauges");
    let found = analyse(&trace, || bar.inc(1)).map_err(Failure::work)?;
    bar.finish_and_clear();
    let sections = press_sections(&trace, &found);
    print(&lines(&trace, &found))?;
    print_sections(&sections.iter().map(in_short).collect::<Vec<_>>())?;
    let subtitle = "one press: from four gauges to a fitted model";
    write_report(&args.report, "palpate demo", subtitle, vec![trace.label()], sections)?;
    print(&format!("Open {} in a browser.\n", args.report.display()))
}

/// Signal, FA and SA of every gauge, each as one line of blocks.
fn lines(trace: &Trace, press: &Press) -> String {
    let terminal = terminal();
    let width = terminal.width.saturating_sub(20).min(80);
    let what =
        format!("{} s of a press, replayed through the filter of the device", trace.duration());
    let mut text = terminal.text("", &what) + "\n";
    for (channel, _) in &press.channels {
        let name = name_of(&channel.signal);
        for (label, values) in
            [("signal", &channel.input), ("FA", &channel.fa), ("SA", &channel.sa)]
        {
            text += &format!("{name:>8} {label:<7} {}\n", terminal.sparkline(values, width));
        }
    }
    text + "\n"
}

/// A section without what only the report needs.
fn in_short(section: &Section) -> Section {
    use palpate_report::Block;
    let kept = section
        .blocks
        .iter()
        .filter(|block| matches!(block, Block::Table(_) | Block::Callout { .. }));
    Section { title: section.title.clone(), blocks: kept.cloned().collect() }
}
