//! Files of other programs come in with the mapping that `--suggest` proposes for them, as it is.
//!
//! The files are written by libraries that share no code with the readers: `cargo xtask formats` sets them up and runs the tests
//! that need them. Each file is also read cut off at 20 places and with a wrong byte at 40, within 10 s and 500 MB.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use assert_cmd::cargo::cargo_bin;
use palpate::afm::curve::ForceCurve;
use palpate::trace::{self, Mapping, Trace};

/// What every file holds, by the number of the sample.
#[derive(Clone, Copy)]
enum Signal {
    Displacement,
    Force,
}
use Signal::{Displacement, Force};

const SAMPLES: usize = 200;

impl Signal {
    fn at(self, index: usize) -> f64 {
        match self {
            Displacement => (index % 50) as f64 / 10.0,
            Force => (index * index) as f64 / 1000.0,
        }
    }
}

const BOTH: &[(&str, Signal)] = &[("displacement_mm", Displacement), ("force_N", Force)];

/// A file, the table that is taken of several, and the columns that it must give.
type Case = (&'static str, Option<&'static str>, &'static [(&'static str, Signal)]);

const CASES: &[Case] = &[
    ("own.csv.gz", None, BOTH),
    ("own.csv.zst", None, BOTH),
    ("german.txt.gz", None, BOTH),
    ("book.xlsx", Some("Run 1"), BOTH),
    ("book.xlsx", Some("Run 2"), BOTH),
    ("book.ods", None, BOTH),
    ("run.h5", None, BOTH),
    ("records.h5", None, BOTH),
    ("new.mat", None, BOTH),
    ("press.mat", None, BOTH),
    ("plain.mat", None, &[("force_N", Force)]),
    ("robot.mcap", Some("/tip/wrench"), &[("force_N", Force)]),
    ("robot.mcap", Some("/joint_states"), &[("position_slide", Displacement)]),
    ("plain.mcap", None, BOTH),
    ("bag8.db3", Some("/tip/wrench"), &[("force_N", Force)]),
    ("bag9.db3", Some("/tip/array"), &[("data_0", Displacement), ("data_1", Force)]),
    ("run.tdms", None, BOTH),
    ("waveform.tdms", None, &[("displacement_mm", Displacement)]),
    ("run.lvm", None, BOTH),
    ("foreign.parquet", None, BOTH),
    ("rheocompass.csv", None, BOTH),
    ("trios.txt", None, BOTH),
    ("bluehill.csv", None, BOTH),
    ("testxpert.tra", None, BOTH),
    ("bioindenter.txt", None, BOTH),
    ("trapezium.csv", None, BOTH),
    ("chinese.txt", None, BOTH),
];

/// Files of plain text, which have no end to miss.
const TEXTS: &[&str] = &[
    "run.lvm",
    "rheocompass.csv",
    "trios.txt",
    "bluehill.csv",
    "testxpert.tra",
    "bioindenter.txt",
    "trapezium.csv",
    "chinese.txt",
];

/// The folder of the files, made anew by `cargo xtask formats`.
fn files() -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/formats/files");
    assert!(folder.is_dir(), "run `cargo xtask formats`");
    folder
}

/// Imports a file by the mapping that is proposed for it.
fn imported(path: &Path, part: Option<&str>) -> Trace {
    let text = trace::suggest(path, part).unwrap_or_else(|error| panic!("{error}"));
    let mapping = Mapping::parse(Path::new("map.toml"), &text)
        .unwrap_or_else(|error| panic!("{error}\n{text}"));
    let found = trace::import(path, &mapping);
    found.unwrap_or_else(|error| panic!("{error}\n{text}")).trace
}

#[test]
#[ignore = "needs the files of `cargo xtask formats`"]
fn files_of_independent_writers_come_in_without_an_edit() {
    for &(file, part, columns) in CASES {
        let found = imported(&files().join(file), part);
        assert_eq!(found.len(), SAMPLES, "{file}");
        let near = |value: f64, expected: f64| (value - expected).abs() <= 1e-12 * expected.abs();
        for (index, &time) in found.time.iter().enumerate() {
            let expected = index as f64 / 100.0;
            // A time stamp of a workbook has whole microseconds, and one in ms is divided.
            assert!((time - expected).abs() < 1e-9, "{file}, sample {index}: {time} s");
        }
        for &(name, signal) in columns {
            let names: Vec<&str> =
                found.columns.iter().map(|column| column.name.as_str()).collect();
            let values = found.column(name).unwrap_or_else(|| panic!("{file}: {names:?}"));
            for (index, &value) in values.iter().enumerate() {
                let expected = signal.at(index);
                assert!(near(value, expected), "{file}, {name}, sample {index}: {value}");
            }
        }
    }
}

