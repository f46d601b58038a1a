//! Foreign recordings become traces, exactly as their mapping says.

use std::path::{Path, PathBuf};

use super::error::Place;
use super::first_force::first_force;
use super::import_error::ImportError;
use super::mapping::{Change, Mapping, Others, Reference, Repeated, Restarts, Time, Word};
use super::names::{self, Fault};
use super::stamp::{Instant, Stamp};
use super::table::Rows;
use super::{Column, FORCE, TIME, Trace, gaps, head};

/// A trace, and what became of the file it was made from.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// The trace; its head says the file's name and the mapping.
    pub trace: Trace,
    /// Rows of numbers in the file.
    pub rows: usize,
    /// Rows that shared their time stamp with another and were merged into it.
    pub merged: usize,
    /// Rows left out because a cell has no value.
    pub missing: usize,
    /// Samples outside the time that every column's own clock covers, left out.
    pub uncovered: usize,
    /// Name in the file and name in the trace of every column, time first.
    pub columns: Vec<(String, String)>,
    /// Columns left out, each with the reason.
    pub dropped: Vec<(String, String)>,
}

/// Brings in one foreign recording.
///
/// # Errors
/// See [`ImportError`]; each names the file and, where there is one, line and column.
pub fn import(path: &Path, mapping: &Mapping) -> Result<Imported, ImportError> {
    alone(path, Recording::read(path, mapping, &mut None)?)?.finish(&[path], mapping)
}

/// Brings in what [`import_parts`] does, or every test of a single file: several where the mapping splits them and the clock begins
/// anew.
///
/// # Errors
/// Those of [`import_parts`].
pub fn import_tests(paths: &[PathBuf], mapping: &Mapping) -> Result<Vec<Imported>, ImportError> {
    let [path] = paths else { return import_parts(paths, mapping).map(|imported| vec![imported]) };
    let tests = Recording::read(path, mapping, &mut None)?;
    tests.into_iter().map(|test| test.finish(&[path], mapping)).collect()
}

/// Where the traces of so many tests go: `pull.trace.csv`, or `pull-1.trace.csv` and so on.
#[must_use]
pub fn places(output: &Path, tests: usize) -> Vec<PathBuf> {
    if tests == 1 {
        return vec![output.into()];
    }
    let name = output.file_name().unwrap_or_default().to_string_lossy();
    let trace = name.strip_suffix(".trace.csv").map(str::len);
    let (stem, ending) = name.split_at(trace.or_else(|| name.rfind('.')).unwrap_or(name.len()));
    (1..=tests).map(|test| output.with_file_name(format!("{stem}-{test}{ending}"))).collect()
}

/// The only test of a file.
fn alone(path: &Path, mut tests: Vec<Recording>) -> Result<Recording, ImportError> {
    let count = tests.len();
    match tests.pop() {
        Some(test) if count == 1 => Ok(test),
        _ => Err(ImportError::SeveralTests { path: path.into(), tests: count }),
    }
}

/// Brings in one recording that its machine wrote into several files, one for each interval or step.
///
/// The files are put into the order of their times, whatever the order of `paths`.
///
/// # Errors
/// Those of [`import`]; [`ImportError::PartsDiffer`] for files of different columns,
/// [`ImportError::PartsOverlap`] for files that share time, [`ImportError::PartsWithoutClock`] for a
/// mapping without a column of time.
pub fn import_parts(paths: &[PathBuf], mapping: &Mapping) -> Result<Imported, ImportError> {
    if let [path] = paths {
        return import(path, mapping);
    }
    if mapping.time.from.is_none() {
        return Err(ImportError::PartsWithoutClock);
    }
    let mut parts = Vec::with_capacity(paths.len());
    let mut origin = None;
    for path in paths {
        parts.push((path.as_path(), alone(path, Recording::read(path, mapping, &mut origin)?)?));
    }
    parts.sort_by(|(_, a), (_, b)| a.start().total_cmp(&b.start()));
    let ordered: Vec<&Path> = parts.iter().map(|(path, _)| *path).collect();
    let mut parts = parts.into_iter();
    let (mut before, mut whole) = parts.next().ok_or(ImportError::PartsWithoutClock)?;
    for (path, part) in parts {
        whole.append(before, part, path)?;
        before = path;
    }
    whole.finish(&ordered, mapping)
}

/// A name of letters, digits and underscores for a column that the mapping does not name.
fn sanitized(name: &str, index: usize) -> String {
    let word = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let spaced: String = name.chars().map(word).collect();
    let words: Vec<&str> = spaced.split('_').filter(|word| !word.is_empty()).collect();
    if words.is_empty() { format!("column_{}", index + 1) } else { words.join("_") }
}

