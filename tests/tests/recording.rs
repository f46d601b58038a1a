//! Recordings of a device: what a kill, a full disk or damage leaves of them, and what they are converted to.

use std::io;
use std::path::{Path, PathBuf};

use palpate::decomposition::{decompose, default_relaxation};
use palpate::recording::{Entry, Gap, Note, Opened, Reader, Writer};
use palpate::trace::recordable::{settings_of, write_recording};
use palpate::trace::recorded::{Options, to_traces};
use palpate::trace::{GAUGES, Trace, read};
use palpate_tests::{bundled, palpate, workspace};
use serde_json::Value;

/// So many samples of the bundled press, 200 a second.
fn press_of(samples: usize) -> Trace {
    let mut trace = read(&bundled("press.csv")).unwrap();
    trace.time.truncate(samples);
    trace.columns.iter_mut().for_each(|column| column.values.truncate(samples));
    trace
}

/// Its first three seconds.
fn press() -> Trace {
    press_of(600)
}

/// What a device would have recorded of a trace.
fn recording_of(trace: &Trace) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_recording(trace, &settings_of(trace), &mut bytes).unwrap();
    bytes
}

fn recording() -> Vec<u8> {
    recording_of(&press())
}

/// Every entry as text, and whether the file ends within a frame.
fn entries(bytes: &[u8]) -> (Vec<String>, bool) {
    let mut reader = Reader::new(bytes).unwrap();
    let mut seen = Vec::new();
    while let Some(entry) = reader.next_entry().unwrap() {
        seen.push(format!("{entry:?}"));
    }
    (seen, reader.truncated())
}

/// A folder with this recording as `take.palpate` in it.
fn folder_with(bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("take.palpate");
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

/// Runs the command in a folder: exit status, standard output, standard error.
fn run(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = palpate().current_dir(folder).args(arguments).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

/// Compares with an expected text in tests/golden/.
fn golden(name: &str, text: &str) {
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path(workspace().join("tests/golden"));
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!(name, text));
}

#[test]
fn a_recording_cut_at_any_byte_reads_up_to_its_last_whole_frame() {
    let bytes = recording_of(&press_of(210));
    let (all, _) = entries(&bytes);
    assert!(all.len() > 15, "{} entries", all.len());
    // Where each entry ends.
    let mut ends = Vec::new();
    let mut reader = Reader::new(&bytes[..]).unwrap();
    while reader.next_entry().unwrap().is_some() {
        let from = usize::try_from(reader.offset()).unwrap();
        ends.push(from + bytes[from..].iter().position(|byte| *byte == 0).unwrap() + 1);
    }
    for cut in 0..=bytes.len() {
        let (seen, truncated) = entries(&bytes[..cut]);
        assert_eq!(seen.len(), ends.partition_point(|end| *end <= cut), "cut at {cut}");
        assert!(all.starts_with(&seen), "cut at {cut}");
        assert_eq!(truncated, cut == 0 || bytes[cut - 1] != 0, "cut at {cut}");
    }
}

#[test]
fn the_rows_of_a_cut_recording_are_those_of_the_whole_one_but_for_regions_said_to_be_provisional() {
    let bytes = recording_of(&press_of(900));
    let traces = |bytes: &[u8]| {
        let reader = Reader::new(bytes).unwrap();
        to_traces(Path::new("take.palpate"), reader, &Options::default())
    };
    let whole = traces(&bytes).unwrap().traces.remove(0);
    // What ends within a frame reads up to its last whole one: cuts between frames are all there are.
    let cuts = (0..bytes.len()).filter(|cut| bytes[*cut] == 0).map(|end| end + 1);
    let (mut seen, mut corrected) = (0, 0);
    for cut in cuts {
        let Ok(mut found) = traces(&bytes[..cut]) else { continue };
        let part = found.traces.remove(0);
        let rows = part.len();
        let provisional = part.head.other["recording"]["region_provisional_rows"].as_integer();
        let firm = rows - usize::try_from(provisional.unwrap()).unwrap();
        assert_eq!(part.time, whole.time[..rows], "cut at {cut}");
        for (column, full) in part.columns.iter().zip(&whole.columns) {
            let known = if column.name.ends_with("_region") { firm } else { rows };
            assert_eq!(column.name, full.name);
            assert_eq!(
                column.values[..known],
                full.values[..known],
                "{}, cut at {cut}",
                column.name
            );
            corrected += usize::from(column.values != full.values[..rows]);
        }
        seen += 1;
    }
    // Enough cuts, and some in which a boundary was yet to be found.
    assert!(seen > 40 && corrected > 0, "{seen} cuts, {corrected} corrected");
}

/// Takes so many bytes and no more.
struct Disk<'a> {
    written: &'a mut Vec<u8>,
    room: usize,
}

