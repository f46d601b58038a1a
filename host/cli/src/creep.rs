//! `palpate creep`.

use std::path::PathBuf;

use super::fit::parse_terms;
use super::output::Output;
use super::{Failure, progress};
use palpate_analysis::conditioning::Butterworth;
use palpate_analysis::creep::creep;
use palpate_fit::hold::Terms;
use palpate_present::answers::{self, CreepAnswer};
use palpate_present::summary::{Conditioning, creep_sections};
use palpate_trace::{DISPLACEMENT, FORCE, Trace, read_set, sampling};

/// Creep in holds of a force: eq. 6.2, Type I and II, what is not identified.
#[derive(clap::Args)]
#[command(after_help = "\
Every hold of the force by itself: D (1 + Σ ci e^(−vi t)) with standard errors, Type I (after loading)
or II (after unloading), one to four exponentials beside each other, and what the hold is too short to
determine. The force is what the head calls controlled (`control = \"force\"`), else the data show it. A
recording of a compliance alone is the answer to one step of force.

Examples:
  palpate creep hold-2N.csv
  palpate creep traces/ --signs --report creep.html
  palpate creep traces/ --cutoff 20                filter the force before holds are looked for
  palpate creep gel.csv --signal creep_compliance_per_Pa --terms 3")]
pub struct Args {
    /// Traces, or folders of traces
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    /// Exponentials of eq. 6.2: 1 to 4, or auto
    #[arg(long, default_value = "2", value_parser = parse_terms)]
    terms: Terms,
    /// Let no share ci have the wrong sign for its type (6.3, 6.4)
    #[arg(long)]
    signs: bool,
    /// The column to fit
    #[arg(long, default_value = DISPLACEMENT, value_name = "COLUMN")]
    signal: String,
    /// Filter the force first (Butterworth): frequency at which one pass is 3 dB down, Hz
    #[arg(long, value_name = "HZ")]
    cutoff: Option<f64>,
    /// Order of that filter, 1 to 8
    #[arg(long, default_value = "4", requires = "cutoff")]
    order: usize,
    /// Filter forward only, with its delay; without it forward and backward
    #[arg(long, requires = "cutoff")]
    one_way: bool,
    #[command(flatten)]
    result: Output,
}

/// Fits and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.result.files(&args.traces)?;
    let mut traces = read_set(&args.traces).map_err(Failure::input)?;
    let mut conditioning = None;
    if let Some(filter) = filter(args) {
        for trace in &mut traces {
            conditioning = condition(trace, filter)?.or(conditioning);
        }
    }
    let wait = progress::bar(traces.len(), "fitting holds");
    let (mut holds, mut left_out) = (Vec::new(), Vec::new());
    for trace in &traces {
        let found = creep(trace, &args.signal, args.terms, args.signs);
        let found = found.map_err(Failure::input)?;
        holds.extend(found.holds);
        left_out.extend(found.left_out);
        wait.inc(1);
    }
    wait.finish_and_clear();
    let sections = creep_sections(&holds, &left_out, &traces, &args.signal, conditioning);
    let names = traces.iter().map(Trace::label).collect();
    let json = || answers::json(&CreepAnswer::of(&holds, &left_out, &args.signal, conditioning));
    args.result.give("Creep", &args.signal, names, &sections, json)
}

fn filter(args: &Args) -> Option<Butterworth> {
    let (order, zero_phase) = (args.order, !args.one_way);
    args.cutoff.map(|cutoff_hz| Butterworth { cutoff_hz, order, zero_phase })
}

/// Filters the force of a trace that has one.
fn condition(trace: &mut Trace, filter: Butterworth) -> Result<Option<Conditioning>, Failure> {
    let Some(force) = trace.force() else {
        return Err(Failure::Input(miette::miette!(
            "{}: --cutoff filters the force, and there is no column force_N",
            trace.label()
        )));
    };
    let filtered = filter.filter(trace, force).map_err(Failure::input)?;
    trace.set_column(FORCE, filtered);
    Ok(sampling(&trace.time).map(|sampling| (filter, sampling.rate_hz())))
}
