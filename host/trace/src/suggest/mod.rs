//! A proposed mapping for a file nobody has described yet. Where names and units leave a question open it is for a person to check.

mod columns;
mod encoding;
mod guess;
mod labview;
mod rest;

use std::fmt::Write as _;
use std::io::{Cursor, Read};
use std::path::Path;

use encoding_rs::Encoding;

use super::DISPLACEMENT;
use super::error::Error;
use super::foreign::{self, Opened};
use super::import_error::ImportError;
use super::lines::Lines;
use super::mapping::Mapping;
use super::table::part_of;
use super::units::{Quantity, Unit};
use columns::{Seen, is_gap, is_strain, is_unit, proposals, time_of};
use encoding::encoding;
use guess::{Guess, Kind, cells, guess};
use rest::Rest;

/// Lines looked at.
const LOOKED_AT: usize = 400;
/// A first time beyond this, s, is counted from long before the recording: 12 days.
const AFAR_S: f64 = 1e6;

/// The beginning of a table, as a person would see it.
struct Beginning {
    /// The table's name, where the file has several.
    part: Option<String>,
    /// The encoding of a text; none of a table that was made text.
    encoding: Option<&'static Encoding>,
    lines: Vec<String>,
    /// The lines below these.
    more: Lines,
}

/// A mapping for a recording, from what stands in the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Proposal {
    /// The text of the mapping file.
    pub text: String,
    /// What the file does not say, so that it was guessed or left; empty where names and units say enough.
    pub open: Vec<String>,
}

impl Proposal {
    /// The mapping itself; in heads it is called `proposed`.
    ///
    /// # Errors
    /// Those of [`Mapping::parse`].
    pub fn mapping(&self) -> Result<Mapping, ImportError> {
        Mapping::parse(Path::new("proposed"), &self.text)
    }
}

/// Proposes a mapping for a recording, as the text of a mapping file for a person to check: [`propose`].
///
/// # Errors
/// Those of [`propose`].
pub fn suggest(path: &Path, part: Option<&str>) -> Result<String, ImportError> {
    propose(path, part).map(|proposal| proposal.text)
}

/// Proposes a mapping for a recording from its first lines. `part` names one of several tables of the file.
///
/// # Errors
/// [`ImportError::NoTable`] if no three rows of numbers follow each other, or that the file cannot be
/// read, or has several tables.
pub fn propose(path: &Path, part: Option<&str>) -> Result<Proposal, ImportError> {
    let mut beginning = beginning(path, part)?;
    let guess = guess(&beginning).ok_or_else(|| ImportError::NoTable {
        path: path.into(),
        what: format!("three rows of at least two numbers in the first {LOOKED_AT} lines"),
    })?;
    let header = header(&beginning.lines, &guess);
    let columns = seen(&beginning.lines, &guess, header);
    let time = time_of(&columns);
    let clock = columns.get(time).filter(|column| column.kind == Kind::Number);
    let clock = clock.map(|column| column.index);
    let rest = Rest::of(&guess, (header, clock), &beginning.lines, &mut beginning.more);
    // Rows that are shorter than the names are told by their places.
    let width = |at: &usize| cells(&beginning.lines[*at], guess.delimiter).len();
    let header = header.filter(|at| width(at) == guess.kinds.len());
    Ok(text(path, &beginning, &guess, header, (&rest, &columns)))
}

fn beginning(path: &Path, part: Option<&str>) -> Result<Beginning, ImportError> {
    match foreign::open(path, part)? {
        Opened::Part { name, text } => {
            let shown = name.as_deref().map_or_else(|| path.into(), |name| part_of(path, name));
            let mut more = Lines::new(&shown, text, encoding_rs::UTF_8);
            let lines = first_lines(&mut more)?;
            Ok(Beginning { part: name, encoding: None, lines, more })
        }
        Opened::Text(mut text) => {
            let open = |source| Error::Open { path: path.into(), source };
            let mut start = Vec::new();
            text.by_ref().take(1 << 16).read_to_end(&mut start).map_err(open)?;
            let encoding = encoding(&start);
            let whole: Box<dyn Read> = Box::new(Cursor::new(start).chain(text));
            let mut more = Lines::new(path, whole, encoding);
            let lines = first_lines(&mut more)?;
            Ok(Beginning { part: None, encoding: Some(encoding), lines, more })
        }
    }
}

