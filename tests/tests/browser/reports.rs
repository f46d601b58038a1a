//! The reports that `--report` writes: one file, seen at any width and on paper.

use std::path::Path;

use palpate_tests::browser::Browser;
use palpate_tests::{answer, bundled};
use serde_json::Value;

use crate::axe::axe;

/// Opens a file in a window of a desk.
fn opened(file: &Path) -> Browser {
    Browser::open(&format!("file://{}", file.display()), 1440, 900)
}

/// Ten traces with a hidden effect in `set`, and a base law fitted to them in `model.toml`.
fn fitted(folder: &Path, effect: &str, seed: &str) {
    answer(folder, &["hide", effect, "--seed", seed, "-o", "set", "--json"]);
    answer(folder, &["fit", "fung", "set", "-o", "model.toml", "--json"]);
}

/// A comparison of the ten traces of a practice set, and the relaxation and the regions of ten presses.
fn reports(folder: &Path) -> [std::path::PathBuf; 3] {
    fitted(folder, "adhesion", "3");
    answer(folder, &["compare", "model.toml", "set", "--report", "compare.html", "--json"]);
    let rows: Vec<String> = (1..=10)
        .map(|row| bundled(&format!("table-3.1-row-{row:02}.csv")).display().to_string())
        .collect();
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    for (question, report) in [("relaxation", "relaxation.html"), ("segment", "segment.html")] {
        answer(folder, &[&[question], &rows[..], &["--report", report, "--json"]].concat());
    }
    ["compare.html", "relaxation.html", "segment.html"].map(|file| folder.join(file))
}

/// Left edge of each table that is not folded away, and whether it can be seen whole or scrolled by keyboard.
const TABLES: &str = r"
  const shown = [...document.querySelectorAll('div.table')].filter((box) => !box.closest('details'));
  return shown.map((box) => [
    Math.round(box.querySelector('table').getBoundingClientRect().left),
    box.scrollWidth <= box.clientWidth || box.tabIndex === 0,
  ])";

