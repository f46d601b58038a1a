//! `palpate relaxation`.

use std::path::PathBuf;

use super::fit::parse_terms;
use super::output::Output;
use super::{Failure, progress};
use crate::analysis::relaxation::relaxation;
use crate::fit::hold::Terms;
use crate::summary::{relaxation_json, relaxation_sections};
use crate::trace::{FORCE, Trace, read_set};

/// What holds of a displacement show: eq. 3.4, repeats, number of exponentials, latency model.
#[derive(clap::Args)]
#[command(after_help = "\
Every hold by itself: eq. 3.4 with standard errors, Type I or II; over repeats mean, standard deviation
and whether they differ by more than noise; one to four exponentials by R², information criterion and
error on samples left out; a power law and a stretched exponential beside them, ranked by the decades of
time that they predict; the linear latency model with its equilibrium. `palpate fit fung --hold-only`
gives the coefficients alone and keeps them as a model; `palpate creep` is for holds of a force.

Examples:
  palpate relaxation traces/
  palpate relaxation take-*.csv --report holds.html
  palpate relaxation step.csv --signal relaxation_modulus_Pa
  palpate relaxation traces/ --json | jq '.holds[].terms.decided'")]
pub struct Args {
    /// Traces, or folders of traces
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    /// Exponentials of eq. 3.4: 1 to 4, or auto
    #[arg(long, default_value = "2", value_parser = parse_terms)]
    terms: Terms,
    /// Let no share ci have the wrong sign for its type, nor c0 be negative
    #[arg(long)]
    signs: bool,
    /// The column to fit
    #[arg(long, default_value = FORCE, value_name = "COLUMN")]
    signal: String,
    #[command(flatten)]
    result: Output,
}

/// Fits and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.result.files(&args.traces)?;
    let traces = read_set(&args.traces).map_err(Failure::input)?;
    let wait = progress::bar(traces.len(), "fitting holds");
    let (mut holds, mut left_out) = (Vec::new(), Vec::new());
    for trace in &traces {
        let found = relaxation(trace, &args.signal, args.terms, args.signs);
        let found = found.map_err(Failure::input)?;
        holds.extend(found.holds);
        left_out.extend(found.left_out);
        wait.inc(1);
    }
    wait.finish_and_clear();
    let sections = relaxation_sections(&holds, &left_out, &traces, &args.signal);
    let names = traces.iter().map(Trace::label).collect();
    let json = || relaxation_json(&holds, &left_out, &args.signal);
    args.result.give("Relaxation", &args.signal, names, &sections, json)
}
