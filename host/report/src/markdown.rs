//! Sections as Markdown, for documents; figures are files of their own.

use std::fmt::Write as _;

use super::page::{Block, Section};
use super::table::{Align, Table};

/// The words and tables of a section, its title as a heading of the first level.
#[must_use]
pub fn markdown(section: &Section) -> String {
    let mut out = format!("# {}\n\n", section.title);
    for block in &section.blocks {
        write_block(&mut out, block);
    }
    out.truncate(out.trim_end().len());
    out + "\n"
}

fn write_block(out: &mut String, block: &Block) {
    let _ = match block {
        Block::Heading(text) => write!(out, "## {text}\n\n"),
        Block::Paragraph(text) => write!(out, "{text}\n\n"),
        Block::List(points) => {
            let points: String = points.iter().map(|point| format!("- {point}\n")).collect();
            writeln!(out, "{points}")
        }
        Block::Table(table) => writeln!(out, "{}", write_table(table)),
        Block::Callout { title, text, .. } => write!(out, "> **{title}**: {text}\n\n"),
        Block::Definitions(terms) => {
            let terms: String =
                terms.iter().map(|(term, meaning)| format!("**{term}**: {meaning}\n\n")).collect();
            out.write_str(&terms)
        }
        Block::Code(text) => write!(out, "```text\n{text}\n```\n\n"),
        Block::Details { blocks, .. } => {
            for block in blocks {
                write_block(out, block);
            }
            Ok(())
        }
        Block::Figure { .. } => Ok(()),
    };
}

fn write_table(table: &Table) -> String {
    let mut out = String::new();
    if !table.caption.is_empty() {
        out += &format!("**{}**\n\n", table.caption);
    }
    let row = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    out += &row(table.columns.iter().map(|column| cell(&column.title())).collect());
    let rule = |align: Align| if align == Align::Left { "-" } else { "-:" };
    out += &format!(
        "|{}|\n",
        table.columns.iter().map(|column| rule(column.align)).collect::<Vec<_>>().join("|")
    );
    for index in 0..table.rows.len() {
        out +=
            &row((0..table.columns.len()).map(|column| cell(table.cell(index, column))).collect());
    }
    for note in &table.notes {
        out += &format!("\n{note}\n");
    }
    out
}

/// A bar would end the cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

#[cfg(test)]
mod tests {
    use super::super::table::Column;
    use super::*;

    #[test]
    fn a_table_keeps_its_cells_apart() {
        let columns = vec![Column::text("law"), Column::number("size", "N")];
        let table = Table::new("Laws", columns).row(["c |v|", "3"]).note("A note.");
        let section = Section::new("An effect").paragraph("What it is.").table(table);
        let expected = "# An effect\n\nWhat it is.\n\n**Laws**\n\n| law | size (N) |\n|-|-:|\n\
                        | c \\|v\\| | 3 |\n\nA note.\n";
        assert_eq!(markdown(&section), expected);
    }
}
