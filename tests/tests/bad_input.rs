//! Input that cannot be used gets one clear error that names file, line and column and what to do.

use std::fs::File;
use std::path::Path;

use palpate::cli::{Failure, Force, import};
use palpate::trace::{self, Mapping};

/// Bytes of a file and the error they get; `press.csv` stands for its path.
const TRACES: &[(&str, &[u8], &str)] = &[
    (
        "an empty file",
        b"",
        "press.csv: no header row and no samples. A trace begins with a row such as `time_s,force_N`.",
    ),
    (
        "a head and nothing else",
        b"# name = \"take 3\"\n",
        "press.csv: no header row and no samples. A trace begins with a row such as `time_s,force_N`.",
    ),
    (
        "a header row and nothing else",
        b"time_s,force_N\n",
        "press.csv: 0 sample(s) below the header row of line 1. A trace has at least two.",
    ),
    (
        "one sample",
        b"# name = \"x\"\ntime_s,force_N\n0,1\n",
        "press.csv: 1 sample(s) below the header row of line 2. A trace has at least two.",
    ),
    (
        "a truncated last line",
        b"time_s,displacement_mm,force_N\n0,0,1\n0.5,1,2\n1.0,2",
        "press.csv, line 4, column 3 (force_N): the row has 2 cell(s), the header row has 3. Complete the \
         row or remove it; a cut last line means that recording or copying broke off.",
    ),
    (
        "a cell too many",
        b"time_s,force_N\n0,1\n1,2,3\n",
        "press.csv, line 3, column 3: the row has 3 cell(s), the header row has 2. Complete the row or \
         remove it; a cut last line means that recording or copying broke off.",
    ),
    (
        "decimal commas between commas",
        b"time_s,force_N\n0,0,1,0\n",
        "press.csv, line 2, column 3: the row has 4 cell(s), the header row has 2. Decimal commas? Then \
         use `palpate import`.",
    ),
    (
        "decimal commas in quotes",
        b"time_s,force_N\n\"0,0\",\"1,0\"\n",
        "press.csv, line 2, column 1 (time_s): `0,0` is not a number. Decimal commas come in through \
         `palpate import`.",
    ),
    (
        "an empty cell",
        b"time_s,force_N\n0,1\n1,\n",
        "press.csv, line 3, column 2 (force_N): an empty cell is not a number. Correct the cell or remove \
         the row.",
    ),
    (
        "a word among numbers",
        b"time_s,force_N\r\n0,1\r\n1,overload\r\n",
        "press.csv, line 3, column 2 (force_N): `overload` is not a number. Correct the cell or remove the \
         row.",
    ),
    (
        "NaN",
        b"time_s,force_N\n0,1\n1,NaN\n",
        "press.csv, line 3, column 2 (force_N): `NaN` is not a finite number. Remove the row; a gap in \
         time is allowed.",
    ),
    (
        "infinity",
        b"time_s,force_N\n0,-inf\n",
        "press.csv, line 2, column 2 (force_N): `-inf` is not a finite number. Remove the row; a gap in \
         time is allowed.",
    ),
    (
        "a number too large to hold",
        b"time_s,force_N\n0,1e999\n",
        "press.csv, line 2, column 2 (force_N): `1e999` is not a finite number. Remove the row; a gap in \
         time is allowed.",
    ),
    (
        "time going backwards",
        b"time_s,force_N\n0,1\n0.5,2\n0.4,3\n",
        "press.csv, line 4, column 1 (time_s): time 0.4 s goes backwards after 0.5 s. Time increases from \
         row to row; `palpate import` can say what to do with repeated time stamps.",
    ),
    (
        "a repeated time stamp",
        b"force_N,time_s\n1,0\n2,0\n",
        "press.csv, line 3, column 2 (time_s): time 0 s is repeated after 0 s. Time increases from row to \
         row; `palpate import` can say what to do with repeated time stamps.",
    ),
    (
        "force in another unit",
        b"time_s,force_mN\n0,1\n1,2\n",
        "press.csv, line 1, column 2 (force_mN): a trace has this quantity as `force_N`. Convert the \
         values, with `palpate import` for instance; nothing is converted by its name.",
    ),
    (
        "time in another unit",
        b"time_ms,force_N\n0,1\n1,2\n",
        "press.csv, line 1, column 1 (time_ms): a trace has this quantity as `time_s`. Convert the \
         values, with `palpate import` for instance; nothing is converted by its name.",
    ),
    (
        "displacement in two units",
        b"time_s,displacement_mm,displacement_m\n0,1,0.001\n",
        "press.csv, line 1, column 3 (displacement_m): a trace has this quantity as `displacement_mm`. \
         Convert the values, with `palpate import` for instance; nothing is converted by its name.",
    ),
    (
        "no column of time",
        b"displacement_mm,force_N\n0,1\n1,2\n",
        "press.csv, line 1: no column `time_s`; there are displacement_mm, force_N. Name the column of \
         time `time_s` if it is in seconds, else use `palpate import`.",
    ),
    (
        "a column twice",
        b"time_s,force_N,force_N\n0,1,2\n",
        "press.csv, line 1, column 3 (force_N): column 2 has the same name. Rename or remove one of them.",
    ),
    (
        "a column without a name",
        b"time_s,,force_N\n0,1,2\n",
        "press.csv, line 1, column 2: this column has no name, or one with a control character in it. Name \
         it, or use `palpate import`.",
    ),
    (
        "no header row",
        b"0,1\n1,2\n",
        "press.csv, line 1, column 1 (0): the first row holds numbers, the header row is missing. Put the \
         names of the columns above it (`time_s,displacement_mm,force_N`), or use `palpate import`.",
    ),
    (
        "semicolons",
        b"time_s;force_N\n0;1\n",
        "press.csv, line 1, column 1: columns seem to be separated by semicolons, a trace uses commas. \
         Bring the file in with `palpate import`.",
    ),
    (
        "tabs",
        b"# name = \"x\"\ntime_s\tforce_N\n0\t1\n",
        "press.csv, line 2, column 1: columns seem to be separated by tabs, a trace uses commas. Bring the \
         file in with `palpate import`.",
    ),
    (
        "UTF-16",
        b"\xFF\xFEt\0i\0m\0e\0",
        "press.csv, line 1, column 1: this is UTF-16 text, a trace is UTF-8 text. If it is a recording, \
         bring it in with `palpate import` and a mapping that names its `encoding`.",
    ),
    (
        "another encoding",
        b"time_s,force_N,winkel_\xB0\n0,1,2\n",
        "press.csv, line 1, column 3: this is text in another encoding, or binary data, a trace is UTF-8 \
         text. If it is a recording, bring it in with `palpate import` and a mapping that names its \
         `encoding`.",
    ),
    (
        "binary data",
        b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR",
        "press.csv, line 3, column 1: this is binary data or UTF-16 text, a trace is UTF-8 text. If it is \
         a recording, bring it in with `palpate import` and a mapping that names its `encoding`.",
    ),
    (
        "a newer version",
        b"# palpate-trace = 2\n# touch = { curved = true }\ntime_s,force_N\n0,1\n1,2\n",
        "press.csv, line 1: palpate-trace version 2, this program reads up to version 1. Use a newer \
         palpate.",
    ),
    (
        "a head that is not TOML",
        b"# name = \"take 3\"\n# recorded on Monday\ntime_s,force_N\n0,1\n1,2\n",
        "press.csv, line 2, column 12 of the line: the head is not understood: key with no value, expected \
         `=`. Lines that start with `#` hold TOML such as `# name = \"take 3\"`; start a free remark with \
         `##`.",
    ),
    (
        "a size that cannot be",
        b"# [specimen]\n# radius_mm = 25\n# height_mm = 0\ntime_s,force_N\n0,1\n1,2\n",
        "press.csv, line 3, column 1 of the line: the head is not understood: height_mm = 0, a size is \
         above 0. Lines that start with `#` hold TOML such as `# name = \"take 3\"`; start a free remark \
         with `##`.",
    ),
];

