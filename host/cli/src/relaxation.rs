//! `palpate relaxation`.

use std::path::PathBuf;
use std::sync::Arc;

use serde_json::Value;

use super::answer::{Answer, labels};
use super::fit::parse_terms;
use super::output::Output;
use super::{Failure, progress};
use palpate_analysis::relaxation::{Hold, relaxation};
use palpate_fit::hold::{HoldError, Terms};
use palpate_present::answers::{self, RelaxationAnswer};
use palpate_present::summary::relaxation_sections;
use palpate_report::Section;
use palpate_trace::{FORCE, Trace, read_set};

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
    #[command(flatten)]
    options: Options,
    #[command(flatten)]
    result: Output,
}

/// What is fitted to the holds.
#[derive(clap::Args)]
pub struct Options {
    /// Exponentials of eq. 3.4: 1 to 4, or auto
    #[arg(long, default_value = "2", value_parser = parse_terms)]
    terms: Terms,
    /// Let no share ci have the wrong sign for its type, nor c0 be negative
    #[arg(long)]
    signs: bool,
    /// The column to fit
    #[arg(long, default_value = FORCE, value_name = "COLUMN")]
    signal: String,
}

/// Fits and prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.result.files(&args.traces)?;
    let traces = Arc::new(read_set(&args.traces).map_err(Failure::input)?);
    args.result.show(&*ask(&args.options, traces)?)
}

/// What the holds of traces in memory show.
pub fn ask(options: &Options, traces: Arc<Vec<Trace>>) -> Result<Box<dyn Answer>, Failure> {
    let wait = progress::bar(traces.len(), "fitting holds");
    let (mut holds, mut left_out) = (Vec::new(), Vec::new());
    for trace in &*traces {
        let found = relaxation(trace, &options.signal, options.terms, options.signs);
        let found = found.map_err(Failure::input)?;
        holds.extend(found.holds);
        left_out.extend(found.left_out);
        wait.inc(1);
    }
    wait.finish_and_clear();
    Ok(Box::new(Relaxed { traces, signal: options.signal.clone(), holds, left_out }))
}

/// What holds show.
struct Relaxed {
    traces: Arc<Vec<Trace>>,
    signal: String,
    holds: Vec<Hold>,
    left_out: Vec<HoldError>,
}

impl Answer for Relaxed {
    fn title(&self) -> &'static str {
        "Relaxation"
    }

    fn subtitle(&self) -> String {
        self.signal.clone()
    }

    fn inputs(&self) -> Vec<String> {
        labels(&self.traces)
    }

    fn json(&self) -> Value {
        answers::json(&RelaxationAnswer::of(&self.holds, &self.left_out, &self.signal))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        Ok(relaxation_sections(&self.holds, &self.left_out, &self.traces, &self.signal))
    }
}
