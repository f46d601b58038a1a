//! Reading a trace: strict, so that a number is never taken for what it is not.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::ops::Range;
use std::path::Path;

use csv::ByteRecord;
use rayon::prelude::*;

use super::error::{Error, Place};
use super::names::{self, Fault};
use super::{Column, Head, PARQUET, TIME, Trace, foreign, has_extension, head, parquet};

/// Largest file that is read whole, bytes.
pub const SIZE_LIMIT: u64 = 1 << 30;
/// Largest text that a packed file may hold to be read whole, bytes.
pub(super) const UNPACKED_LIMIT: u64 = 128 << 20;
/// Longest line, bytes of UTF-8.
pub(super) const MAX_LINE: usize = 1 << 20;
/// Most lines of a head.
const MAX_HEAD_LINES: usize = 2_000;
/// Most columns.
pub(super) const MAX_COLUMNS: usize = 10_000;
/// Bytes that one thread reads at a time.
const STRETCH: usize = 4 << 20;

/// Reads one trace: Parquet if the file's name ends in `.parquet`, else CSV, or what is in it if that is another format.
///
/// # Errors
/// See [`Error`]; each names the file and, where there is one, line and column.
pub fn read(path: &Path) -> Result<Trace, Error> {
    if has_extension(path, PARQUET) {
        return parquet::read(path);
    }
    match foreign::trace(path)? {
        Some(trace) => Ok(trace),
        None => parse(path, &load(path, SIZE_LIMIT)?),
    }
}

/// Reads all traces of a file: of a file of another program every table that is one as it stands, such as the curves of a map,
/// and of any other the one that [`read()`] gives.
///
/// # Errors
/// As [`read()`], but for several traces in one file.
pub fn read_all(path: &Path) -> Result<Vec<Trace>, Error> {
    let foreign = if has_extension(path, PARQUET) { None } else { foreign::traces(path)? };
    foreign.map_or_else(|| Ok(vec![read(path)?]), Ok)
}

/// Reads the head of a trace alone.
///
/// # Errors
/// When the file cannot be read, or its head is not understood.
pub fn read_head(path: &Path) -> Result<Head, Error> {
    if has_extension(path, PARQUET) {
        return parquet::read_head(path);
    }
    let open = |source| Error::Open { path: path.into(), source };
    let mut input = BufReader::new(fs::File::open(path).map_err(open)?);
    let mut bytes = Vec::new();
    for _ in 0..=MAX_HEAD_LINES {
        let from = bytes.len();
        let limit = MAX_LINE as u64 + 1;
        input.by_ref().take(limit).read_until(b'\n', &mut bytes).map_err(open)?;
        let line = bytes[from..].trim_ascii_start();
        if bytes.len() == from || !(line.is_empty() || line[0] == b'#') {
            bytes.truncate(from);
            break;
        }
    }
    check_text(path, &bytes)?;
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&bytes);
    Ok(File { path, bytes }.head()?.0)
}

/// The bytes of a file of at most `limit` bytes.
pub(super) fn load(path: &Path, limit: u64) -> Result<Vec<u8>, Error> {
    let open = |source| Error::Open { path: path.into(), source };
    let about = fs::metadata(path).map_err(open)?;
    if about.is_dir() {
        return Err(open(std::io::Error::from(std::io::ErrorKind::IsADirectory)));
    }
    if about.len() > limit {
        return Err(Error::TooLarge { path: path.into(), bytes: about.len(), limit });
    }
    fs::read(path).map_err(open)
}

/// Reads a trace from the bytes of a file; `path` is what errors call it.
///
/// # Errors
/// As [`read`], but for those of the file system.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Trace, Error> {
    parse_by(path, bytes, STRETCH)
}

