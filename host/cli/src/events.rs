//! `palpate events`.

use std::path::PathBuf;

use super::Failure;
use super::output::Output;
use palpate_analysis::decomposition::{default_relaxation, relaxation_of};
use palpate_analysis::events::{Asked, contacts, events, relaxation_of_device};
use palpate_model::Model;
use palpate_present::answers::{self, EventsAnswer};
use palpate_present::summary::events_sections;
use palpate_trace::{Trace, read_set};

/// Touch, release and incipient slip, found in FA as a device finds them.
#[derive(clap::Args)]
#[command(after_help = "\
A burst of FA is a touch where nothing is held, a release where it takes more than half of what is
held; several jolts soon after each other, vibrations of FA above a corner, are an incipient slip. All
gauges of a trace are taken together, as those of one fingertip; a trace without gauges by its force.
The same code runs in `shared/` without an allocator, sample by sample: nothing later is looked at.

Each event has the time at which it was reported, and when it began by hindsight. A simulated trace says
what happened when; then each has its delay, and false alarms and misses are counted.

Examples:
  palpate sensor slip -o pull.csv
  palpate events pull.csv                           touch, and slip before it slides
  palpate events press.csv --signal force_N         a force instead of the gauges
  palpate events traces/ --json | jq '.traces[].events[]'
  palpate events pull.csv --report pull.html        FA with its levels, and the events")]
pub struct Args {
    /// Traces, or folders of traces
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    /// Columns that feel one contact, up to four; without it, the gauges, or the force where there is none
    #[arg(long, value_name = "COLUMN")]
    signal: Vec<String>,
    /// Take the relaxation function from this model; without it, that of the device or of eq. 3.6
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,
    /// FA of a burst, in the unit of the signal
    #[arg(long, value_name = "LEVEL")]
    burst: Option<f64>,
    /// Vibration of FA of a jolt, in the unit of the signal
    #[arg(long, value_name = "LEVEL")]
    jolt: Option<f64>,
    /// Jolts that make a slip, 2 to 8; 0 looks for none
    #[arg(long, value_name = "COUNT")]
    jolts: Option<u8>,
    /// Time within which these jolts come, s
    #[arg(long, value_name = "S")]
    within: Option<f64>,
    /// What of FA is faster than this is vibration, Hz
    #[arg(long, value_name = "HZ")]
    corner: Option<f64>,
    #[command(flatten)]
    result: Output,
}

/// Looks, prints.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.result.files(args.traces.iter().chain(&args.model))?;
    if args.signal.len() > shared::pipeline::GAUGES {
        return Err(Failure::Input(miette::miette!(
            "{} columns: at most 4 are taken together as one contact",
            args.signal.len()
        )));
    }
    let traces = read_set(&args.traces).map_err(Failure::input)?;
    let model = match &args.model {
        Some(path) => {
            let model = Model::read(path).map_err(Failure::input)?;
            Some(relaxation_of(&model).map_err(Failure::input)?)
        }
        None => None,
    };
    let asked = Asked {
        burst: args.burst,
        jolt: args.jolt,
        jolts: args.jolts,
        within_s: args.within,
        corner_hz: args.corner,
    };
    let mut found = Vec::new();
    for trace in &traces {
        let relaxation =
            model.or_else(|| relaxation_of_device(trace)).unwrap_or_else(default_relaxation);
        let signals = match &args.signal[..] {
            [] => contacts(trace).map_err(Failure::input)?,
            asked => asked.to_vec(),
        };
        found.push((trace, events(trace, &signals, &relaxation, &asked).map_err(Failure::input)?));
    }
    let sections: Vec<_> =
        found.iter().map(|(trace, found)| events_sections(trace, found)).collect();
    let names = traces.iter().map(Trace::label).collect();
    let json = || answers::json(&EventsAnswer::of(&found));
    args.result.give("Touch, release and slip", "", names, &sections, json)
}