/// Tables that do not say enough: those of arrays without names, and of numbers without units.
const OPEN: &[&str] = &[
    "bag8-tip-array",
    "bag9-tip-array",
    "lerobot-episode-0",
    "lerobot-episode-1",
    "plain",
    "robot-joint_states",
];

#[test]
#[ignore = "needs the files of `cargo xtask formats`"]
fn a_folder_with_a_file_of_each_format_comes_in_by_one_command_and_at_most_one_edit() {
    let folder = tempfile::tempdir().unwrap();
    let call = || {
        let mut command = palpate_tests::palpate();
        let output = command.arg("import").arg(files()).arg("-o").arg(folder.path()).output();
        let output = output.unwrap();
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned(), error)
    };
    let (status, _, error) = call();
    assert_eq!(status, Some(2), "{error}");
    let mut open = Vec::new();
    for entry in std::fs::read_dir(folder.path()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if let Some(name) = name.strip_suffix(".map.toml") {
            open.push(name.to_owned());
            // What is proposed was right: the edit is to say so.
            let text = std::fs::read_to_string(&path).unwrap();
            std::fs::write(&path, text + "\n# looked at\n").unwrap();
        }
    }
    open.sort();
    assert_eq!(open, OPEN, "{error}");
    let (status, said, error) = call();
    assert_eq!(status, Some(0), "{error}");
    assert!(said.starts_with("25 traces in "), "{said}");
}

#[test]
#[ignore = "needs the files of `cargo xtask formats`"]
fn an_episode_is_a_table_with_its_lists_in_columns() {
    let found = imported(&files().join("lerobot.parquet"), Some("episode 1"));
    assert_eq!(found.len(), SAMPLES / 2);
    assert!((found.time[1] - 0.01).abs() < 1e-8, "{}", found.time[1]);
    assert_eq!(found.column("observation_state_1").unwrap()[30], Force.at(SAMPLES / 2 + 30));
    assert_eq!(found.column("action_2").unwrap()[1], f64::from(-Displacement.at(1) as f32));
}

#[test]
#[ignore = "needs the files of `cargo xtask formats`"]
fn a_waveform_is_scaled_and_has_its_clock() {
    let found = imported(&files().join("waveform.tdms"), None);
    let force = found.force().unwrap();
    // 0.001 N for each count, and 5 N.
    assert!((force[30] - 5.9).abs() < 1e-12, "{}", force[30]);
}

#[test]
#[ignore = "needs the files of `cargo xtask formats`"]
fn a_table_with_the_names_of_a_trace_is_one_to_every_command() {
    for file in ["own.csv.gz", "own.csv.zst", "records.h5", "new.mat", "press.mat"] {
        let found =
            trace::read_set(&[files().join(file)]).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(found.len(), 1, "{file}");
        assert_eq!(found[0].len(), SAMPLES, "{file}");
        assert_eq!(found[0].force().unwrap()[30], Force.at(30), "{file}");
    }
    let error = trace::read(&files().join("book.xlsx")).unwrap_err().to_string();
    assert!(error.contains("no table that has a column `time_s` (Run 1, Run 2)"), "{error}");
}

#[test]
#[ignore = "needs the files of `cargo xtask formats`"]
fn a_table_that_is_not_there_is_told_those_that_are() {
    let error = trace::suggest(&files().join("book.xlsx"), Some("Run 3")).unwrap_err().to_string();
    assert!(error.contains("no table `Run 3`; there are Run 1, Run 2"), "{error}");
    let error = trace::suggest(&files().join("book.xlsx"), None).unwrap_err().to_string();
    assert!(error.contains("2 tables: Run 1, Run 2. Say which: `--part NAME`"), "{error}");
}

/// Kilobytes of addresses that a call may take: 500 MB beside the program, its threads and what it maps.
const ADDRESSES_KB: u32 = 500_000 + 400_000;
/// Longest time for a file of a few hundred kilobytes.
const LIMIT: Duration = Duration::from_secs(10);

/// What `palpate import` makes of a file within the limits of memory and time.
fn preview(file: &Path, map: &Path) -> Output {
    within_limits(file, |call| call.arg("import").arg(file).arg("--map").arg(map).arg("--preview"))
}

/// What palpate makes of a file within the limits of memory and time.
fn within_limits(file: &Path, arguments: impl Fn(&mut Command) -> &mut Command) -> Output {
    let limited = format!("ulimit -v {ADDRESSES_KB}; exec \"$@\"");
    let began = Instant::now();
    let mut call = Command::new("sh");
    call.args(["-c", &limited, "sh"]).arg(cargo_bin("palpate-tests"));
    let output = arguments(&mut call).output().unwrap();
    assert!(began.elapsed() < LIMIT, "{}: {:?}", file.display(), began.elapsed());
    let status = output.status.code();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(matches!(status, Some(0 | 2)), "{}: {status:?} {said}", file.display());
    assert!(!said.contains("panicked"), "{}: {said}", file.display());
    output
}

