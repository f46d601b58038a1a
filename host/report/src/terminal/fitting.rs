//! How a table is made to fit a terminal without a number being cut: its words wrap; then its columns move closer, and long words
//! are shortened; then its rows become its columns; then numbers lose a digit, where there are several rows; else they are stacked.

use super::super::number::with_a_digit_less;
use super::super::table::{Align, Column, Table, split_decimal};

/// Columns of characters that a column of a table takes beside its content: usually, and where room is scarce.
const PADDINGS: [usize; 2] = [2, 1];
/// Columns of characters between two columns of a table.
const BETWEEN: usize = 1;
/// A word is not shortened further than to so many characters.
const SHORTEST_WORD: usize = 8;
/// How often a digit is dropped from every number.
pub(super) const DIGITS_DROPPED: usize = 2;
/// Keeps two words on one line.
pub(super) const TIE: char = '\u{a0}';

/// A table, the widths of its columns, and what each takes beside its content.
pub(super) struct Fitted {
    pub(super) table: Table,
    pub(super) widths: Vec<usize>,
    pub(super) padding: usize,
}

/// The table as it fits into `width`, with so many digits less at most; none where no number of it would stay whole.
pub(super) fn fitted(table: &Table, width: usize, most_dropped: usize) -> Option<Fitted> {
    let rows = table.rows.iter().map(|row| row.iter().map(|cell| tied(cell)).collect()).collect();
    let mut table = Table { rows, ..table.clone() };
    for dropped in 0..=most_dropped {
        if dropped > 0 {
            table = with_less_digits(&table);
        }
        let longest = words(&table).map(|word| word.chars().count()).max().unwrap_or(0);
        // Words stay as long as they can, the longest are shortened first.
        let limits = (SHORTEST_WORD..longest.max(SHORTEST_WORD + 1)).rev();
        let found = std::iter::once(table.clone())
            .chain(without_ending(&table))
            .chain(limits.filter_map(|limit| with_short_words(&table, limit)))
            .find_map(|table| {
                let fits = |padding| Some((padding, widths(&table, width, padding)?));
                let (padding, widths) = PADDINGS.into_iter().find_map(fits)?;
                Some(Fitted { table, widths, padding })
            });
        if found.is_some() {
            return found;
        }
    }
    None
}

/// The widths of the columns; none where a number or a word would have to be cut.
fn widths(table: &Table, width: usize, padding: usize) -> Option<Vec<usize>> {
    let columns = || table.columns.iter().enumerate();
    let whole =
        |column: usize| (0..table.rows.len()).map(move |row| cell_width(table, row, column));
    let least: Vec<usize> = columns()
        .map(|(index, column)| {
            let cells = (0..table.rows.len()).map(|row| least_width(table, row, index));
            cells.max().unwrap_or(0).max(longest_word(&column.title()))
        })
        .collect();
    let cells: Vec<usize> =
        columns().map(|(index, _)| whole(index).max().unwrap_or(0).max(least[index])).collect();
    // A heading wraps before a cell does, and all headings into as few lines as can be.
    let widths = shared(width.checked_sub(taken(&least, padding))?, &least, &cells);
    let within = |lines: usize| -> Vec<usize> {
        let titled = columns().map(|(_, column)| title_width(&column.title(), lines));
        titled.zip(&widths).map(|(title, width)| title.max(*width)).collect()
    };
    let most = columns().map(|(_, column)| column.title().split(' ').count()).max().unwrap_or(1);
    (1..=most).map(within).find(|widths| taken(widths, padding) <= width).or(Some(widths))
}

/// The least width at which a title takes no more than so many lines.
fn title_width(title: &str, lines: usize) -> usize {
    let taken = |width: usize| {
        let (mut lines, mut used) = (1, 0);
        for word in title.split(' ').map(|word| word.chars().count()) {
            if used > 0 && used + 1 + word > width {
                (lines, used) = (lines + 1, word);
            } else {
                used += word + usize::from(used > 0);
            }
        }
        lines
    };
    let whole = title.chars().count();
    (longest_word(title)..whole).find(|width| taken(*width) <= lines).unwrap_or(whole)
}

/// The width of a table whose columns are so wide.
fn taken(widths: &[usize], padding: usize) -> usize {
    let between = BETWEEN * widths.len().saturating_sub(1);
    widths.iter().map(|width| width + padding).sum::<usize>() + between
}

