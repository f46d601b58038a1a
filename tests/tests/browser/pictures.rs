//! Every room and a report as pictures, in `target/browser/`, at the widths of a phone, a tablet, a desk and a wall, light and
//! dark. `cargo xtask pictures` puts those of the docs into their place.

use std::time::Duration;

use palpate_tests::browser::Browser;
use palpate_tests::server::Server;
use palpate_tests::{answer, bundled, workspace};
use serde_json::Value;

use crate::axe::axe;
use crate::{HEIGHT, WIDTH, opened};

const WIDTHS: [u32; 4] = [390, 1024, 1440, 2560];

/// Texts that are cut off without a sign of it.
const TORN: &str = r"
  const found = [];
  for (const e of document.querySelectorAll('button,h1,h2,h3,th,td,dt,dd,p,li,summary,figcaption,select')) {
    if (!e.checkVisibility() || e.closest('.spoken,.skip')) continue;
    const style = getComputedStyle(e);
    if (style.overflowX === 'visible' || style.textOverflow === 'ellipsis') continue;
    if (e.scrollWidth > e.clientWidth + 1 && !['auto', 'scroll'].includes(style.overflowX)) found.push(`cut off: ${e.outerHTML.slice(0, 100)}`);
  }
  return found";

pub(super) fn words(found: &Value) -> Vec<String> {
    let words = found.as_array().expect("a list").iter();
    words.map(|text| text.as_str().unwrap_or_default().to_owned()).collect()
}

fn theme(browser: &Browser, theme: &str) {
    if browser.script("return document.documentElement.dataset.theme ?? 'light'") != theme {
        let _ = browser.script("document.querySelector('#theme').click(); return 0");
    }
}

/// Pictures at all widths in both themes, and what is wrong in them.
fn looked_at(browser: &Browser, name: &str) -> Vec<String> {
    let mut wrong = Vec::new();
    for colours in ["light", "dark"] {
        theme(browser, colours);
        for width in WIDTHS {
            let _ = browser.whole_picture(&format!("{name}-{width}-{colours}"), width);
            browser.fits(&format!("{name} at {width}"));
            let torn = words(&browser.script(TORN));
            wrong.extend(torn.iter().map(|text| format!("{name} at {width}: {text}")));
        }
        browser.resize(WIDTH, HEIGHT);
        wrong.extend(axe(browser).iter().map(|text| format!("{name}, {colours}: {text}")));
    }
    wrong
}

/// Puts a picture into the docs where that is wanted.
fn for_docs(browser: &Browser, name: &str) {
    let file = browser.picture(name);
    if std::env::var_os("PALPATE_PICTURES").is_some() {
        std::fs::copy(file, workspace().join(format!("docs/{name}.png"))).expect("it is put there");
    }
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn no_room_is_torn_at_any_width_in_any_theme() {
    let server = Server::begin(&["--demo"]);
    let browser = opened(&server);
    let mut wrong = looked_at(&browser, "lab-new");
    theme(&browser, "light");
    browser.click(".lab-fit");
    browser.click(".lab-diagnose");
    browser.says(".lab-missing", "named");
    browser.says(".lab-closer", "Spectrum of what is left");
    wrong.extend(looked_at(&browser, "lab-whole"));
    theme(&browser, "light");
    // The Lab of the README, with what the first candidate would change laid over.
    browser.resize(1440, 1800);
    // The pointer may be there already.
    browser.point("h1");
    browser.point(".lab-next");
    browser.says(".lab-legend", "predicted");
    for_docs(&browser, "page-lab");
    browser.click(".lab-next");
    browser.says(".lab-floor-reached", "nothing but noise");
    wrong.extend(looked_at(&browser, "lab-done"));
    theme(&browser, "light");
    for (key, room, there) in [
        (
            '1',
            "live",
            "document.querySelector('.gauge .reading')?.innerText.includes('settles at')",
        ),
        ('3', "device", "document.querySelector('[aria-label=Settings] input') !== null"),
    ] {
        browser.press(key);
        browser.until("the room is open", there);
        wrong.extend(looked_at(&browser, &format!("{room}-whole")));
        theme(&browser, "light");
    }
    assert_eq!(wrong, Vec::<String>::new());
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// What a picture of a moving page shows of a press.
const OF_A_PRESS: Duration = Duration::from_secs(5);

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn a_replayed_press_in_the_live_room_is_pictured() {
    let press = bundled("press.csv").display().to_string();
    let server = Server::begin(&["--replay", &press]);
    let browser = opened(&server);
    browser.resize(1440, 900);
    browser.says(".gauge .reading", "EF");
    std::thread::sleep(OF_A_PRESS);
    for_docs(&browser, "page-live");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn a_hand_is_pictured_and_torn_at_no_width() {
    let server = Server::begin(&["--simulate", "--fingers", "3"]);
    let browser = opened(&server);
    browser.resize(1440, 900);
    browser.says(".finger:last-child .tip-regions", "1 CD");
    std::thread::sleep(OF_A_PRESS);
    for_docs(&browser, "page-hand");
    assert_eq!(looked_at(&browser, "hand"), Vec::<String>::new());
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn no_report_is_torn_at_any_width_in_any_theme() {
    let folder = tempfile::tempdir().unwrap();
    let call = |arguments: &[&str]| drop(answer(folder.path(), arguments));
    call(&["hide", "adhesion", "--seed", "3", "-o", "set", "--json"]);
    call(&["fit", "fung", "set", "-o", "model.toml", "--report", "fit.html", "--json"]);
    call(&["compare", "model.toml", "set", "--report", "compare.html", "--json"]);
    call(&["diagnose", "--model", "model.toml", "set", "--report", "diagnose.html", "--json"]);
    let hold = bundled("table-3.1-row-01.csv").display().to_string();
    call(&["relaxation", &hold, "--report", "relaxation.html", "--json"]);
    let mut wrong = Vec::new();
    for report in ["fit", "compare", "diagnose", "relaxation"] {
        let file = folder.path().join(format!("{report}.html"));
        let browser = Browser::open(&format!("file://{}", file.display()), WIDTH, HEIGHT);
        wrong.extend(looked_at(&browser, report));
        assert_eq!(browser.complaints(), Vec::<String>::new());
    }
    assert_eq!(wrong, Vec::<String>::new());
}
