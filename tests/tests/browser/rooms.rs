//! What every room has: it can be read and handled, in both themes, by keys, in narrow windows.

use palpate_tests::browser::Browser;
use palpate_tests::server::Server;
use serde_json::{Value, json};

use crate::axe::axe;
use crate::{HEIGHT, WIDTH, opened};

/// Text against what is behind it, as WCAG 2.1 counts (1.4.3, level AA); the worst that falls short.
const CONTRAST: &str = r"
  const channel = (c) => ((c /= 255) <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
  const canvas = document.createElement('canvas').getContext('2d', { willReadFrequently: true });
  const rgba = (text) => {
    canvas.clearRect(0, 0, 1, 1);
    canvas.fillStyle = text;
    canvas.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = canvas.getImageData(0, 0, 1, 1).data;
    return [r, g, b, a / 255];
  };
  const over = ([r, g, b, a], [R, G, B]) => [r * a + R * (1 - a), g * a + G * (1 - a), b * a + B * (1 - a), 1];
  const light = ([r, g, b]) => 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b);
  const ground = (element) => {
    const layers = [];
    for (let at = element; at; at = at.parentElement) layers.push(rgba(getComputedStyle(at).backgroundColor));
    return layers.reverse().reduce((below, layer) => over(layer, below), [255, 255, 255, 1]);
  };
  const found = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const element = walker.currentNode.parentElement;
    if (!walker.currentNode.data.trim() || !element.checkVisibility({ opacityProperty: true, visibilityProperty: true })) continue;
    if (element.closest(':disabled,.spoken,.skip,option')) continue;
    const style = getComputedStyle(element);
    const inside = element.closest('svg');
    const behind = ground(element);
    const drawn = over(rgba(inside ? style.fill : style.color), behind);
    const [a, b] = [light(drawn), light(behind)].sort((a, b) => b - a);
    const ratio = (a + 0.05) / (b + 0.05);
    const size = parseFloat(style.fontSize);
    const needed = size >= 24 || (size >= 18.66 && style.fontWeight >= 700) ? 3 : 4.5;
    if (ratio < needed) found.push(`${ratio.toFixed(2)}: ${walker.currentNode.data.trim().slice(0, 40)} <${element.tagName} ${element.className}>`);
  }
  return found;
";

/// What can be handled but has no name that would be spoken, and pictures without words.
const NAMELESS: &str = r"
  const name = (e) => (e.getAttribute('aria-label') ?? '') + (e.innerText ?? '') + [...(e.labels ?? [])].map((l) => l.innerText).join('') + (e.title ?? '');
  const found = [...document.querySelectorAll('button,input,select,textarea,a,summary,[role=img],section,figure svg')];
  return found.filter((e) => e.checkVisibility() && !name(e).trim()).map((e) => e.outerHTML.slice(0, 120));
";

/// How far the page is too wide as soon as its place is narrower, before anything was told of it, px.
const NARROWED: &str = r"
  const width = 420;
  document.body.style.width = `${width}px`;
  const beyond = document.body.scrollWidth - width;
  document.body.style.width = '';
  return beyond;
";

/// Everything that the room can show, at once.
fn filled(browser: &Browser, room: &str) {
    let _ = browser.script(&format!("location.hash = '{room}'; return 0"));
    match room {
        "lab" => {
            if browser.count(".lab-bar-fitted") == 0 {
                browser.click(".lab-fit");
                browser.click(".lab-diagnose");
            }
            browser.says(".lab-missing", "named");
        }
        "hand" => browser.says(".finger:last-child .finger-state", "Streaming"),
        "live" => browser.says(".gauge .reading", "settles at"),
        _ => browser.until("the room is there", "document.querySelector('#room h2') !== null"),
    }
    let _ = browser
        .script("document.querySelectorAll('details').forEach((d) => (d.open = true)); return 0");
}

/// What of these rooms cannot be read or handled, in both themes and in a narrow window.
fn faults(browser: &Browser, rooms: &[&str]) -> Vec<String> {
    let mut wrong = Vec::new();
    let mut add = |about: &str, found: Value| {
        let found: Vec<String> = serde_json::from_value(found).unwrap();
        wrong.extend(found.iter().map(|text| format!("{about}: {text}")));
    };
    for room in rooms {
        filled(browser, room);
        for theme in ["light", "dark"] {
            if browser.script("return document.documentElement.dataset.theme ?? 'light'") != theme {
                browser.click("#theme");
            }
            let _ = browser.picture(&format!("{room}-{theme}"));
            add(&format!("{room}, {theme}, contrast"), browser.script(CONTRAST));
            add(&format!("{room}, {theme}, axe"), json!(axe(browser)));
        }
        add(&format!("{room}, without a name"), browser.script(NAMELESS));
        // The other rooms have columns that only a narrower window puts below each other.
        let stacks = ["live", "hand"].contains(room);
        if stacks && browser.script(NARROWED).as_f64().unwrap() > 0.0 {
            add(room, json!(["too wide until plots have followed a narrower window"]));
        }
        browser.resize(420, 900);
        browser.fits(room);
        let _ = browser.picture(&format!("{room}-narrow"));
        browser.resize(WIDTH, HEIGHT);
    }
    wrong
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn every_room_can_be_read_and_handled_in_both_themes_and_in_narrow_windows() {
    for (source, wanted) in [
        (&["--demo"][..], &["live", "lab", "device"][..]),
        (&["--simulate", "--fingers", "3"], &["hand", "live", "device"]),
    ] {
        let server = Server::begin(source);
        let browser = opened(&server);
        let rooms = browser
            .script("return [...document.querySelectorAll('#rooms a')].map((a) => a.dataset.room)");
        assert_eq!(rooms, json!(wanted));
        assert_eq!(faults(&browser, wanted), Vec::<String>::new());
        assert_eq!(browser.complaints(), Vec::<String>::new());
    }
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn rooms_theme_and_help_are_reached_by_keys() {
    let server = Server::begin(&["--demo"]);
    let browser = opened(&server);
    browser.until("the Lab is open", "document.querySelector('.lab-bench') !== null");
    browser.press('1');
    browser.until("Live is open", "document.querySelector('.gauge') !== null");
    browser.press('t');
    browser.until("it is dark", "document.documentElement.dataset.theme === 'dark'");
    browser.press('?');
    browser.until("keys are shown", "document.getElementById('help').open");
    assert!(browser.text("#keys").contains("light or dark"));
    browser.press('\u{e00c}');
    browser.until("keys are put away", "!document.getElementById('help').open");
    browser.press('2');
    browser.until("the Lab is open", "document.querySelector('.lab-bench') !== null");
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn without_the_token_the_page_says_what_to_do() {
    let server = Server::simulated();
    let browser = Browser::open(&format!("http://{}/", server.host()), WIDTH, HEIGHT);
    browser.says("#room", "Open the address that `palpate serve` printed");
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn a_room_can_be_left_before_its_stream_has_come() {
    let server = Server::simulated();
    let browser = opened(&server);
    let closed = browser.later(
        "const { api } = await import('/api.js');
         let heard = 0;
         for (let times = 0; times < 20; times++) api.socket('/live/stream', () => heard++)();
         await new Promise((resolve) => setTimeout(resolve, 1000));
         return heard",
    );
    assert_eq!(closed, 0);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}