/// Titles of figures that do not begin where their figure does, to a pixel and a half.
const FIGURES: &str = r"
  const left = (e) => e.getBoundingClientRect().left;
  const titles = [...document.querySelectorAll('figure .pl-title:first-of-type')].filter((e) => e.checkVisibility());
  return titles.filter((e) => Math.abs(left(e) - left(e.closest('figure'))) > 1.5).map((e) => e.textContent)";

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn the_tables_of_a_report_have_one_left_edge_and_none_is_clipped() {
    let folder = tempfile::tempdir().unwrap();
    for file in reports(folder.path()) {
        let browser = opened(&file);
        for width in [1024, 1085, 1440, 2560] {
            browser.resize(width, 900);
            browser.until("it is laid out", "document.readyState === 'complete'");
            let tables = browser.script(TABLES);
            let tables: Vec<&Value> = tables.as_array().unwrap().iter().collect();
            let text = browser.script(
                "return Math.round(document.querySelector('h2').getBoundingClientRect().left)",
            );
            assert!(tables.len() > 1);
            for table in &tables {
                assert_eq!(
                    (&table[0], &table[1]),
                    (&text, &Value::Bool(true)),
                    "{file:?} at {width}"
                );
            }
            let askew = browser.script(FIGURES);
            assert_eq!(askew, Value::Array(Vec::new()), "{file:?} at {width}");
            browser.fits(&format!("{} at {width}", file.display()));
        }
        assert_eq!(axe(&browser), Vec::<String>::new(), "{file:?}");
        // An index is set as an index.
        let raw = browser.script(r"return /[ε]_[a-z]/.test(document.body.innerText)");
        assert_eq!(raw, false, "{file:?}");
        assert_eq!(browser.complaints(), Vec::<String>::new());
    }
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn the_numbers_of_a_figure_are_saved_as_csv() {
    let folder = tempfile::tempdir().unwrap();
    let press = bundled("press.csv").display().to_string();
    answer(folder.path(), &["fit", "fung", &press, "--report", "fit.html", "--json"]);
    let browser = opened(&folder.path().join("fit.html"));
    let saved = browser.script(
        "let saved, name;
         URL.createObjectURL = (file) => { saved = file; return '#'; };
         HTMLAnchorElement.prototype.click = function () { name = this.download; };
         const buttons = [...document.querySelectorAll('.tools button')];
         buttons.find((button) => button.textContent === 'Save CSV').click();
         return saved.text().then((text) => [name, saved.type, text])",
    );
    let [name, kind, text] = [0, 1, 2].map(|at| saved[at].as_str().unwrap());
    assert!(name.ends_with(".csv") && kind == "text/csv", "{name}, {kind}");
    let mut lines = csv::Reader::from_reader(text.as_bytes());
    let header: Vec<String> = lines.headers().unwrap().iter().map(str::to_owned).collect();
    assert_eq!(header, ["series", "quantity", "time (s)", "value", "upper end or error"]);
    let trace = palpate::trace::read(&bundled("press.csv")).unwrap();
    let (mut measured, mut series) = (0, std::collections::BTreeSet::new());
    for line in lines.records().map(Result::unwrap) {
        series.insert(line[0].to_owned());
        let (time, value): (f64, f64) = (line[2].parse().unwrap(), line[3].parse().unwrap());
        if &line[0] == "measured" && &line[1] == "force (N)" {
            let near =
                |(t, force): (&f64, &f64)| (t - time).abs() < 1e-5 && (force - value).abs() < 1e-5;
            let there = trace.time.iter().zip(trace.force().unwrap()).any(near);
            assert!(there, "{time} s, {value} N");
            measured += 1;
        }
    }
    assert_eq!(measured, trace.len());
    assert!(series.contains("model") && series.contains("residual"), "{series:?}");
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn a_report_of_ten_traces_fits_on_six_pages() {
    let folder = tempfile::tempdir().unwrap();
    for file in reports(folder.path()) {
        let pages = opened(&file).printed_pages();
        assert!((2..=6).contains(&pages), "{file:?}: {pages}");
    }
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn the_figure_for_a_paper_is_one_page_with_before_verdict_and_after_and_nothing_runs_out_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fitted(folder, "mullins", "7");
    answer(folder, &["diagnose", "--model", "model.toml", "set", "--figure", "one.svg", "--json"]);
    let browser = opened(&folder.join("one.svg"));
    let titles = browser.script(
        "return [...document.querySelectorAll('.pl-title')].map((title) => title.textContent).join(' ')",
    );
    let titles = titles.as_str().unwrap();
    let places = ["Before: ", "mullins is missing", "After: "].map(|words| titles.find(words));
    assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{titles}");
    let beyond = browser.script(
        "const { width, height } = document.documentElement.viewBox.baseVal;
         const scale = document.documentElement.getBoundingClientRect().width / width;
         const within = ({ left, right, top, bottom }) => left >= 0 && top >= 0 && right <= scale * width && bottom <= scale * height;
         return [...document.querySelectorAll('text')].filter((text) => !within(text.getBoundingClientRect())).map((text) => text.textContent)",
    );
    assert_eq!(beyond, Value::Array(Vec::new()));
    assert_eq!(browser.printed_pages(), 1);
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn the_figure_for_a_paper_is_a_pdf_of_one_page_with_its_fonts() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fitted(folder, "mullins", "7");
    let call = ["diagnose", "--model", "model.toml", "set", "--figure", "one.pdf", "--json"];
    answer(folder, &call);
    let pdf = std::fs::read(folder.join("one.pdf")).unwrap();
    let count = |wanted: &[u8]| pdf.windows(wanted.len()).filter(|bytes| *bytes == wanted).count();
    assert!(pdf.starts_with(b"%PDF-"));
    assert_eq!(count(b"/Type /Page\n"), 1);
    assert!(count(b"/FontFile2") + count(b"/FontFile3") > 0, "its fonts are in it");
    // What palpate printed may be printed again.
    answer(folder, &call);

    let lost = palpate_tests::palpate()
        .current_dir(folder)
        .args(["diagnose", "--model", "model.toml", "set", "--figure", "two.pdf"])
        .env("PALPATE_BROWSER", "no-such-browser")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&lost.stderr);
    assert!(!lost.status.success() && said.contains("no-such-browser cannot be run"), "{said}");
    assert!(String::from_utf8_lossy(&lost.stdout).contains("mullins"), "the answer is not lost");
    assert!(!folder.join("two.pdf").exists());
}
