//! The dissertation recomputed: how much of it agrees, and chapter by chapter.

use crate::dissertation::{
    Chapter, Check, Comparison, Counterpart, Evidence, SLIPS, Tally, comparisons, counterparts,
    tallies,
};
use palpate_report::number::significant;
use palpate_report::{Block, Callout, Column, Section, Table};

/// The first page: what agrees, what that shows, and what does not agree.
#[must_use]
pub fn dissertation_overview(chapters: &[Chapter]) -> Section {
    let missed = comparisons(chapters).flat_map(Comparison::missed).count();
    let kind = if missed == 0 { Callout::Finding } else { Callout::Warning };
    Section::new("In short")
        .callout(kind, "Agreement", in_words(chapters))
        .table(kind_table(chapters))
        .table(source_table(chapters))
        .table(not_reproduced_table(chapters))
}

/// The tally of each kind, and what it shows.
fn in_words(chapters: &[Chapter]) -> String {
    let said = tallies(chapters).into_iter().map(|tally| {
        let Tally { evidence, figures, exact, agree } = tally;
        match evidence {
            Evidence::Derived => format!(
                "{agree} of {figures} printed figures that follow from other printed numbers agree with what follows here, {exact} of them within half of the last digit."
            ),
            Evidence::FoundAgain => format!(
                "{agree} of {figures} were fed into rebuilt or simulated recordings and found again: that shows that the method works, not that the text is right."
            ),
            Evidence::Fitted => format!(
                "{exact} of {figures} that the model is fitted to are met within half of the last digit."
            ),
            Evidence::Said => format!("{agree} of {figures} statements without a printed number hold for the models here."),
            Evidence::NotReproduced => format!("{figures} are not reproduced; each has its reason."),
        }
    });
    said.collect::<Vec<_>>().join(" ")
}

fn kind_table(chapters: &[Chapter]) -> Table {
    let columns = vec![
        Column::text("kind of evidence"),
        Column::whole("figures"),
        Column::whole("within half of the last digit"),
        Column::whole("within what is allowed"),
        Column::text("agreement shows"),
    ];
    let mut table = Table::new("Kinds of evidence", columns);
    for Tally { evidence, figures, exact, agree } in tallies(chapters) {
        table = table.row([
            evidence.names().0.to_owned(),
            figures.to_string(),
            if evidence == Evidence::Said { "–".into() } else { exact.to_string() },
            if matches!(evidence, Evidence::Fitted | Evidence::NotReproduced) {
                "–".into()
            } else {
                agree.to_string()
            },
            evidence.shows().to_owned(),
        ]);
    }
    table
}

fn source_table(chapters: &[Chapter]) -> Table {
    let columns = vec![
        Column::text("printed in"),
        Column::text("kind of evidence"),
        Column::whole("figures"),
        Column::whole("within half of the last digit"),
        Column::whole("within what is allowed"),
        Column::number("largest difference", "half units of the last digit"),
    ];
    let mut table = Table::new("Printed and recomputed", columns);
    let reproduced = |comparison: &&Comparison| comparison.evidence != Evidence::NotReproduced;
    for comparison in comparisons(chapters).filter(reproduced) {
        let checks = &comparison.checks;
        let count = |passes: fn(&Check) -> bool| {
            checks.iter().filter(|check| passes(check)).count().to_string()
        };
        let largest = checks.iter().map(Check::half_units).fold(0.0, f64::max);
        let said = comparison.evidence == Evidence::Said;
        table = table.row([
            comparison.source.to_owned(),
            comparison.evidence.names().0.to_owned(),
            checks.len().to_string(),
            if said { "–".into() } else { count(Check::is_exact) },
            if comparison.evidence == Evidence::Fitted {
                "–".into()
            } else {
                count(Check::agrees)
            },
            if said { "–".into() } else { significant(largest, 2) },
        ]);
    }
    table.note("What is allowed is said in each chapter: the rounding of the numbers that a figure follows from, or the standard errors of a fit to a rebuilt recording.")
}