/// Shares the room among the columns: the first, which names the rows, is served first, then those that lack least.
fn shared(mut room: usize, least: &[usize], natural: &[usize]) -> Vec<usize> {
    let mut widths = least.to_vec();
    let lacks = |column: usize| natural[column] - least[column];
    let mut others: Vec<usize> = (1..least.len()).collect();
    others.sort_by_key(|column| lacks(*column));
    let order: Vec<usize> = std::iter::once(0).take(least.len()).chain(others).collect();
    for (served, column) in order.iter().enumerate() {
        let fair = if served == 0 { room } else { room / (order.len() - served) };
        let given = lacks(*column).min(fair);
        widths[*column] += given;
        room -= given;
    }
    widths
}

/// The width of a cell on one line, with the room that puts decimal points below each other.
fn cell_width(table: &Table, row: usize, column: usize) -> usize {
    let text = table.cell(row, column);
    let after = split_decimal(text).1.chars().count();
    let padding = match table.columns[column].align {
        Align::Decimal => table.tail(column) - after,
        _ => 0,
    };
    text.chars().count() + padding
}

/// The width that a cell needs at least: a number stays on one line.
fn least_width(table: &Table, row: usize, column: usize) -> usize {
    if is_number(&table.columns[column], table.cell(row, column)) {
        cell_width(table, row, column)
    } else {
        longest_word(table.cell(row, column))
    }
}

fn is_number(column: &Column, text: &str) -> bool {
    column.align != Align::Left
        && text.starts_with(|c: char| c.is_ascii_digit() || "(-−+–".contains(c))
}

fn longest_word(text: &str) -> usize {
    text.split(' ').map(|word| word.chars().count()).max().unwrap_or(0)
}

/// The words of all cells that are no numbers.
fn words(table: &Table) -> impl Iterator<Item = &str> {
    let cells = table.rows.iter().flat_map(|row| row.iter().zip(&table.columns));
    let texts = cells.filter(|(cell, column)| !is_number(column, cell)).map(|(cell, _)| cell);
    texts.flat_map(|text| text.split(' '))
}

/// The table with all words of its cells no longer than this; none where two rows would then read the same.
fn with_short_words(table: &Table, limit: usize) -> Option<Table> {
    let short = |(cell, column): (&String, &Column)| {
        if is_number(column, cell) {
            return cell.clone();
        }
        cell.split(' ').map(|word| shortened(word, limit)).collect::<Vec<_>>().join(" ")
    };
    let shorter = |row: &Vec<String>| row.iter().zip(&table.columns).map(short).collect();
    let rows: Vec<Vec<String>> = table.rows.iter().map(shorter).collect();
    let same = |rows: &[Vec<String>], a: usize, b: usize| rows[a].first() == rows[b].first();
    let told_apart = |a: usize, b: usize| same(&table.rows, a, b) || !same(&rows, a, b);
    let distinct = (0..rows.len()).all(|a| (a + 1..rows.len()).all(|b| told_apart(a, b)));
    distinct.then(|| Table { rows, ..table.clone() })
}

/// The table without the ending that the files share which name its rows; none where they share none.
fn without_ending(table: &Table) -> Option<Table> {
    let names = || table.rows.iter().filter_map(|row| row.first()).filter(|n| !n.contains(' '));
    let at = names().next()?.rfind('.')?;
    let ending = &names().next()?[at..];
    let is_ending = ending.len() > 1 && ending[1..].chars().all(char::is_alphabetic);
    if !is_ending || !names().all(|name| name.ends_with(ending)) {
        return None;
    }
    let mut shorter = table.clone();
    for name in shorter.rows.iter_mut().filter_map(|row| row.first_mut()) {
        if !name.contains(' ') {
            name.truncate(name.len() - ending.len());
        }
    }
    Some(shorter)
}

/// A word without its middle; what tells file names apart is at their ends.
fn shortened(word: &str, limit: usize) -> String {
    let letters: Vec<char> = word.chars().collect();
    if letters.len() <= limit || word.contains(TIE) {
        return word.to_owned();
    }
    let kept = limit - 1;
    let head: String = letters[..kept / 2].iter().collect();
    let tail: String = letters[letters.len() - (kept - kept / 2)..].iter().collect();
    format!("{head}…{tail}")
}

fn with_less_digits(table: &Table) -> Table {
    let shorter = |(cell, column): (&String, &Column)| {
        let less = (column.align == Align::Decimal).then(|| with_a_digit_less(cell)).flatten();
        less.unwrap_or_else(|| cell.clone())
    };
    let rows = table.rows.iter().map(|row| row.iter().zip(&table.columns).map(shorter).collect());
    Table { rows: rows.collect(), ..table.clone() }
}

