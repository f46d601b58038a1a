//! A proposed mapping for a file nobody has described yet: for a person to check, never applied.

use std::fmt::Write as _;
use std::path::Path;

use encoding_rs::Encoding;

use super::import_error::ImportError;
use super::lines::Lines;
use super::mapping::Delimiter;
use super::table::{number, split};
use super::{error::Error, units};

/// Lines looked at.
const LOOKED_AT: usize = 400;

/// What the first lines of a file look like.
struct Guess {
    delimiter: Delimiter,
    decimal: char,
    /// Index of the first row of numbers.
    first: usize,
    /// Cells in that row that are numbers.
    numeric: Vec<bool>,
}

/// Proposes a mapping for a recording from its first lines, as the text of a mapping file in which
/// every line is to be checked by a person.
///
/// # Errors
/// [`ImportError::NoTable`] if no three rows of numbers follow each other, or that the file cannot be
/// read.
pub fn suggest(path: &Path) -> Result<String, ImportError> {
    let encoding = encoding(path)?;
    let lines = first_lines(path, encoding)?;
    let guess = guess(&lines).ok_or_else(|| ImportError::NoTable {
        path: path.into(),
        what: format!("three rows of at least two numbers in the first {LOOKED_AT} lines"),
    })?;
    Ok(text(path, encoding, &lines, &guess))
}

/// The encoding that the first bytes speak for.
fn encoding(path: &Path) -> Result<&'static Encoding, ImportError> {
    use std::io::Read;
    let open = |source| Error::Open { path: path.into(), source };
    let mut start = Vec::new();
    let file = std::fs::File::open(path).map_err(open)?;
    file.take(1 << 16).read_to_end(&mut start).map_err(open)?;
    let in_utf8 = match std::str::from_utf8(&start) {
        Ok(_) => true,
        // A character cut by the end of what was read.
        Err(error) => error.error_len().is_none(),
    };
    Ok(match Encoding::for_bom(&start) {
        Some((encoding, _)) => encoding,
        None if in_utf8 => encoding_rs::UTF_8,
        None => encoding_rs::WINDOWS_1252,
    })
}

fn first_lines(path: &Path, encoding: &'static Encoding) -> Result<Vec<String>, ImportError> {
    let mut lines = Lines::open(path, encoding)?;
    let mut found = Vec::new();
    let mut line = String::new();
    while found.len() < LOOKED_AT && lines.next(&mut line)? {
        found.push(line.clone());
    }
    Ok(found)
}

/// The reading with most numbers in the first three rows of one width that follow each other.
fn guess(lines: &[String]) -> Option<Guess> {
    let delimiters = [Delimiter::Semicolon, Delimiter::Tab, Delimiter::Comma, Delimiter::Space];
    let mut best: Option<(usize, Guess)> = None;
    for delimiter in delimiters {
        for decimal in ['.', ','] {
            if decimal == ',' && delimiter == Delimiter::Comma {
                continue;
            }
            let rows: Vec<Vec<bool>> =
                lines.iter().map(|line| numeric(line, delimiter, decimal)).collect();
            let counts = |row: &Vec<bool>| row.iter().filter(|&&number| number).count();
            let table = rows.windows(3).position(|three| {
                counts(&three[0]) >= 2 && three.iter().all(|row| *row == three[0])
            });
            let Some(first) = table else { continue };
            let numeric = rows[first].clone();
            let score = counts(&numeric);
            if best.as_ref().is_none_or(|(other, _)| score > *other) {
                best = Some((score, Guess { delimiter, decimal, first, numeric }));
            }
        }
    }
    best.map(|(_, guess)| guess)
}

fn numeric(line: &str, delimiter: Delimiter, decimal: char) -> Vec<bool> {
    cells(line, delimiter).iter().map(|cell| number(cell, decimal).is_some()).collect()
}

fn cells(line: &str, delimiter: Delimiter) -> Vec<String> {
    let mut found = Vec::new();
    split(line, delimiter, &mut found);
    found.into_iter().map(|cell| line[cell].trim().to_owned()).collect()
}

/// Writes the mapping.
fn text(path: &Path, encoding: &'static Encoding, lines: &[String], guess: &Guess) -> String {
    let width = guess.numeric.len();
    let same_width = |line: &&String| cells(line, guess.delimiter).len() == width;
    let above = lines[..guess.first].iter().enumerate().rev();
    // A row of units in brackets has words too, but no names.
    let named = |line: &str| {
        let cells = cells(line, guess.delimiter);
        let mut words = cells.iter().filter(|cell| cell.chars().any(char::is_alphabetic));
        words.clone().count() >= 2 && words.any(|cell| !cell.starts_with(['[', '(']))
    };
    let header = above.clone().find(|(_, line)| same_width(line) && named(line)).map(|(at, _)| at);
    let names = header.map(|at| cells(&lines[at], guess.delimiter)).unwrap_or_default();
    // Each name with what stands between it and the numbers: its unit, often.
    let below = header.map_or(0..0, |at| at + 1..guess.first);
    let units: Vec<Vec<String>> = below.map(|at| cells(&lines[at], guess.delimiter)).collect();
    let empty_last = lines[guess.first].trim_end().ends_with([',', ';']);
    let mut out = String::new();
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let quoted = |text: &str| toml::Value::from(text).to_string();
    // Writing to a string does not fail.
    let _ = writeln!(
        out,
        "# A proposal from the first lines of the file. Check every line, units above all.\n\
         palpate-map = 1\nabout = {}\nothers = \"drop\"\n\n[text]\nencoding = {}\n\
         delimiter = \"{}\"\ndecimal = \"{}\"\n\n[table]",
        quoted(&format!("As {file}")),
        quoted(&encoding.name().to_lowercase()),
        format!("{:?}", guess.delimiter).to_lowercase(),
        guess.decimal,
    );
    match header {
        Some(at) => {
            let _ = writeln!(out, "header_line = {}", at + 1);
            if guess.first > at + 1 {
                let _ = writeln!(out, "skip_lines = {}", guess.first - at - 1);
            }
        }
        None if guess.first > 0 => {
            let _ = writeln!(out, "skip_lines = {}", guess.first);
        }
        None => {}
    }
    if empty_last {
        let _ = writeln!(out, "empty_last_cell = true");
    }
    columns(&mut out, &names, &units, guess);
    out
}