fn not_reproduced_table(chapters: &[Chapter]) -> Table {
    let columns = vec![
        Column::text("figure"),
        Column::number("printed", ""),
        Column::number("here", ""),
        Column::text("unit"),
        Column::text("why"),
    ];
    let mut table = Table::new("Not reproduced", columns);
    for comparison in comparisons(chapters) {
        if comparison.evidence != Evidence::NotReproduced {
            continue;
        }
        for (index, check) in comparison.checks.iter().enumerate() {
            let here = check.recomputed;
            table = table.row([
                format!("{}: {}", comparison.source, check.quantity),
                significant(check.printed, 5),
                if here.is_finite() { significant(here, 5) } else { "–".into() },
                check.unit.to_owned(),
                if index == 0 { comparison.reason.clone() } else { "as above".into() },
            ]);
        }
    }
    table
}

/// Every figure of the text: where its counterpart is, or why there is none.
fn figure_table(chapters: &[Chapter]) -> Table {
    let columns = vec![
        Column::text("figure"),
        Column::text("of"),
        Column::text("here"),
        Column::text("drawn, or why not"),
    ];
    let all = counterparts(chapters);
    let drawn = all.iter().filter(|figure| !figure.drawn.is_empty()).count();
    let title = format!("Figures of the text: {drawn} of {} have their counterpart", all.len());
    let mut table = Table::new(title, columns);
    for Counterpart { number, subject, drawn, reason } in all {
        let (place, words) = match drawn.first() {
            Some((chapter, _)) => {
                let words: Vec<&str> = drawn.iter().map(|(_, words)| words.as_str()).collect();
                (*chapter, words.join("; "))
            }
            None => ("–", reason.unwrap_or("missing").to_owned()),
        };
        table = table.row([number.to_owned(), subject.to_owned(), place.to_owned(), words]);
    }
    table.note("A counterpart is computed here from what the text prints; measurements and photographs were not published. Its chapter says what is assumed.")
}

/// The whole report.
#[must_use]
pub fn dissertation_report(chapters: &[Chapter]) -> Vec<Section> {
    let about = Section::new("What this is").paragraph(
        "A dissertation on viscoelastic contact is the ground that palpate stands on. Its printed numbers stand \
         here beside what its models make of them. Where a number follows from others, their agreement tests \
         the text; where only the result of a fit is printed, a recording is rebuilt from it and the fit has to \
         find it again, which tests the method alone, for the measurements were not published. Differences \
         count in half units of the last printed digit. Figures are redrawn in kind; where the text slips, the \
         right form is used and the slip is said. Each analysis is a subcommand for your own recordings.",
    );
    let slips = SLIPS.map(|(place, what)| (place.to_owned(), what.to_owned())).to_vec();
    let slips = Section::new("Slips in the text").block(Block::Definitions(slips));
    let figures = Section::new("Every figure of the text").table(figure_table(chapters));
    let mut sections = vec![about, dissertation_overview(chapters), figures, slips];
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
        whole = whole.block(if count > FOLDED_FIGURES {
            let summary = format!("{} recomputed: {count} figures", comparison.source);
            Block::Details { summary, blocks: vec![table] }
        } else {
            table
        });
    }
    whole
}

/// Comparisons with more figures are folded away.
const FOLDED_FIGURES: usize = 20;

/// Header row of [`comparisons_csv`].
pub const COMPARISONS_HEADER: &str =
    "printed_in,evidence,quantity,unit,printed,last_digit,recomputed,allowed,agrees";

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
                comparison.evidence.names().1,
                &check.quantity,
                check.unit,
                &check.printed.to_string(),
                &check.digit.to_string(),
                &if check.recomputed.is_finite() {
                    check.recomputed.to_string()
                } else {
                    String::new()
                },
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
