//! `palpate import`: a foreign recording becomes a trace.

mod folder;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use miette::{Report, miette};

use super::Failure;
use super::output::{Force, print};
use palpate_trace::files::plan::{Plan, TRACE};
use palpate_trace::{self as trace, Error, ImportError, Imported, Mapping};

/// Samples that `--preview` shows.
const PREVIEW_SAMPLES: usize = 5;

/// Turn a foreign recording into a trace, by a mapping that says what is what
///
/// The mapping is a small TOML file that names the encoding, the delimiter, the table within the file,
/// and for each column its name and unit in the trace. It can be used for any number of files, and its
/// text is kept in the head of every trace made with it.
///
/// Without a mapping one is proposed from the names and units in the file, and taken where these leave no question open. Of a
/// folder every file, and every table in it, becomes a trace; where a question is open the proposed mapping is written beside
/// the traces, to be completed before the same call is made again.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Examples:
  palpate import pull.csv                              where names and units say enough; writes pull.trace.csv
  palpate import lab/ -o traces                        the same of every file in a folder
  palpate import pull.csv --suggest > pull.map.toml    a proposal to check and edit
  palpate import pull.csv --map pull.map.toml --preview
  palpate import pull.csv --map pull.map.toml          writes pull.trace.csv
  palpate import long.csv --map pull.map.toml --every 10 -o long.trace.csv
  palpate import book.xlsx --part \"Run 1\" --suggest    one sheet of a workbook
  palpate import step_*.csv --map pull.map.toml -o all.trace.csv    one recording in many files")]
pub struct Args {
    /// The recording; several files are parts of one, put in the order of their times. Or one folder of recordings
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// The mapping file [default: what the names and units in the file say]
    #[arg(long, value_name = "MAP.toml")]
    pub map: Option<PathBuf>,
    /// The trace to write [default: the first FILE's name with .trace.csv, in the current folder]; of a folder, the folder
    /// of the traces [default: its name with .traces]
    #[arg(short, long, value_name = "TRACE")]
    pub output: Option<PathBuf>,
    /// The table of the file, where it has several: a sheet of a workbook, whatever the mapping says
    #[arg(long, value_name = "NAME")]
    pub part: Option<String>,
    /// Keep every N-th sample, whatever the mapping says
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub every: Option<u32>,
    /// Show what the mapping makes of the file and write nothing
    #[arg(long)]
    pub preview: bool,
    /// Print a proposed mapping for the file, to be checked by you
    #[arg(long, conflicts_with_all = ["map", "output", "every", "preview", "force"])]
    pub suggest: bool,
    /// Leave to write over files
    #[command(flatten)]
    pub over: Force,
}

/// Runs the command.
///
/// # Errors
/// [`Failure::Input`] for a recording, a mapping or a name that will not do, [`Failure::Work`] if the
/// trace cannot be written.
pub fn run(args: &Args) -> Result<(), Failure> {
    if args.suggest {
        let suggested = trace::suggest(first(args), args.part.as_deref());
        return print(&suggested.map_err(|error| input(&error))?);
    }
    if let [folder] = &args.files[..]
        && folder.is_dir()
    {
        return folder::import(folder, args);
    }
    let mapping = args.adjusted(match &args.map {
        Some(map) => Mapping::read(map).map_err(|error| input(&error))?,
        None => proposed(first(args), args.part.as_deref())?,
    });
    let output = args.output.clone().unwrap_or_else(|| default_output(first(args)));
    let tests = trace::import_tests(&args.files, &mapping).map_err(|error| input(&error))?;
    if args.preview {
        return tests.iter().try_for_each(|test| print(&preview(test)));
    }
    let outputs = trace::places(&output, tests.len());
    let read = args.map.iter().chain(&args.files);
    let mut plan = Plan::reading(read, args.over.into());
    outputs.iter().try_for_each(|output| plan.writes(output, &TRACE))?;
    for (test, output) in tests.iter().zip(&outputs) {
        trace::write(output, &test.trace).map_err(|error| Failure::Work(report(&error)))?;
        eprintln!("{}", summary(test, output));
    }
    if let Some(test) = tests.first().filter(|_| args.map.is_none()) {
        eprint!("{}", taken(test));
    }
    Ok(())
}