impl io::Write for Disk<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = bytes.len().min(self.room - self.written.len());
        self.written.extend(&bytes[..taken]);
        if taken == 0 { Err(io::ErrorKind::StorageFull.into()) } else { Ok(taken) }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_full_disk_ends_a_recording_with_an_error_and_what_is_on_it_reads() {
    let bytes = recording();
    let (all, _) = entries(&bytes);
    for room in (0..bytes.len()).step_by(997) {
        let mut written = Vec::new();
        let disk = Disk { written: &mut written, room };
        let trace = press();
        let error = write_recording(&trace, &settings_of(&trace), disk).unwrap_err().to_string();
        assert!(error.contains("no storage space"), "{error}");
        assert_eq!(written.len(), room);
        let (seen, _) = entries(&written);
        assert!(all.starts_with(&seen) && (room < 300 || seen.len() > 1));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_is_full_from_the_beginning_is_an_error_at_once() {
    let full = Path::new("/dev/full");
    let error = Writer::create(full, true, &Opened::now("tty")).unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::StorageFull);
}

#[test]
fn a_converted_recording_holds_what_the_host_computes_of_the_same_trace() {
    let (folder, _) = folder_with(&recording());
    let (status, out, said) = run(folder.path(), &["convert", "take.palpate", "-o", "take.csv"]);
    assert_eq!((status, out.as_str()), (0, ""), "{said}");
    insta::assert_snapshot!(said, @"take.csv: 600 samples over 2.995 s");
    let (given, found) = (press(), read(&folder.path().join("take.csv")).unwrap());
    // Without the displacement, as on the device, a trace is not taken to begin pressed.
    let mut gauges = given.clone();
    gauges.columns.retain(|column| GAUGES.contains(&column.name.as_str()));
    for gauge in 1..=4 {
        let name = format!("gauge{gauge}_ustrain");
        let expected = decompose(&gauges, &name, &default_relaxation(), || {}).unwrap();
        let column = |part: &str| found.column(&format!("gauge{gauge}_{part}ustrain")).unwrap();
        assert_eq!(column(""), expected.input);
        assert_eq!(column("fa_"), expected.fa);
        assert_eq!(column("sa_"), expected.sa);
        assert_eq!(column("elastic_"), expected.elastic);
        assert_eq!(column("equilibrium_"), expected.equilibrium);
    }
}

#[test]
fn the_head_and_the_columns_of_a_converted_recording_are_these() {
    let (folder, _) = folder_with(&recording());
    run(folder.path(), &["convert", "take.palpate", "-o", "take.csv"]);
    let text = std::fs::read_to_string(folder.path().join("take.csv")).unwrap();
    let head: Vec<&str> = text.lines().take_while(|line| line.starts_with('#')).collect();
    golden("converted-head", &head.join("\n"));
    let columns = text.lines().nth(head.len()).unwrap();
    golden("converted-columns", &columns.replace(',', "\n"));
}

#[test]
fn csv_to_parquet_to_csv_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["press.csv", "table-3.1-row-01.csv"] {
        let path = bundled(name);
        let given = read(&path).unwrap();
        let parquet = folder.path().join(name).with_extension("parquet");
        let csv = folder.path().join(name);
        for (from, to) in [(&path, &parquet), (&parquet, &csv)] {
            let arguments = ["convert", from.to_str().unwrap(), "-o", to.to_str().unwrap()];
            assert_eq!(run(folder.path(), &arguments).0, 0);
        }
        for back in [read(&parquet).unwrap(), read(&csv).unwrap()] {
            assert_eq!((&back.time, &back.columns), (&given.time, &given.columns));
            assert_eq!(back.head, given.head);
        }
    }
}

#[test]
fn a_trace_becomes_a_recording_that_every_command_takes() {
    let folder = tempfile::tempdir().unwrap();
    let press = bundled("press.csv");
    let arguments = ["convert", press.to_str().unwrap(), "-o", "press.palpate"];
    assert_eq!(run(folder.path(), &arguments).0, 0);
    let (status, out, said) = run(folder.path(), &["decompose", "press.palpate", "-o", "split"]);
    assert_eq!(status, 0, "{said}");
    assert!(out.contains("CD") && out.contains("relaxation"), "{out}");
    assert!(read(&folder.path().join("split/press.csv")).is_ok());
    let (status, _, said) = run(folder.path(), &["plot", "press.palpate", "-o", "press.html"]);
    assert_eq!(status, 0, "{said}");
}

#[test]
fn several_stretches_become_numbered_files() {
    let mut bytes = Vec::new();
    let mut writer = Writer::new(&mut bytes, &Opened::timeless("tty")).unwrap();
    // Twice the same stream, with a lost link between.
    let recording = recording();
    for _ in 0..2 {
        for frame in device_frames(&recording) {
            writer.frame(0, frame).unwrap();
        }
        writer.note(0, &Note::Gap(Gap::LinkLost)).unwrap();
    }
    drop(writer);
    let (folder, _) = folder_with(&bytes);
    let arguments = ["convert", "take.palpate", "-o", "out.parquet", "--json"];
    let (status, out, said) = run(folder.path(), &arguments);
    assert_eq!(status, 0, "{said}");
    golden("converted-json", &out);
    insta::assert_snapshot!(said, @"! the recording was not ended in order; it is read up to its last whole frame");
    for name in ["out-1.parquet", "out-2.parquet"] {
        assert_eq!(read(&folder.path().join(name)).unwrap().len(), 600);
    }
}