/// What a column on the clock of the recording comes from.
struct Source {
    index: usize,
    shown: String,
    name: String,
    change: Change,
    reference: Option<Reference>,
    /// A column the mapping does not name: left out, with this reason, once it holds no number.
    other: bool,
    dropped: Option<String>,
}

/// A column with a clock of its own.
struct Clocked {
    source: Source,
    clock: usize,
    clock_change: Change,
    clock_reference: f64,
    time: Vec<f64>,
    values: Vec<f64>,
}

/// Rows with one time stamp.
struct Instants {
    time: f64,
    sums: Vec<f64>,
    count: f64,
}

/// The samples so far.
struct Recording {
    time_from: Option<usize>,
    time_shown: String,
    time_change: Change,
    plan: Time,
    every: usize,
    sources: Vec<Source>,
    clocked: Vec<Clocked>,
    open: Option<Instants>,
    time: Vec<f64>,
    values: Vec<Vec<f64>>,
    /// Which test of its file it is, from 1; none where the file has but one.
    test: Option<i64>,
    rows: usize,
    missing: usize,
    stamps: usize,
    /// The whole second from which written times are counted, else the whole count of the clock's own unit; and the last written time.
    origin: i64,
    last: Option<Instant>,
}

/// Whether a clock that has counted from `first` to `last` begins anew at a time.
pub(super) fn begins_anew(time: f64, last: f64, first: f64) -> bool {
    time < last && last - time >= RESTART * (last - first)
}

/// Part of what a clock has counted by which it falls at least where it begins anew.
const RESTART: f64 = 0.5;
/// Seconds in a day.
const DAY: i64 = 86_400;

impl Recording {
    /// Takes every row of a file: a recording, or one for each test. Times are counted from `origin`, which the first file of a
    /// recording sets.
    fn read(
        path: &Path,
        mapping: &Mapping,
        origin: &mut Option<i64>,
    ) -> Result<Vec<Self>, ImportError> {
        let mut rows = Rows::open(path, mapping)?;
        let mut tests: Vec<Self> = Vec::new();
        while rows.next()? {
            let goes_on = match tests.last_mut() {
                Some(test) => !test.is_over(&rows)?,
                None => false,
            };
            if !goes_on {
                let mut plan = Self::plan(&rows, mapping)?;
                plan.origin = *origin.get_or_insert(plan.first_count(&rows)?);
                tests.push(plan);
            }
            if let Some(test) = tests.last_mut() {
                test.take(&rows)?;
            }
        }
        tests.iter_mut().for_each(Self::close);
        if tests.len() > 1 {
            tests.iter_mut().zip(1..).for_each(|(test, number)| test.test = Some(number));
        }
        if tests.is_empty() {
            return Err(ImportError::TooShort { path: path.into(), samples: 0 });
        }
        Ok(tests)
    }

    /// Whether the clock begins anew with this row, and another test with it.
    fn is_over(&self, rows: &Rows) -> Result<bool, ImportError> {
        let splits = self.plan.restarts == Restarts::Split;
        let Some((index, open)) = self.time_from.filter(|_| splits).zip(self.open.as_ref()) else {
            return Ok(false);
        };
        if rows.is_missing(index) {
            return Ok(false);
        }
        let time = counted(rows, index, self.origin as f64, &self.time_change)?;
        let first = self.time.first().copied().unwrap_or(open.time);
        Ok(begins_anew(time, open.time, first))
    }

    /// Time of the first sample, s.
    fn start(&self) -> f64 {
        self.time.first().copied().unwrap_or(f64::INFINITY)
    }

    /// Adds the samples of the file that follows; `before` is the file the last ones came from.
    fn append(&mut self, before: &Path, part: Self, path: &Path) -> Result<(), ImportError> {
        let names = |of: &Self| -> Vec<String> {
            of.sources.iter().map(|source| source.name.clone()).collect()
        };
        if names(self) != names(&part) {
            return Err(ImportError::PartsDiffer { path: path.into(), other: before.into() });
        }
        if let (Some(&end), Some(&start)) = (self.time.last(), part.time.first())
            && start <= end
        {
            let (path, other) = (path.into(), before.into());
            let (start, end) = (self.told(start), self.told(end));
            return Err(ImportError::PartsOverlap { path, other, start, end });
        }
        for (source, more) in self.sources.iter_mut().zip(part.sources) {
            source.dropped = source.dropped.take().or(more.dropped);
        }
        for (column, more) in self.clocked.iter_mut().zip(part.clocked) {
            column.time.extend(more.time);
            column.values.extend(more.values);
        }
        self.time.extend(part.time);
        for (column, more) in self.values.iter_mut().zip(part.values) {
            column.extend(more);
        }
        self.rows += part.rows;
        self.missing += part.missing;
        self.stamps += part.stamps;
        Ok(())
    }

