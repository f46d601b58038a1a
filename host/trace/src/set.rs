//! A data set: several traces of the same specimen and set-up, in the order they were recorded.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::error::Error;
use super::{PARQUET, Trace, elapsed, has_extension, read, recorded};
use crate::recording;

/// Reads files and folders; a folder stands for its `.csv` and `.parquet` files by name (`.csv.gz` and
/// `.csv.zst` too), a recording of a device (`.palpate`)
/// for the stretches of its stream, in the time of the device. Where every trace has
/// `setup.sequence`, else where every trace has `setup.start_s`, the set is put into that order; where no head says anything of it and no
/// two traces share a time, one clock ran through all of them, and says when each began. Otherwise the set keeps the order given.
///
/// # Errors
/// The first of: a folder without traces, no trace at all, a file given twice, a file that
/// [`read()`] refuses, two traces with the same place in the order.
pub fn read_set<P: AsRef<Path>>(paths: &[P]) -> Result<Vec<Trace>, Error> {
    let files = files(paths)?;
    let mut traces = Vec::new();
    for file in &files {
        if has_extension(file, recording::EXTENSION) {
            traces.extend(recorded::read_recording(file, &recorded::Options::default())?.traces);
        } else {
            traces.push(read(file)?);
        }
    }
    order(&mut traces)?;
    for trace in &traces {
        tracing::info!(
            "{}: {} samples over {:.3} s, {} gap(s)",
            trace.label(),
            trace.len(),
            trace.duration(),
            super::gaps(&trace.time).len()
        );
    }
    Ok(traces)
}

/// The files meant, each once.
fn files<P: AsRef<Path>>(paths: &[P]) -> Result<Vec<PathBuf>, Error> {
    let mut files = Vec::new();
    for path in paths {
        let path = path.as_ref();
        if path.is_dir() { files.extend(folder(path)?) } else { files.push(path.to_path_buf()) }
    }
    if files.is_empty() {
        return Err(Error::EmptySet);
    }
    let mut seen = HashMap::new();
    for path in &files {
        let real = path.canonicalize().unwrap_or_else(|_| path.clone());
        if let Some(first) = seen.insert(real, path.clone()) {
            return Err(Error::SameFile { path: path.clone(), first });
        }
    }
    Ok(files)
}

/// Whether a file's name is that of a trace: `.csv`, packed or not, or `.parquet`.
fn named_as_trace(file: &Path) -> bool {
    let packed = has_extension(file, "gz") || has_extension(file, "zst");
    let inner = if packed { Path::new(file.file_stem().unwrap_or_default()) } else { file };
    has_extension(inner, "csv") || has_extension(file, PARQUET)
}

/// The traces of a folder, by name.
fn folder(path: &Path) -> Result<Vec<PathBuf>, Error> {
    let open = |source| Error::Open { path: path.into(), source };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(path).map_err(open)? {
        let file = entry.map_err(open)?.path();
        if named_as_trace(&file) {
            files.push(file);
        }
    }
    files.sort();
    if files.is_empty() { Err(Error::EmptyFolder { path: path.into() }) } else { Ok(files) }
}

/// Keys of the head by which a set is ordered.
const SEQUENCE: &str = "sequence";
const START: &str = "start_s";

fn sequence(trace: &Trace) -> Option<i64> {
    trace.head.setup.sequence
}

fn start(trace: &Trace) -> Option<f64> {
    trace.head.setup.start_s
}

/// The key of the heads that says in which order traces were recorded; none where no key is in all of them.
#[must_use]
pub fn ordered_by(traces: &[Trace]) -> Option<&'static str> {
    if traces.iter().all(|trace| sequence(trace).is_some()) {
        Some(SEQUENCE)
    } else {
        traces.iter().all(|trace| start(trace).is_some()).then_some(START)
    }
}

/// Puts a set into the order in which it was recorded, if its heads say it, or the one clock that ran through all of it.
///
/// # Errors
/// [`Error::SameOrder`].
pub fn order(traces: &mut [Trace]) -> Result<(), Error> {
    begin_by_the_clock(traces);
    let Some(key) = ordered_by(traces) else { return Ok(()) };
    if key == SEQUENCE {
        traces.sort_by_key(sequence);
    } else {
        traces.sort_by(|a, b| start(a).unwrap_or(0.0).total_cmp(&start(b).unwrap_or(0.0)));
    }
    let value = |trace: &Trace| match key {
        SEQUENCE => sequence(trace).map(|number| number.to_string()),
        _ => start(trace).map(|time| time.to_string()),
    };
    let name = |trace: &Trace| trace.path.clone().unwrap_or_else(|| trace.label().into());
    let same = traces.windows(2).find(|pair| value(&pair[0]) == value(&pair[1]));
    same.map_or(Ok(()), |pair| {
        Err(Error::SameOrder {
            path: name(&pair[1]),
            first: name(&pair[0]),
            key,
            value: value(&pair[0]).unwrap_or_default(),
        })
    })
}

