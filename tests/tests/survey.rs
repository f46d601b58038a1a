//! Surveys: many groups, the numbers of the single commands, and nothing lost or done twice where a process is killed.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use palpate::survey::results::{About, about, read_rows};
use palpate::survey::row::{Asked, Row, Said, Status, Worked};
use palpate::trace::{DISPLACEMENT, FORCE, TIME, Trace, read};
use palpate_tests::{answer, bundled, palpate, workspace};
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int32Type};
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use serde_json::{Value, json};

/// Exit status, standard output and standard error of a call in a folder.
fn call(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = palpate().current_dir(folder).args(arguments).output().expect("palpate runs");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().expect("an exit status"), text(&output.stdout), text(&output.stderr))
}

fn rows(results: &Path) -> (About, Vec<(Row, Worked)>) {
    let about = about(results).expect("a manifest");
    let mut rows = Vec::new();
    read_rows(results, &about, |row, worked| rows.push((row, worked))).expect("whole parts");
    (about, rows)
}

/// A folder with bundled traces, each in a folder of its own by number: `lab/finger=1/…`.
fn lab(names: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (k, name) in names.iter().enumerate() {
        let own = folder.path().join(format!("lab/finger={}", k + 1));
        fs::create_dir_all(&own).unwrap();
        fs::copy(bundled(name), own.join(name)).unwrap();
    }
    folder
}

const FEW: [&str; 3] = ["press.csv", "table-3.1-row-01.csv", "table-3.1-row-02.csv"];

/// A command over each trace and over the survey of all, row by row.
fn same_as_single(asked: Asked, command: &[&str], options: &[&str]) {
    let lab = lab(&FEW);
    let folder = lab.path();
    let model = ["fit", "fung", "lab/finger=1/press.csv", "-o", "model.toml"];
    assert_eq!(call(folder, &model).0, 0);
    let survey = [&["survey"], command, &["lab", "--by", "finger", "-o", "out"], options].concat();
    let (status, _, error) = call(folder, &survey);
    assert_eq!(status, 0, "{error}");
    let (about, rows) = rows(&folder.join("out"));
    assert!(about.finished && about.asked == asked);
    assert_eq!(rows.len(), FEW.len());
    for (k, (row, _)) in rows.iter().enumerate() {
        let path = format!("lab/finger={}/{}", k + 1, FEW[k]);
        let single = [command, &[&path[..]], options, &["--json"]].concat();
        let expected = Said::of(asked, &answer(folder, &single));
        assert_eq!(row.status, Status::Done, "{:?}", row.reason);
        assert_eq!(row.key, [Some((k + 1).to_string())]);
        assert!(!expected.estimates.is_empty() || asked == Asked::Diagnose, "{expected:?}");
        assert_eq!(row.said, expected, "{path}");
        assert_eq!(row.samples, read(&folder.join(&path)).unwrap().len() as u64);
    }
}

#[test]
fn a_survey_of_fits_has_the_numbers_of_the_single_fits() {
    same_as_single(Asked::Fit, &["fit", "fung"], &["--terms", "1"]);
}

#[test]
fn a_survey_of_comparisons_has_the_numbers_of_the_single_comparisons() {
    same_as_single(Asked::Compare, &["compare", "model.toml"], &[]);
}

#[test]
fn a_survey_of_diagnoses_has_the_numbers_of_the_single_diagnoses() {
    same_as_single(Asked::Diagnose, &["diagnose", "--model", "model.toml"], &[]);
}

#[test]
fn a_survey_of_regions_has_the_numbers_of_the_single_command() {
    same_as_single(Asked::Segment, &["segment"], &[]);
}

#[test]
fn a_survey_of_holds_has_the_numbers_of_the_single_command() {
    same_as_single(Asked::Relaxation, &["relaxation"], &["--terms", "1"]);
}

#[test]
fn a_survey_of_decompositions_has_the_numbers_of_the_single_command() {
    same_as_single(Asked::Decompose, &["decompose"], &["--signal", "force_N"]);
}

