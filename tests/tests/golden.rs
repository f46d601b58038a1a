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
fn the_help() {
    golden("help", &["--help"]);
}