/// The frames of the device in a recording, as bytes without their zero byte.
fn device_frames(bytes: &[u8]) -> Vec<&[u8]> {
    let mut reader = Reader::new(bytes).unwrap();
    let mut frames = Vec::new();
    while let Some(entry) = reader.next_entry().unwrap() {
        if let Entry::Frame { .. } = entry {
            let from = usize::try_from(reader.offset()).unwrap();
            frames.push(bytes[from..].split(|byte| *byte == 0).next().unwrap());
        }
    }
    frames
}

#[test]
fn an_existing_file_is_written_over_only_with_force_and_the_input_never() {
    let (folder, path) = folder_with(&recording());
    std::fs::write(folder.path().join("take.csv"), "precious").unwrap();
    let call = |arguments: &[&str]| run(folder.path(), arguments);
    let (status, _, said) = call(&["convert", "take.palpate", "-o", "take.csv"]);
    assert_eq!(status, 2);
    insta::assert_snapshot!(said, @"error: take.csv: exists already. Choose another name, or write over it with --force.");
    assert_eq!(call(&["convert", "take.palpate", "-o", "take.csv", "--force"]).0, 0);
    let before = std::fs::read(&path).unwrap();
    let (status, _, said) = call(&["convert", "take.palpate", "-o", "take.palpate", "--force"]);
    assert_eq!(status, 2);
    insta::assert_snapshot!(said, @"error: take.palpate: is read by this call. Choose another name for the result.");
    assert_eq!(std::fs::read(&path).unwrap(), before);
}

/// A recording with a wrong bit in the middle, and where the frame begins that has it.
fn damaged() -> (Vec<u8>, usize) {
    let mut bytes = recording();
    let middle = bytes.len() / 2;
    let offset = bytes[..middle].iter().rposition(|byte| *byte == 0).unwrap() + 1;
    bytes[middle] ^= if bytes[middle] == 1 { 2 } else { 1 };
    (bytes, offset)
}

#[test]
fn what_cannot_be_converted_is_refused_in_one_line() {
    let (damaged, offset) = damaged();
    let (folder, _) = folder_with(&damaged);
    let at = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    at("newer.palpate", b"palpate-recording 7\n\0");
    at("other.palpate", b"time_s,force_N\n0,1\n1,2\n");
    at("empty.palpate", b"");
    at("press.csv", b"time_s,force_N\n0,1\n1,2\n");
    at("text.parquet", b"time_s,force_N\n0,1\n1,2\n");
    let mut opened = Opened::timeless("tty");
    (opened.schema, opened.version) = (1, "0.0.9");
    let mut foreign = Vec::new();
    drop(Writer::new(&mut foreign, &opened).unwrap());
    at("foreign.palpate", &foreign);
    let refused = |arguments: &[&str]| {
        let (status, out, said) = run(folder.path(), arguments);
        assert_eq!((status, out.as_str()), (2, ""), "{said}");
        said
    };
    let mut all = String::new();
    for input in ["take", "newer", "other", "empty", "foreign"] {
        all += &refused(&["convert", &format!("{input}.palpate"), "-o", "out.csv"]);
    }
    all += &refused(&["convert", "text.parquet", "-o", "out.csv"]);
    all += &refused(&["convert", "press.csv", "-o", "out.palpate"]);
    all += &refused(&["convert", "press.csv", "-o", "out.xlsx"]);
    let schema = format!("{:016x}", shared::wire::SCHEMA);
    let all = all.replace(&schema, "OURS").replace(&format!("byte {offset}"), "byte N");
    golden("not-converted", &all);
    assert!(!folder.path().join("out.csv").exists());
}

#[test]
fn damaged_frames_are_left_out_on_demand_and_counted() {
    let (damaged, _) = damaged();
    let (folder, _) = folder_with(&damaged);
    let arguments = ["convert", "take.palpate", "-o", "out.csv", "--skip-damaged", "--json"];
    let (status, out, said) = run(folder.path(), &arguments);
    assert_eq!(status, 0, "{said}");
    let answer: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(answer["damaged_frames"], 1);
    let lost = answer["rows_lost"].as_u64().unwrap();
    assert!((1..=16).contains(&lost), "{lost}");
    assert_eq!(answer["written"][0]["samples"], 600 - lost);
}

/// Whatever releases come: measurements outlive them.
#[test]
fn a_recording_of_release_0_1_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let (from, to) = (
        workspace().join("tests/golden/release-0.1/recording.palpate"),
        folder.path().join("r.csv"),
    );
    palpate().args(["convert", "-o"]).arg(&to).arg(&from).assert().success();
    let trace = read(&to).unwrap();
    assert_eq!(trace.time.len(), 1_977);
    let column = |name: &str| trace.column(name).unwrap_or_else(|| panic!("no column {name}"));
    assert_eq!(column("gauge1_ustrain")[..3], [603.648_437_5, 603.503_906_25, 603.593_75]);
    assert_eq!(column("gauge1_fa_ustrain")[1], -0.035_156_25);
    assert_eq!(column("gauge1_counts")[..3], [337_585.0, 337_503.0, 337_555.0]);
}