/// The files of what was found, with their bytes.
fn found(results: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let files = fs::read_dir(results.join("groups")).unwrap();
    let read = |file: PathBuf| (file.file_name().unwrap().into(), fs::read(&file).unwrap());
    files.map(|file| read(file.unwrap().path())).collect()
}

/// A short trace many times over, the force a little larger each time.
fn many(folder: &Path, count: usize) {
    let trace = read(&bundled("table-3.1-row-01.csv")).unwrap();
    fs::create_dir(folder.join("lab")).unwrap();
    for k in 0..count {
        let mut trace = trace.clone();
        let force = trace.force().unwrap().iter().map(|f| f * (1.0 + 0.001 * k as f64)).collect();
        trace.set_column(FORCE, force);
        palpate::trace::write(&folder.join(format!("lab/f{k:03}-a.csv")), &trace).unwrap();
    }
}

const FIT: [&str; 10] = [
    "survey",
    "fit",
    "fung",
    "lab",
    "--by",
    "finger",
    "--names",
    "f{finger}-*.csv",
    "--terms",
    "1",
];

#[test]
fn a_survey_that_is_killed_goes_on_with_what_is_missing_and_its_bytes_are_those_of_one_that_was_not()
 {
    let folder = tempfile::tempdir().unwrap();
    many(folder.path(), 120);
    let whole = [&FIT[..], &["-o", "whole", "--jobs", "1"]].concat();
    let (status, _, error) = call(folder.path(), &whole);
    assert_eq!(status, 0, "{error}");
    // Killed in the middle.
    let broken = [&FIT[..], &["-o", "broken", "--jobs", "3"]].concat();
    let mut process = Command::new(palpate().get_program())
        .current_dir(folder.path())
        .args(&broken)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let journal = folder.path().join("broken/unfinished/part-00000.jsonl");
    let lines = || fs::read_to_string(&journal).map_or(0, |text| text.matches('\n').count());
    let begun = Instant::now();
    while lines() < 10 {
        assert!(begun.elapsed() < Duration::from_secs(60), "nothing is done");
        assert!(process.try_wait().unwrap().is_none(), "it ended before it could be killed");
        std::thread::sleep(Duration::from_micros(200));
    }
    process.kill().unwrap();
    process.wait().unwrap();
    let kept: Vec<(Row, Worked)> = fs::read_to_string(&journal)
        .unwrap()
        .split_inclusive('\n')
        .filter(|line| line.ends_with('\n'))
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert!((10..120).contains(&kept.len()), "{} rows", kept.len());
    assert!(!about(&folder.path().join("broken")).unwrap().finished);
    let (status, _, error) = call(folder.path(), &broken);
    assert_eq!(status, 0, "{error}");
    assert_eq!(found(&folder.path().join("broken")), found(&folder.path().join("whole")));
    // What was done before was not done again: its cost is the one that was noted then.
    let (_, rows) = rows(&folder.path().join("broken"));
    assert_eq!(rows.len(), 120);
    for (row, worked) in kept {
        assert_eq!(rows[row.group as usize], (row, worked));
    }
    assert_eq!(fs::read_dir(folder.path().join("broken/unfinished")).unwrap().count(), 0);
}