/// The same, so many bytes to a thread; the outcome does not depend on how many.
fn parse_by(path: &Path, bytes: &[u8], stretch: usize) -> Result<Trace, Error> {
    check_text(path, bytes)?;
    check_lines(path, bytes)?;
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let file = File { path, bytes };
    let (head, body) = file.head()?;
    let mut table = reader(&bytes[body..]);
    let mut record = ByteRecord::new();
    if !next(&mut table, &mut record) {
        return Err(Error::Empty { path: path.into() });
    }
    let header_at = file.row_start(body, &record);
    let (names, time_at) = file.header(&record, header_at)?;
    let numbers = Numbers { file, names: &names, time_at };
    let stretches = stretches(bytes, body + table.position().byte() as usize, stretch);
    let mut values = numbers.read(&stretches)?;
    let samples = values[time_at].len();
    if samples < 2 {
        let line = file.line(header_at);
        return Err(Error::TooShort { path: path.into(), line, samples });
    }
    let time = values.remove(time_at);
    let columns = names.into_iter().filter(|name| name != TIME).zip(values);
    let columns = columns.map(|(name, values)| Column { name, values }).collect();
    Ok(Trace { path: Some(path.into()), head, time, columns })
}

fn reader(bytes: &[u8]) -> csv::Reader<&[u8]> {
    let mut rows = csv::ReaderBuilder::new();
    rows.has_headers(false).flexible(true).buffer_capacity(1 << 16).from_reader(bytes)
}

/// The next row; false at the end. A reader over memory of rows of any length has no errors.
fn next(table: &mut csv::Reader<&[u8]>, record: &mut ByteRecord) -> bool {
    table.read_byte_record(record).unwrap_or(false)
}

/// What follows `from`, in stretches of whole rows and about so many bytes; one, if an end of line may be within quotes.
fn stretches(bytes: &[u8], from: usize, length: usize) -> Vec<Range<usize>> {
    let length = if bytes[from..].contains(&b'"') { bytes.len() } else { length };
    let mut stretches = Vec::new();
    let mut begin = from;
    while begin < bytes.len() {
        let rest = bytes[begin..].iter().skip(length).position(|&byte| byte == b'\n');
        let end = rest.map_or(bytes.len(), |rest| begin + length + rest + 1);
        stretches.push(begin..end);
        begin = end;
    }
    stretches
}

/// A finite number, spaces around it allowed.
fn number(cell: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(cell.trim_ascii()).ok()?;
    text.parse().ok().filter(|value: &f64| value.is_finite())
}

/// Refuses what is not text before anything is made of it.
fn check_text(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let found = |at: usize, found| Error::NotText {
        path: path.into(),
        line: line_of(bytes, at),
        column: 1 + line_start(bytes, at).iter().filter(|&&byte| byte == b',').count(),
        found,
    };
    if bytes.starts_with(b"\xFF\xFE") || bytes.starts_with(b"\xFE\xFF") {
        return Err(found(0, "UTF-16 text"));
    }
    // `contains` is much faster than `position`, and nearly always all that is needed.
    if bytes.contains(&0) {
        let at = bytes.iter().take_while(|&&byte| byte != 0).count();
        return Err(found(at, "binary data or UTF-16 text"));
    }
    match std::str::from_utf8(bytes) {
        Ok(_) => Ok(()),
        Err(error) => Err(found(error.valid_up_to(), "text in another encoding, or binary data")),
    }
}

/// Refuses a line that no table of numbers has, before it is taken apart.
fn check_lines(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let mut from = 0;
    while bytes.len() - from > MAX_LINE {
        // The last end of a line within reach: no byte is looked at twice.
        let reach = &bytes[from..=from + MAX_LINE];
        match reach.iter().rposition(|&byte| byte == b'\n' || byte == b'\r') {
            Some(end) => from += end + 1,
            None => {
                let what = format!("longer than {} MiB", MAX_LINE >> 20);
                return Err(Error::Beyond { path: path.into(), line: line_of(bytes, from), what });
            }
        }
    }
    Ok(())
}

/// Line of a byte, from 1; ends of line are `\n`, `\r\n` and `\r`.
pub(super) fn line_of(bytes: &[u8], at: usize) -> usize {
    let ends = |index: usize| {
        bytes[index] == b'\n' || (bytes[index] == b'\r' && bytes.get(index + 1) != Some(&b'\n'))
    };
    1 + (0..at.min(bytes.len())).filter(|&index| ends(index)).count()
}

/// The part of a byte's line before it.
fn line_start(bytes: &[u8], at: usize) -> &[u8] {
    let start = bytes[..at].iter().rposition(|&byte| byte == b'\n' || byte == b'\r');
    &bytes[start.map_or(0, |end| end + 1)..at]
}

