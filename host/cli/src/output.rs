//! How results reach standard output, and files.

use std::ffi::OsString;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::sync::OnceLock;

use super::Failure;
use super::answer::Answer;
use palpate_report::{Block, Callout, Origin, Page, Section, Table, Terminal};
use palpate_trace::files::plan::{Overwrite, Plan, REPORT, Refused};
use palpate_trace::files::{quoted, write_whole};

/// How a subcommand gives its result.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Output<O: clap::Args = Force> {
    /// Print one JSON object instead of tables
    #[arg(long)]
    pub json: bool,
    /// Also write a report with plots: one HTML file
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<std::path::PathBuf>,
    #[command(flatten)]
    over: O,
}

/// Leave to write over files.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct Force {
    /// Write over existing files that palpate did not write, and over traces and recordings that may be measured
    #[arg(long, visible_alias = "overwrite")]
    pub force: bool,
}

/// The same where `--force` is a force.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct OverwriteOnly {
    /// Write over existing files that palpate did not write, and over traces and recordings that may be measured
    #[arg(long)]
    pub overwrite: bool,
}

impl From<Force> for Overwrite {
    fn from(given: Force) -> Self {
        Self { allowed: given.force, option: "--force" }
    }
}

impl From<OverwriteOnly> for Overwrite {
    fn from(given: OverwriteOnly) -> Self {
        Self { allowed: given.overwrite, option: "--overwrite" }
    }
}

impl From<Refused> for Failure {
    fn from(refused: Refused) -> Self {
        Self::input(refused)
    }
}

impl<O: clap::Args + Copy + Into<Overwrite>> Output<O> {
    /// The files of a call that reads these and writes the report, if one is asked for.
    pub fn files<P: AsRef<Path>>(
        &self,
        read: impl IntoIterator<Item = P>,
    ) -> Result<Plan, Failure> {
        let mut files = Plan::reading(read, self.over.into());
        if let Some(report) = &self.report {
            files.writes(report, &REPORT)?;
        }
        Ok(files)
    }

    /// What may be written over.
    pub fn over(&self) -> Overwrite {
        self.over.into()
    }

    /// Gives what was found: a report where one is asked for, then the tables or the JSON object.
    pub fn show(&self, found: &dyn Answer) -> Result<(), Failure> {
        for remark in found.remarks() {
            eprintln!("! {remark}");
        }
        if let Some(path) = &self.report {
            let (title, subtitle) = (found.title(), found.subtitle());
            write_report(path, title, &subtitle, found.inputs(), found.sections()?)?;
        }
        if self.json {
            print_json(&found.json())?;
        } else {
            print_sections(&found.in_short()?)?;
        }
        match found.failed() {
            Some(why) => Err(Failure::Work(miette::miette!("{why}"))),
            None => Ok(()),
        }
    }

    /// Gives a result: a report where one is asked for, then the tables or the JSON object.
    pub fn give(
        &self,
        title: &str,
        subtitle: &str,
        inputs: Vec<String>,
        sections: &[Section],
        json: impl FnOnce() -> serde_json::Value,
    ) -> Result<(), Failure> {
        if let Some(path) = &self.report {
            write_report(path, title, subtitle, inputs, sections.to_vec())?;
        }
        if self.json { print_json(&json()) } else { print_sections(sections) }
    }
}

/// Writes text to standard output; a reader that has gone away is no error.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::work(error)),
        _ => Ok(()),
    }
}

/// Prints a JSON value on lines of its own.
pub fn print_json(value: &serde_json::Value) -> Result<(), Failure> {
    print(&format!("{value:#}\n"))
}

/// What standard output can show. Where it is no terminal, `COLUMNS` says how wide.
pub fn terminal() -> Terminal {
    let shown = io::stdout().is_terminal();
    let told = || std::env::var("COLUMNS").ok()?.parse().ok().filter(|width| *width >= 20);
    let size = console::Term::stdout().size_checked();
    let width = size.map(|(_, width)| width.into()).or_else(told).unwrap_or(160);
    let colour = shown && std::env::var_os("NO_COLOR").is_none();
    Terminal { width, unicode: true, colour }
}

/// Prints the words and tables of sections; plots are for reports.
pub fn print_sections(sections: &[Section]) -> Result<(), Failure> {
    let terminal = terminal();
    let blocks = sections.iter().flat_map(|section| &section.blocks);
    let text: String = blocks.filter_map(|block| plain(block, &terminal)).collect();
    print(&text)
}

fn plain(block: &Block, terminal: &Terminal) -> Option<String> {
    match block {
        Block::Heading(text) | Block::Paragraph(text) => {
            Some(terminal.text("", &strip(text)) + "\n")
        }
        Block::List(points) => {
            let lines = points.iter().map(|point| terminal.text("- ", &strip(point)));
            Some(lines.collect::<String>() + "\n")
        }
        Block::Table(table) => {
            let rows = table.rows.iter().map(|row| row.iter().map(|cell| strip(cell)).collect());
            let plain = Table { rows: rows.collect(), ..table.clone() };
            Some(terminal.table(&plain) + "\n")
        }
        Block::Callout { kind, text, .. } => {
            let mark = match kind {
                Callout::Finding => "=> ",
                Callout::Warning => "! ",
            };
            Some(terminal.text(mark, &strip(text)) + "\n")
        }
        Block::Definitions(terms) => {
            let lines = terms.iter().map(|(term, meaning)| format!("{term}: {}\n", strip(meaning)));
            Some(lines.collect::<String>() + "\n")
        }
        Block::Code(text) => Some(format!("{text}\n\n")),
        Block::Details { blocks, .. } => {
            Some(blocks.iter().filter_map(|block| plain(block, terminal)).collect())
        }
        Block::Figure { .. } => None,
    }
}

/// Text without the marks of code.
fn strip(text: &str) -> String {
    text.replace('`', "")
}

/// Writes a report and says where it is.
pub fn write_report(
    path: &Path,
    title: &str,
    subtitle: &str,
    inputs: Vec<String>,
    sections: Vec<Section>,
) -> Result<(), Failure> {
    let origin = Origin {
        program: concat!("palpate ", env!("CARGO_PKG_VERSION")).into(),
        command: command_line(),
        inputs,
    };
    let mut page = Page::new(title, subtitle, origin);
    page.sections = sections;
    write_file(path, page.to_html().as_bytes())?;
    eprintln!("report: {}", path.display());
    Ok(())
}

/// Writes a file whole or not at all.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    write_whole(path, |file| file.write_all(bytes)).map_err(|source| cannot_write(path, source))
}

/// A file could not be written.
pub fn cannot_write(path: &Path, source: io::Error) -> Failure {
    Failure::work(WriteError { path: path.into(), source })
}

#[derive(Debug, thiserror::Error)]
#[error("{path} was not written: {source}")]
struct WriteError {
    path: std::path::PathBuf,
    source: io::Error,
}

/// The words of the call but the name of the program.
static CALL: OnceLock<Vec<String>> = OnceLock::new();

/// Keeps a call, so that a report can say how to make it again.
pub(super) fn remember_call(words: &[OsString]) {
    let words = words.iter().skip(1).map(|word| word.to_string_lossy().into_owned());
    let _ = CALL.set(words.collect());
}

/// The words of the call but the name of the program.
pub(super) fn called() -> &'static [String] {
    CALL.get().map_or(&[], Vec::as_slice)
}

/// The command that was called.
fn command_line() -> String {
    command_of(called())
}

/// The command of these words.
pub(super) fn command_of(words: &[String]) -> String {
    let words = words.iter().map(|word| quoted(word));
    std::iter::once("palpate".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}
