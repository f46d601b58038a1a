//! `palpate decompose`.

use std::path::{Path, PathBuf};

use shared::adaptation::Relaxation;

use super::output::{Output, cannot_write, print_json, print_sections, write_report};
use super::{Failure, progress};
use crate::decomposition::{Channel, decompose, default_relaxation, relaxation_of, signals};
use crate::files::plan::COMPUTED;
use crate::model::Model;
use crate::regions::{Regions, regions};
use crate::summary::{decomposed_trace, decomposition_json, decomposition_sections};
use crate::trace::{Trace, read_set, write};

/// Split signals into fast (FA) and slow adapting (SA) parts, and mark the regions of the grasp.
#[derive(clap::Args)]
#[command(after_help = "\
Runs each signal through the filter of the device, in the device's numbers. With -o, every trace is
written again with these columns for each signal (here gauge1):
  gauge1_fa_ustrain  gauge1_sa_ustrain            FA + SA is the signal
  gauge1_fa_rectified_ustrain                     |FA|: answers to touch and to release alike, as
                                                  rapidly adapting receptors do
  gauge1_elastic_ustrain                          the response without memory to the same motion
  gauge1_equilibrium_ustrain                      where it settles if the motion stops
  gauge1_latent_ustrain                           what is still to relax
  gauge1_region                                   0 rest, 1 OA, 2 AB, 3 BC, 4 CD, 5 DE, 6 EF
  gauge1_relaxation                               0 settled, 1 Type I, 2 Type II

Examples:
  palpate decompose press.csv                     the regions of the grasp
  palpate decompose press.csv --model model.toml  with the relaxation function of a fitted model
  palpate decompose traces/ -o split/             traces with more columns
  palpate decompose press.csv --report press.html")]
pub struct Args {
    /// Traces, or folders of traces
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    /// Take the relaxation function from this model; without it, that of eq. 3.6 is taken
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,
    /// Columns to decompose; without it, the gauges, or the force where there is no gauge
    #[arg(long, value_name = "COLUMN")]
    signal: Vec<String>,
    /// Folder for the traces with more columns
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    #[command(flatten)]
    result: Output,
}

/// Decomposes, prints the regions, writes what was asked for.
pub fn run(args: &Args) -> Result<(), Failure> {
    let read = args.traces.iter().chain(&args.model);
    let mut files = args.result.files(read)?;
    let traces = read_set(&args.traces).map_err(Failure::input)?;
    if let Some(folder) = &args.output {
        for trace in &traces {
            files.writes(&folder.join(file_name(trace)), &COMPUTED)?;
        }
    }
    let relaxation = match &args.model {
        Some(path) => {
            let model = Model::read(path).map_err(Failure::input)?;
            relaxation_of(&model).map_err(Failure::input)?
        }
        None => default_relaxation(),
    };
    let mut parts = Vec::new();
    for trace in &traces {
        parts.push((trace, channels(trace, &args.signal, &relaxation)?));
    }
    if let Some(folder) = &args.output {
        write_all(folder, &parts)?;
    }
    let sections: Vec<_> = parts
        .iter()
        .flat_map(|(trace, channels)| decomposition_sections(trace, channels))
        .collect();
    if let Some(path) = &args.result.report {
        let names = traces.iter().map(Trace::label).collect();
        write_report(path, "Fast and slow adapting parts", "", names, sections.clone())?;
    }
    if args.result.json {
        print_json(&decomposition_json(&parts, &relaxation))
    } else {
        print_sections(&sections)
    }
}

/// Every channel asked for, decomposed, with its regions.
pub fn channels(
    trace: &Trace,
    asked: &[String],
    relaxation: &Relaxation,
) -> Result<Vec<(Channel, Regions)>, Failure> {
    let signals =
        if asked.is_empty() { signals(trace).map_err(Failure::input)? } else { asked.to_vec() };
    let wait = progress::bar(signals.len() * trace.len(), &trace.label());
    let each = |signal: &String| {
        let mut pending = 0;
        let channel = decompose(trace, signal, relaxation, || {
            pending += 1;
            if pending == 4096 {
                wait.inc(pending);
                pending = 0;
            }
        })
        .map_err(Failure::input)?;
        let regions = regions(trace, &channel).map_err(Failure::input)?;
        if channel.saturated > 0 {
            eprintln!(
                "! {} of {}: {} samples beyond full scale",
                signal,
                trace.label(),
                channel.saturated
            );
        }
        Ok((channel, regions))
    };
    let found = signals.iter().map(each).collect();
    wait.finish_and_clear();
    found
}

fn write_all(folder: &Path, parts: &[(&Trace, Vec<(Channel, Regions)>)]) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|source| cannot_write(folder, source))?;
    for (trace, channels) in parts {
        let path = folder.join(file_name(trace));
        write(&path, &decomposed_trace(trace, channels)).map_err(Failure::work)?;
    }
    eprintln!("{} trace(s) in {}", parts.len(), folder.display());
    Ok(())
}

/// The name of the trace's own file; one from a recording of a device has none yet.
fn file_name(trace: &Trace) -> String {
    match trace.path {
        Some(_) => trace.label(),
        None => trace.label() + ".csv",
    }
}