#[test]
fn results_of_other_options_are_refused_and_made_anew_on_demand() {
    let folder = tempfile::tempdir().unwrap();
    many(folder.path(), 3);
    let first = [&FIT[..], &["-o", "out"]].concat();
    assert_eq!(call(folder.path(), &first).0, 0);
    let before = found(&folder.path().join("out"));
    let other = [&first[..], &["--tare"]].concat();
    let (status, _, error) = call(folder.path(), &other);
    assert_eq!(status, 2, "{error}");
    assert!(error.contains("--tare `false`, this call has `true`"), "{error}");
    fs::write(folder.path().join("lab/f009-a.csv"), "time_s,force_N\n0,1\n1,2\n").unwrap();
    let (status, _, error) = call(folder.path(), &first);
    assert_eq!(status, 2, "{error}");
    assert!(error.contains("f009-a.csv is new"), "{error}");
    assert_eq!(found(&folder.path().join("out")), before);
    let (status, _, error) = call(folder.path(), &[&first[..], &["--force"]].concat());
    assert_eq!(status, 0, "{error}");
    let (about, rows) = rows(&folder.path().join("out"));
    assert_eq!((about.groups, rows.len()), (4, 4));
    assert_eq!(rows[3].0.status, Status::Refused);
    // A folder of anything else is never filled.
    fs::create_dir(folder.path().join("thesis")).unwrap();
    fs::write(folder.path().join("thesis/one.tex"), "").unwrap();
    for force in [&[][..], &["--force"]] {
        let call_there = [&FIT[..], &["-o", "thesis"], force].concat();
        let (status, _, error) = call(folder.path(), &call_there);
        assert!(status == 2 && error.contains("holds no survey"), "{error}");
    }
}

#[test]
fn a_group_that_fails_is_a_row_with_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    many(folder.path(), 3);
    let lab = folder.path().join("lab");
    fs::write(lab.join("f100-a.csv"), "time_s,force_N\n0,1\n1\n").unwrap();
    fs::write(lab.join("f101-a.csv"), "").unwrap();
    let nothing = "time_s,displacement_mm,force_N\n0,-2,0\n1,-1,1\n2,-2,2\n";
    fs::write(lab.join("f102-a.csv"), nothing).unwrap();
    let told = answer(folder.path(), &[&FIT[..], &["-o", "out", "--json"]].concat());
    assert_eq!((&told["done"], &told["refused"]), (&Value::from(3), &Value::from(3)));
    let (_, rows) = rows(&folder.path().join("out"));
    let reason = |row: usize| rows[row].0.reason.clone().unwrap();
    assert!(reason(3).contains("f100-a.csv, line 3"), "{}", reason(3));
    assert!(reason(4).contains("no samples"), "{}", reason(4));
    assert!(reason(5).contains("no trace reaches"), "{}", reason(5));
    assert_eq!(rows[2].0.status, Status::Done);
    let again = answer(folder.path(), &["survey", "report", "out", "--json"]);
    assert_eq!(again["failures"].as_array().unwrap().len(), 3);
    let mut again = again;
    let mut told = told;
    // Sums of the same numbers, whichever call makes them.
    for answer in [&mut again, &mut told] {
        answer.as_object_mut().unwrap().remove("cpu_seconds");
    }
    assert_eq!(again, told);
}

/// One Parquet file with many traces: long, with text and a number to group by.
fn long(path: &Path, traces: &[(String, i32, Trace)]) {
    let column = |name: &str, kind, logical| {
        let column = Type::primitive_type_builder(name, kind);
        let column = column.with_repetition(Repetition::REQUIRED).with_logical_type(logical);
        Arc::new(column.build().unwrap())
    };
    let text = Some(LogicalType::String);
    let mut fields = vec![column("trace_id", Physical::BYTE_ARRAY, text)];
    fields.push(column("finger", Physical::INT32, None));
    fields.extend([TIME, DISPLACEMENT, FORCE].map(|name| column(name, Physical::DOUBLE, None)));
    let schema = Type::group_type_builder("long").with_fields(fields).build().unwrap();
    let out = fs::File::create(path).unwrap();
    let properties = WriterProperties::builder().set_data_page_row_count_limit(500).build();
    let mut writer = SerializedFileWriter::new(out, Arc::new(schema), properties.into()).unwrap();
    // Groups of rows that end in the middle of traces' groups.
    for traces in traces.chunks(7) {
        let mut group = writer.next_row_group().unwrap();
        let all = |of: &dyn Fn(&Trace) -> Vec<f64>| {
            traces.iter().flat_map(|(.., trace)| of(trace)).collect::<Vec<f64>>()
        };
        let each = traces.iter().flat_map(|one| std::iter::repeat_n(one, one.2.len()));
        let ids: Vec<ByteArray> =
            each.clone().map(|(id, ..)| ByteArray::from(id.as_str())).collect();
        let fingers: Vec<i32> = each.map(|(_, finger, _)| *finger).collect();
        let mut next = group.next_column().unwrap().unwrap();
        next.typed::<ByteArrayType>().write_batch(&ids, None, None).unwrap();
        next.close().unwrap();
        let mut next = group.next_column().unwrap().unwrap();
        next.typed::<Int32Type>().write_batch(&fingers, None, None).unwrap();
        next.close().unwrap();
        for values in [
            all(&|trace| trace.time.clone()),
            all(&|trace| trace.displacement().unwrap().to_vec()),
            all(&|trace| trace.force().unwrap().to_vec()),
        ] {
            let mut next = group.next_column().unwrap().unwrap();
            next.typed::<DoubleType>().write_batch(&values, None, None).unwrap();
            next.close().unwrap();
        }
        group.close().unwrap();
    }
    writer.close().unwrap();
}

