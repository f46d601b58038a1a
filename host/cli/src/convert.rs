//! `palpate convert`: recordings of a device into traces, traces into other files, traces into recordings.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use miette::miette;

use super::Failure;
use super::output::{Force, cannot_write, print_json};
use palpate_present::answers::{self, ConversionAnswer};
use palpate_trace::files::plan::{CONVERTED, Plan};
use palpate_trace::files::write_whole;
use palpate_trace::recordable::{RecordableError, settings_of, write_recording};
use palpate_trace::recorded::{Options, Recorded, read_recording};
use palpate_trace::recording;
use palpate_trace::{self as trace, Export, Trace};

/// Turn recordings of a device into traces (CSV, Parquet), and back
#[derive(clap::Args)]
#[command(after_help = "\
The ending of OUT says what is written: .csv and .parquet for traces, .palpate for a recording that a
device would have made of a trace with gauges, to try things without one; .mat (7.3) for MATLAB and .mcap
for the viewers of robots, where palpate was built with --features formats. Several traces are numbered:
OUT-1.csv, OUT-2.csv … A recording gives one trace for each stretch of its stream: it ends where the
device began anew, the link was lost or the settings changed. Rows that were lost are a gap in time.
Of several devices in one recording each gives its own, with time on the clock of this computer.

Columns of each gauge in a trace made from a recording:
  gauge1_ustrain  gauge1_fa_ustrain  gauge1_sa_ustrain    FA + SA is the strain
  gauge1_elastic_ustrain  gauge1_equilibrium_ustrain      if the device sent them
  gauge1_counts                                           of the converter
  gauge1_region  gauge1_relaxation                        numbers as in `palpate decompose`
  gauge1_flags                                            1 at a rail + 2 strain + 4 filter saturated

Examples:
  palpate convert take.palpate -o take.csv
  palpate convert take.palpate -o take.parquet --host-time
  palpate convert traces/ -o all.parquet                  all-1.parquet, all-2.parquet …
  palpate convert press.csv -o press.palpate              a recording without a device
  palpate convert press.csv -o press.mat                  load('press.mat') in MATLAB")]
pub struct Args {
    /// Recordings, traces, or folders of traces
    #[arg(required = true, value_name = "IN")]
    inputs: Vec<PathBuf>,
    /// What to write: a name that ends in .csv, .parquet, .palpate, .mat or .mcap
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Time of recordings in seconds of this computer's clock, not of the device's
    #[arg(long)]
    host_time: bool,
    /// Leave out damaged frames of recordings instead of refusing them
    #[arg(long)]
    skip_damaged: bool,
    /// Print one JSON object that says what was written
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    over: Force,
}

/// Converts, and says what was written.
///
/// # Errors
/// [`Failure::Input`] for what cannot be read or has no such form, [`Failure::Work`] if a file cannot be written.
pub fn run(args: &Args) -> Result<(), Failure> {
    let form = Form::of(&args.output)?;
    let read = read_all(args)?;
    let files = file_names(&args.output, read.traces.len());
    let mut plan = Plan::reading(&args.inputs, args.over.into());
    for file in &files {
        plan.writes(file, &CONVERTED)?;
    }
    for (trace, file) in read.traces.iter().zip(&files) {
        form.write(file, trace)?;
        if !args.json {
            eprintln!("{}: {}", file.display(), summary(trace));
        }
    }
    for warning in warnings(&read) {
        eprintln!("! {warning}");
    }
    if args.json {
        print_json(&answers::json(&ConversionAnswer::of(&read, &files)))
    } else {
        Ok(())
    }
}

/// What can be written.
#[derive(Clone, Copy)]
pub(super) enum Form {
    Trace,
    Recording,
    Export(Export),
}

impl Form {
    pub(super) fn of(path: &Path) -> Result<Self, Failure> {
        if let Some(export) = Export::of(path) {
            return Ok(Self::Export(export));
        }
        let extension = path.extension().map(OsStr::to_ascii_lowercase);
        match extension.as_ref().and_then(|ending| ending.to_str()) {
            Some("csv" | "parquet") => Ok(Self::Trace),
            Some(recording::EXTENSION) => Ok(Self::Recording),
            _ => Err(Failure::Input(miette!(
                "{}: the name must end in .csv, .parquet, .palpate, .mat or .mcap",
                path.display()
            ))),
        }
    }

    pub(super) fn write(self, path: &Path, trace: &Trace) -> Result<(), Failure> {
        match self {
            Self::Trace => trace::write(path, trace).map_err(Failure::work),
            Self::Export(export) => export.write(path, trace).map_err(|error| match error {
                error @ trace::Error::Write { .. } => Failure::work(error),
                error => Failure::input(error),
            }),
            Self::Recording => {
                let mut bytes = Vec::new();
                write_recording(trace, &settings_of(trace), &mut bytes).map_err(
                    |error| match error {
                        RecordableError::Write(source) => cannot_write(path, source),
                        error => Failure::input(error),
                    },
                )?;
                write_whole(path, |file| file.write_all(&bytes))
                    .map_err(|source| cannot_write(path, source))
            }
        }
    }
}

/// Everything the inputs hold, in the order they were given.
fn read_all(args: &Args) -> Result<Recorded, Failure> {
    let options = Options { host_time: args.host_time, skip_damaged: args.skip_damaged };
    let mut all = Recorded { closed: true, ..Recorded::default() };
    for input in &args.inputs {
        if input.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(recording::EXTENSION))
        {
            let recorded = read_recording(input, &options).map_err(Failure::input)?;
            all.traces.extend(recorded.traces);
            all.rows_lost += recorded.rows_lost;
            all.rows_unknown += recorded.rows_unknown;
            all.damaged += recorded.damaged;
            all.closed &= recorded.closed;
        } else {
            all.traces.extend(trace::read_set(&[input]).map_err(Failure::input)?);
        }
    }
    Ok(all)
}

/// The name itself for one trace, numbered names for several.
fn file_names(output: &Path, count: usize) -> Vec<PathBuf> {
    if count == 1 {
        return vec![output.into()];
    }
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    let ending = output.extension().unwrap_or_default().to_string_lossy();
    (1..=count).map(|number| output.with_file_name(format!("{stem}-{number}.{ending}"))).collect()
}

fn summary(trace: &Trace) -> String {
    let gaps = match trace::gaps(&trace.time).len() {
        0 => String::new(),
        count => format!(", {count} gaps in time"),
    };
    let timed = match trace.pulses() {
        None => String::new(),
        Some(1) => ", timed by a pulse of a shared line".into(),
        Some(pulses) => format!(", timed by {pulses} pulses of a shared line"),
    };
    format!("{} samples over {:.3} s{gaps}{timed}", trace.len(), trace.duration())
}

/// What is missing from the recordings that were read.
fn warnings(read: &Recorded) -> Vec<String> {
    let mut warnings = Vec::new();
    let mut warn = |missing: bool, text: String| {
        if missing {
            warnings.push(text);
        }
    };
    warn(read.rows_lost > 0, format!("{} rows were lost while recording", read.rows_lost));
    warn(
        read.rows_unknown > 0,
        format!(
            "{} rows were left out: the settings that made them are not in the recording",
            read.rows_unknown
        ),
    );
    warn(read.damaged > 0, format!("{} damaged frames were left out", read.damaged));
    warn(
        !read.closed,
        "the recording was not ended in order; it is read up to its last whole frame".into(),
    );
    warnings
}
