//! `palpate decompose`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value;
use shared::adaptation::Relaxation;

use super::answer::{Answer, labels};
use super::output::{Output, cannot_write};
use super::{Failure, progress};
use palpate_analysis::decomposition::{
    Channel, decompose, default_relaxation, relaxation_of, signals,
};
use palpate_analysis::regions::{Regions, regions};
use palpate_model::Model;
use palpate_present::answers::{self, DecompositionAnswer};
use palpate_present::summary::{decomposed_trace, decomposition_sections};
use palpate_report::Section;
use palpate_report::number::counted;
use palpate_trace::files::plan::COMPUTED;
use palpate_trace::{Trace, read_set, write};

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
    #[command(flatten)]
    options: Options,
    /// Folder for the traces with more columns
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    #[command(flatten)]
    result: Output,
}

/// What is decomposed.
#[derive(clap::Args)]
pub struct Options {
    /// Columns to decompose; without it, the gauges, or the force where there is no gauge
    #[arg(long, value_name = "COLUMN")]
    signal: Vec<String>,
}

/// Decomposes, prints the regions, writes what was asked for.
pub fn run(args: &Args) -> Result<(), Failure> {
    let read = args.traces.iter().chain(&args.model);
    let mut files = args.result.files(read)?;
    let traces = Arc::new(read_set(&args.traces).map_err(Failure::input)?);
    if let Some(folder) = &args.output {
        for trace in &*traces {
            files.writes(&folder.join(file_name(trace)), &COMPUTED)?;
        }
    }
    let model = args.model.as_deref().map(Model::read).transpose().map_err(Failure::input)?;
    let found = ask(&args.options, model.as_ref(), traces)?;
    if let Some(folder) = &args.output {
        write_all(folder, &found)?;
    }
    args.result.show(&found)
}

/// Decomposes traces in memory with the relaxation function of a model, or with that of eq. 3.6.
pub fn ask(
    options: &Options,
    model: Option<&Model>,
    traces: Arc<Vec<Trace>>,
) -> Result<Decomposed, Failure> {
    let relaxation = match model {
        Some(model) => relaxation_of(model).map_err(Failure::input)?,
        None => default_relaxation(),
    };
    let parts = traces.iter().map(|trace| channels(trace, &options.signal, &relaxation));
    let parts = parts.collect::<Result<_, Failure>>()?;
    Ok(Decomposed { traces, parts, relaxation })
}

/// Traces in their fast and slow adapting parts.
pub struct Decomposed {
    /// The traces.
    pub traces: Arc<Vec<Trace>>,
    /// The channels of each trace with their regions.
    pub parts: Vec<Channels>,
    /// The relaxation function of the filter.
    pub relaxation: Relaxation,
}

/// Channels of one trace, each with its regions.
pub type Channels = Vec<(Channel, Regions)>;

impl Decomposed {
    fn each(&self) -> impl Iterator<Item = (&Trace, &[(Channel, Regions)])> {
        self.traces.iter().zip(self.parts.iter().map(|part| &part[..]))
    }
}

impl Answer for Decomposed {
    fn title(&self) -> &'static str {
        "Fast and slow adapting parts"
    }

    fn inputs(&self) -> Vec<String> {
        labels(&self.traces)
    }

    fn json(&self) -> Value {
        let each: Vec<_> = self.each().collect();
        answers::json(&DecompositionAnswer::of(&each, &self.relaxation))
    }

    fn sections(&self) -> Result<Vec<Section>, Failure> {
        Ok(self.each().flat_map(|(trace, part)| decomposition_sections(trace, part)).collect())
    }

    fn remarks(&self) -> Vec<String> {
        let each = self.each().flat_map(|(trace, part)| part.iter().map(move |it| (trace, &it.0)));
        let saturated = each.filter(|(_, channel)| channel.saturated > 0);
        saturated
            .map(|(trace, channel)| {
                let Channel { signal, saturated, .. } = channel;
                format!("{signal} of {}: {saturated} samples beyond full scale", trace.label())
            })
            .collect()
    }

    fn traces(&self) -> Vec<Trace> {
        self.each().map(|(trace, part)| decomposed_trace(trace, part)).collect()
    }
}

/// Every channel asked for, decomposed, with its regions.
fn channels(trace: &Trace, asked: &[String], relaxation: &Relaxation) -> Result<Channels, Failure> {
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
        Ok((channel, regions))
    };
    let found = signals.iter().map(each).collect();
    wait.finish_and_clear();
    found
}

fn write_all(folder: &Path, found: &Decomposed) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|source| cannot_write(folder, source))?;
    for (trace, channels) in found.each() {
        let path = folder.join(file_name(trace));
        write(&path, &decomposed_trace(trace, channels)).map_err(Failure::work)?;
    }
    eprintln!("{} in {}", counted(found.parts.len(), "trace"), folder.display());
    Ok(())
}

/// The name of the trace's own file; one from a recording of a device has none yet.
fn file_name(trace: &Trace) -> String {
    match trace.path {
        Some(_) => trace.label(),
        None => trace.label() + ".csv",
    }
}