/// Notes in each head when its trace began, where no head says anything of the order and the stamps are of one clock: no two traces then
/// share a time. Clocks that begin anew with each trace do.
fn begin_by_the_clock(traces: &mut [Trace]) {
    let ordered =
        |trace: &Trace| trace.is_empty() || sequence(trace).is_some() || start(trace).is_some();
    if traces.len() < 2 || traces.iter().any(ordered) {
        return;
    }
    let mut spans: Vec<(f64, f64)> =
        traces.iter().map(|trace| (trace.time[0], trace.time[trace.len() - 1])).collect();
    spans.sort_by(|a, b| a.0.total_cmp(&b.0));
    if spans.windows(2).all(|pair| pair[0].1 < pair[1].0) {
        let first = spans[0].0;
        for trace in traces {
            trace.head.setup.start_s = Some(elapsed(&[first, trace.time[0]])[1]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(folder: &Path, name: &str, head: &str) -> PathBuf {
        let path = folder.join(name);
        std::fs::write(&path, format!("{head}time_s,force_N\n0,1\n1,2\n")).unwrap();
        path
    }

    fn parsed(path: &Path) -> Trace {
        crate::parse(path, &std::fs::read(path).unwrap()).unwrap()
    }

    fn names(traces: &[Trace]) -> Vec<String> {
        traces.iter().map(Trace::label).collect()
    }

    #[test]
    fn a_folder_is_its_csv_and_parquet_files_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let one = write(folder.path(), "notes.txt", "");
        crate::write(&folder.path().join("c.parquet"), &parsed(&one)).unwrap();
        for name in ["b.csv", "a.CSV", "notes.txt"] {
            write(folder.path(), name, "");
        }
        assert_eq!(names(&read_set(&[folder.path()]).unwrap()), ["a.CSV", "b.csv", "c.parquet"]);
    }

    #[test]
    fn a_set_is_ordered_by_sequence_else_by_start_else_as_given() {
        let folder = tempfile::tempdir().unwrap();
        let a = write(folder.path(), "a.csv", "# [setup]\n# sequence = 2\n# start_s = 0\n");
        let b = write(folder.path(), "b.csv", "# [setup]\n# sequence = 1\n# start_s = 9.5\n");
        let c = write(folder.path(), "c.csv", "# [setup]\n# start_s = 5\n");
        let d = write(folder.path(), "d.csv", "");
        assert_eq!(names(&read_set(&[&a, &b]).unwrap()), ["b.csv", "a.csv"]);
        assert_eq!(names(&read_set(&[&b, &c, &a]).unwrap()), ["a.csv", "c.csv", "b.csv"]);
        assert_eq!(names(&read_set(&[&d, &b]).unwrap()), ["d.csv", "b.csv"]);
    }

    #[test]
    fn one_clock_through_all_traces_says_their_order_and_their_beginnings() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, times: [&str; 2]| {
            let path = folder.path().join(name);
            let rows = format!("time_s,force_N\n{},1\n{},2\n", times[0], times[1]);
            std::fs::write(&path, rows).unwrap();
            path
        };
        let later = write("a.csv", ["1700000060.005", "1700000070.005"]);
        let earlier = write("b.csv", ["1700000000.000", "1700000030.000"]);
        let set = read_set(&[&later, &earlier]).unwrap();
        assert_eq!(names(&set), ["b.csv", "a.csv"]);
        let begins: Vec<_> = set.iter().map(|trace| trace.head.setup.start_s).collect();
        assert_eq!(begins, [Some(0.0), Some(60.005)]);
        // A clock of its own for each.
        let other = write("c.csv", ["1700000020.000", "1700000080.000"]);
        let set = read_set(&[&other, &earlier]).unwrap();
        assert_eq!(names(&set), ["c.csv", "b.csv"]);
        assert!(set.iter().all(|trace| trace.head.setup.start_s.is_none()));
    }

    #[test]
    fn an_empty_folder_a_repeated_file_and_a_shared_place_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(read_set(&[folder.path()]), Err(Error::EmptyFolder { .. })));
        let a = write(folder.path(), "a.csv", "# [setup]\n# sequence = 2\n");
        let b = write(folder.path(), "b.csv", "# [setup]\n# sequence = 2\n");
        let again = folder.path().join(".").join("a.csv");
        assert!(matches!(read_set(&[&a, &again]), Err(Error::SameFile { .. })));
        assert!(matches!(read_set(&[&a, &b]), Err(Error::SameOrder { .. })));
        assert!(matches!(read_set::<&Path>(&[]), Err(Error::EmptySet)));
    }
}
