//! `palpate markers`.

use std::path::PathBuf;

use super::Failure;
use super::output::Output;
use super::strain_rate::parse_order;
use palpate_analysis::markers::markers;
use palpate_analysis::strain_rate::Order;
use palpate_present::answers::{self, MarkersAnswer};
use palpate_present::summary::markers_sections;
use palpate_trace::{Trace, read_set};

/// Markers that a camera follows: the latency model of the gaps between them.
#[derive(clap::Args)]
#[command(after_help = "\
Markers are columns marker1_mm, marker2_mm, … of a trace: their places along the direction of
compression, in their order. While the specimen is held, the gap between two neighbours still goes to an
equilibrium, and so gives the rate of the latency model inside of it, without a force. Holds are those
of the displacement, or of a controlled force; a trace of markers alone is one hold. What a camera wrote
with other names or units comes in with `palpate import`.

Examples:
  palpate markers hold.csv                     the lowest odd order that fits
  palpate markers hold.csv --order 1           the linear model (chapter 4)
  palpate markers traces/ --report gaps.html")]
pub struct Args {
    /// Traces, or folders of traces
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    /// n: a number from 1 to 25, free, or odd: the lowest odd one that fits all gaps as well as the best
    #[arg(long, default_value = "odd", value_parser = parse_order)]
    order: Order,
    #[command(flatten)]
    result: Output,
}

/// Fits and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.result.files(&args.traces)?;
    let traces = read_set(&args.traces).map_err(Failure::input)?;
    let study = markers(&traces, args.order).map_err(Failure::input)?;
    let names = traces.iter().map(Trace::label).collect();
    let sections = markers_sections(&study);
    let json = || answers::json(&MarkersAnswer::from(&study));
    args.result.give("Gaps between markers", "", names, &sections, json)
}
