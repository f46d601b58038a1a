//! How a file goes on below the first row of numbers: where the table ends, and whether it begins again.

use super::super::import::begins_anew;
use super::super::lines::Lines;
use super::super::table::number;
use super::guess::{Guess, Kind, cells, grouped, kinds, value};

/// Most lines looked at: an interval of a rheometer has fewer.
const MOST: usize = 200_000;

/// What stands below the first row of numbers.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Rest {
    /// How the line of names begins, where it comes again above another table.
    pub(super) block: Option<String>,
    /// What ends a table: a line that begins so, or a blank one (`""`).
    pub(super) stop: Option<String>,
    /// Whether the clock begins anew further down.
    pub(super) restarts: bool,
    /// What stands between thousands.
    pub(super) thousands: Option<char>,
    /// What cells say that have no value, where such are few.
    pub(super) missing: Vec<String>,
}

impl Rest {
    /// Looks through the lines from the first row on: what is left of `lines`, then `more`. `header` is the line of
    /// names, `clock` the column that counts the time.
    pub(super) fn of(
        guess: &Guess,
        (header, clock): (Option<usize>, Option<usize>),
        lines: &[String],
        more: &mut Lines,
    ) -> Self {
        let names = header.map(|at| &lines[at]);
        let mut found = Self::default();
        // Whether a blank line stood between rows, and whether the last line was blank.
        let (mut blanks_within, mut after_blank) = (false, false);
        let mut line = String::new();
        let mut counted: Option<(f64, f64)> = None;
        let (mut all, mut lacking) = (0, 0);
        for number in 0..MOST {
            match lines.get(guess.first + number) {
                Some(known) => line.clone_from(known),
                // What cannot be read further down is told by the import.
                None if !more.next(&mut line).unwrap_or(false) => break,
                None => {}
            }
            if line.trim().is_empty() {
                after_blank = true;
                continue;
            }
            if names == Some(&line) {
                let start = beginning(&line, guess);
                let others = lines.iter().filter(|other| **other != line);
                let alone = !others.into_iter().any(|other| other.starts_with(&start));
                found.block = Some(if alone { start } else { line.clone() });
                continue;
            }
            let goes_on = found.stop.is_none() || found.block.is_some();
            let is_row = is_row(&line, guess);
            if goes_on && is_row {
                let cells = cells(&line, guess.delimiter);
                if let Some(time) = clock.and_then(|clock| value(&cells[clock], guess.decimal)) {
                    let (first, last) = counted.unwrap_or((time, time));
                    found.restarts |= begins_anew(time, last, first);
                    counted = Some((first, time));
                }
                all += 1;
                lacking += usize::from(found.look_at(&cells, guess));
            }
            if found.block.is_some() {
                continue;
            }
            if is_row {
                blanks_within |= after_blank && found.stop.is_none();
            } else if found.stop.is_none() {
                let blank = after_blank && !blanks_within;
                found.stop = Some(if blank { String::new() } else { beginning(&line, guess) });
            }
            after_blank = false;
            if names.is_none() && found.stop.is_some() {
                break;
            }
        }
        if lacking * FEW > all {
            found.missing.clear();
        }
        found
    }

    /// Takes from a row what stands between thousands and in cells without a value; whether there are such.
    fn look_at(&mut self, cells: &[String], guess: &Guess) -> bool {
        let mut lacks = false;
        for (cell, kind) in cells.iter().zip(&guess.kinds) {
            if *kind != Kind::Number {
                continue;
            }
            if MISSING.contains(&&*cell.to_lowercase()) {
                lacks = true;
                if !self.missing.contains(cell) {
                    self.missing.push(cell.clone());
                }
            } else if self.thousands.is_none() && number(cell, guess.decimal, None).is_none() {
                self.thousands = grouped(cell, guess.decimal).map(|(mark, _)| mark);
            }
        }
        lacks
    }
}

/// What programs write into a cell that has no value.
const MISSING: [&str; 10] = ["nan", "n/a", "#n/a", "na", "null", "none", "-", "--", "---", ""];
/// Rows for each that lacks a value, where leaving these out loses little.
const FEW: usize = 10;

/// Whether a line may be one of the rows, even a faulty one: an import is to say what is wrong with it.
fn is_row(line: &str, guess: &Guess) -> bool {
    let kinds = kinds(line, guess.delimiter, guess.decimal);
    let text_first =
        kinds.first() == Some(&Kind::Other) && guess.kinds.first() != Some(&Kind::Other);
    kinds.len() == guess.kinds.len() && !text_first && kinds.iter().any(|kind| kind.is_value())
}

/// How a line begins: its first cell, or all of it where that is empty.
fn beginning(line: &str, guess: &Guess) -> String {
    let first = cells(line, guess.delimiter).into_iter().next().unwrap_or_default();
    if !first.is_empty() && line.starts_with(&first) { first } else { line.to_owned() }
}

#[cfg(test)]
mod tests {
    use crate::{Mapping, import, suggest};
    use std::path::Path;

    /// The proposal for a text, and the samples that it takes.
    fn taken(text: &str) -> (String, usize) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("foreign.txt");
        std::fs::write(&path, text).unwrap();
        let proposed = suggest(&path, None).unwrap();
        let mapping = Mapping::parse(Path::new("map.toml"), &proposed).unwrap();
        let found = import(&path, &mapping).unwrap_or_else(|error| panic!("{error}\n{proposed}"));
        (proposed, found.trace.len())
    }

    /// Rows of time and force, from a row on.
    fn rows(from: usize, count: usize) -> String {
        (from..from + count).map(|i| format!("{i},{}\n", i * i)).collect()
    }

    #[test]
    fn a_line_of_names_that_comes_again_begins_another_table() {
        let names = "Time [s],Force [N]\n";
        // The second is beyond the lines that a proposal looks at closely.
        for count in [9, 900] {
            let (first, second) = (rows(0, count), rows(count, 9));
            for between in ["", "\n", "\nInterval,2\n", "Interval,2 of 2,x\n"] {
                let text = format!("Interval,1\n{names}{first}{between}{names}{second}");
                let (proposed, samples) = taken(&text);
                assert_eq!(samples, count + 9, "{text}\n{proposed}");
                assert!(proposed.contains("block_prefix = \"Time [s]\"\nblock_names = true"));
            }
        }
        // Where another line begins like it, the whole line tells it.
        let text = format!("Time [s] of day,12\n{names}{}\n{names}{}", rows(0, 9), rows(9, 9));
        let (proposed, samples) = taken(&text);
        assert!(proposed.contains("block_prefix = \"Time [s],Force [N]\""), "{proposed}");
        assert_eq!(samples, 18);
    }

    #[test]
    fn remarks_below_the_rows_end_the_table_and_blank_lines_between_rows_do_not() {
        let names = "Time [s],Force [N]\n";
        let (proposed, samples) = taken(&format!("{names}{}\n\nOperator,me\n", rows(0, 9)));
        assert!(proposed.contains("stop_at_blank = true") && samples == 9, "{proposed}");
        let text = format!("{names}{}\n{}\nOperator: me\n", rows(0, 9), rows(9, 9));
        let (proposed, samples) = taken(&text);
        assert!(proposed.contains("stop_at_prefix = \"Operator: me\""), "{proposed}");
        assert_eq!(samples, 18);
        let (proposed, samples) = taken(&format!("{names}{}\n\n", rows(0, 9)));
        assert!(!proposed.contains("stop") && samples == 9, "{proposed}");
    }
}
