//! A folder of recordings comes in by one command: at once where names and units say enough, after one edit where they do not.

use std::fs;
use std::path::Path;

use palpate::trace::read;
use palpate_tests::palpate;

/// Status, standard output and standard error of a call in a folder.
fn call(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = palpate().current_dir(folder).args(arguments).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

/// A folder with a table of nine rows under this line of names, by the name of its file.
fn lab(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("lab")).unwrap();
    for (name, header) in files {
        let width = header.split(',').count();
        let row = |row: usize| vec![row.to_string(); width].join(",") + "\n";
        let rows: String = (0..9).map(row).collect();
        fs::write(folder.path().join("lab").join(name), format!("{header}\n{rows}")).unwrap();
    }
    folder
}

#[test]
fn a_file_whose_names_and_units_say_enough_needs_no_mapping() {
    let folder = lab(&[("a.txt", "Time (s),Weg (mm),Kraft (mN)"), ("b.txt", "Time,Force")]);
    let (status, _, said) = call(folder.path(), &["import", "lab/a.txt"]);
    assert_eq!(status, Some(0), "{said}");
    assert!(said.contains("force_N  from Kraft (mN)"), "{said}");
    assert_eq!(read(&folder.path().join("a.trace.csv")).unwrap().force().unwrap()[3], 0.003);
    let (status, _, said) = call(folder.path(), &["import", "lab/b.txt"]);
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("does not say the unit of `Time`, the unit of `Force`"), "{said}");
    assert!(said.contains("palpate import lab/b.txt --suggest > b.map.toml"), "{said}");
    assert!(!folder.path().join("b.trace.csv").exists());
}

#[test]
fn a_folder_comes_in_with_one_edit_for_what_its_files_do_not_say() {
    let own = "time_s,displacement_mm,force_N";
    let folder = lab(&[("a.txt", "Time (s),Force (N)"), ("a.csv", "Time,Force"), ("own.csv", own)]);
    let folder = folder.path();
    let again = || call(folder, &["import", "lab", "-o", "traces"]);
    let (status, _, said) = again();
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("lab/own.csv: is a trace as it is"), "{said}");
    let open = "lab/a.csv: the file does not say the unit of `Time`, the unit of `Force`; complete traces/a.map.toml";
    assert!(said.contains(open), "{said}");
    assert!(said.contains("1 of 3 tables did not come in"), "{said}");
    assert_eq!(read(&folder.join("traces/a-txt.trace.csv")).unwrap().force().unwrap()[3], 3.0);

    // Nobody has looked at the proposal: it is still not taken.
    assert_eq!(again().0, Some(2));
    assert!(!folder.join("traces/a.trace.csv").exists());
    let map = folder.join("traces/a.map.toml");
    let text = fs::read_to_string(&map).unwrap().replace("unit = \"s\"", "unit = \"ms\"");
    fs::write(&map, text).unwrap();
    let (status, said, _) = again();
    assert_eq!((status, &*said), (Some(0), "2 traces in traces\n"));
    assert_eq!(read(&folder.join("traces/a.trace.csv")).unwrap().time[3], 0.003);

    // What is there is what would be written; where it is not, it may be precious.
    assert_eq!(again().0, Some(0));
    fs::write(folder.join("traces/a-txt.trace.csv"), "time_s,force_N\n0,1\n1,2\n").unwrap();
    let (status, _, said) = again();
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("a-txt.trace.csv: exists already"), "{said}");
}

