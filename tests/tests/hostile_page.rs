//! The local page among what it should not trust: names with markup, clocks that jump, a server that begins again:
//! `cargo xtask browser`.
#![cfg(unix)]

use std::path::Path;

use palpate_tests::browser::Browser;
use palpate_tests::device::Foreign;
use palpate_tests::server::Server;
use palpate_tests::{answer, bundled};

/// What would run, or be an element, if it were taken for markup.
const SCRIPT: &str = "<script>window.owned=1</script>";
const IMAGE: &str = "<img src=x onerror=window.owned=1>";

fn opened(server: &Server) -> Browser {
    let browser = Browser::open(&server.url(), 1280, 900);
    browser.until("a room is open", "document.querySelector('#rooms [aria-current]') !== null");
    browser
}

/// Nothing of what was named has become part of the page.
fn nothing_ran(browser: &Browser) {
    assert_eq!(browser.script("return window.owned === undefined"), true);
    assert_eq!(browser.count("img[src=x], script:not([src]), b.owned"), 0);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// A practice set whose names, heads, columns and laws are markup.
fn marked_up(folder: &Path) {
    answer(folder, &["hide", "coulomb-friction", "--seed", "3", "-o", "set", "--json"]);
    let set = folder.join("set");
    let mut files: Vec<_> = std::fs::read_dir(&set).unwrap().map(|e| e.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|ending| ending == "csv"));
    files.sort();
    for (number, file) in files.iter().enumerate() {
        let text = std::fs::read_to_string(file).unwrap();
        let head = format!("# material = \"{SCRIPT}\"\n");
        let named = text.replace("# [specimen]\n", &format!("# [specimen]\n{head}"));
        std::fs::write(set.join(format!("{number}{IMAGE}.csv")), named).unwrap();
        std::fs::remove_file(file).unwrap();
    }
    std::fs::write(set.join(format!("bad{IMAGE}.csv")), format!("{SCRIPT}\n1\n")).unwrap();
    answer(
        folder,
        &[
            "fit",
            "maxwell",
            "set/0<img src=x onerror=window.owned=1>.csv",
            "-o",
            "plain.toml",
            "--json",
        ],
    );
    let model = std::fs::read_to_string(folder.join("plain.toml")).unwrap();
    let law = format!(
        "\n[[candidate]]\nname = '{IMAGE}'\nstage = \"sensor\"\nexpression = \"k*x\"\nmeaning = '{SCRIPT}'\n\
         [candidate.parameters]\nk = {{ value = 0.1, unit = '<b class=owned>N</b>' }}\n"
    );
    std::fs::write(set.join(format!("model{IMAGE}.toml")), model + &law).unwrap();
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn markup_in_names_heads_and_laws_is_shown_as_it_is_written() {
    let folder = tempfile::tempdir().unwrap();
    marked_up(folder.path());
    let server = Server::begin_in(folder, &["set", "--model", &format!("set/model{IMAGE}.toml")]);
    let browser = opened(&server);
    let folds = "document.querySelectorAll('details').forEach((d) => (d.open = true)); return 0";
    browser.until("the Lab is open", "document.querySelector('.lab-bench') !== null");
    let _ = browser.script(folds);
    browser.says(".lab-bench", IMAGE);
    browser.says(".lab-bench", "is left out");
    nothing_ran(&browser);
    browser.click(".lab-fit");
    browser.says(".lab-rungs", "fung");
    browser.click(".lab-diagnose");
    browser.says(".lab-missing", "coulomb-friction");
    let _ = browser.script(folds);
    browser.write("#lab-expression", &format!("k * {SCRIPT}"));
    browser.says(".lab-fault", "^");
    nothing_ran(&browser);
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn markup_in_the_name_of_a_replayed_trace_is_shown_as_it_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let name = format!("{IMAGE}.csv");
    std::fs::copy(bundled("press.csv"), folder.path().join(&name)).unwrap();
    let server = Server::begin_in(folder, &["--replay", &name]);
    let browser = opened(&server);
    browser.says(".health", "replayed");
    browser.says(".gauge .reading", "settles at");
    nothing_ran(&browser);
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn markup_in_what_a_device_says_of_itself_is_shown_as_it_is_written() {
    let device = Foreign::that_says(IMAGE).unwrap();
    let server = Server::begin(&["--port", &device.port.display().to_string()]);
    let browser = opened(&server);
    browser.press('2');
    browser.says("#room", IMAGE);
    nothing_ran(&browser);
    browser.press('1');
    browser.until("Live is open", "document.querySelector('.gauge') !== null");
    nothing_ran(&browser);
}

/// Rows that the page was told of.
const ROWS: &str = "Number([...document.querySelectorAll('.health dt')].find(t => t.textContent === 'rows').nextSibling.textContent.replaceAll(',', ''))";

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn a_clock_that_jumps_stops_nothing() {
    let server = Server::simulated();
    let browser = opened(&server);
    browser.says(".gauge .reading", "settles at");
    for hours in [-48.0, 48.0] {
        let _ = browser.script(&format!(
            "const before = Date.now; Date.now = () => before() + {hours} * 3600e3; return 0"
        ));
        let before = browser.script(&format!("return {ROWS}"));
        browser.until("rows come", &format!("{ROWS} > {before} + 1000"));
        browser.says(".health", "rows lost\n0");
    }
    nothing_ran(&browser);
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn a_page_whose_server_began_again_says_where_to_go_on() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(bundled("press.csv"), folder.path().join("press.csv")).unwrap();
    let mut first = Server::begin_in(folder, &[".", "--simulate"]);
    let browser = opened(&first);
    browser.press('2');
    browser.until("the Lab is open", "document.querySelector('.lab-bench') !== null");
    browser.press('1');
    browser.says(".gauge .reading", "settles at");
    first.process.kill().unwrap();
    first.process.wait().unwrap();
    browser.says(".live .where", "is `palpate serve` still running?");
    // The same port, another token.
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(bundled("press.csv"), folder.path().join("press.csv")).unwrap();
    let port = first.port.to_string();
    let second = Server::begin_in(folder, &[".", "--simulate", "--port-http", &port]);
    browser.says(".live .where", "open the address that `palpate serve` printed");
    // With the new address all is there again. A new fragment alone would not load the page.
    browser.go("about:blank");
    browser.go(&second.url());
    browser.until("the Lab is open", "document.querySelector('.lab-bench') !== null");
    browser.press('1');
    browser.says(".gauge .reading", "settles at");
}

/// More work than anybody does in a day.
#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn a_day_of_work_in_one_session_stays_quick_and_small() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(bundled("press.csv"), folder.path().join("press.csv")).unwrap();
    let server = Server::begin_in(folder, &["."]);
    let browser = opened(&server);
    browser.until("the Lab is open", "document.querySelector('.lab-bench') !== null");
    // Through the page's own connection: what it shows is asked for anew each time.
    for round in 0..4 {
        let asked = browser.script(
            "const token = sessionStorage.getItem('palpate-token'); \
             const ask = (path) => fetch('/api/lab' + path, { headers: { 'x-palpate-token': token } }).then((r) => r.text()); \
             return (async () => { let n = 0; for (let k = 0; k < 500; k++) { await ask('/state'); await ask('/overlay?trace=0&width=800'); n += 2; } return n; })()",
        );
        assert_eq!(asked, 1000, "round {round}");
    }
    #[cfg(target_os = "linux")]
    assert!(palpate_tests::server::memory_mb(&server, "VmHWM") < 300.0);
    nothing_ran(&browser);
}