/// The file under way, to say where something is.
#[derive(Clone, Copy)]
struct File<'a> {
    path: &'a Path,
    bytes: &'a [u8],
}

impl File<'_> {
    fn line(&self, at: usize) -> usize {
        line_of(self.bytes, at)
    }

    /// The commented TOML before the header row, and where the header row begins.
    fn head(&self) -> Result<(Head, usize), Error> {
        let mut lines = Vec::new();
        let mut at = 0;
        while at < self.bytes.len() {
            let rest = &self.bytes[at..];
            let end = rest.iter().position(|&byte| byte == b'\n' || byte == b'\r');
            let text = &rest[..end.unwrap_or(rest.len())];
            let content = text.trim_ascii_start();
            if !content.is_empty() && content[0] != b'#' {
                break;
            }
            if rest[text.len()..].starts_with(b"\r\n") {
                at += 1;
            }
            at += text.len() + usize::from(end.is_some());
            let text = std::str::from_utf8(text).expect("checked by the caller");
            lines.push(text);
            if lines.len() > MAX_HEAD_LINES {
                let what = format!("the head has more than {MAX_HEAD_LINES} lines");
                return Err(Error::Beyond { path: self.path.into(), line: lines.len(), what });
            }
        }
        Ok((head::parse(self.path, &lines)?, at))
    }

    /// Where in the file a row begins. The reader's own position is before the blank lines above it.
    fn row_start(&self, body: usize, record: &ByteRecord) -> usize {
        let from = body + record.position().map_or(0, |position| position.byte() as usize);
        let blank = |&byte: &u8| byte == b'\n' || byte == b'\r';
        from + self.bytes[from..].iter().take_while(|byte| blank(byte)).count()
    }

    /// The names of the columns and which of them is time.
    fn header(&self, record: &ByteRecord, at: usize) -> Result<(Vec<String>, usize), Error> {
        let line = self.line(at);
        let text =
            |cell| std::str::from_utf8(cell).expect("checked by the caller").trim().to_owned();
        let names: Vec<String> = record.iter().map(text).collect();
        let place = |index: usize| Place {
            path: self.path.into(),
            line,
            column: index + 1,
            name: names[index].clone(),
        };
        if let [only] = &names[..] {
            let found = [(';', "semicolons"), ('\t', "tabs"), ('|', "bars")];
            if let Some((_, found)) = found.into_iter().find(|(mark, _)| only.contains(*mark)) {
                return Err(Error::Delimiter { path: self.path.into(), line, found });
            }
        }
        if names.len() > MAX_COLUMNS {
            let what = format!("{} columns, more than {MAX_COLUMNS}", names.len());
            return Err(Error::Beyond { path: self.path.into(), line, what });
        }
        if record.iter().all(|cell| number(cell).is_some()) {
            return Err(Error::NoHeader { place: place(0) });
        }
        names::check(&names).map_err(|fault| match fault {
            Fault::Unnamed(index) => Error::ColumnName { place: place(index) },
            Fault::Duplicate { index, first } => {
                Error::DuplicateColumn { place: place(index), first: first + 1 }
            }
            Fault::Unit { index, expected } => Error::WrongUnit { place: place(index), expected },
        })?;
        match names.iter().position(|name| name == TIME) {
            Some(time_at) => Ok((names, time_at)),
            None => Err(Error::NoTime { path: self.path.into(), line, columns: names }),
        }
    }
}

/// The rows of numbers below the header.
#[derive(Clone, Copy)]
struct Numbers<'a> {
    file: File<'a>,
    names: &'a [String],
    time_at: usize,
}

