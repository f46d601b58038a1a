//! Where the numbers are: delimiter, decimal mark and the first row.

use super::super::mapping::{Delimiter, THOUSANDS};
use super::super::stamp::Stamp;
use super::super::table::{number, split};
use super::Beginning;

/// What the first lines of a file look like.
pub(super) struct Guess {
    pub(super) delimiter: Delimiter,
    pub(super) decimal: char,
    /// Index of the first row of numbers.
    pub(super) first: usize,
    /// What the cells of that row are.
    pub(super) kinds: Vec<Kind>,
}

/// What a cell is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Number,
    Time(Stamp),
    Empty,
    Other,
}

impl Kind {
    pub(super) fn is_value(self) -> bool {
        matches!(self, Self::Number | Self::Time(_))
    }
}

/// The reading with most numbers and times in the first three rows of one width that follow each other. These may hold no decimal mark:
/// that is then the one with most in all lines.
pub(super) fn guess(beginning: &Beginning) -> Option<Guess> {
    use Delimiter::{Comma, Semicolon, Space, Tab};
    let lines = &beginning.lines;
    let (delimiters, decimals): (&[_], &[_]) = match beginning.encoding {
        Some(_) => (&[Semicolon, Tab, Comma, Space], &['.', ',']),
        None => (&[Comma], &['.']),
    };
    let mut best: Option<((usize, usize), Guess)> = None;
    for &delimiter in delimiters {
        for &decimal in decimals {
            if decimal == ',' && delimiter == Comma {
                continue;
            }
            let rows: Vec<Vec<Kind>> =
                lines.iter().map(|line| kinds(line, delimiter, decimal)).collect();
            let counts = |row: &Vec<Kind>| row.iter().filter(|kind| kind.is_value()).count();
            let table = rows.windows(3).position(|three| {
                counts(&three[0]) >= 2 && three.iter().all(|row| *row == three[0])
            });
            let Some(table) = table else { continue };
            let kinds = rows[table].clone();
            // Rows above it in which other cells are missing belong to it too.
            let alike = |row: &&Vec<Kind>| {
                let pairs = row.iter().zip(&kinds);
                let fits = |(a, b): (&Kind, &Kind)| a == b || [a, b].contains(&&Kind::Empty);
                row.len() == kinds.len() && counts(row) >= 2 && pairs.into_iter().all(fits)
            };
            let first = table - rows[..table].iter().rev().take_while(alike).count();
            let (score, all) = (counts(&kinds), rows.iter().map(counts).sum());
            let better = |((other, others), guess): &((usize, usize), Guess)| {
                score > *other || (score == *other && guess.delimiter == delimiter && all > *others)
            };
            if best.as_ref().is_none_or(better) {
                best = Some(((score, all), Guess { delimiter, decimal, first, kinds }));
            }
        }
    }
    best.map(|(_, guess)| guess)
}

pub(super) fn kinds(line: &str, delimiter: Delimiter, decimal: char) -> Vec<Kind> {
    let kind = |cell: &String| {
        let stamp = || Stamp::ALL.into_iter().find(|stamp| stamp.read(cell).is_some());
        match value(cell, decimal) {
            Some(_) => Kind::Number,
            None if cell.is_empty() => Kind::Empty,
            None => stamp().map_or(Kind::Other, Kind::Time),
        }
    };
    cells(line, delimiter).iter().map(kind).collect()
}

/// The number in a cell, in groups of thousands too.
pub(super) fn value(cell: &str, decimal: char) -> Option<f64> {
    number(cell, decimal, None).or_else(|| Some(grouped(cell, decimal)?.1))
}

/// The mark between thousands and the number, where the cell can mean nothing else: both marks stand in it, or a blank or an apostrophe.
pub(super) fn grouped(cell: &str, decimal: char) -> Option<(char, f64)> {
    let marks = THOUSANDS.into_iter().filter(|&mark| mark != decimal && cell.contains(mark));
    let sure = |mark: &char| !matches!(mark, ',' | '.') || cell.contains(decimal);
    marks.filter(sure).find_map(|mark| Some((mark, number(cell, decimal, Some(mark))?)))
}

/// The texts of the cells of a line.
pub(super) fn cells(line: &str, delimiter: Delimiter) -> Vec<String> {
    let mut found = Vec::new();
    split(line, delimiter, &mut found);
    found.into_iter().map(|cell| line[cell].replace("\"\"", "\"").trim().to_owned()).collect()
}

impl Guess {
    /// The numbers of every column in the rows that look like the first; a written time counts as its seconds.
    pub(super) fn columns(&self, lines: &[String]) -> Vec<Vec<f64>> {
        let mut columns = vec![Vec::new(); self.kinds.len()];
        for line in &lines[self.first..] {
            if kinds(line, self.delimiter, self.decimal) != self.kinds {
                continue;
            }
            let cells = cells(line, self.delimiter);
            for ((column, cell), kind) in columns.iter_mut().zip(&cells).zip(&self.kinds) {
                column.extend(match kind {
                    Kind::Number => value(cell, self.decimal),
                    Kind::Time(stamp) => {
                        stamp.read(cell).map(|instant| instant.whole as f64 + instant.rest)
                    }
                    Kind::Empty | Kind::Other => None,
                });
            }
        }
        columns
    }
}