#[test]
#[cfg(target_os = "linux")]
#[ignore = "needs the files of `cargo xtask formats`"]
fn cut_and_damaged_files_are_refused_or_read_within_bounds() {
    use rayon::prelude::*;
    CASES.par_iter().for_each(|&(file, part, _)| {
        let folder = tempfile::tempdir().unwrap();
        let (path, map) = (folder.path().join(file), folder.path().join("map.toml"));
        let whole = std::fs::read(files().join(file)).unwrap();
        std::fs::write(&path, &whole).unwrap();
        std::fs::write(&map, trace::suggest(&path, part).unwrap()).unwrap();
        let expected = preview(&path, &map);
        assert!(expected.status.success(), "{file}");
        for place in 1..=20 {
            std::fs::write(&path, &whole[..whole.len() * place / 21]).unwrap();
            let found = preview(&path, &map);
            // What reads at all reads whole: nothing is left out in silence.
            let whole_or_text = found.stdout == expected.stdout || TEXTS.contains(&file);
            assert!(!found.status.success() || whole_or_text, "{file} {place}");
        }
        for place in 0..40 {
            std::fs::write(&path, damaged(&whole, place)).unwrap();
            preview(&path, &map);
        }
    });
}

/// A file with a wrong byte at one of 40 places: spread over it, the beginning and the end more closely.
fn damaged(whole: &[u8], place: usize) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    let at = match place {
        0..10 => place * 7,
        10..20 => whole.len() - 1 - (place - 10) * 5,
        _ => whole.len() * (place - 20) / 20 + place,
    };
    bytes[at.min(whole.len() - 1)] ^= 0x55;
    bytes
}

/// Force curves in the layouts of their microscopes, in a folder, and what independent libraries read of them.
fn force_curves(folder: &Path) -> serde_json::Value {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let output = Command::new(top.join("target/formats/python/bin/python"))
        .arg(top.join("tests/formats/force_curves.py"))
        .arg(folder)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
#[ignore = "needs the libraries of `cargo xtask formats`"]
fn force_curves_of_microscopes_are_what_other_libraries_read() {
    let folder = tempfile::tempdir().unwrap();
    for (file, curves) in force_curves(folder.path()).as_object().unwrap() {
        let found = ForceCurve::read_all(&folder.path().join(file)).unwrap();
        let curves = curves.as_array().unwrap();
        assert_eq!(found.len(), curves.len(), "{file}");
        for (found, expected) in found.iter().zip(curves) {
            assert_eq!(found.spring_n_per_m, expected["spring"].as_f64(), "{file}");
            assert!(found.time_s.is_sorted_by(|a, b| a < b), "{file}");
            let ways = [found.segments.approach.clone(), found.segments.retract.clone().unwrap()];
            // One of the libraries takes the last force off all, and leaves out what it takes for a marker.
            let last = if file.ends_with(".spm") { *found.force_n.last().unwrap() } else { 0.0 };
            for (range, stretch) in ways.into_iter().zip(expected["stretches"].as_array().unwrap())
            {
                let same = |name: &str, mine: Vec<f64>| {
                    let theirs: Vec<f64> = stretch[name]
                        .as_array()
                        .unwrap()
                        .iter()
                        .map(|n| n.as_f64().unwrap())
                        .collect();
                    assert!(theirs.len() + 2 > mine.len(), "{file}, {name}: {}", theirs.len());
                    let size = theirs.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
                    let pairs = mine.iter().rev().zip(theirs.iter().rev());
                    let off = pairs.fold(0.0_f64, |off, (a, b)| off.max((a - b).abs()));
                    assert!(off < 1e-12 * size, "{file}, {name}: {off} of {size}");
                };
                same("way_m", found.piezo_m[range.clone()].to_vec());
                same("force_N", found.force_n[range].iter().map(|force| force - last).collect());
            }
        }
    }
}

#[test]
#[cfg(target_os = "linux")]
#[ignore = "needs the libraries of `cargo xtask formats`"]
fn cut_and_damaged_force_curves_are_refused_or_read_within_bounds() {
    use rayon::prelude::*;
    let folder = tempfile::tempdir().unwrap();
    let files = force_curves(folder.path());
    files.as_object().unwrap().keys().collect::<Vec<_>>().par_iter().for_each(|file| {
        let copy = tempfile::tempdir().unwrap();
        let path = copy.path().join(file);
        let whole = std::fs::read(folder.path().join(file)).unwrap();
        let analysed = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            within_limits(&path, |call| {
                call.arg("afm").arg(&path).args(["--tip-radius-nm", "2500"])
            })
        };
        assert!(analysed(&whole).status.success(), "{file}");
        for place in 1..=20 {
            let found = analysed(&whole[..whole.len() * place / 21]);
            assert!(!found.status.success(), "{file}, cut {place}");
        }
        for place in 0..40 {
            analysed(&damaged(&whole, place));
        }
    });
}