/// An error's text with the folder left out.
fn shown(error: impl std::fmt::Display, folder: &Path) -> String {
    error.to_string().replace(&format!("{}/", folder.display()), "")
}

#[test]
fn every_bad_trace_gets_its_one_clear_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.csv");
    for (what, bytes, expected) in TRACES {
        std::fs::write(&path, bytes).unwrap();
        match trace::read(&path) {
            Ok(_) => panic!("{what}: was read"),
            Err(error) => assert_eq!(&shown(error, folder.path()), expected, "{what}"),
        }
    }
}

#[test]
fn a_missing_file_and_a_folder_are_said_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let error = trace::read(&folder.path().join("press.csv")).unwrap_err();
    let text = shown(error, folder.path());
    assert!(text.starts_with("press.csv: cannot be read: "), "{text}");
    assert!(text.ends_with("Check the name and the permissions."), "{text}");
    let error = trace::read(folder.path()).unwrap_err().to_string();
    assert!(error.contains("cannot be read"), "{error}");
    let error = trace::read_set(&[folder.path()]).unwrap_err().to_string();
    assert!(error.ends_with("no .csv and no .parquet file in this folder."), "{error}");
}

#[test]
fn a_file_of_2_gb_is_refused_before_it_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.csv");
    File::create(&path).unwrap().set_len(2_000_000_000).unwrap();
    assert_eq!(
        shown(trace::read(&path).unwrap_err(), folder.path()),
        "press.csv: 2.0 GB is more than the limit of 1.1 GB. Thin it with `palpate import --every N` and \
         a mapping, or split it."
    );
}

