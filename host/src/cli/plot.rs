//! `palpate plot`.

use std::path::{Path, PathBuf};

use super::Failure;
use super::output::{Force, print, terminal, write_file, write_report};
use crate::files::plan::{DRAWING, Plan, REPORT};
use crate::report::{Figure, Section};
use crate::summary::{loops, overview, trace_panels};
use crate::trace::{Trace, has_extension, read_set};

/// Draw traces.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  palpate plot press.csv                    writes press.html
  palpate plot press.csv -o press.svg       one figure, for a document
  palpate plot traces/ -o all.html          every trace, and the loops of force over displacement")]
pub struct Args {
    /// Traces, or folders of traces
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    /// Where to draw: .html for any number of traces, .svg for one
    #[arg(short, long, value_name = "FILE.html|FILE.svg")]
    output: Option<PathBuf>,
    #[command(flatten)]
    over: Force,
}

/// Draws the traces and prints what they hold.
pub fn run(args: &Args) -> Result<(), Failure> {
    let traces = read_set(&args.traces).map_err(Failure::input)?;
    let path = args.output.clone().unwrap_or_else(|| default_path(&traces));
    let mut files = Plan::reading(&args.traces, args.over.into());
    if has_extension(&path, "svg") {
        files.writes(&path, &DRAWING)?;
        svg(&path, &traces)?;
    } else {
        files.writes(&path, &REPORT)?;
        html(&path, &traces)?;
    }
    print(&terminal().table(&overview(&traces)))
}

/// The first trace's name with .html, in this folder.
fn default_path(traces: &[Trace]) -> PathBuf {
    let label = traces.first().map_or("traces".into(), Trace::label);
    PathBuf::from(label).with_extension("html")
}

fn svg(path: &Path, traces: &[Trace]) -> Result<(), Failure> {
    let [trace] = traces else {
        return Err(Failure::Input(miette::miette!(
            "an SVG holds one trace, {} were named: write an .html, or name one",
            traces.len()
        )));
    };
    write_file(path, Figure::from(trace_panels(trace)).to_svg().as_bytes())?;
    eprintln!("drawn: {}", path.display());
    Ok(())
}

fn html(path: &Path, traces: &[Trace]) -> Result<(), Failure> {
    let mut section = Section::new("Traces").table(overview(traces));
    for trace in traces {
        let caption = trace.head.name.clone().unwrap_or_default();
        section = section.figure(trace_panels(trace), caption);
    }
    let mut sections = vec![section];
    if let Some(plot) = loops(traces) {
        sections.push(Section::new("Loops").figure(plot, ""));
    }
    let names = traces.iter().map(Trace::label).collect();
    write_report(path, "Recordings", "as they are", names, sections)
}