/// The sections of the columns: time first, the rest under names with the unit that is written there.
fn columns(out: &mut String, names: &[String], units_rows: &[Vec<String>], guess: &Guess) {
    let numbers: Vec<usize> = (0..guess.numeric.len()).filter(|&i| guess.numeric[i]).collect();
    let name = |index: usize| names.get(index).map_or("", String::as_str);
    let is_time = |index: &&usize| name(**index).to_lowercase().contains("time");
    let time = *numbers.iter().find(is_time).unwrap_or(&numbers[0]);
    let from = |index: usize| match name(index) {
        "" => (index + 1).to_string(),
        name if names.iter().filter(|other| *other == name).count() > 1 => (index + 1).to_string(),
        name => toml::Value::from(name).to_string(),
    };
    let unit = |index: usize| {
        let below = units_rows.iter().filter_map(|row| row.get(index)).map(String::as_str);
        let texts = std::iter::once(name(index)).chain(below);
        let words =
            texts.flat_map(|text| text.split(|c: char| c.is_whitespace() || "()[]_".contains(c)));
        words.filter_map(units::named).next_back().map(|unit| unit.name)
    };
    let _ = writeln!(out, "\n[time]\nfrom = {}", from(time));
    match unit(time) {
        Some(unit) => {
            let _ = writeln!(out, "unit = \"{unit}\"");
        }
        None => {
            let _ = writeln!(out, "unit = \"s\"   # not written in the file");
        }
    }
    for index in numbers.into_iter().filter(|&index| index != time) {
        let _ = writeln!(out, "\n[[column]]\nfrom = {}", from(index));
        let word = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let plain: String = name(index).chars().map(word).collect();
        let words: Vec<&str> = plain.split('_').filter(|word| !word.is_empty()).collect();
        let plain = if words.is_empty() {
            format!("column_{}", index + 1)
        } else {
            words.join("_").to_lowercase()
        };
        let _ = writeln!(
            out,
            "name = \"{plain}\"   # such as displacement_mm, force_N, stress_kPa: the unit wanted"
        );
        if let Some(unit) = unit(index) {
            let _ = writeln!(out, "# unit = \"{unit}\"   # with it, the name must end in a unit");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::{Mapping, import};

    fn proposal(
        bytes: &[u8],
    ) -> Result<(Mapping, std::path::PathBuf, tempfile::TempDir), ImportError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("foreign.txt");
        std::fs::write(&path, bytes).unwrap();
        let text = suggest(&path)?;
        let mapping =
            Mapping::parse(Path::new("map.toml"), &text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        Ok((mapping, path, folder))
    }

    #[test]
    fn a_proposal_reads_the_file_it_was_made_from() {
        let utf16: Vec<u8> =
            "\u{feff}Test\r\nTime\tStress\r\n[s]\t[Pa]\r\n0,1\t5,5\r\n0,2\t4\r\n0,3\t3\r\n"
                .encode_utf16()
                .flat_map(u16::to_le_bytes)
                .collect();
        let (mapping, path, _folder) = proposal(&utf16).unwrap();
        let trace = import(&path, &mapping).unwrap().trace;
        assert_eq!(trace.time, [0.1, 0.2, 0.3]);
        assert_eq!(trace.column("stress").unwrap(), [5.5, 4.0, 3.0]);
        let (mapping, path, _folder) = proposal(b"0 1 2\n1 1 3\n2 1 4\n").unwrap();
        assert_eq!(import(&path, &mapping).unwrap().trace.columns.len(), 2);
    }

    #[test]
    fn units_below_the_names_are_told_from_the_names() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("foreign.txt");
        std::fs::write(&path, "No.\tTime\tForce\n\t[ms]\t[mN]\n1\t0\t5\n2\t1\t4\n3\t2\t3\n")
            .unwrap();
        let text = suggest(&path).unwrap();
        for line in [
            "header_line = 1",
            "skip_lines = 1",
            "from = \"Time\"\nunit = \"ms\"",
            "# unit = \"mN\"",
        ] {
            assert!(text.contains(line), "{text}\nlacks {line}");
        }
    }

    #[test]
    fn no_mapping_is_proposed_for_what_is_no_table() {
        assert!(matches!(proposal(b"a poem\nof two lines\n"), Err(ImportError::NoTable { .. })));
        assert!(matches!(proposal(b""), Err(ImportError::NoTable { .. })));
    }
}