/// Text in which a number and its unit, or its error, are one word.
fn tied(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for word in text.split(' ') {
        let unit = word.chars().filter(|c| !matches!(c, '.' | ',' | ';' | ')')).count() <= 2;
        let number = word.starts_with(|c: char| c.is_ascii_digit());
        if !out.is_empty() {
            let after_number = unit && out.ends_with(|c: char| c.is_ascii_digit());
            let before_number = number && out.ends_with(['±', '<']);
            out.push(if after_number || before_number { TIE } else { ' ' });
        }
        out += word;
    }
    out
}

/// The table with its rows as columns: it may fit where the table does not. None where there is one row.
pub(super) fn transposed(table: &Table) -> Option<Table> {
    if table.rows.len() < 2 {
        return None;
    }
    let named = |row: usize| Column {
        name: table.cell(row, 0).to_owned(),
        align: Align::Right,
        ..Column::default()
    };
    let first = table.columns.first().map(|column| Column::text(column.title()))?;
    let columns = std::iter::once(first).chain((0..table.rows.len()).map(named)).collect();
    let row = |(index, column): (usize, &Column)| {
        let cells = (0..table.rows.len()).map(|row| table.cell(row, index).to_owned());
        std::iter::once(column.title()).chain(cells).collect()
    };
    let rows = table.columns.iter().enumerate().skip(1).map(row).collect();
    Some(Table { columns, rows, ..table.clone() })
}

/// The rows one below the other, each as its name with what the columns say of it.
pub(super) fn stacked(table: &Table) -> Vec<(String, Vec<(String, String)>)> {
    let row = |row: usize| {
        let cells = table.columns.iter().enumerate().skip(1);
        let told = cells.map(|(index, column)| (column.title(), tied(table.cell(row, index))));
        (tied(table.cell(row, 0)), told.filter(|(_, cell)| !cell.is_empty()).collect())
    };
    (0..table.rows.len()).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn errors(columns: usize, rows: usize) -> Table {
        let names = (0..columns).map(|c| Column::number(format!("region {c}"), "N"));
        let columns = std::iter::once(Column::text("trace")).chain(names).collect::<Vec<_>>();
        let mut table = Table::new("", columns.clone());
        for row in 0..rows {
            let cells = (1..columns.len()).map(|c| format!("0.00{}{}", 100 + 7 * row, c));
            let name = format!("table-3.1-row-{row:02}.csv");
            table = table.row(std::iter::once(name).chain(cells));
        }
        table
    }

    #[test]
    fn words_wrap_before_they_are_shortened_and_numbers_lose_digits_last() {
        let at = |width| fitted(&errors(4, 3), width, DIGITS_DROPPED).unwrap();
        assert_eq!(at(200).table, errors(4, 3));
        let wrapped = at(66);
        assert_eq!(wrapped.table, errors(4, 3));
        assert!(taken(&wrapped.widths, wrapped.padding) <= 66);
        let short = at(56);
        assert!(short.table.cell(0, 0).contains('…') && short.table.cell(0, 1) == "0.001001");
        let rounded = at(47);
        assert_eq!(rounded.table.cell(0, 1), "0.00100");
        assert!(fitted(&errors(4, 3), 24, DIGITS_DROPPED).is_none());
    }

    #[test]
    fn shortened_rows_are_still_told_apart() {
        for width in 20..120 {
            let Some(Fitted { table, .. }) = fitted(&errors(3, 12), width, DIGITS_DROPPED) else {
                continue;
            };
            let names: std::collections::BTreeSet<&str> =
                (0..12).map(|row| table.cell(row, 0)).collect();
            assert_eq!(names.len(), 12, "{width}");
        }
    }

    proptest! {
        #[test]
        fn no_number_is_wider_than_its_column(
            values in proptest::collection::vec(-1e6..1e6f64, 1..8),
            error in 1e-6..1e3f64,
            width in 20..160_usize,
        ) {
            let names = values.iter().map(|_| Column::number("of a long name", "mm/s"));
            let columns = std::iter::once(Column::text("file")).chain(names).collect();
            let cells = values.iter().map(|value| super::super::super::number::with_error(*value, error));
            let name = std::iter::once("a-file-of-a-long-name.csv".to_owned());
            let table = Table::new("", columns).row(name.chain(cells));
            if let Some(Fitted { table, widths, padding }) = fitted(&table, width, DIGITS_DROPPED) {
                prop_assert!(taken(&widths, padding) <= width);
                for (column, width) in widths.iter().enumerate().skip(1) {
                    prop_assert!(cell_width(&table, 0, column) <= *width);
                }
            }
        }
    }
}
