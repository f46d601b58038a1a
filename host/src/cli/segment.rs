//! `palpate segment`.

use std::path::PathBuf;

use serde_json::json;

use super::Failure;
use super::output::Output;
use crate::analysis::cycles::segment;
use crate::summary::{segment_json, segment_sections};
use crate::trace::{Trace, read_set};

/// Cut grasps into their six regions, cycle by cycle: points, forces, work, dissipation.
#[derive(clap::Args)]
#[command(after_help = "\
Regions are those of Fig. 3.10: OA preloading, AB loading, BC transition, CD relaxation (or creep),
DE unloading, EF recovery. They follow from the displacement, or from the force where that was
controlled: the head says so (`control = \"force\"`), else the data do.

Examples:
  palpate segment press.csv                        points, regions and work
  palpate segment cycles.csv --report loops.html   the loops, with their points
  palpate segment traces/ --json | jq '.traces[].cycles[].dissipated_mJ'")]
pub struct Args {
    /// Traces, or folders of traces
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    #[command(flatten)]
    result: Output,
}

/// Segments and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.result.files(&args.traces)?;
    let traces = read_set(&args.traces).map_err(Failure::input)?;
    let found = traces
        .iter()
        .map(|trace| Ok((trace, segment(trace).map_err(Failure::input)?)))
        .collect::<Result<Vec<_>, Failure>>()?;
    let sections: Vec<_> =
        found.iter().flat_map(|(trace, found)| segment_sections(trace, found)).collect();
    let names = traces.iter().map(Trace::label).collect();
    let json = || {
        let traces = found.iter().map(|(trace, found)| segment_json(trace, found));
        json!({"palpate_segment": 1, "traces": traces.collect::<Vec<_>>()})
    };
    args.result.give("The regions of a grasp", "", names, &sections, json)
}