#[test]
fn what_is_no_recording_is_named_and_does_not_stop_the_others() {
    let folder = lab(&[("a.txt", "Time (s),Force (N)")]);
    let folder = folder.path();
    fs::write(folder.join("lab/poem.txt"), "of\ntwo lines\n").unwrap();
    fs::write(folder.join("lab/old.xls"), b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1").unwrap();
    let (status, said, error) = call(folder, &["import", "lab", "--preview"]);
    assert_eq!(status, Some(2), "{error}");
    assert!(said.contains("force_N  from Force (N)"), "{said}");
    assert!(error.contains("lab/poem.txt: three rows of at least two numbers"), "{error}");
    assert!(error.contains("lab/old.xls") && error.contains("Save it as .xlsx"), "{error}");
    assert!(!folder.join("lab.traces").exists(), "a preview writes nothing");
    assert_eq!(call(folder, &["import", "lab"]).0, Some(2));
    assert!(folder.join("lab.traces/a.trace.csv").exists());
}

/// Tests that one program appended to one file: each begins its own clock.
fn appended(between: &str) -> String {
    let test = |force: usize| -> String {
        (0..9).map(|row| format!("{force},{},{row},{}\n", 0.5 * row as f64, force * row)).collect()
    };
    let names = "Test No,Time (s),Displacement (mm),Force (N)\n";
    let tests: Vec<String> = [1, 2, 3].into_iter().map(test).collect();
    names.to_owned() + &tests.join(between)
}

#[test]
fn tests_that_follow_one_another_in_a_file_become_a_trace_each() {
    let names = "Test No,Time (s),Displacement (mm),Force (N)\n";
    for between in ["", "\n", names] {
        let folder = lab(&[]);
        let folder = folder.path();
        fs::write(folder.join("lab/all.csv"), appended(between)).unwrap();
        let check = |folder: &Path| {
            for number in 1..=3 {
                let trace = read(&folder.join(format!("all-{number}.trace.csv"))).unwrap();
                assert_eq!((trace.len(), trace.time[0]), (9, 0.0), "{between:?}");
                assert_eq!(trace.force().unwrap()[8], 8.0 * f64::from(number), "{between:?}");
            }
        };
        let (status, _, said) = call(folder, &["import", "lab/all.csv"]);
        assert_eq!(status, Some(0), "{said}");
        check(folder);
        let (status, told, said) = call(folder, &["import", "lab", "-o", "traces"]);
        assert_eq!((status, told.trim()), (Some(0), "3 traces in traces"), "{said}");
        check(&folder.join("traces"));
        // The head says which test of the file it is, and the same call again finds all in place.
        let text = fs::read_to_string(folder.join("traces/all-2.trace.csv")).unwrap();
        assert!(text.contains("test = 2"), "{text}");
        assert_eq!(call(folder, &["import", "lab", "-o", "traces"]).0, Some(0));
    }
}

#[test]
fn a_clock_that_falls_a_little_is_a_fault_and_begins_no_test() {
    let folder = lab(&[]);
    let folder = folder.path();
    let rows = "0,0,0\n1,1,1\n2,2,2\n3,3,3\n2.9,4,4\n4,5,5\n";
    let text = format!("Time (s),Displacement (mm),Force (N)\n{rows}");
    fs::write(folder.join("lab/back.csv"), text).unwrap();
    let (status, _, said) = call(folder, &["import", "lab/back.csv"]);
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("time 2.9 s goes backwards after 3 s"), "{said}");
    assert!(fs::read_dir(folder).unwrap().count() == 1, "nothing is written");
}

#[test]
fn cells_without_a_value_and_marks_between_thousands_are_told_and_counted() {
    let folder = lab(&[]);
    let folder = folder.path();
    let names = "Time (s),Displacement (mm),Force (N)\n";
    let force = |row: usize| match row {
        7 => "NaN".to_owned(),
        11 => "#N/A".to_owned(),
        13 => String::new(),
        20 => "\"1,047.5\"".to_owned(),
        _ => row.to_string(),
    };
    let rows: String = (0..60).map(|row| format!("{row},{row},{}\n", force(row))).collect();
    fs::write(folder.join("lab/few.csv"), names.to_owned() + &rows).unwrap();
    let (status, _, said) = call(folder, &["import", "lab/few.csv"]);
    assert_eq!(status, Some(0), "{said}");
    assert!(said.contains("57 samples, 3 rows left out that lack a value"), "{said}");
    let trace = read(&folder.join("few.trace.csv")).unwrap();
    assert_eq!(trace.force().unwrap()[17], 1047.5);
    assert!(!trace.time.contains(&11.0) && trace.time.contains(&12.0));
    // The other way round: a point between thousands and a decimal comma.
    let force = |row: usize| if row == 20 { "1.047,5".to_owned() } else { row.to_string() };
    let rows: String = (0..60).map(|row| format!("{row};{row};{}\n", force(row))).collect();
    fs::write(folder.join("lab/comma.csv"), names.replace(',', ";") + &rows).unwrap();
    assert_eq!(call(folder, &["import", "lab/comma.csv"]).0, Some(0));
    assert_eq!(read(&folder.join("comma.trace.csv")).unwrap().force().unwrap()[20], 1047.5);
    // Where most rows lack a value, leaving them out would lose much: it is for a person to say.
    let rows: String = (0..60)
        .map(|row| format!("{row},{row},{}\n", if row < 5 { row.to_string() } else { "-".into() }))
        .collect();
    fs::write(folder.join("lab/most.csv"), names.to_owned() + &rows).unwrap();
    let (status, _, said) = call(folder, &["import", "lab/most.csv"]);
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("line 7") && said.contains("`missing = [\"-\"]`"), "{said}");
}