    /// Finds every column that the mapping names in the file.
    fn plan(rows: &Rows, mapping: &Mapping) -> Result<Self, ImportError> {
        let shown = |index: usize| match rows.names.get(index) {
            Some(name) if !name.is_empty() => name.clone(),
            _ => format!("column {}", index + 1),
        };
        let checked = "checked when the mapping was read";
        let time_from = mapping.time.from.as_ref().map(|from| rows.find(from)).transpose()?;
        let mut used: Vec<usize> = time_from.into_iter().collect();
        let (mut sources, mut clocked) = (Vec::new(), Vec::new());
        for column in &mapping.column {
            let index = rows.find(&column.from)?;
            used.push(index);
            let source = Source {
                index,
                shown: shown(index),
                name: column.name.clone(),
                change: column.change().expect(checked),
                reference: column.reference.clone(),
                other: false,
                dropped: None,
            };
            let Some(clock) = &column.clock else {
                sources.push(source);
                continue;
            };
            let clock_at = rows.find(&clock.from)?;
            used.push(clock_at);
            clocked.push(Clocked {
                source,
                clock: clock_at,
                clock_change: Change::clock(clock.unit.as_deref()).expect(checked),
                clock_reference: clock.reference.unwrap_or(0.0),
                time: Vec::new(),
                values: Vec::new(),
            });
        }
        for index in (0..rows.width()).filter(|index| !used.contains(index)) {
            let drop = (mapping.others == Others::Drop).then(|| "`others = \"drop\"`".to_owned());
            let name = sanitized(rows.names.get(index).map_or("", String::as_str), index);
            let (change, reference) = (Change::NONE, None);
            let shown = shown(index);
            sources.push(Source {
                index,
                shown,
                name,
                change,
                reference,
                other: true,
                dropped: drop,
            });
        }
        Ok(Self {
            time_from,
            time_shown: time_from.map_or_else(|| "start_s and step_s".into(), shown),
            time_change: Change::clock(mapping.time.unit.as_deref()).expect(checked),
            plan: mapping.time.clone(),
            every: mapping.every.unwrap_or(1),
            values: vec![Vec::new(); sources.len()],
            sources,
            clocked,
            open: None,
            time: Vec::new(),
            test: None,
            rows: 0,
            missing: 0,
            stamps: 0,
            origin: 0,
            last: None,
        })
    }

    /// The whole second of the first written time, or the whole count of the clock's own unit, where times are counted from the
    /// first in the end: near 0 none of their digits are lost.
    fn first_count(&self, rows: &Rows) -> Result<i64, ImportError> {
        let from_first = self.plan.reference == Some(Reference::Word(Word::First));
        match (self.plan.stamp, self.time_from.filter(|_| from_first)) {
            (Some(stamp), Some(index)) => Ok(instant(rows, index, stamp)?.whole),
            (None, Some(index)) => Ok(rows.number(index)?.floor() as i64),
            (_, None) => Ok(0),
        }
    }

    /// A time as the file tells it, s; a written one from its first whole second on.
    fn told(&self, time: f64) -> f64 {
        let numbers = self.plan.stamp.is_none();
        if numbers { time + self.time_change.apply(self.origin as f64) } else { time }
    }

    /// The time of a row, s.
    fn time(&mut self, rows: &Rows) -> Result<f64, ImportError> {
        let Some(index) = self.time_from else {
            let (start, step) = (self.plan.start_s, self.plan.step_s);
            return Ok(start.unwrap_or(0.0) + self.rows as f64 * step.unwrap_or(1.0));
        };
        let Some(stamp) = self.plan.stamp else {
            return counted(rows, index, self.origin as f64, &self.time_change);
        };
        let mut now = instant(rows, index, stamp)?;
        // A clock that falls by half a day or more has passed midnight.
        if let Some(last) = self.last.filter(|_| stamp == Stamp::Clock) {
            let fallen = (last.whole - now.whole + DAY / 2).div_euclid(DAY);
            now.whole += fallen.max(0) * DAY;
        }
        self.last = Some(now);
        Ok((now.whole - self.origin) as f64 + now.rest)
    }