impl Numbers<'_> {
    /// The columns of all stretches, which are read side by side.
    fn read(&self, stretches: &[Range<usize>]) -> Result<Vec<Vec<f64>>, Error> {
        let parts: Vec<_> =
            stretches.par_iter().map(|at| self.rows(at, f64::NEG_INFINITY)).collect();
        let rows = |part: &Result<Vec<Vec<f64>>, _>| part.as_ref().map_or(0, |part| part[0].len());
        let count = parts.iter().map(rows).sum();
        let mut all: Vec<Vec<f64>> = self.names.iter().map(|_| Vec::with_capacity(count)).collect();
        for (at, part) in stretches.iter().zip(parts) {
            let before = *all[self.time_at].last().unwrap_or(&f64::NEG_INFINITY);
            let goes_on =
                |part: &Vec<Vec<f64>>| part[self.time_at].first().is_none_or(|&time| time > before);
            let part = match part {
                Ok(part) if goes_on(&part) => part,
                // The first thing that is wrong may be that time goes back from the stretch before.
                _ => self.rows(at, before)?,
            };
            all.iter_mut().zip(part).for_each(|(all, part)| all.extend(part));
        }
        Ok(all)
    }

    /// The columns of one stretch; its first time must be later than `before`, s.
    fn rows(&self, at: &Range<usize>, mut before: f64) -> Result<Vec<Vec<f64>>, Error> {
        let Self { file, names, time_at } = *self;
        // About one row for each as many bytes as it has columns of 8: one allocation for most stretches.
        let rows = at.len() / (8 * names.len()).max(1);
        let mut values: Vec<Vec<f64>> = names.iter().map(|_| Vec::with_capacity(rows)).collect();
        let mut table = reader(&file.bytes[at.clone()]);
        let mut record = ByteRecord::new();
        while next(&mut table, &mut record) {
            let row = Row { file: &file, names, at: (at.start, &record) };
            if record.len() != names.len() {
                return Err(row.field_count());
            }
            for (column, cell) in record.iter().enumerate() {
                let value = number(cell).ok_or_else(|| row.not_a_number(column, cell))?;
                values[column].push(value);
            }
            let time = *values[time_at].last().expect("one value was pushed");
            if time <= before {
                return Err(Error::TimeOrder { place: row.place(time_at), time, previous: before });
            }
            before = time;
        }
        Ok(values)
    }
}

/// One row of numbers, to say what is wrong with it.
struct Row<'a> {
    file: &'a File<'a>,
    names: &'a [String],
    at: (usize, &'a ByteRecord),
}