fn first_lines(lines: &mut Lines) -> Result<Vec<String>, ImportError> {
    let mut found = Vec::new();
    let mut line = String::new();
    while found.len() < LOOKED_AT && lines.next(&mut line)? {
        found.push(line.clone());
    }
    Ok(found)
}

/// Writes the mapping.
fn text(
    path: &Path,
    beginning: &Beginning,
    guess: &Guess,
    header: Option<usize>,
    (rest, columns): (&Rest, &[Seen]),
) -> Proposal {
    let lines = &beginning.lines;
    let mut out = String::new();
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let quoted = |text: &str| toml::Value::from(text).to_string();
    // Writing to a string does not fail.
    let _ = writeln!(
        out,
        "# A proposal from the first lines of the file. Check every line, units above all.\n\
         palpate-map = 1\nabout = {}\nothers = \"drop\"\n",
        quoted(&format!("As {file}")),
    );
    let cells = cells_told(beginning.encoding, guess, rest);
    if !cells.is_empty() {
        let _ = writeln!(out, "[text]\n{cells}");
    }
    let _ = writeln!(out, "[table]");
    if let Some(part) = &beginning.part {
        let _ = writeln!(out, "part = {}", quoted(part));
    }
    let skipped = guess.first - header.map_or(0, |at| at + 1);
    match (header, &rest.block) {
        (Some(_), Some(prefix)) => {
            let _ = writeln!(out, "block_prefix = {}\nblock_names = true", quoted(prefix));
        }
        (Some(at), None) => {
            let _ = writeln!(out, "header_line = {}", at + 1);
        }
        (None, _) => {}
    }
    if skipped > 0 {
        let _ = writeln!(out, "skip_lines = {skipped}");
    }
    if lines[guess.first].trim_end().ends_with([',', ';']) && beginning.encoding.is_some() {
        let _ = writeln!(out, "empty_last_cell = true");
    }
    match rest.stop.as_deref() {
        Some("") => {
            let _ = writeln!(out, "stop_at_blank = true");
        }
        Some(prefix) => {
            let _ = writeln!(out, "stop_at_prefix = {}", quoted(prefix));
        }
        None => {}
    }
    let open = write_columns(&mut out, columns, header.is_some(), rest.restarts);
    Proposal { text: out, open }
}

/// What the mapping says of cells: of a text how they are told, and of any table which have no value.
fn cells_told(encoding: Option<&'static Encoding>, guess: &Guess, rest: &Rest) -> String {
    let quoted = |text: &str| toml::Value::from(text).to_string();
    let mut lines = Vec::new();
    if let Some(encoding) = encoding {
        let delimiter = format!("{:?}", guess.delimiter).to_lowercase();
        lines.push(format!("encoding = {}", quoted(&encoding.name().to_lowercase())));
        lines.push(format!("delimiter = \"{delimiter}\""));
        lines.push(format!("decimal = \"{}\"", guess.decimal));
        let mark = rest.thousands.map(|mark| quoted(&mark.to_string()));
        lines.extend(mark.map(|mark| format!("thousands = {mark}")));
    }
    if !rest.missing.is_empty() {
        let words: Vec<String> = rest.missing.iter().map(|word| quoted(word)).collect();
        let words = words.join(", ");
        lines.push(format!("missing = [{words}]   # rows with such a cell are left out"));
    }
    lines.into_iter().map(|line| line + "\n").collect()
}

/// The line above the numbers that names the columns: as wide as they, but for a comment that few rows have, with two words at least
/// that are no units.
fn header(lines: &[String], guess: &Guess) -> Option<usize> {
    let width = guess.kinds.len();
    let named = |line: &String| {
        let cells = cells(line, guess.delimiter);
        let words: Vec<&String> =
            cells.iter().filter(|cell| cell.chars().any(char::is_alphabetic)).collect();
        let without_comment = match cells.last() {
            Some(last) if last.eq_ignore_ascii_case("comment") => cells.len() - 1,
            _ => cells.len(),
        };
        (cells.len() == width || without_comment == width)
            && words.len() >= 2
            && words.iter().any(|cell| !is_unit(cell))
    };
    lines[..guess.first].iter().rposition(named)
}

