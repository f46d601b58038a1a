//! What all rows of a survey say together, as tables and plots.
//!
//! - [`estimates`]: how each number is distributed, and what lies far out.
//! - [`population`]: what the specimens have in common, and how much they differ.
//! - [`missing`]: which effect is missing in how many groups, and since when.

mod estimates;
mod missing;
mod population;

pub use population::population_sections;

use palpate_report::number::{duration, significant};
use palpate_report::{Block, Callout, Column, Section, Table};
use palpate_survey::overview::Overview;
use palpate_survey::results::About;
use palpate_survey::row::Status;

/// Most rows of a table of groups; the Parquet files have them all.
const MOST_LISTED: usize = 20;

/// The survey in short, what is missing, estimates, what lies far out, drift, failures.
#[must_use]
pub fn survey_sections(about: &About, overview: &Overview, folder: &str) -> Vec<Section> {
    let mut sections = vec![in_short(about, overview, folder)];
    sections.extend(missing::section(overview));
    sections.extend(estimates::sections(overview));
    sections.extend(failures(overview));
    sections.push(closer(folder));
    sections
}

fn in_short(about: &About, overview: &Overview, folder: &str) -> Section {
    let [done, refused, failed] = Status::ALL.map(|status| overview.count(status));
    let rows = overview.groups.len();
    let each = overview.seconds / (rows as f64).max(1.0);
    let text = format!(
        "{rows} groups by {}: {done} done, {refused} refused, {failed} failed. {} traces, {} samples; {} of processor time, {} a group, at most {}.",
        about.by.join(", "),
        overview.traces,
        overview.samples,
        duration(overview.seconds),
        duration(each),
        duration(overview.longest),
    );
    let mut section = Section::new("The survey").paragraph(text);
    if !about.finished {
        let missing = about.groups - rows as u64;
        let text = format!(
            "{missing} of {} groups have no row in {folder} yet: `{}` goes on.",
            about.groups, about.command
        );
        section = section.callout(Callout::Warning, "Not finished", text);
    }
    if !overview.verdicts.is_empty() {
        let columns = vec![Column::text("verdict"), Column::whole("groups")];
        let mut table = Table::new("Verdicts", columns);
        for (verdict, groups) in &overview.verdicts {
            table = table.row([verdict.clone(), groups.to_string()]);
        }
        section = section.table(table);
    }
    section
}

fn failures(overview: &Overview) -> Option<Section> {
    if overview.failures.is_empty() {
        return None;
    }
    let columns = vec![Column::text("group"), Column::text("status"), Column::text("reason")];
    let mut table = Table::new("Groups without an answer", columns);
    for (row, status, reason) in overview.failures.iter().take(MOST_LISTED) {
        table = table.row([&overview.groups[*row], status.word(), reason]);
    }
    Some(Section::new("Failures").table(more(table, overview.failures.len())))
}

/// Says how many rows a table leaves out.
fn more(table: Table, all: usize) -> Table {
    match all.checked_sub(MOST_LISTED) {
        Some(more @ 1..) => {
            table.note(format!("And {more} more; the Parquet files have them all."))
        }
        _ => table,
    }
}

/// How to look at one group.
fn closer(folder: &str) -> Section {
    let groups =
        format!("Rows of all groups are in {folder}/groups, what they cost in {folder}/work.");
    let commands = [
        format!(
            "palpate survey traces {folder} 0 -o group-0   # the traces of group 0 in a folder"
        ),
        "palpate serve group-0 --open                # in the Lab".to_owned(),
    ];
    Section::new("Look at one").paragraph(groups).block(Block::Code(commands.join("\n")))
}

/// A number as tables have it.
fn shown(value: f64) -> String {
    significant(value, 4)
}