    /// Takes one row.
    fn take(&mut self, rows: &Rows) -> Result<(), ImportError> {
        for column in &mut self.clocked {
            column.take(rows)?;
        }
        let named = self.sources.iter().filter(|source| !source.other).map(|source| source.index);
        // Columns with clocks of their own may go on after the recording's has ended.
        let ended = self.time_from.is_some_and(|time| rows.cell(time).is_empty())
            && named.clone().all(|index| rows.cell(index).is_empty());
        if ended && !self.clocked.is_empty() {
            return Ok(());
        }
        if named.chain(self.time_from).any(|index| rows.is_missing(index)) {
            (self.rows, self.missing) = (self.rows + 1, self.missing + 1);
            return Ok(());
        }
        let time = self.time(rows)?;
        self.rows += 1;
        let mut values = Vec::with_capacity(self.sources.len());
        for source in &mut self.sources {
            values.push(source.take(rows)?);
        }
        self.put(time, values, rows)
    }

    /// Adds a row to the time stamp under way, or begins the next.
    fn put(&mut self, time: f64, values: Vec<f64>, rows: &Rows) -> Result<(), ImportError> {
        let before = self.open.as_ref().map_or(f64::NEG_INFINITY, |stamp| stamp.time);
        let repeated = self.plan.repeated;
        if time < before || (time == before && repeated == Repeated::Error) {
            let place = rows.place(self.time_from.unwrap_or(0));
            let (time, previous) = (self.told(time), self.told(before));
            return Err(ImportError::TimeOrder { place, time, previous });
        }
        match &mut self.open {
            Some(stamp) if time == before => match repeated {
                Repeated::KeepLast => stamp.sums = values,
                Repeated::Mean => {
                    stamp.sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
                    stamp.count += 1.0;
                }
                Repeated::KeepFirst | Repeated::Error => {}
            },
            _ => {
                self.close();
                self.open = Some(Instants { time, sums: values, count: 1.0 });
            }
        }
        Ok(())
    }

    /// Ends the time stamp under way; one of every so many becomes a sample.
    fn close(&mut self) {
        let Some(stamp) = self.open.take() else { return };
        if self.stamps.is_multiple_of(self.every) {
            self.time.push(stamp.time);
            for (column, sum) in self.values.iter_mut().zip(&stamp.sums) {
                column.push(sum / stamp.count);
            }
        }
        self.stamps += 1;
    }

    /// The trace of all that was taken from the files `paths`, in their order.
    fn finish(mut self, paths: &[&Path], mapping: &Mapping) -> Result<Imported, ImportError> {
        let path = paths.first().copied().unwrap_or_else(|| Path::new(""));
        subtract(path, TIME, self.plan.reference.as_ref(), None, &mut self.time)?;
        let force = self.sources.iter().position(|source| source.name == FORCE);
        let touch = force.and_then(|index| first_force(self.values.get(index)?));
        let mut columns = vec![(self.time_shown, TIME.to_owned())];
        let mut dropped = Vec::new();
        let mut trace = Trace { time: self.time, ..Trace::default() };
        for (source, mut values) in self.sources.into_iter().zip(self.values) {
            if let Some(reason) = source.dropped {
                dropped.push((source.shown, reason));
                continue;
            }
            subtract(path, &source.name, source.reference.as_ref(), touch, &mut values)?;
            columns.push((source.shown, source.name.clone()));
            trace.columns.push(Column { name: source.name, values });
        }
        let samples = trace.len();
        for column in self.clocked {
            columns.push((column.source.shown.clone(), column.source.name.clone()));
            column.join(path, &mut trace)?;
        }
        check_names(path, &columns)?;
        if trace.len() < 2 {
            return Err(ImportError::TooShort { path: path.into(), samples: trace.len() });
        }
        trace.head = mapping.head.clone();
        trace.head.version = Some(head::VERSION);
        trace
            .head
            .other
            .insert("import".into(), origin(paths, mapping, (self.test, self.every)).into());
        Ok(Imported {
            uncovered: samples - trace.len(),
            merged: self.rows - self.missing - self.stamps,
            missing: self.missing,
            rows: self.rows,
            trace,
            columns,
            dropped,
        })
    }
}

impl Source {
    /// The number of one row; of a column that the mapping does not name it may be none.
    fn take(&mut self, rows: &Rows) -> Result<f64, ImportError> {
        if self.dropped.is_some() {
            return Ok(0.0);
        }
        match changed(rows, self.index, &self.change) {
            Ok(value) => Ok(value),
            Err(_) if self.other => {
                self.dropped = Some(format!("no number in line {}", rows.line_number()));
                Ok(0.0)
            }
            Err(error) => Err(error),
        }
    }
}