/// A mapping below its version line, and the error it gets.
const MAPPINGS: &[(&str, &str)] = &[
    (
        "[time]\nfrom = 1\nunits = \"s\"",
        "line 4, column 1: the mapping is not understood: unknown field `units`",
    ),
    (
        "[time]\nfrom = 1\nunit = \"sec\"",
        "line 2, column 1: the mapping is not understood: unit `sec` is not known",
    ),
    (
        "[time]\nstart_s = 0",
        "line 2, column 1: the mapping is not understood: both `start_s` and a `step_s`",
    ),
    (
        "[time]\nfrom = \"t\"",
        "line 3, column 8: the mapping is not understood: without a header row columns go by their place",
    ),
    (
        "[text]\nencoding = \"utf-61\"\n[time]\nfrom = 1",
        "line 3, column 1: the mapping is not understood: no such encoding",
    ),
    (
        "[text]\ndecimal = \",\"\n[time]\nfrom = 1",
        "line 3, column 1: the mapping is not understood: a comma cannot separate both",
    ),
    (
        "[time]\nfrom = 1\n[[column]]\nfrom = 2\nname = \"force_N\"\nunit = \"MPa\"",
        "line 6, column 8: the mapping is not understood: `MPa` does not convert to `N` (give `area_mm2`)",
    ),
    (
        "[text]\nthousands = \".\"\n[time]\nfrom = 1",
        "line 3, column 1: the mapping is not understood: thousands are told by `,` `.` `'` or a blank, and not by",
    ),
    (
        "[time]\nstart_s = 0\nstep_s = 1\nrestarts = \"split\"",
        "line 5, column 1: the mapping is not understood: `restarts` is of a time in a column that counts",
    ),
    ("about = \"no clock\"", "the mapping is not understood: missing field `time`"),
    ("[time]\nfrom = ", "line 3, column 8: the mapping is not understood"),
];

#[test]
fn every_bad_mapping_gets_its_one_clear_error() {
    for (text, expected) in MAPPINGS {
        let text = format!("palpate-map = 1\n{text}\n");
        let error = Mapping::parse(Path::new("map.toml"), &text).unwrap_err().to_string();
        assert!(error.starts_with("map.toml, line "), "{error}");
        assert!(error.contains(expected), "{error}\nlacks\n{expected}");
    }
    let newer = Mapping::parse(Path::new("map.toml"), "\npalpate-map = 9\nwarp = 1").unwrap_err();
    assert_eq!(
        newer.to_string(),
        "map.toml, line 2: palpate-map version 9, this program reads up to version 1. Use a newer palpate."
    );
}