#[test]
fn one_parquet_file_of_many_traces_gives_what_as_many_files_give() {
    let folder = tempfile::tempdir().unwrap();
    many(folder.path(), 20);
    // Two traces a finger.
    let mut traces = Vec::new();
    for k in 0..20 {
        let path = folder.path().join(format!("lab/f{k:03}-a.csv"));
        let mut trace = read(&path).unwrap();
        let name = format!("{}{}", k / 2, ["a", "b"][k % 2]);
        // The head of a file is that of all its traces: here none has one.
        trace.head = Default::default();
        palpate::trace::write(&folder.path().join(format!("lab/g{}-{name}.csv", k / 2)), &trace)
            .unwrap();
        fs::remove_file(path).unwrap();
        traces.push((name, k as i32 / 2, trace));
    }
    long(&folder.path().join("all.parquet"), &traces);
    let fit = ["survey", "fit", "fung", "--by", "finger", "--terms", "1"];
    let files = [&fit[..], &["lab", "--names", "g{finger}-*", "-o", "files"]].concat();
    let one = [&fit[..], &["all.parquet", "-o", "one", "--jobs", "3"]].concat();
    for arguments in [files, one] {
        let (status, _, error) = call(folder.path(), &arguments);
        assert_eq!(status, 0, "{error}");
    }
    let (files, one) = (rows(&folder.path().join("files")).1, rows(&folder.path().join("one")).1);
    assert_eq!((files.len(), one.len()), (10, 10));
    for ((expected, _), (found, _)) in files.iter().zip(&one) {
        assert_eq!((found.traces, found.status), (2, Status::Done), "{:?}", found.reason);
        assert_eq!(found, expected);
        assert!(found.said.heldout_rms.is_some());
    }
    // The survey of one trace each, and a trace by its name.
    let each =
        ["survey", "fit", "fung", "all.parquet", "--by", "trace_id", "--terms", "1", "-o", "each"];
    assert_eq!(call(folder.path(), &each).0, 0);
    assert_eq!(rows(&folder.path().join("each")).1[3].0.key, [Some("1b".into())]);
}

#[test]
fn a_key_that_nothing_tells_and_a_pattern_that_cannot_be_are_refused_before_any_work() {
    let lab = lab(&FEW);
    let refused = |arguments: &[&str], words: &str| {
        let (status, out, error) = call(lab.path(), arguments);
        assert_eq!((status, out.as_str()), (2, ""), "{arguments:?}: {error}");
        assert!(error.contains(words), "{error}");
        assert!(!lab.path().join("out").exists(), "{arguments:?}");
    };
    let fit = ["survey", "fit", "fung", "lab", "-o", "out"];
    refused(&[&fit[..], &["--by", "operator"]].concat(), "nothing gives its `operator`");
    refused(&[&fit[..], &["--by", "finger", "--names", "{a}{b}"]].concat(), "side by side");
    refused(&[&fit[..], &["--by", "status"]].concat(), "nothing gives its `status`");
    refused(
        &["survey", "fit", "fnug", "lab", "--by", "finger", "-o", "out"],
        "did you mean `fung`?",
    );
    refused(&["survey", "fit", "fung", "lab", "-o", "out"], "--by");
}