impl Clocked {
    fn take(&mut self, rows: &Rows) -> Result<(), ImportError> {
        if rows.cell(self.clock).is_empty() && rows.cell(self.source.index).is_empty() {
            return Ok(());
        }
        let time = changed(rows, self.clock, &self.clock_change)? - self.clock_reference;
        if let Some(&previous) = self.time.last()
            && time <= previous
        {
            return Err(ImportError::TimeOrder { place: rows.place(self.clock), time, previous });
        }
        self.time.push(time);
        self.values.push(self.source.take(rows)?);
        Ok(())
    }

    /// Puts the column onto the clock of the trace. Samples of the trace before its first, after its
    /// last or in one of its gaps are left out: nothing is extrapolated or made up across a gap.
    fn join(mut self, path: &Path, trace: &mut Trace) -> Result<(), ImportError> {
        subtract(path, &self.source.name, self.source.reference.as_ref(), None, &mut self.values)?;
        let gaps = gaps(&self.time);
        let mut keep = Vec::with_capacity(trace.len());
        let mut values = Vec::new();
        let mut next = 0;
        for &t in &trace.time {
            next += self.time[next..].iter().take_while(|&&own| own < t).count();
            let value = match self.time.get(next) {
                Some(&own) if own == t => Some(self.values[next]),
                Some(_) if next > 0 && !gaps.iter().any(|gap| gap.index == next) => {
                    let (t0, t1) = (self.time[next - 1], self.time[next]);
                    let (y0, y1) = (self.values[next - 1], self.values[next]);
                    Some(y0 + (y1 - y0) * ((t - t0) / (t1 - t0)))
                }
                _ => None,
            };
            keep.push(value.is_some());
            values.extend(value);
        }
        if values.len() < 2 {
            return Err(ImportError::NoOverlap {
                path: path.into(),
                column: self.source.name,
                from_s: self.time.first().copied().unwrap_or(0.0),
                to_s: self.time.last().copied().unwrap_or(0.0),
            });
        }
        let thin = |all: &mut Vec<f64>| {
            let mut kept = keep.iter();
            all.retain(|_| kept.next().copied().unwrap_or(false));
        };
        thin(&mut trace.time);
        trace.columns.iter_mut().for_each(|column| thin(&mut column.values));
        trace.columns.push(Column { name: self.source.name, values });
        Ok(())
    }
}

/// The number in a cell, in the unit of the trace.
fn changed(rows: &Rows, index: usize, change: &Change) -> Result<f64, ImportError> {
    counted(rows, index, 0.0, change)
}

/// The number in a cell, counted from `zero` in its own unit.
fn counted(rows: &Rows, index: usize, zero: f64, change: &Change) -> Result<f64, ImportError> {
    let value = change.apply(rows.number(index)? - zero);
    if value.is_finite() {
        return Ok(value);
    }
    let place: Place = rows.place(index);
    Err(ImportError::NotFinite { place, text: rows.cell(index).into() })
}

/// The written time in a cell.
fn instant(rows: &Rows, index: usize, stamp: Stamp) -> Result<Instant, ImportError> {
    let text = rows.cell(index);
    stamp.read(text).ok_or_else(|| ImportError::NotATime {
        place: rows.place(index),
        text: text.into(),
        stamp: stamp.name(),
    })
}

/// Subtracts what the mapping says from a column; `touch` is the sample at which contact begins.
fn subtract(
    path: &Path,
    name: &str,
    reference: Option<&Reference>,
    touch: Option<usize>,
    values: &mut [f64],
) -> Result<(), ImportError> {
    let no_contact = || ImportError::NoContact { path: path.into(), column: name.into() };
    let zero = match reference {
        None => return Ok(()),
        Some(Reference::Value(value)) => *value,
        Some(Reference::Word(Word::First)) => values.first().copied().unwrap_or(0.0),
        Some(Reference::Word(Word::Contact)) => {
            touch.and_then(|index| values.get(index)).copied().ok_or_else(no_contact)?
        }
    };
    values.iter_mut().for_each(|value| *value -= zero);
    Ok(())
}

fn check_names(path: &Path, columns: &[(String, String)]) -> Result<(), ImportError> {
    let all: Vec<&str> = columns.iter().map(|(_, name)| name.as_str()).collect();
    names::check(&all).map_err(|fault| {
        let (index, fault) = match fault {
            Fault::Unnamed(index) => (index, "has no printable name".to_owned()),
            Fault::Duplicate { index, .. } => (index, "appears twice".to_owned()),
            Fault::Unit { index, expected } => (index, format!("is `{expected}` in a trace")),
        };
        ImportError::Name { path: path.into(), name: all[index].to_owned(), fault }
    })
}