/// A mapping below its version line, the recording, and the error it gets.
const IMPORTS: &[(&str, &[u8], &str)] = &[
    ("[time]\nfrom = 1", b"0,1\n1,x\n", ""),
    (
        "[time]\nfrom = 1\n[[column]]\nfrom = 2\nname = \"force_N\"",
        b"0,1\n1,x\n",
        "odd.txt, line 2, column 2: `x` is not a number with decimal mark `.`. Correct the cell, or \
         `decimal`, `skip_lines`, `comment` or `last_row` in the mapping. If it says that there is no value, \
         `missing = [\"x\"]` in `[text]` leaves its row out.",
    ),
    (
        "[time]\nfrom = 1",
        b"0,1\n1\n",
        "odd.txt, line 2, column 2: the row has 1 cell(s), 2 expected. Correct the row, or `delimiter`, \
         `empty_last_cell`, `stop_at_blank` or `last_row` in the mapping.",
    ),
    (
        "[time]\nfrom = 3",
        b"0,1\n1,2\n",
        "odd.txt, line 1: no column number 3; there are 2 columns without names. Correct `from` in the \
         mapping.",
    ),
    (
        "[table]\nheader_line = 1\n[time]\nfrom = \"zeit\"",
        b"t,F\n0,1\n1,2\n",
        "odd.txt, line 1: no column `zeit`; there are t, F. Correct `from` in the mapping.",
    ),
    (
        "[table]\nheader_line = 9\n[time]\nfrom = \"t\"",
        b"t,F\n0,1\n1,2\n",
        "odd.txt: header line 9 not found. Correct `[table]` in the mapping.",
    ),
    (
        "[time]\nfrom = 1",
        b"0,1\n",
        "odd.txt: 1 sample(s) after the mapping, a trace has at least two. Correct `[table]` in the \
         mapping.",
    ),
    (
        "[time]\nfrom = 1",
        b"",
        "odd.txt: 0 sample(s) after the mapping, a trace has at least two. Correct `[table]` in the \
         mapping.",
    ),
    (
        "[time]\nfrom = 1",
        b"5,1\n4,2\n",
        "odd.txt, line 2, column 1: time 4 s goes backwards after 5 s. Take part of the rows (`first_row`, \
         `last_row`), give an even clock (`start_s`, `step_s`) if the rate is known, or where another test begins \
         there, say `restarts = \"split\"` in `[time]`.",
    ),
    (
        "[time]\nfrom = 1",
        b"\xFF\xFE0\0",
        "odd.txt, line 1: these bytes are not UTF-8. The file seems to be utf-16le: set `encoding = \
         \"utf-16le\"` in the mapping.",
    ),
    (
        "[table]\nheader_line = 1\n[time]\nfrom = 1",
        b"t,Force (mN)\n0,1\n1,2\n",
        "odd.txt: column `Force_mN` is `force_N` in a trace. Name or drop it in the mapping.",
    ),
];

#[test]
fn every_bad_import_gets_its_one_clear_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("odd.txt");
    for (map, bytes, expected) in IMPORTS {
        std::fs::write(&path, bytes).unwrap();
        let map =
            Mapping::parse(Path::new("map.toml"), &format!("palpate-map = 1\n{map}\n")).unwrap();
        match trace::import(&path, &map) {
            // A column that the mapping does not name may hold words: it is left out, and said so.
            Ok(imported) => assert!(expected.is_empty() && !imported.dropped.is_empty()),
            Err(error) => assert_eq!(&shown(error, folder.path()), expected),
        }
    }
}

#[test]
fn an_import_writes_over_nothing_unasked_and_leaves_nothing_half_written() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("odd.txt"), "0,1\n1,2\n").unwrap();
    std::fs::write(at("map.toml"), "palpate-map = 1\n[time]\nfrom = 1\n").unwrap();
    std::fs::write(at("out.csv"), "precious").unwrap();
    let mut args = import::Args {
        files: vec![at("odd.txt")],
        map: Some(at("map.toml")),
        output: Some(at("out.csv")),
        every: None,
        part: None,
        preview: false,
        suggest: false,
        over: Force { force: false },
    };
    assert!(matches!(import::run(&args), Err(Failure::Input(_))));
    assert_eq!(std::fs::read(at("out.csv")).unwrap(), b"precious");
    args.over.force = true;
    std::fs::write(at("odd.txt"), "0,1\n1,2,3\n").unwrap();
    assert!(matches!(import::run(&args), Err(Failure::Input(_))));
    assert_eq!(std::fs::read(at("out.csv")).unwrap(), b"precious");
    args.output = Some(at("odd.txt"));
    assert!(matches!(import::run(&args), Err(Failure::Input(_))), "the recording itself is kept");
    args.output = Some(at("no such folder/out.csv"));
    std::fs::write(at("odd.txt"), "0,1\n1,2\n").unwrap();
    assert!(matches!(import::run(&args), Err(Failure::Work(_))));
    args.output = Some(at("out.csv"));
    import::run(&args).unwrap();
    assert_eq!(trace::read(&at("out.csv")).unwrap().len(), 2);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3, "no litter");
}