/// The columns of numbers, with their names and what stands between these and the numbers, or in the head of the file, of their units.
fn seen(lines: &[String], guess: &Guess, header: Option<usize>) -> Vec<Seen> {
    let names = header.map(|at| cells(&lines[at], guess.delimiter)).unwrap_or_default();
    let below = header.map_or(0..0, |at| at + 1..guess.first);
    let below: Vec<Vec<String>> = below.map(|at| cells(&lines[at], guess.delimiter)).collect();
    let head = labview::units(&lines[..header.unwrap_or(0)], guess.delimiter);
    let column = |(index, values): (usize, Vec<f64>)| Seen {
        index,
        name: names.get(index).cloned().unwrap_or_default(),
        below: below
            .iter()
            .filter_map(|row| row.get(index))
            .chain(head.get(index).into_iter().flatten())
            .cloned()
            .collect(),
        kind: guess.kinds[index],
        values,
    };
    let all = guess.columns(lines).into_iter().enumerate().map(column);
    all.filter(|column| column.kind.is_value()).collect()
}

/// The sections of the columns: time first, the rest under names with the unit that is wanted; taken by their names in the file where
/// these are `named` in the mapping, else by their places. Gives what is left open.
fn write_columns(out: &mut String, columns: &[Seen], named: bool, restarts: bool) -> Vec<String> {
    let from = |column: &Seen| {
        let same = columns.iter().filter(|other| other.name == column.name).count();
        match column.name.as_str() {
            "" => (column.index + 1).to_string(),
            _ if same > 1 || !named => (column.index + 1).to_string(),
            name => toml::Value::from(name).to_string(),
        }
    };
    let time_at = time_of(columns);
    let time = &columns[time_at];
    let _ = writeln!(out, "\n[time]\nfrom = {}", from(time));
    let _ = match (time.kind, time.unit()) {
        (Kind::Time(stamp), _) => writeln!(out, "stamp = \"{}\"", stamp.name()),
        (_, Some(unit)) => writeln!(out, "unit = \"{}\"", unit.name),
        _ => writeln!(out, "unit = \"s\"   # not written in the file"),
    };
    let mut open = Vec::new();
    if time.kind == Kind::Number && time.unit().is_none() {
        open.push(format!("the unit of {}", time.shown()));
    }
    let counted_from_afar = time.values.first().is_some_and(|first| first.abs() > AFAR_S);
    if counted_from_afar || matches!(time.kind, Kind::Time(_)) {
        let _ = writeln!(out, "reference = \"first\"");
    }
    if restarts {
        let _ = writeln!(out, "restarts = \"split\"   # another test begins where the clock does");
    }
    let others = columns.iter().filter(|column| column.index != time.index);
    let others: Vec<&Seen> = others.filter(|column| column.kind == Kind::Number).collect();
    let proposals = proposals(&others);
    let guessed = others.iter().zip(&proposals).filter(|(_, proposal)| proposal.guessed);
    open.extend(guessed.map(|(column, _)| format!("the unit of {}", column.shown())));
    let has_displacement = proposals.iter().any(|proposal| proposal.name == DISPLACEMENT);
    // Another clock beside the time is no signal.
    let measures = |unit: &Unit| unit.quantity != Quantity::Time;
    if !proposals.iter().any(|proposal| proposal.guessed || proposal.unit.is_some_and(measures)) {
        open.push("what its columns measure".into());
    }
    for (column, proposal) in others.iter().zip(proposals) {
        let _ = writeln!(out, "\n[[column]]\nfrom = {}", from(column));
        let _ = match (&proposal.unit, proposal.guessed) {
            (_, true) => writeln!(
                out,
                "name = \"{}\"   # the file does not say the unit: check it",
                proposal.name
            ),
            (Some(_), _) => writeln!(out, "name = \"{}\"", proposal.name),
            (None, _) => writeln!(
                out,
                "name = \"{}\"   # such as displacement_mm, force_N, stress_kPa: the unit wanted",
                proposal.name
            ),
        };
        if let Some(unit) = proposal.unit {
            let _ = writeln!(out, "unit = \"{}\"", unit.name);
        }
        if !has_displacement && is_strain(column) {
            let _ = writeln!(
                out,
                "# name = \"displacement_mm\"  # with the length of the specimen a strain is a displacement\n\
                 # gauge_length_mm = 20"
            );
        }
        if is_gap(column) {
            let _ = writeln!(
                out,
                "# negate = true           # a gap falls while it is pressed\n\
                 # reference = \"contact\"   # and is 0 where the force begins"
            );
        }
    }
    open
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import;

    fn proposal(
        bytes: &[u8],
    ) -> Result<(Mapping, std::path::PathBuf, tempfile::TempDir), ImportError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("foreign.txt");
        std::fs::write(&path, bytes).unwrap();
        let text = suggest(&path, None)?;
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
        assert_eq!(trace.column("stress_Pa").unwrap(), [5.5, 4.0, 3.0]);
        let (mapping, path, _folder) = proposal(b"0 1 2\n1 1 3\n2 1 4\n").unwrap();
        assert_eq!(import(&path, &mapping).unwrap().trace.columns.len(), 2);
    }

    #[test]
    fn units_below_the_names_are_told_from_the_names() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("foreign.txt");
        std::fs::write(&path, "No.\tTime\tForce\n\t[ms]\t[mN]\n1\t0\t5\n2\t1\t4\n3\t2\t3\n")
            .unwrap();
        let text = suggest(&path, None).unwrap();
        for line in [
            "header_line = 1",
            "skip_lines = 1",
            "from = \"Time\"\nunit = \"ms\"",
            "name = \"force_N\"\nunit = \"mN\"",
        ] {
            assert!(text.contains(line), "{text}\nlacks {line}");
        }
    }

    #[test]
    fn a_proposal_for_a_trace_gives_the_trace_back() {
        let text = "# name = \"a\"\ntime_s,displacement_mm,force_N,gauge1_ustrain,gauge1_region\n\
                    0,0,1,5,0\n1,1,2,6,0\n2,2,3,7,2\n";
        let (mapping, path, _folder) = proposal(text.as_bytes()).unwrap();
        let found = import(&path, &mapping).unwrap().trace;
        let own = crate::parse(&path, text.as_bytes()).unwrap();
        assert_eq!((found.time, found.columns), (own.time, own.columns));
    }

    #[test]
    fn names_and_units_say_what_a_column_is_in_many_ways() {
        let cases = [
            ("Zeit;Weg;Kraft\ns;µm;N\n", "header_line = 1\nskip_lines = 1"),
            ("No.;Normal Force [N];Time [s];Gap (mm)\n", "negate = true"),
            (
                "时间(s);位移(mm);载荷(N)\n",
                "from = \"位移(mm)\"\nname = \"displacement_mm\"\nunit = \"mm\"",
            ),
            ("Segment;Depth (nm);Load (mN);Test Time (s)\n", "unit = \"nm\""),
            ("a;b mm;c N;d\n", "from = \"a\"\nunit = \"s\"   # not written in the file"),
        ];
        for (header, expected) in cases {
            let width = header.lines().next().unwrap().split(';').count();
            let cell = |row: usize, column: usize| match (width, column) {
                (4, 0) if header.starts_with('S') => "1".to_owned(),
                _ => format!("{row},{column}"),
            };
            let row = |row| (0..width).map(|at| cell(row, at)).collect::<Vec<_>>().join(";") + "\n";
            let rows: String = (0..9).map(row).collect();
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("foreign.txt");
            std::fs::write(&path, format!("{header}{rows}")).unwrap();
            let text = suggest(&path, None).unwrap();
            assert!(text.contains(expected), "{text}\nlacks {expected}");
            let mapping = Mapping::parse(Path::new("map.toml"), &text).unwrap();
            let trace = import(&path, &mapping).unwrap_or_else(|e| panic!("{e}\n{text}")).trace;
            assert!(trace.displacement().is_some() && trace.force().is_some(), "{text}");
        }
    }

    #[test]
    fn what_the_file_does_not_say_is_left_open() {
        let open = |text: &str| {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("foreign.txt");
            let width = text.lines().next().unwrap().split(';').count();
            let row = |row: usize| vec![row.to_string(); width].join(";") + "\n";
            std::fs::write(&path, text.to_owned() + &(0..9).map(row).collect::<String>()).unwrap();
            propose(&path, None).unwrap().open
        };
        assert_eq!(open("Time (s);Weg (mm);Kraft (N);Kanal 7\n"), [] as [String; 0]);
        assert_eq!(open("Zeit;Stress\ns;kPa\n"), [] as [String; 0]);
        assert_eq!(open("Time;Force;Gap (mm)\n"), ["the unit of `Time`", "the unit of `Force`"]);
        assert_eq!(open("Time (s);a;Other clock (s)\n"), ["what its columns measure"]);
        assert_eq!(open("0;0;0\n"), ["the unit of column 1", "what its columns measure"]);
    }

    #[test]
    fn a_mass_that_a_force_is_told_in_is_its_weight_and_a_clock_may_be_called_by_its_unit() {
        for (header, force, second) in [
            ("Force (g);Distance (mm);Time (sec)\n", 9.806_65e-3, 1.0),
            ("Load [kg];DISTANCE [MM];millis\n", 9.806_65, 1e-3),
            ("Load;Distance;Zeit\nlb;mm;ms\n", 4.448_221_615_260_5, 1e-3),
        ] {
            let rows: String = (0..9).map(|i| format!("{i};{i};{i}\n")).collect();
            let (mapping, path, _folder) = proposal(format!("{header}{rows}").as_bytes()).unwrap();
            let trace = import(&path, &mapping).unwrap().trace;
            assert!((trace.force().unwrap()[3] - 3.0 * force).abs() < 1e-12, "{header}");
            assert!((trace.time[3] - 3.0 * second).abs() < 1e-12, "{header}");
            assert_eq!(trace.displacement().unwrap()[3], 3.0, "{header}");
        }
        let (mapping, path, _folder) = proposal(b"Time (s);Mass (g)\n0;1\n1;2\n2;3\n").unwrap();
        assert_eq!(import(&path, &mapping).unwrap().trace.force(), None, "a mass is no force");
    }

    #[test]
    fn the_head_of_a_labview_file_gives_the_units() {
        let head = "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\t\t\t\nChannels\t2\t\t\n\
                    Y_Unit_Label\tmm\tmN\t\nX_Dimension\tTime\tTime\t\n***End_of_Header***\t\t\t\n\
                    X_Value\tDisplacement\tForce\tComment\n";
        for end in ["", "\t"] {
            let rows: String = (0..9).map(|i| format!("0.{i}\t{i}.5\t{i}.0{end}\n")).collect();
            let (mapping, path, _folder) = proposal(format!("{head}{rows}").as_bytes()).unwrap();
            let trace = import(&path, &mapping).unwrap().trace;
            assert_eq!(trace.time[3], 0.3);
            assert_eq!(trace.displacement().unwrap()[3], 3.5);
            assert_eq!(trace.force().unwrap()[3], 0.003);
        }
    }

    #[test]
    fn a_second_in_a_capital_letter_and_a_clock_of_ros_are_times() {
        for (header, second) in [
            ("Time (S),Force (uN),Tip Displacement (um)\n", 1.0),
            ("Time_S,Displacement_mm,Force_N\n", 1.0),
            ("Time_sec,Displacement_mm,Force_N\n", 1.0),
            ("%time,Displacement_mm,Force_N\n", 1e-9),
        ] {
            let rows: String = (0..9).map(|i| format!("{i},{i},{i}\n")).collect();
            let (mapping, path, _folder) = proposal(format!("{header}{rows}").as_bytes()).unwrap();
            let trace = import(&path, &mapping).unwrap().trace;
            assert!((trace.time[3] - 3.0 * second).abs() < 1e-12, "{header}");
        }
    }

    #[test]
    fn a_row_in_which_another_cell_is_missing_belongs_to_the_table() {
        let rows: String =
            (0..9).map(|i| format!("{i},{i},{}\n", if i == 0 { "7" } else { "" })).collect();
        let (mapping, path, _folder) =
            proposal(format!("Time,Force,Mark\n{rows}").as_bytes()).unwrap();
        assert_eq!(import(&path, &mapping).unwrap().trace.len(), 9);
    }

    #[test]
    fn written_times_are_found_and_count_from_the_first() {
        let rows: String = (0..9).map(|i| format!("2024-05-31 14:03:0{i}.5,{i},1\n")).collect();
        let text = format!("Timestamp,Force (N),Status\n{rows}");
        let (mapping, path, _folder) = proposal(text.as_bytes()).unwrap();
        let trace = import(&path, &mapping).unwrap().trace;
        assert_eq!(trace.time[..3], [0.0, 1.0, 2.0]);
    }

    #[test]
    fn no_mapping_is_proposed_for_what_is_no_table() {
        assert!(matches!(proposal(b"a poem\nof two lines\n"), Err(ImportError::NoTable { .. })));
        assert!(matches!(proposal(b""), Err(ImportError::NoTable { .. })));
    }
}