/// Where a trace came from, for its head.
fn origin(paths: &[&Path], mapping: &Mapping, (test, every): (Option<i64>, usize)) -> toml::Table {
    let name = |path: &&Path| -> toml::Value {
        path.file_name().unwrap_or_default().to_string_lossy().into_owned().into()
    };
    let mut origin = toml::Table::new();
    match paths {
        [path] => origin.insert("file".into(), name(path)),
        several => {
            origin.insert("files".into(), several.iter().map(name).collect::<Vec<_>>().into())
        }
    };
    origin.insert("mapping".into(), mapping.name.clone().into());
    if every > 1 {
        origin.insert("every".into(), i64::try_from(every).unwrap_or(i64::MAX).into());
    }
    origin.insert("mapping_text".into(), mapping.source.clone().into());
    origin.extend(test.map(|test| ("test".to_owned(), test.into())));
    origin
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn try_import(map: &str, bytes: &[u8]) -> Result<Imported, ImportError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("foreign.txt");
        std::fs::write(&path, bytes).unwrap();
        let mapping = Mapping::parse(Path::new("map.toml"), &format!("palpate-map = 1\n{map}"))
            .unwrap_or_else(|error| panic!("{error}"));
        import(&path, &mapping)
    }

    fn column<'a>(imported: &'a Imported, name: &str) -> &'a [f64] {
        imported.trace.column(name).unwrap()
    }

    #[test]
    fn units_scale_sign_and_reference_are_applied_in_the_order_documented() {
        let map = r#"
            [time]
            from = 1
            unit = "ms"
            reference = "first"
            [[column]]
            from = 2
            name = "displacement_mm"
            unit = "m"
            scale = 2.0
            offset = 1.0
            negate = true
            reference = -5000.0
            [[column]]
            from = 3
            name = "force_N"
            unit = "kPa"
            area_mm2 = 20.0"#;
        let found = try_import(map, b"1000,1,50\n1500,2,100\n").unwrap();
        assert_eq!(found.trace.time, [0.0, 0.5]);
        assert_eq!(column(&found, "displacement_mm"), [2000.0, 0.0]);
        assert_eq!(column(&found, "force_N"), [1.0, 2.0]);
    }

    #[test]
    fn a_column_with_its_own_clock_is_interpolated_where_its_clock_reaches_and_nowhere_else() {
        let map = r#"
            [time]
            from = 1
            [[column]]
            from = 2
            name = "force_N"
            [[column]]
            from = 4
            name = "displacement_mm"
            clock = { from = 3, unit = "ms" }"#;
        let rows = b"0,10,500,1\n1,11,1500,3\n2,12,2500,5\n3,13,,\n4,14,,\n";
        let found = try_import(map, rows).unwrap();
        assert_eq!(found.trace.time, [1.0, 2.0]);
        assert_eq!(column(&found, "displacement_mm"), [2.0, 4.0]);
        assert_eq!(column(&found, "force_N"), [11.0, 12.0]);
        assert_eq!(found.uncovered, 3);
        let apart = b"0,10,50000,1\n1,11,51000,3\n";
        assert!(matches!(try_import(map, apart), Err(ImportError::NoOverlap { .. })));
    }

    #[test]
    fn a_gap_of_a_columns_own_clock_stays_a_gap() {
        let map = r#"
            [time]
            from = 1
            [[column]]
            from = 3
            name = "force_N"
            clock = { from = 2 }"#;
        let own = |i: i32| if i < 20 { f64::from(i) } else { f64::from(i) + 40.0 };
        let text: String = (0..100).map(|i| format!("{i},{},{i}\n", own(i))).collect();
        let trace = try_import(map, text.as_bytes()).unwrap().trace;
        let gaps = gaps(&trace.time);
        assert_eq!((gaps.len(), gaps[0].from_s, gaps[0].to_s), (1, 19.0, 60.0));
    }

    #[test]
    fn repeated_time_stamps_follow_the_policy() {
        let rows = b"0,1\n1,2\n1,4\n2,8\n";
        let with = |policy: &str| {
            let map = format!("[time]\nfrom = 1\n{policy}\n[[column]]\nfrom = 2\nname = \"a\"");
            try_import(&map, rows)
        };
        for (policy, values) in [
            ("keep-first", [1.0, 2.0, 8.0]),
            ("keep-last", [1.0, 4.0, 8.0]),
            ("mean", [1.0, 3.0, 8.0]),
        ] {
            let found = with(&format!("repeated = \"{policy}\"")).unwrap();
            assert_eq!(column(&found, "a"), values, "{policy}");
            assert_eq!(found.merged, 1);
        }
        let error = with("").unwrap_err().to_string();
        assert!(error.contains("line 3, column 1: time 1 s is repeated"), "{error}");
    }

    #[test]
    fn a_recording_in_several_files_is_one_trace_whatever_their_order() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            path
        };
        let map = |time: &str| {
            let text = format!(
                "palpate-map = 1\n[table]\nheader_line = 1\n[time]\n{time}\n\
                 [[column]]\nfrom = \"x\"\nname = \"a\"\nreference = \"first\""
            );
            Mapping::parse(Path::new("map.toml"), &text).unwrap()
        };
        let own = map("from = \"t\"\nreference = \"first\"");
        let late = file("a.csv", "t,x\n7,30\n8,40\n");
        let early = file("b.csv", "t,x\n5,10\n6,20\n");
        let found = import_parts(&[late.clone(), early.clone()], &own).unwrap();
        assert_eq!(found.trace.time, [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(column(&found, "a"), [0.0, 10.0, 20.0, 30.0]);
        assert_eq!(found.rows, 4);
        let files = found.trace.head.other["import"]["files"].as_array().unwrap();
        assert_eq!(files, &["b.csv".into(), "a.csv".into()] as &[toml::Value]);

        let refused = |paths: &[PathBuf], map: &Mapping| import_parts(paths, map).unwrap_err();
        let same = file("c.csv", "t,x\n6,1\n9,2\n");
        let error = refused(&[early.clone(), same], &own);
        assert!(matches!(error, ImportError::PartsOverlap { start: 6.0, end: 6.0, .. }), "{error}");
        let other = file("d.csv", "t,x,y\n9,1,2\n10,2,3\n");
        let error = refused(&[early.clone(), other], &own);
        assert!(matches!(error, ImportError::PartsDiffer { .. }), "{error}");
        let even = map("start_s = 0.0\nstep_s = 1.0");
        assert!(matches!(refused(&[early, late], &even), ImportError::PartsWithoutClock));
    }

    #[test]
    fn a_clock_that_counts_from_1970_keeps_its_digits_in_any_unit() {
        for (unit, step) in [("ns", 500), ("us", 250), ("ms", 10), ("min", 1)] {
            let row = |i: i64| format!("{},{i}\n", 1_717_164_185_000_000 + step * i);
            let rows: String = (0..4).map(row).collect();
            let map = format!("[time]\nfrom = 1\nunit = \"{unit}\"\nreference = \"first\"");
            let found = try_import(&map, rows.as_bytes()).unwrap();
            let alone = try_import(
                &format!("[time]\nfrom = 1\nunit = \"{unit}\""),
                (0..4).map(|i| format!("{},{i}\n", step * i)).collect::<String>().as_bytes(),
            );
            assert_eq!(found.trace.time, alone.unwrap().trace.time, "{unit}");
        }
    }

    #[test]
    fn every_nth_sample_and_a_part_of_the_rows_can_be_taken() {
        let rows: String = (0..20).map(|i| format!("{i},{i}\n")).collect();
        let map = "every = 4\n[table]\nfirst_row = 3\nlast_row = 15\n[time]\nfrom = 1";
        let found = try_import(map, rows.as_bytes()).unwrap();
        assert_eq!(found.trace.time, [2.0, 6.0, 10.0, 14.0]);
        assert_eq!(found.trace.head.other["import"]["every"].as_integer(), Some(4));
    }

    #[test]
    fn columns_that_the_mapping_does_not_name_are_kept_if_they_are_numbers() {
        let map = "[table]\nheader_line = 1\n[time]\nfrom = \"t\"";
        let found = try_import(map, b"t,Shear Stress [Pa],Status\n0,1,ok\n1,2,ok\n").unwrap();
        assert_eq!(column(&found, "Shear_Stress_Pa"), [1.0, 2.0]);
        assert_eq!(found.dropped, [("Status".to_owned(), "no number in line 2".to_owned())]);
        let map = format!("others = \"drop\"\n{map}");
        let found = try_import(&map, b"t,a\n0,1\n1,2\n").unwrap();
        assert!(found.trace.columns.is_empty());
    }

    #[test]
    fn tables_are_chosen_by_their_marker_and_end_where_the_mapping_says() {
        let file =
            b"title\n#begin\nt;a;\n0;1;\n1;2;\n\nrubbish\n#begin\nt;a;\n2;3;\n3;4;\nEND\n9;9\n";
        let map = |blocks: &str| {
            format!(
                "[text]\ndelimiter = \"semicolon\"\n[table]\nblock_prefix = \"#begin\"\n\
                 header_prefix = \"t;\"\nempty_last_cell = true\nstop_at_blank = true\n\
                 stop_at_prefix = \"END\"\n{blocks}\n[time]\nfrom = 1"
            )
        };
        // The prefix is not part of the names: one name is left for two columns.
        assert!(matches!(try_import(&map(""), file), Err(ImportError::CellCount { .. })));
        let file = String::from_utf8_lossy(file).replace("t;a;", "names t;a;");
        let whole = map("").replace("\"t;\"", "\"names \"");
        assert_eq!(try_import(&whole, file.as_bytes()).unwrap().trace.time, [0.0, 1.0, 2.0, 3.0]);
        let second = map("blocks = [1]").replace("\"t;\"", "\"names \"");
        assert_eq!(try_import(&second, file.as_bytes()).unwrap().trace.time, [2.0, 3.0]);
        let third = map("blocks = [2]").replace("\"t;\"", "\"names \"");
        assert!(matches!(try_import(&third, file.as_bytes()), Err(ImportError::NoTable { .. })));
    }

    #[test]
    fn a_line_that_begins_a_table_may_name_its_columns() {
        let map = "[text]\ndelimiter = \"tab\"\n[table]\nblock_prefix = \"t\\t\"\nblock_names = true\n\
                   skip_lines = 1\n[time]\nfrom = \"t\"";
        let found = try_import(map, b"about\nt\tF\ns\tN\n0\t1\n1\t2\nt\tF\ns\tN\n2\t3\n").unwrap();
        assert_eq!(found.trace.time, [0.0, 1.0, 2.0]);
        assert_eq!(column(&found, "F"), [1.0, 2.0, 3.0]);
    }

    #[test]
    fn written_times_keep_their_digits_and_go_on_past_midnight() {
        let map = |stamp: &str| {
            format!(
                "[text]\ndelimiter = \"semicolon\"\n[time]\nfrom = 1\nstamp = \"{stamp}\"\n\
                 reference = \"first\""
            )
        };
        let dated = b"31.12.2024 23:59:59,7;1\n31.12.2024 23:59:59,8;2\n01.01.2025 00:00:00,2;3\n";
        let found = try_import(&map("day-first"), dated).unwrap();
        for (time, expected) in found.trace.time.iter().zip([0.0, 0.1, 0.5]) {
            assert!((time - expected).abs() < 1e-15, "{time}");
        }
        let clock = b"23:59:59.5;1\n00:00:00.5;2\n00:00:01;3\n";
        let found = try_import(&map("clock"), clock).unwrap();
        assert_eq!(found.trace.time, [0.0, 1.0, 1.5]);
        let error = try_import(&map("clock"), b"1.5;2\n2.5;3\n").unwrap_err().to_string();
        assert!(error.contains("line 1, column 1: `1.5` is not a time written `clock`"), "{error}");
    }

    #[test]
    fn a_gap_that_closes_becomes_a_displacement_from_contact() {
        let map = "[time]\nfrom = 1\n[[column]]\nfrom = 2\nname = \"displacement_mm\"\nnegate = true\n\
                   reference = \"contact\"\n[[column]]\nfrom = 3\nname = \"force_N\"";
        let force = |i: i32| if i < 20 { 0.0 } else { f64::from(i - 19) };
        let rows: String = (0..40).map(|i| format!("{i},{},{}\n", 50 - i, force(i))).collect();
        let found = try_import(map, rows.as_bytes()).unwrap();
        assert_eq!(column(&found, "displacement_mm")[19..22], [-1.0, 0.0, 1.0]);
        let rows: String = (0..40).map(|i| format!("{i},{},0\n", 50 - i)).collect();
        assert!(matches!(try_import(map, rows.as_bytes()), Err(ImportError::NoContact { .. })));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn no_bytes_make_the_importer_panic(
            bytes in proptest::collection::vec(any::<u8>(), 0..200),
            encoding in "utf-8|utf-16le|latin1|shift_jis",
            delimiter in "comma|tab|space|semicolon",
        ) {
            let map = format!(
                "[text]\nencoding = \"{encoding}\"\ndelimiter = \"{delimiter}\"\n[time]\nfrom = 1"
            );
            let _ = try_import(&map, &bytes);
            let rows = String::from_utf8_lossy(&bytes).replace(char::is_alphabetic, "1,2\n");
            let _ = try_import(&map, rows.as_bytes());
        }

        #[test]
        fn no_text_makes_the_mapping_panic(text in "(palpate-map = 1\n)?(\\[?\\[?(time|table|text|column|head)\\]?\\]?\n|from = [0-9]\n|\\PC{0,20}\n){0,8}") {
            let _ = Mapping::parse(Path::new("map.toml"), &text);
        }
    }
}