/// A file that `gzip` would write, by a library of the tests.
fn gzipped(text: &str) -> Vec<u8> {
    let mut writer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    writer.write_all(text.as_bytes()).unwrap();
    writer.finish().unwrap()
}

#[test]
fn a_packed_trace_is_a_trace_and_a_packed_export_comes_in_by_its_mapping() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.csv.gz");
    std::fs::write(&path, gzipped("# name = \"a\"\ntime_s,force_N\n0,1\n0.5,2\n")).unwrap();
    let found = trace::read_set(&[folder.path()]).unwrap();
    assert_eq!(found[0].head.name.as_deref(), Some("a"));
    assert_eq!(found[0].force(), Some(&[1.0, 2.0][..]));
    let text: String = (0..9).map(|i| format!("{i},5;{i}0\n")).collect();
    std::fs::write(&path, gzipped(&format!("Time;Force (mN)\n{text}"))).unwrap();
    assert_eq!(imported(&path, None).force().unwrap()[3], 0.03);
}

/// Converts a bundled press to a file of that name.
fn exported(folder: &Path, name: &str) -> PathBuf {
    let path = folder.join(name);
    let press = palpate_tests::bundled("press.csv");
    let output = palpate_tests::palpate().arg("convert").arg(&press).arg("-o").arg(&path).output();
    let output = output.unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    path
}

#[test]
fn what_is_written_for_other_programs_comes_back_to_the_last_bit() {
    let folder = tempfile::tempdir().unwrap();
    let press = trace::read(&palpate_tests::bundled("press.csv")).unwrap();
    for name in ["press.mat", "press.mcap"] {
        let back = trace::read(&exported(folder.path(), name)).unwrap();
        assert_eq!(back.time, press.time, "{name}");
        for column in &press.columns {
            assert_eq!(
                back.column(&column.name),
                Some(&column.values[..]),
                "{name}, {}",
                column.name
            );
        }
    }
    std::fs::write(folder.path().join("odd.csv"), "time_s,Kraft (N)\n0,1\n1,2\n").unwrap();
    let odd = ["convert", "odd.csv", "-o", "odd.mat"];
    let output = palpate_tests::palpate().current_dir(folder.path()).args(odd).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("odd.mat: MATLAB 7.3, Kraft (N): MATLAB allows no such name"), "{said}");
    assert!(!folder.path().join("odd.mat").exists());
}

#[test]
#[ignore = "needs the libraries of `cargo xtask formats`"]
fn what_is_written_for_other_programs_is_read_by_their_libraries() {
    let folder = tempfile::tempdir().unwrap();
    let press = trace::read(&palpate_tests::bundled("press.csv")).unwrap();
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let output = Command::new(top.join("target/formats/python/bin/python"))
        .arg(top.join("tests/formats/read.py"))
        .args(["press.mat", "press.mcap"].map(|name| exported(folder.path(), name)))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    for file in found.as_array().unwrap() {
        let head = file["head"].as_str().unwrap();
        assert!(head.contains("shape = \"block\""), "{head}");
        let numbers = |name: &str| -> Vec<f64> {
            let values = file["columns"][name].as_array().unwrap_or_else(|| panic!("{name}"));
            values.iter().map(|value| value.as_f64().unwrap()).collect()
        };
        assert_eq!(numbers("time_s"), press.time);
        for column in &press.columns {
            assert_eq!(numbers(&column.name), column.values, "{}", column.name);
        }
    }
}

#[test]
fn what_nothing_reads_is_refused_by_its_name_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes, words) in [
        ("a.xls", &b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1"[..], "Save it as .xlsx"),
        ("a.ibw", b"\0\x05\0\0", "a file of Igor Pro, which"),
        ("a.npy", b"\x93NUMPY\x01\0", "to_csv"),
        ("a.tri", b"\0\x01\x02", "Export it from TRIOS"),
        ("a.mat", b"\0\0\0\0\x01\0\0\0", "save run.mat -v7"),
        ("a.csv", b"%PDF-1.7", "a PDF document"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        for error in [
            trace::read(&path).unwrap_err().to_string(),
            trace::suggest(&path, None).unwrap_err().to_string(),
        ] {
            assert!(error.contains(name) && error.contains(words), "{error}");
        }
    }
}
