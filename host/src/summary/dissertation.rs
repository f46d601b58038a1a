//! The dissertation recomputed: how much of it agrees, and chapter by chapter.

use serde_json::{Value, json};

use crate::dissertation::{Chapter, Check, Comparison, SLIPS};
use crate::report::number::significant;
use crate::report::{Block, Callout, Column, Section, Table};

fn comparisons(chapters: &[Chapter]) -> impl Iterator<Item = &Comparison> {
    chapters.iter().flat_map(|chapter| &chapter.comparisons)
}

/// Figures in all, and those that agree.
fn counts(chapters: &[Chapter]) -> (usize, usize) {
    let checks = || comparisons(chapters).flat_map(|comparison| &comparison.checks);
    (checks().count(), checks().filter(|check| check.agrees()).count())
}

/// The first page: how much agrees, by table and equation.
#[must_use]
pub fn dissertation_overview(chapters: &[Chapter]) -> Section {
    let (figures, agree) = counts(chapters);
    let columns = vec![
        Column::text("printed in"),
        Column::whole("figures"),
        Column::whole("agree"),
        Column::number("largest difference", "of the allowed"),
    ];
    let mut table = Table::new("Printed and recomputed", columns);
    for comparison in comparisons(chapters) {
        let count = comparison.checks.len();
        table = table.row([
            comparison.source.to_owned(),
            count.to_string(),
            (count - comparison.missed().count()).to_string(),
            comparison
                .checks
                .iter()
                .filter_map(part)
                .max_by(f64::total_cmp)
                .map_or_else(|| "exact".into(), |part| significant(part, 2)),
        ]);
    }
    let kind = if agree == figures { Callout::Finding } else { Callout::Warning };
    Section::new("In short")
        .callout(
            kind,
            "Agreement",
            format!("{agree} of {figures} printed figures agree with what is computed here."),
        )
        .table(table.note("A difference of 1 is as large as the precision of the text allows."))
}

/// Difference as a part of what is allowed; none where it must be exact.
fn part(check: &Check) -> Option<f64> {
    (check.tolerance > 0.0).then(|| check.difference().abs() / check.tolerance)
}

/// The whole report.
#[must_use]
pub fn dissertation_report(chapters: &[Chapter]) -> Vec<Section> {
    let about = Section::new("What this is").paragraph(
        "A dissertation on viscoelastic contact is the ground that palpate stands on. Every table and equation \
         that it prints numbers in is recomputed here from its models, beside the printed number and with the \
         difference that the precision of the text allows; its figures are redrawn in kind (the measurements \
         behind them were not published); where the text slips, the right form is used and the slip is said. \
         Each analysis is a subcommand for your own recordings.",
    );
    let slips = SLIPS.map(|(place, what)| (place.to_owned(), what.to_owned())).to_vec();
    let slips = Section::new("Slips in the text").block(Block::Definitions(slips));
    let mut sections = vec![about, dissertation_overview(chapters), slips];
    sections.extend(chapters.iter().map(chapter_section));
    sections
}

/// A chapter as one section: what it says, then what is printed beside what is recomputed.
fn chapter_section(chapter: &Chapter) -> Section {
    let mut whole = Section::new(chapter.title);
    for section in &chapter.sections {
        whole = whole.block(Block::Heading(section.title.clone()));
        whole.blocks.extend(section.blocks.iter().cloned());
    }
    if !chapter.comparisons.is_empty() {
        whole = whole.block(Block::Heading("Printed and recomputed".into()));
    }
    for comparison in &chapter.comparisons {
        let table = Block::Table(comparison.table());
        let count = comparison.checks.len();
        whole = whole.block(if count > LONG {
            let summary = format!("{} recomputed: {count} figures", comparison.source);
            Block::Details { summary, blocks: vec![table] }
        } else {
            table
        });
    }
    whole
}

/// Comparisons with more figures are folded away.
const LONG: usize = 20;

/// Header row of [`comparisons_csv`].
pub const COMPARISONS_HEADER: &str = "printed_in,quantity,unit,printed,recomputed,allowed,agrees";

/// Every printed figure with its recomputed one, as CSV.
#[must_use]
pub fn comparisons_csv(chapters: &[Chapter]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    // Writing to memory cannot fail.
    let _ = writer.write_record(COMPARISONS_HEADER.split(','));
    for comparison in comparisons(chapters) {
        for check in &comparison.checks {
            let _ = writer.write_record([
                comparison.source,
                &check.quantity,
                check.unit,
                &check.printed.to_string(),
                &check.recomputed.to_string(),
                &check.tolerance.to_string(),
                if check.agrees() { "yes" } else { "no" },
            ]);
        }
    }
    writer
        .into_inner()
        .map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
        .unwrap_or_default()
}

/// The comparisons as one JSON object.
#[must_use]
pub fn dissertation_json(chapters: &[Chapter]) -> Value {
    let (figures, agree) = counts(chapters);
    let check = |check: &Check| {
        json!({
            "quantity": check.quantity,
            "unit": check.unit,
            "printed": check.printed,
            "recomputed": check.recomputed,
            "allowed": check.tolerance,
            "agrees": check.agrees(),
        })
    };
    let comparison = |comparison: &Comparison| {
        json!({
            "printed_in": comparison.source,
            "reason": comparison.reason,
            "checks": comparison.checks.iter().map(check).collect::<Vec<_>>(),
        })
    };
    json!({
        "palpate_dissertation": 1,
        "figures": figures,
        "agree": agree,
        "comparisons": comparisons(chapters).map(comparison).collect::<Vec<_>>(),
    })
}