/// A column as the schema tells it: name, type, whether it may be null, and what is in a list.
fn told(column: &Value, name: &str) -> Value {
    let inner = match &column["element"] {
        Value::Array(parts) => {
            parts.iter().map(|part| told(part, part["name"].as_str().unwrap())).collect()
        }
        element => element.clone(),
    };
    json!([name, column["type"], column["null"], inner])
}

/// The same of a column in a file.
fn written(column: &Type) -> Value {
    let optional = column.get_basic_info().repetition() == Repetition::OPTIONAL;
    if column.is_group() {
        let element = &column.get_fields()[0].get_fields()[0];
        let inner = match element.is_group() {
            true => element.get_fields().iter().map(|part| written(part)).collect(),
            false => written(element)[1].clone(),
        };
        return json!([column.name(), "list", optional, inner]);
    }
    let kind = match column.get_physical_type() {
        Physical::INT64 => "int64",
        Physical::DOUBLE => "double",
        Physical::BYTE_ARRAY => "string",
        other => panic!("{other}"),
    };
    json!([column.name(), kind, optional, null])
}

#[test]
fn the_schema_tells_what_is_written() {
    let folder = tempfile::tempdir().unwrap();
    many(folder.path(), 2);
    assert_eq!(call(folder.path(), &[&FIT[..], &["-o", "out"]].concat()).0, 0);
    let out = folder.path().join("out");
    let schema = fs::read_to_string(workspace().join("docs/schema/survey.json")).unwrap();
    let schema: Value = serde_json::from_str(&schema).unwrap();
    for table in ["groups", "work"] {
        let expected = schema[table].as_array().unwrap().iter();
        let expected: Vec<Value> = expected
            .map(|column| match column["name"].as_str().unwrap() {
                "KEY" => told(column, "finger"),
                name => told(column, name),
            })
            .collect();
        let file = fs::File::open(out.join(table).join("part-00000.parquet")).unwrap();
        let file = SerializedFileReader::new(file).unwrap();
        let fields = file.metadata().file_metadata().schema().get_fields();
        assert_eq!(fields.iter().map(|field| written(field)).collect::<Vec<_>>(), expected);
    }
    let manifest = fs::read_to_string(out.join("manifest.json")).unwrap();
    let manifest: Value = serde_json::from_str(&manifest).unwrap();
    let mut names: Vec<&str> = manifest.as_object().unwrap().keys().map(String::as_str).collect();
    let listed = schema["manifest"].as_array().unwrap().iter();
    let mut listed: Vec<&str> = listed.map(|part| part["name"].as_str().unwrap()).collect();
    names.sort_unstable();
    listed.sort_unstable();
    assert_eq!(names, listed);
    let files = schema["folder"].as_array().unwrap();
    for entry in fs::read_dir(&out).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let known = |file: &Value| file["name"].as_str().unwrap().split('/').next() == Some(&name);
        assert!(name == ".lock" || files.iter().any(known), "{name}");
    }
}

#[test]
fn the_traces_of_a_group_are_given_back_for_the_other_commands() {
    let lab = lab(&FEW);
    let segment = ["survey", "segment", "lab", "--by", "finger", "-o", "out"];
    assert_eq!(call(lab.path(), &segment).0, 0);
    let traces = ["survey", "traces", "out", "1", "-o", "one"];
    let (status, _, error) = call(lab.path(), &traces);
    assert!(status == 0 && error.contains("finger 2: 1 trace in one"), "{error}");
    let given = read(&lab.path().join("one").join(FEW[1])).unwrap();
    let own = read(&bundled(FEW[1])).unwrap();
    assert_eq!((given.time, given.columns), (own.time, own.columns));
    assert_eq!(call(lab.path(), &traces).0, 2, "it lies there already");
    assert_eq!(call(lab.path(), &["survey", "traces", "out", "3", "-o", "none"]).0, 2);
}
