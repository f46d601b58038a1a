//! `palpate segment`.

use std::path::PathBuf;

use serde_json::json;

use super::Failure;
use super::output::Output;
use crate::analysis::cycles::segment;
use crate::analysis::pull_off_growth::growth;
use crate::summary::{growth_section, pull_off_growth_json, segment_json, segment_sections};
use crate::trace::{Trace, read_set};

/// Cut grasps into their six regions, cycle by cycle: points, forces, work, dissipation.
#[derive(clap::Args)]
#[command(after_help = "\
Regions are those of Fig. 3.10: OA preloading, AB loading, BC transition, CD relaxation (or creep),
DE unloading, EF recovery. They follow from the displacement, or from the force where that was
controlled: the head says so (`control = \"force\"`), else the data do. Where the specimen adheres, the
pull on the way out has its force, work and separation; several speeds are compared.

Examples:
  palpate segment press.csv                        points, regions and work
  palpate segment cycles.csv --report loops.html   the loops, with their points
  palpate segment slow.csv fast.csv                pull-off over the speed of the retreat
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
    let mut sections: Vec<_> =
        found.iter().flat_map(|(trace, found)| segment_sections(trace, found)).collect();
    let cycles = found.iter().flat_map(|(_, found)| &found.cycles);
    let growth = growth(&cycles.filter_map(|cycle| cycle.pull_off).collect::<Vec<_>>());
    sections.extend(growth.as_ref().map(growth_section));
    let names = traces.iter().map(Trace::label).collect();
    let json = || {
        let traces = found.iter().map(|(trace, found)| segment_json(trace, found));
        json!({
            "palpate_segment": 1,
            "traces": traces.collect::<Vec<_>>(),
            "pull_off_growth": growth.as_ref().map(pull_off_growth_json),
        })
    };
    args.result.give("The regions of a grasp", "", names, &sections, json)
}