impl Args {
    /// A mapping with what the call says otherwise.
    fn adjusted(&self, mut mapping: Mapping) -> Mapping {
        mapping.table.part = self.part.clone().or(mapping.table.part);
        mapping.every = self.every.map(|every| every as usize).or(mapping.every);
        mapping
    }
}

/// The mapping that names and units in a file say, where they say enough.
fn proposed(file: &Path, part: Option<&str>) -> Result<Mapping, Failure> {
    let proposal = trace::propose(file, part).map_err(|error| input(&error))?;
    if proposal.open.is_empty() {
        return proposal.mapping().map_err(|error| input(&error));
    }
    let (shown, map) = (file.display(), default_map(file));
    Err(Failure::Input(miette!(
        "{shown}: the file does not say {}. `palpate import {shown} --suggest > {map}` writes a mapping to complete; give it with \
         `--map {map}`.",
        proposal.open.join(", ")
    )))
}

/// The file that stands for the recording where one is enough.
fn first(args: &Args) -> &Path {
    args.files.first().map_or_else(|| Path::new(""), PathBuf::as_path)
}

/// `pull.csv` and `pull.csv.gz` become `pull.trace.csv` in the current folder.
fn default_output(file: &Path) -> PathBuf {
    let mut name = stem(file).to_os_string();
    name.push(".trace.csv");
    name.into()
}

/// The mapping of `pull.csv` is `pull.map.toml`.
fn default_map(file: &Path) -> String {
    format!("{}.map.toml", stem(file).to_string_lossy())
}

/// `pull` of `pull.csv` and `pull.csv.gz`.
fn stem(file: &Path) -> &OsStr {
    let packed = trace::has_extension(file, "gz") || trace::has_extension(file, "zst");
    let unpacked = if packed { Path::new(file.file_stem().unwrap_or_default()) } else { file };
    unpacked.file_stem().unwrap_or_default()
}

/// What was made, in one or a few lines.
fn summary(imported: &Imported, output: &Path) -> String {
    let trace = &imported.trace;
    let mut text = format!("{}: {} samples", output.display(), trace.len());
    let mut add = |count: usize, what: &str| {
        if count > 0 {
            text += &format!(", {count} {what}");
        }
    };
    add(imported.merged, "rows merged by their time stamp");
    add(imported.missing, "rows left out that lack a value");
    add(imported.uncovered, "samples left out where a column's own clock does not reach");
    add(trace::gaps(&trace.time).len(), "gaps in time");
    if !imported.dropped.is_empty() {
        let names: Vec<&str> = imported.dropped.iter().map(|(name, _)| name.as_str()).collect();
        text += &format!("; columns left out: {}", names.join(", "));
    }
    text
}

/// Which columns became what.
fn taken(imported: &Imported) -> String {
    let line = |(from, name): &(String, String)| format!("  {name}  from {from}\n");
    imported.columns.iter().map(line).collect()
}

/// What the mapping makes of the file.
fn preview(imported: &Imported) -> String {
    let trace = &imported.trace;
    let mut text = format!("{} rows, {} samples\n{}", imported.rows, trace.len(), taken(imported));
    for (name, reason) in &imported.dropped {
        text += &format!("  left out: {name} ({reason})\n");
    }
    let names = trace.columns.iter().map(|column| column.name.as_str());
    text += &std::iter::once(trace::TIME).chain(names).collect::<Vec<_>>().join(",");
    text.push('\n');
    for row in 0..PREVIEW_SAMPLES.min(trace.len()) {
        let values = trace.columns.iter().map(|column| column.values[row]);
        let cells: Vec<_> = std::iter::once(trace.time[row]).chain(values).collect();
        let cells: Vec<_> = cells.iter().map(|value| trace::shortest(*value)).collect();
        text += &cells.join(",");
        text.push('\n');
    }
    text
}

fn input(error: &ImportError) -> Failure {
    match error {
        ImportError::File(error @ Error::Write { .. }) => Failure::Work(report(error)),
        error => Failure::Input(report(error)),
    }
}

/// The message is whole as it is; the source it was made from would only repeat it.
fn report(error: &dyn std::error::Error) -> Report {
    miette!("{error}")
}