impl Row<'_> {
    fn place(&self, column: usize) -> Place {
        let (body, record) = self.at;
        Place {
            path: self.file.path.into(),
            line: self.file.line(self.file.row_start(body, record)),
            column: column + 1,
            name: self.names.get(column).cloned().unwrap_or_default(),
        }
    }

    fn field_count(&self) -> Error {
        let (found, expected) = (self.at.1.len(), self.names.len());
        Error::FieldCount { place: self.place(found.min(expected)), expected, found }
    }

    fn not_a_number(&self, column: usize, cell: &[u8]) -> Error {
        let place = self.place(column);
        let text = String::from_utf8_lossy(cell).trim().to_owned();
        match text.parse::<f64>() {
            Ok(_) => Error::NotFinite { place, text },
            Err(_) => Error::NotANumber { place, text },
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn parse_text(text: &str) -> Result<Trace, Error> {
        parse(Path::new("press.csv"), text.as_bytes())
    }

    #[test]
    fn a_file_with_no_head_is_a_trace() {
        let trace = parse_text("time_s,force_N\n0,1\n0.5,2\n").unwrap();
        assert_eq!(trace.time, [0.0, 0.5]);
        assert_eq!(trace.force().unwrap(), [1.0, 2.0]);
        assert_eq!(trace.head, Head::default());
    }

    #[test]
    fn windows_line_ends_a_byte_order_mark_quotes_and_blank_lines_at_the_end_are_accepted() {
        let text = "\u{feff}# name = \"take 3\"\r\n\r\n\"time_s\",\"force_N\"\r\n0, 1\r\n1,2e0\r\n\r\n\r\n";
        let trace = parse_text(text).unwrap();
        assert_eq!(trace.head.name.as_deref(), Some("take 3"));
        assert_eq!(trace.force().unwrap(), [1.0, 2.0]);
    }

    /// The error of a text that is no trace; short, whatever is in the text.
    fn refusal(text: &str) -> String {
        let error = parse_text(text).unwrap_err().to_string();
        assert!(error.len() < 1000, "{} bytes of error", error.len());
        error
    }

    #[test]
    fn what_no_recording_has_so_much_of_is_refused_in_a_few_words() {
        let long = "x".repeat(2 * MAX_LINE);
        assert!(refusal(&long).contains("line 1: longer than 1 MiB"));
        assert!(refusal(&format!("time_s,force_N\n0,1\n{long}\n")).contains("line 3: longer"));
        assert!(refusal(&format!("# name = \"{long}\"\n")).contains("line 1: longer"));
        let head = "# a = 1\n".repeat(MAX_HEAD_LINES + 1);
        assert!(refusal(&head).contains("the head has more than 2000 lines"));
        let columns: Vec<String> = (0..=MAX_COLUMNS).map(|k| format!("c{k}")).collect();
        assert!(refusal(&columns.join(",")).contains("10001 columns, more than 10000"));
    }

    #[test]
    fn an_error_repeats_no_more_of_a_file_than_a_person_would_read() {
        let name = "n".repeat(100_000);
        assert!(refusal(&format!("time_s,{name},{name}\n0,1,2\n")).contains("has the same name"));
        let names: Vec<String> = (0..2_000).map(|k| format!("column{k}")).collect();
        let error = refusal(&format!("{}\n", names.join(",")));
        assert!(error.contains("column19 and 1980 more"), "{error}");
        let unclosed = format!("time_s,\"{}", "line\n".repeat(100_000));
        refusal(&unclosed);
    }

    #[test]
    fn unknown_columns_are_kept_in_order_wherever_time_stands() {
        let trace = parse_text("a,time_s,b\n5,0,7\n6,1,8\n").unwrap();
        let names: Vec<_> = trace.columns.iter().map(|column| column.name.as_str()).collect();
        assert_eq!(names, ["a", "b"]);
        assert_eq!(trace.column("b").unwrap(), [7.0, 8.0]);
    }

    #[test]
    fn an_error_names_the_line_as_an_editor_counts_it() {
        for text in [
            "# name = \"x\"\n\ntime_s,force_N\n0,1\n\n1,x\n",
            "# name = \"x\"\r\n\r\ntime_s,force_N\r\n0,1\r\n\r\n1,x\r\n",
            "# name = \"x\"\r\rtime_s,force_N\r0,1\r\r1,x\r",
        ] {
            let error = parse_text(text).unwrap_err().to_string();
            assert!(
                error.starts_with("press.csv, line 6, column 2 (force_N): `x` is not"),
                "{error}"
            );
        }
    }

    proptest! {
        #[test]
        fn trace_and_errors_do_not_depend_on_the_stretches_that_are_read_side_by_side(
            times in proptest::collection::vec((0..40_i32, 0..30_u8), 0..30), stretch in 0..40_usize
        ) {
            // Mostly ascending, with what else there may be in a file in between.
            let row = |(k, (jitter, what)): (usize, &(i32, u8))| match what {
                0 => format!("{k},x\n"),
                1 => format!("{k}\n"),
                2 => "\n\n".into(),
                3 => format!("{k},\"1\n\"\r\n"),
                4 => format!("{},1\r", k as i32 - jitter),
                _ => format!("{k},{jitter}\r\n"),
            };
            let rows: String = times.iter().enumerate().map(row).collect();
            let text = format!("time_s,force_N\n{rows}");
            let by = |stretch| parse_by(Path::new("press.csv"), text.as_bytes(), stretch).map_err(|error| error.to_string());
            prop_assert_eq!(by(stretch), by(usize::MAX));
        }

        #[test]
        fn no_bytes_make_the_reader_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let _ = parse(Path::new("press.csv"), &bytes);
        }

        #[test]
        fn nothing_like_a_trace_makes_the_reader_panic(
            text in "(# [a-z=\"\\[\\]0-9 .]{0,12}\r?\n){0,3}(time_s|\"time_s\"|a),b\r?\n([0-9.,;\"eE+-]{0,9}[\r\n]{0,2}){0,6}"
        ) {
            if let Ok(trace) = parse_text(&text) {
                prop_assert!(trace.len() >= 2);
                prop_assert!(trace.time.windows(2).all(|pair| pair[0] < pair[1]));
            }
        }
    }
}
