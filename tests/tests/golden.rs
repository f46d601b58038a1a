//! What people read in the terminal, word for word. `INSTA_UPDATE=always cargo test -p palpate-tests`
//! rewrites the expected texts in tests/golden/.

use palpate_tests::{palpate, workspace};

/// Compares what a call prints, in a folder of its own with the bundled recordings in it.
fn golden(name: &str, arguments: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    for recording in palpate_tests::all_bundled() {
        std::fs::copy(&recording, folder.path().join(recording.file_name().unwrap())).unwrap();
    }
    let output = palpate().current_dir(folder.path()).args(arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path(workspace().join("tests/golden"));
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!(name, String::from_utf8_lossy(&output.stdout)));
}

#[test]
fn the_demo() {
    golden("demo", &["demo"]);
}

#[test]
fn a_fit_of_whole_motions() {
    let row = |row: u32| format!("table-3.1-row-{row:02}.csv");
    golden("fit", &["fit", "fung", &row(1), &row(2), &row(3)]);
}

#[test]
fn a_fit_of_holds() {
    let row = |row: u32| format!("table-3.3-row-{row:02}.csv");
    golden("holds", &["fit", "fung", &row(1), &row(2), "--hold-only", "--terms", "auto"]);
}

#[test]
fn a_decomposition() {
    golden("decompose", &["decompose", "press.csv"]);
}

#[test]
fn a_plan() {
    golden(
        "plan",
        &["plan", "--noise", "0.01", "--want", "v1=2", "--want", "v2=1", "--longest", "5"],
    );
}

#[test]
fn a_plot_in_the_terminal() {
    golden("plot", &["plot", "press.csv"]);
}

#[test]
fn the_help() {
    golden("help", &["--help"]);
}

/// What a call prints in a terminal of so many columns.
fn printed(folder: &std::path::Path, arguments: &[&str], columns: &str) -> String {
    let mut call = palpate();
    let output = call.current_dir(folder).args(arguments).env("COLUMNS", columns).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The numbers of a text, each with how far its rounding may have moved it.
fn numbers(text: &str) -> Vec<(f64, f64)> {
    let number = |word: &str| {
        let word = word.trim_matches(|c| "(),;:%±".contains(c)).replace('−', "-");
        let value = word.parse().ok()?;
        let decimals = word.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        Some((value, 0.5 * 0.1_f64.powi(i32::try_from(decimals).unwrap())))
    };
    text.split(|c: char| c.is_whitespace() || c == '│').filter_map(number).collect()
}

#[test]
fn no_number_is_cut_in_a_narrow_terminal() {
    let folder = tempfile::tempdir().unwrap();
    for recording in palpate_tests::all_bundled() {
        std::fs::copy(&recording, folder.path().join(recording.file_name().unwrap())).unwrap();
    }
    let rows: Vec<String> = (1..4).map(|row| format!("table-3.1-row-{row:02}.csv")).collect();
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    printed(folder.path(), &[&["fit", "fung"], &rows[..], &["-o", "m.toml"]].concat(), "80");
    let calls = [
        [&["compare", "m.toml"], &rows[..]].concat(),
        [&["relaxation"], &rows[..]].concat(),
        vec!["demo"],
    ];
    for call in calls {
        let wide = printed(folder.path(), &call, "400");
        let known = numbers(&wide);
        for columns in ["120", "100", "80", "60", "40"] {
            let narrow = printed(folder.path(), &call, columns);
            let long = narrow.lines().find(|line| line.chars().count() > columns.parse().unwrap());
            // A path or an address may be longer than the terminal.
            assert!(
                long.is_none_or(|line| !line.trim().contains(' ')),
                "{call:?} in {columns}: {long:?}"
            );
            let shown = numbers(&narrow);
            // Where rows are stacked, headings are there for every row, with the numbers in them.
            let stacked = narrow.lines().any(|line| line.starts_with("  ") && line.contains(": "));
            assert!(stacked || shown.len() == known.len(), "{call:?} in {columns}\n{narrow}");
            for (value, _) in &known {
                let is_shown =
                    |(other, rounding): &(f64, f64)| (other - value).abs() <= rounding * 1.001;
                assert!(shown.iter().any(is_shown), "{value}: {call:?} in {columns}\n{narrow}");
            }
            for (value, rounding) in shown {
                let is_told = |(other, _): &(f64, f64)| (other - value).abs() <= rounding * 1.001;
                assert!(known.iter().any(is_told), "{value}: {call:?} in {columns}\n{narrow}");
            }
        }
    }
}
