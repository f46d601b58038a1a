//! Writing a trace: reading it back gives the same trace, to the last bit.

use std::io::{self, Write};
use std::path::Path;

use super::error::Error;
use super::{PARQUET, TIME, Trace, has_extension, head, names, parquet};
use crate::files::write_whole;

/// Writes a trace whole or not at all, as Parquet if the file's name ends in `.parquet`, else as CSV. The head says the
/// version even if `trace.head` does not.
///
/// # Errors
/// [`Error::Write`] where the file system refuses, or where reading would: a number that is not
/// finite, time that does not increase, fewer than two samples, a column name no trace may have.
pub fn write(path: &Path, trace: &Trace) -> Result<(), Error> {
    write_whole(path, |file| match has_extension(path, PARQUET) {
        true => file.write_all(&parquet::to_bytes(trace)?),
        false => write_to(file, trace),
    })
    .map_err(|source| Error::Write { path: path.into(), source })
}

/// As [`write()`], to anything that takes bytes; nothing is written if the trace is not one.
///
/// # Errors
/// As [`write()`], as an [`io::Error`].
pub fn write_to(mut out: impl Write, trace: &Trace) -> io::Result<()> {
    checked(trace)?;
    for line in head::to_toml(&trace.head).map_err(io::Error::other)?.lines() {
        writeln!(out, "{}", format!("# {line}").trim_end_matches(' '))?;
    }
    let header = std::iter::once(TIME).chain(trace.columns.iter().map(|column| &column.name[..]));
    let mut writer = csv::Writer::from_writer(&mut out);
    writer.write_record(header)?;
    writer.flush()?;
    drop(writer);
    for (row, time) in trace.time.iter().enumerate() {
        write_number(&mut out, *time)?;
        for column in &trace.columns {
            out.write_all(b",")?;
            write_number(&mut out, column.values[row])?;
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

/// The shortest text that reads back as the same number.
#[must_use]
pub fn shortest(value: f64) -> String {
    let mut text = Vec::new();
    // Writing to memory does not fail, and what is written is ASCII.
    let _ = write_number(&mut text, value);
    String::from_utf8_lossy(&text).into_owned()
}

/// Writes [`shortest`] without a string in between.
fn write_number(out: &mut impl Write, value: f64) -> io::Result<()> {
    let size = value.abs();
    if value == 0.0 || (1e-5..1e16).contains(&size) {
        write!(out, "{value}")
    } else {
        write!(out, "{value:e}")
    }
}

/// [`check`] as an error of writing.
pub(super) fn checked(trace: &Trace) -> io::Result<()> {
    check(trace).map_err(|message| io::Error::new(io::ErrorKind::InvalidData, message))
}

/// What a reader would refuse, in words.
pub(super) fn check(trace: &Trace) -> Result<(), String> {
    let mut header = vec![TIME];
    header.extend(trace.columns.iter().map(|column| &column.name[..]));
    names::check(&header).map_err(|fault| match fault {
        names::Fault::Unnamed(index) => format!("column {} has no printable name", index + 1),
        names::Fault::Duplicate { index, .. } => format!("two columns are named {}", header[index]),
        names::Fault::Unit { index, expected } => {
            format!("column {} must be {expected}", header[index])
        }
    })?;
    trace.head.check()?;
    if trace.len() < 2 {
        return Err(format!("{} sample(s), a trace has at least two", trace.len()));
    }
    let times = (TIME, &trace.time[..]);
    let all = trace.columns.iter().map(|column| (&column.name[..], &column.values[..]));
    for (name, values) in std::iter::once(times).chain(all) {
        if values.len() != trace.len() {
            return Err(format!("column {name} is not as long as the trace"));
        }
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            return Err(format!("{name} is not finite in sample {}", at + 1));
        }
    }
    if let Some(at) = trace.time.windows(2).position(|pair| pair[0] >= pair[1]) {
        return Err(format!("time does not increase after sample {}", at + 1));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{Column, Control, Head, parse};

    fn written(trace: &Trace) -> String {
        let mut out = Vec::new();
        write_to(&mut out, trace).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn a_written_trace_looks_as_a_person_would_write_it() {
        let mut trace = Trace { time: vec![0.0, 0.005], ..Trace::default() };
        trace.head.name = Some("take 3".into());
        trace.head.control = Some(Control::Displacement);
        trace.head.specimen.height_mm = Some(30.0);
        trace.set_column("displacement_mm", vec![0.1, 1e-9]);
        assert_eq!(
            written(&trace),
            "# palpate-trace = 1\n# name = \"take 3\"\n# control = \"displacement\"\n#\n# [specimen]\n\
             # height_mm = 30.0\ntime_s,displacement_mm\n0,0.1\n0.005,1e-9\n"
        );
    }

    #[test]
    fn what_no_reader_would_take_is_not_written_and_an_earlier_file_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        std::fs::write(&path, "earlier").unwrap();
        let mut trace = Trace { time: vec![0.0, 1.0], ..Trace::default() };
        trace.set_column("force_N", vec![0.0, f64::NAN]);
        let error = write(&path, &trace).unwrap_err().to_string();
        assert!(error.contains("force_N is not finite in sample 2"), "{error}");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "earlier");
    }

    prop_compose! {
        fn any_head()(
            name in proptest::option::of(any::<String>()),
            material in proptest::option::of(any::<String>()),
            height in proptest::option::of(1e-3..1e3_f64),
            sequence in proptest::option::of(any::<i64>()),
            keys in proptest::collection::btree_map("[a-z \"#=é.]{1,8}", any::<String>(), 0..3),
            nested in proptest::collection::btree_map("[a-z]{9,12}", -1e300..1e300_f64, 0..3),
        ) -> Head {
            let mut head = Head { version: Some(1), name, ..Head::default() };
            head.specimen.material = material;
            head.specimen.height_mm = height;
            head.setup.sequence = sequence;
            let known = ["name", "control", "specimen", "setup"];
            head.other = keys.into_iter().filter(|(key, _)| !known.contains(&&key[..]))
                .map(|(key, text)| (key, toml::Value::String(text))).collect();
            head.setup.other = nested.into_iter().filter(|(key, _)| key != "force_resolution_N")
                .map(|(key, number)| (key, toml::Value::Float(number))).collect();
            head
        }
    }

    prop_compose! {
        fn any_trace()(
            head in any_head(),
            steps in proptest::collection::vec((1e-9..1e3_f64, any::<f64>(), any::<f64>()), 2..20),
            name in "[a-zA-Z \",;#\u{e9}]{1,10}x",
        ) -> Trace {
            let finite = |value: f64| if value.is_finite() { value } else { 0.0 };
            let mut now = -5.0;
            let time = steps.iter().map(|step| { now += step.0; now }).collect();
            let force = steps.iter().map(|step| finite(step.1)).collect();
            let other = steps.iter().map(|step| finite(step.2)).collect();
            let columns = vec![
                Column { name: "force_N".into(), values: force },
                Column { name: name.trim().into(), values: other },
            ];
            Trace { path: None, head, time, columns }
        }
    }

    proptest! {
        #[test]
        fn reading_what_was_written_gives_the_same_trace(trace in any_trace()) {
            let text = written(&trace);
            let mut back = parse(Path::new("t.csv"), text.as_bytes()).map_err(|e| TestCaseError::fail(format!("{e}\n{text}")))?;
            back.path = None;
            prop_assert_eq!(back, trace);
        }
    }
}
