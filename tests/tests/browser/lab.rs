//! The Lab: a model beside recordings, what it lacks, and putting it right.

use std::time::{Duration, Instant};

use palpate_tests::browser::Browser;
use palpate_tests::server::Server;
use palpate_tests::{answer, bundled, palpate, workspace};

use crate::axe::axe;
use crate::plots::kept;
use crate::{HEIGHT, WIDTH, opened};

/// A server with a practice set in its folder.
fn practice(effect: &str, seed: &str) -> Server {
    let folder = tempfile::tempdir().unwrap();
    answer(folder.path(), &["hide", effect, "--seed", seed, "-o", "set", "--json"]);
    Server::begin_in(folder, &["set"])
}

/// Goes on with the button that the guide offers, when it says this.
fn go_on(browser: &Browser, words: &str) {
    browser.says(".lab-next", words);
    browser.click(".lab-next");
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn a_first_time_user_names_the_effect_and_sees_the_error_fall_with_the_mouse_alone() {
    let begun = Instant::now();
    let server = Server::begin(&["--demo"]);
    let browser = opened(&server);
    go_on(&browser, "Fit fung");
    go_on(&browser, "Diagnose");
    browser.says(".lab-next", "Add");
    let named = browser.text(".lab-next").replace("Add ", "");
    // What it would change is shown before it is done.
    browser.point_until(".lab-next", ".lab-legend", &format!("with {named}"));
    browser.click(".lab-next");
    browser.says(".lab-floor-reached", "nothing but noise");
    println!("from `palpate serve --demo` to {named} in {:.1} s", begun.elapsed().as_secs_f64());
    let fell = browser.text(".lab-guide");
    assert!(fell.contains("The error fell from") && fell.contains(&named), "{fell}");
    browser.click(".lab-reveal");
    browser.says(".lab-practice", &named);
    let truth = answer(server.folder.path(), &["hide", "--open", "palpate-demo", "--json"]);
    assert_eq!(truth["effects"][0]["effect"], *named);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn a_hidden_effect_is_added_from_the_candidates_and_taken_out_again() {
    let server = practice("coulomb-friction", "3");
    let browser = opened(&server);
    browser.click(".lab-fit");
    browser.click(".lab-diagnose");
    let friction = ".lab-candidate[data-effect=coulomb-friction]";
    browser.point(friction);
    browser.says(".lab-legend", "with coulomb-friction");
    // As long as the pointer is there, whichever trace is drawn: the legend is made anew with it.
    let _ = browser.script(
        "document.querySelectorAll('.lab-legend > *').forEach((key) => (key.dataset.before = ''))",
    );
    browser.press(']');
    browser.until(
        "the forecast of the next trace",
        "[...document.querySelectorAll('.lab-legend > :not([data-before])')].some((key) => key.textContent.includes('with coulomb-friction'))",
    );
    let formula =
        browser.script("return document.querySelector('.lab-model .lab-formula').innerHTML");
    let formula = formula.as_str().unwrap();
    assert!(
        formula.contains("x<sup>q + 1</sup>") && formula.contains("c<sub>0</sub>"),
        "{formula}"
    );
    browser.click(&format!("{friction} .lab-add"));
    browser.says(".lab-floor-reached", "nothing but noise");
    assert_eq!(browser.count(".lab-bar-fitted"), 2);
    browser.click(".lab-undo");
    browser.until(
        "the ladder is short again",
        "document.querySelectorAll('.lab-bar-fitted').length === 1",
    );
    // Everything at once, in the background.
    browser.click(".lab-explore");
    browser.says(".lab-floor-reached", "nothing but noise");
    browser.click(".lab-save");
    browser.says(".lab-save", "Saved");
    let file = browser.text(".lab-save").replace("Saved: ", "");
    assert!(server.folder.path().join(&file).is_file(), "{file}");
    browser.click(".lab-drop");
    browser.says(".lab-rungs", "coulomb-friction taken out");
    assert_eq!(browser.count(".lab-floor-reached"), 0);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn a_typing_error_in_a_law_of_ones_own_is_shown_in_place_and_the_law_can_be_mended() {
    let server = practice("adhesion", "3");
    let browser = opened(&server);
    browser.click(".lab-fit");
    browser.write("#lab-expression", "k * tanh(vv / w)");
    browser.says(".lab-fault", "^^");
    browser.says(".lab-fault", "vv");
    let is_off = "document.querySelector('.lab-law button[type=submit]').disabled";
    browser.until("it cannot be added", is_off);
    browser.write("#lab-expression", "k * tanh(v / w)");
    browser.until("it can be added", &format!("!{is_off}"));
    browser.click(".lab-law button[type=submit]");
    browser.says(".lab-rungs", "mine added");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// Presses Enter on a control and waits for what comes of it; where the keyboard is then.
fn enter(browser: &Browser, control: &str, comes: &str) -> String {
    browser.until(control, &format!("document.querySelector('{control}:enabled') !== null"));
    let _ = browser.script(&format!("document.querySelector('{control}').focus(); return 0"));
    browser.press('\u{e007}');
    browser.until(
        "it is worked on or done",
        &format!("document.querySelector('.lab-busy') !== null || {comes}"),
    );
    browser.until(comes, &format!("document.querySelector('.lab-busy') === null && {comes}"));
    let held = "const at = document.activeElement; return `${at.tagName} in ${at.closest('section')?.ariaLabel}`";
    browser.script(held).as_str().unwrap().to_owned()
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn the_whole_way_is_gone_by_keyboard_without_losing_the_place() {
    let server = Server::begin(&["--demo"]);
    let browser = opened(&server);
    let next =
        |word: &str| format!("document.querySelector('.lab-next')?.textContent.includes('{word}')");
    let guide = "BUTTON in What to do next";
    browser.says(".lab-next", "Fit fung");
    assert_eq!(enter(&browser, ".lab-next", &next("Diagnose")), guide);
    assert_eq!(enter(&browser, ".lab-next", &next("Add")), guide);
    let done = "document.querySelector('.lab-floor-reached') !== null";
    assert_eq!(enter(&browser, ".lab-next", done), "SECTION in What to do next");
    // Then there is nothing more to undo: the next control of the panel has the keyboard.
    assert_eq!(enter(&browser, ".lab-undo", &next("Diagnose")), "BUTTON in Model");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn the_map_of_failures_is_one_stop_of_the_keyboard_and_is_walked_with_arrows() {
    let server = Server::begin(&["--demo"]);
    let browser = opened(&server);
    go_on(&browser, "Fit fung");
    browser.says(".lab-next", "Diagnose");
    let stops = "return [...document.querySelectorAll('.lab-heatmap button')].filter((b) => b.tabIndex >= 0).length";
    assert_eq!(browser.script(stops), 1);
    let at = "const cell = document.activeElement.closest('td'); return [cell.parentElement.rowIndex, cell.cellIndex]";
    let _ = browser
        .script("document.querySelector('.lab-heatmap button[tabindex=\"0\"]').focus(); return 0");
    let (down, right) = ('\u{e015}', '\u{e014}');
    let first = browser.script(at);
    browser.press(down);
    browser.press(right);
    let moved = browser.script(at);
    let step = |k: usize| moved[k].as_u64().unwrap() - first[k].as_u64().unwrap();
    assert!(step(0) == 1 && step(1) >= 1, "{first} {moved}");
    assert_eq!(browser.script(stops), 1);
    browser.press('\u{e007}');
    browser.until("it went there", "document.querySelector('.lab-trace select').value === '1'");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn nothing_jumps_while_one_goes_the_way() {
    let server = Server::begin(&["--demo"]);
    let browser = opened(&server);
    let _ = browser.script(
        "window.shifts = [];
         new PerformanceObserver((list) => window.shifts.push(...list.getEntries()))
           .observe({ type: 'layout-shift', buffered: true });
         return 0",
    );
    go_on(&browser, "Fit fung");
    go_on(&browser, "Diagnose");
    go_on(&browser, "Add");
    browser.says(".lab-floor-reached", "nothing but noise");
    browser.click(".lab-undo");
    browser.says(".lab-next", "Diagnose");
    std::thread::sleep(Duration::from_secs(1));
    let told = browser.script(
        "return window.shifts.map((shift) => [shift.value, ...shift.sources.map(({ node }) => `${node?.nodeName} ${node?.className}`)])",
    );
    let shifts = told.as_array().unwrap();
    let sum: f64 = shifts.iter().map(|shift| shift[0].as_f64().unwrap()).sum();
    assert!(sum < 0.1, "{sum}: {told}");
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn all_traces_stand_side_by_side_or_lie_over_each_other() {
    let server = practice("adhesion", "3");
    let browser = opened(&server);
    browser.says(".lab-all summary", "All traces");
    browser.click(".lab-all summary");
    browser.until("ten pictures", "document.querySelectorAll('.lab-small button').length === 10");
    browser.click(".lab-fit");
    browser.until(
        "the model is in them",
        "document.querySelectorAll('.lab-small .lab-chart-model').length === 10",
    );
    let _ = browser.picture("lab-side");
    let columns = kept(&browser, ".lab-picture", ".lab-data");
    assert_eq!(columns, "time_s,force_N,predicted_N,residual_N");
    // A click opens the trace.
    browser.click(".lab-small button:nth-child(4)");
    browser.until("it is shown", "document.querySelector('.lab-trace select').value === '3'");
    let choose = |of: &str, value: &str| {
        let _ = browser.script(&format!(
            "const select = document.querySelector('.lab-all select[data-of={of}]'); select.value = '{value}';
             select.dispatchEvent(new Event('change')); return 0"
        ));
    };
    choose("what", "residual");
    browser.until(
        "residuals with the noise",
        "document.querySelectorAll('.lab-small .lab-chart-noise').length === 20",
    );
    choose("layout", "over");
    browser.until(
        "one picture of ten lines",
        "document.querySelectorAll('.lab-all .lab-chart-line').length === 10",
    );
    let _ = browser.picture("lab-over");
    assert_eq!(browser.count(".lab-over li"), 10);
    // In a narrow window figures are drawn anew, not shrunk.
    browser.resize(390, HEIGHT);
    browser.until(
        "letters keep their size",
        "[...document.querySelectorAll('.lab-all .lab-chart text, .lab-against .lab-chart text')]
             .every((text) => text.getBoundingClientRect().height > 11)",
    );
    browser.fits("the Lab");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// Drops files, by name and text, on the room.
fn drop_files(browser: &Browser, files: &[(&str, &str)]) {
    let all = serde_json::to_string(files).unwrap();
    let _ = browser.script(&format!(
        "const data = new DataTransfer();
         for (const [name, text] of {all}) data.items.add(new File([text], name));
         document.querySelector('.lab').dispatchEvent(new DragEvent('drop', {{ dataTransfer: data, bubbles: true, cancelable: true }}));
         return 0"
    ));
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn files_are_dropped_on_the_room_and_a_foreign_one_is_imported_with_its_mapping() {
    let server = practice("adhesion", "3");
    let browser = opened(&server);
    browser.says(".lab-bench", "10 of 10 traces");
    let press = std::fs::read_to_string(bundled("press.csv")).unwrap();
    drop_files(&browser, &[("press.csv", &press)]);
    browser.says(".lab-bench", "1 of 1 trace");
    browser.says(".lab-trace", "press.csv");
    let rows = (0..40).map(|k| format!("{},{};{},5\n", k / 10, k % 10, k));
    let foreign = format!("Zeit;Kraft\ns;N\n{}", rows.collect::<String>());
    drop_files(&browser, &[("lab.txt", &foreign)]);
    browser.says(".lab-foreign", "a file of another program");
    browser.click(".lab-preview");
    browser.says(".lab-foreign table", "time_s");
    let _ = browser.picture("lab-foreign");
    let text = "document.querySelector('.lab-foreign textarea')";
    let proposal = browser.script(&format!("return {text}.value"));
    let _ = browser.script(&format!("{text}.value = 'palpate-map = 1\\nwhat = 3'; return 0"));
    browser.click(".lab-import");
    browser.says(".lab-fault", "what");
    let _ = browser.script(&format!("{text}.value = {proposal}; return 0"));
    browser.click(".lab-import");
    browser.says(".lab-trace", "lab.trace.csv");
    assert_eq!(browser.count(".lab-foreign"), 0);
    assert!(server.folder.path().join("set/dropped-2/foreign/lab.map.toml").is_file());
}

/// Six recordings of a drive with teeth, an effect that the library lacks.
fn geared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("geared")).unwrap();
    let press = std::fs::read_to_string(workspace().join("tests/discover/press.toml")).unwrap();
    let law = workspace().join("tests/discover/geared.toml").display().to_string();
    for depth in ["4", "8", "12"] {
        for speed in ["5", "20"] {
            let motion = press.replace("DEPTH", depth).replace("SPEED", speed);
            std::fs::write(folder.path().join("motion.toml"), motion).unwrap();
            let out = format!("geared/{depth}-mm-at-{speed}.csv");
            let seed = format!("{depth}{speed}");
            let made = palpate()
                .args(["simulate", &law, "--motion", "motion.toml", "--noise", "0.02"])
                .args(["--seed", &seed, "-o", &out])
                .current_dir(folder.path())
                .output()
                .unwrap();
            assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
        }
    }
    folder
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn a_formula_for_what_the_library_lacks_is_found_added_and_the_error_falls() {
    let server = Server::begin_in(geared(), &["geared"]);
    let browser = opened(&server);
    for button in ["Fit fung", "Diagnose", "Look for a formula"] {
        go_on(&browser, button);
    }
    browser.says(".lab-formula", "found-1");
    assert!(browser.text(".lab-formula").contains("Can come from"));
    let _ = browser.script("document.querySelectorAll('.lab-formula details').forEach((d) => (d.open = true)); return 0");
    browser.until("a surface is drawn", "document.querySelectorAll('.lab-surface').length > 10");
    assert_eq!(axe(&browser), Vec::<String>::new());
    for width in [390, 1440] {
        let _ = browser.whole_picture(&format!("lab-discovery-{width}"), width);
        browser.fits("the Lab");
    }
    browser.resize(WIDTH, HEIGHT);
    go_on(&browser, "Add found-1");
    browser.says(".lab-rungs", "found-1 added");
    browser.says(".lab-floor-reached", "nothing but noise");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn the_motion_that_decides_is_drawn_and_saved() {
    let folder = tempfile::tempdir().unwrap();
    let hide =
        ["hide", "elastic-stiffening", "--seed", "2", "--size", "0.3", "-o", "set", "--json"];
    answer(folder.path(), &hide);
    let server = Server::begin_in(folder, &["set"]);
    let browser = opened(&server);
    browser.says(".lab-traces", "10 of 10 traces");
    browser.click(".lab-traces summary");
    for k in 4..=10 {
        browser.click(&format!(".lab-traces li:nth-child({k}) input"));
    }
    // What was ticked stays when the panel is drawn anew.
    let _ = browser.script(
        "const select = [...document.querySelectorAll('.lab-field')].find((of) => of.innerText.startsWith('Where contact')).lastChild;
         select.dispatchEvent(new Event('change')); return 0",
    );
    browser.click(".lab-take");
    browser.says(".lab-traces", "3 of 10 traces");
    go_on(&browser, "Fit fung");
    go_on(&browser, "Diagnose");
    browser.click(".lab-next-motion");
    browser.says(".lab-motion", "Save next-motion.csv");
    assert_eq!(browser.count(".lab-motion .lab-chart"), 3);
    assert_eq!(axe(&browser), Vec::<String>::new());
    let _ = browser.whole_picture("lab-motion", 1440);
    browser.resize(WIDTH, HEIGHT);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn a_group_of_a_survey_is_one_click_away() {
    let folder = tempfile::tempdir().unwrap();
    for finger in ["thumb", "index", "little"] {
        let own = folder.path().join("lab").join(finger);
        std::fs::create_dir_all(&own).unwrap();
        std::fs::copy(bundled("press.csv"), own.join("press.csv")).unwrap();
    }
    answer(
        folder.path(),
        &["survey", "fit", "fung", "lab", "--by", "folder", "-o", "results", "--json"],
    );
    let server = Server::begin_in(folder, &["."]);
    let browser = opened(&server);
    browser.click(".lab-survey-open");
    browser.says(".lab-survey", "3 groups by folder");
    browser.write(".lab-survey input[type=search]", "little\n");
    browser.says(".lab-survey caption", "1 of 3");
    assert_eq!(axe(&browser), Vec::<String>::new());
    let _ = browser.whole_picture("lab-survey", 1440);
    browser.resize(WIDTH, HEIGHT);
    browser.click(".lab-group");
    browser.says(".lab-bench", "results-group-");
    browser.says(".lab-guide", "1 trace of force_N");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}
