//! `palpate segment`.

use std::path::PathBuf;
use std::sync::Arc;

use serde_json::Value;

use super::Failure;
use super::answer::{Answer, labels};
use super::output::Output;
use palpate_analysis::cycles::{Segmentation, segment};
use palpate_analysis::pull_off_growth::{Growth, growth};
use palpate_present::answers::{self, SegmentationAnswer};
use palpate_present::summary::{growth_section, segment_sections};
use palpate_report::Section;
use palpate_trace::{Trace, read_set};

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
    let traces = Arc::new(read_set(&args.traces).map_err(Failure::input)?);
    args.result.show(&*ask(traces)?)
}

/// Cuts the grasps of traces in memory.
pub fn ask(traces: Arc<Vec<Trace>>) -> Result<Box<dyn Answer>, Failure> {
    let found = traces.iter().map(|trace| segment(trace).map_err(Failure::input));
    let found = found.collect::<Result<Vec<_>, Failure>>()?;
    let cycles = found.iter().flat_map(|found| &found.cycles);
    let growth = growth(&cycles.filter_map(|cycle| cycle.pull_off).collect::<Vec<_>>());
    Ok(Box::new(Segmented { traces, found, growth }))
}

/// Grasps in their six regions.
struct Segmented {
    traces: Arc<Vec<Trace>>,
    found: Vec<Segmentation>,
    growth: Option<Growth>,
}

impl Segmented {
    fn each(&self) -> impl Iterator<Item = (&Trace, &Segmentation)> {
        self.traces.iter().zip(&self.found)
    }
}

impl Answer for Segmented {
    fn title(&self) -> &'static str {
        "The regions of a grasp"
    }

    fn inputs(&self) -> Vec<String> {
        labels(&self.traces)
    }

    fn json(&self) -> Value {
        answers::json(&SegmentationAnswer::of(self.each(), self.growth.as_ref()))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        let mut sections = segment_sections(&self.each().collect::<Vec<_>>());
        sections.extend(self.growth.as_ref().map(growth_section));
        Ok(sections)
    }
}
