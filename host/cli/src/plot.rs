//! `palpate plot`.

use std::path::{Path, PathBuf};

use super::Failure;
use super::output::{Force, print, terminal, write_file, write_report};
use palpate_present::summary::{loops, name_of, overview, trace_panels, unit_of};
use palpate_report::{Figure, Section};
use palpate_trace::files::plan::{DRAWING, Plan, REPORT};
use palpate_trace::{Trace, has_extension, read_set};

/// Draw traces, in the terminal or into a file.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  palpate plot press.csv                    in the terminal
  palpate plot press.csv -o press.html      a page to look at closely
  palpate plot press.csv -o press.svg       one figure, for a document
  palpate plot traces/ -o all.html          every trace, and the loops of force over displacement")]
pub struct Args {
    /// Traces, or folders of traces
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    /// Where to draw: .html for any number of traces, .svg for one [default: in the terminal]
    #[arg(short, long, value_name = "FILE.html|FILE.svg")]
    output: Option<PathBuf>,
    #[command(flatten)]
    over: Force,
}

/// Draws the traces and prints what they hold. A file is written only where one is named.
pub fn run(args: &Args) -> Result<(), Failure> {
    let traces = read_set(&args.traces).map_err(Failure::input)?;
    let mut files = Plan::reading(&args.traces, args.over.into());
    let drawn = match &args.output {
        None => in_terminal(&traces),
        Some(path) if has_extension(path, "svg") => {
            files.writes(path, &DRAWING)?;
            svg(path, &traces)?;
            String::new()
        }
        Some(path) => {
            files.writes(path, &REPORT)?;
            html(path, &traces)?;
            String::new()
        }
    };
    print(&(drawn + &terminal().table(&overview(&traces))))
}

/// Most traces of which every column is a plot of its own; of more, every column is one line.
const MOST_PLOTTED: usize = 2;
/// Rows of characters of a plot.
const HEIGHT: usize = 7;

fn in_terminal(traces: &[Trace]) -> String {
    let terminal = terminal();
    let mut text = String::new();
    for trace in traces {
        text += &terminal.text("", &trace.label());
        if traces.len() <= MOST_PLOTTED {
            for column in &trace.columns {
                let label = with_unit(&name_of(&column.name), unit_of(&column.name));
                text += &terminal.chart(&trace.time, &column.values, &label, "time (s)", HEIGHT);
            }
        } else {
            let names: Vec<String> = trace.columns.iter().map(|c| name_of(&c.name)).collect();
            let widest = names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
            let width = terminal.width.saturating_sub(widest + 3).min(80);
            for (name, column) in names.iter().zip(&trace.columns) {
                text +=
                    &format!("  {name:<widest$} {}\n", terminal.sparkline(&column.values, width));
            }
        }
        text += "\n";
    }
    text
}

fn with_unit(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} ({unit})") }
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
