//! The local page as its user sees and handles it, in a real browser: `cargo xtask browser`.
#![cfg(unix)]

use std::time::{Duration, Instant};

use palpate_tests::browser::Browser;
#[cfg(target_os = "linux")]
use palpate_tests::server::memory_mb;
use palpate_tests::server::{Server, simulate};
use palpate_tests::{answer, bundled};
use serde_json::Value;

/// A window as on a desk.
const WIDTH: u32 = 1280;
const HEIGHT: u32 = 900;

/// The page, once it knows its rooms: before, it does not hear their keys.
fn opened(server: &Server) -> Browser {
    let browser = Browser::open(&server.url(), WIDTH, HEIGHT);
    browser.until("a room is open", "document.querySelector('#rooms [aria-current]') !== null");
    browser
}

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
    browser.point(".lab-next");
    browser.says(".lab-legend", &format!("with {named}"));
    browser.click(".lab-next");
    browser.says(".lab-floor-reached", "nothing but noise");
    assert!(begun.elapsed() < Duration::from_secs(120), "{:?}", begun.elapsed());
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

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn a_replayed_press_is_drawn_and_can_be_paused_and_zoomed_into() {
    let press = bundled("press.csv").display().to_string();
    let server = Server::begin(&["--replay", &press, "--speed", "4"]);
    let browser = opened(&server);
    browser.says(".gauge .reading", "µε, settles at");
    browser.says(".health", "replayed");
    assert_eq!(browser.count(".gauge canvas"), 4);
    browser.says(".gauge .reading", "CD");
    browser.click(".live .tools button");
    browser.says(".live .where", "…");
    let seen = |browser: &Browser| {
        let text = browser.text(".live .where");
        let (from, to) = text.trim_end_matches(" s").split_once(" … ").expect("a stretch");
        (from.parse::<f64>().unwrap(), to.parse::<f64>().unwrap())
    };
    let (from, to) = seen(&browser);
    browser.drag(".gauge .u-over", 0.4, 0.6);
    browser.until(
        "it is zoomed",
        &format!("!document.querySelector('.live .where').innerText.startsWith('{from:.2}')"),
    );
    let (closer_from, closer_to) = seen(&browser);
    let share = (closer_to - closer_from) / (to - from);
    assert!((share - 0.2).abs() < 0.02 && closer_from > from && closer_to < to, "{share}");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn unplugging_is_seen_and_heals_without_a_click() {
    let folder = tempfile::tempdir().unwrap();
    let mut device = simulate(folder.path());
    let server = Server::begin_in(folder, &["--port", "fingertip"]);
    let browser = opened(&server);
    browser.says(".health .state", "Streaming");
    device.kill().unwrap();
    device.wait().unwrap();
    browser.says(".health .state", "The device is gone");
    let mut device = simulate(server.folder.path());
    browser.says(".health .state", "Streaming");
    let rows = "Number([...document.querySelectorAll('.health dt')].find(t => t.textContent === 'rows').nextSibling.textContent.replaceAll(',', ''))";
    let before = browser.script(&format!("return {rows}"));
    browser.until("rows come again", &format!("{rows} > {before} + 500"));
    device.kill().unwrap();
    device.wait().unwrap();
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn a_tab_that_stops_reading_is_told_what_it_was_not_shown_and_sees_it_afterwards() {
    let server = Server::simulated();
    let browser = opened(&server);
    browser.says(".health", "not shown in time");
    let _ = browser.script("const begun = Date.now(); while (Date.now() - begun < 4000); return 0");
    let missed = "(cell => cell && Number(cell.textContent.split(' ')[0]) > 20)([...document.querySelectorAll('.health dt')].find(t => t.textContent === 'not shown in time')?.nextSibling)";
    browser.until("frames were dropped", missed);
    browser.says(".health", "rows lost\n0");
    // Nothing is missing in the session: the stretch before is drawn from there.
    browser.click(".live .tools button");
    let view = server.get("/api/live/view?from=0&to=1e6&bins=5000");
    let (count, times) = (view.numbers(0, 1)[0] as usize, 16);
    let times = view.numbers(times, count);
    assert!(times.windows(2).all(|pair| pair[1] - pair[0] < 0.05), "the session has no hole");
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn a_gauge_is_calibrated_step_by_step_and_the_device_tests_itself() {
    let server = Server::simulated();
    let browser = opened(&server);
    browser.press('2');
    let step = "[aria-label=Calibration] .device-main";
    browser.click(step);
    browser.says("[aria-label=Calibration]", "Take everything off");
    browser.click(".device-read");
    browser.says("[aria-label=Calibration]", "Put a known load on");
    browser.write("[aria-label=Calibration] .fields input", "300");
    browser.click(".device-read");
    let readings = "document.querySelectorAll('[aria-label=Calibration] tbody tr').length";
    browser.until("both readings are there", &format!("{readings} === 2"));
    browser.click(&format!("{step}:not(.device-read)"));
    browser.says("[aria-label=Calibration]", "Nothing has been written to the device yet");
    browser.click(step);
    browser.says("[aria-label=Calibration]", "Gain and offset are set and saved");
    browser.click("[aria-label=Self-test] .device-main");
    browser.says("[aria-label=Self-test]", "Passed.");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn the_filter_of_the_device_is_that_of_the_model_in_the_lab() {
    let folder = tempfile::tempdir().unwrap();
    answer(folder.path(), &["hide", "mullins", "--seed", "3", "-o", "set", "--json"]);
    let fit = answer(folder.path(), &["fit", "fung", "set", "-o", "model.toml", "--json"]);
    let server = Server::begin_in(folder, &["set", "--model", "model.toml", "--simulate"]);
    let browser = opened(&server);
    browser.press('3');
    browser.click(".device-from-lab");
    browser.says("[aria-label=Settings]", "The relaxation function of the model is filled in");
    browser.click("[aria-label=Settings] button[value=set]");
    browser.says("[aria-label=Settings]", "palpate device set");
    let command = browser.text("[aria-label=Settings] .answer code");
    let numbers = command.split_once("--filter ").expect("the filter is set").1.split(' ');
    for (name, number) in ["c1", "v1", "c2", "v2"].iter().zip(numbers) {
        let (set, fitted) = (number.parse::<f64>().unwrap(), &fit["parameters"][name]["value"]);
        assert!((set / fitted.as_f64().unwrap() - 1.0).abs() < 1e-5, "{name}: {set}, {fitted}");
    }
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// The part of values that is not greater.
#[cfg(target_os = "linux")]
fn quantile(values: &[f64], part: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[(part * (sorted.len() - 1) as f64) as usize]
}

/// Times are printed, not tested; `cargo xtask browser` goes on for an hour.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn a_steady_stream_is_shown_without_a_loss_and_in_little_memory() {
    let seconds = std::env::var("PALPATE_STEADY_S").map_or(60, |text| text.parse().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let mut device = simulate(folder.path());
    let server = Server::begin_in(folder, &["--port", "fingertip"]);
    let browser = opened(&server);
    browser.says(".health", "frames/s");
    std::thread::sleep(Duration::from_secs(5));
    let health = "return Object.fromEntries([...document.querySelectorAll('.health dt')].map((t) => [t.textContent, t.nextSibling.textContent]))";
    let count = |text: &Value| text.as_str().unwrap().replace(',', "").parse::<u64>().unwrap();
    let (mut frames, mut delays, mut memory) = (Vec::new(), Vec::new(), Vec::new());
    let (begun, before) = (Instant::now(), browser.script(health));
    let (mut after, mut passed) = (before.clone(), 0.0);
    while begun.elapsed() < Duration::from_secs(seconds) {
        std::thread::sleep(Duration::from_secs(1));
        after = browser.script(health);
        passed = begun.elapsed().as_secs_f64();
        let display = after["display"].as_str().unwrap();
        let mut numbers =
            display.split(|c: char| !c.is_ascii_digit()).filter_map(|n| n.parse::<f64>().ok());
        frames.push(numbers.next().unwrap());
        delays.push(numbers.next().unwrap());
        memory.push(memory_mb(&server, "VmRSS"));
    }
    let rows = count(&after["rows"]) - count(&before["rows"]);
    println!(
        "{passed:.0} s, {rows} rows, lost {}, not shown in time {}; frames/s: median {}, 1 % {}; behind, 99th percentile of \
         each second: median {} ms, in 99 of 100 seconds under {} ms, worst {} ms; memory {:.1} MB at first, {:.1} MB at last, {:.1} MB at most",
        after["rows lost"],
        after["not shown in time"],
        quantile(&frames, 0.5),
        quantile(&frames, 0.01),
        quantile(&delays, 0.5),
        quantile(&delays, 0.99),
        quantile(&delays, 1.0),
        memory[0],
        memory[memory.len() - 1],
        quantile(&memory, 1.0),
    );
    assert_eq!(count(&after["rows lost"]), 0);
    assert!((rows as f64 / passed / 1_000.0 - 1.0).abs() < 0.05, "{rows} rows in {passed} s");
    // The session that can be looked back at takes 6 MB when it is full.
    assert!(memory[memory.len() - 1] - memory[0] < 7.0, "{memory:?}");
    assert_eq!(browser.complaints(), Vec::<String>::new());
    device.kill().unwrap();
    device.wait().unwrap();
}

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
        "live" => browser.says(".gauge .reading", "settles at"),
        _ => browser.until("the room is there", "document.querySelector('#room h2') !== null"),
    }
    let _ = browser
        .script("document.querySelectorAll('details').forEach((d) => (d.open = true)); return 0");
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn every_room_can_be_read_and_handled_in_both_themes_and_in_narrow_windows() {
    let server = Server::begin(&["--demo"]);
    let browser = opened(&server);
    browser.until("there are rooms", "document.querySelectorAll('#rooms a').length > 1");
    let rooms = browser
        .script("return [...document.querySelectorAll('#rooms a')].map((a) => a.dataset.room)");
    let rooms: Vec<&str> =
        rooms.as_array().unwrap().iter().map(|room| room.as_str().unwrap()).collect();
    let mut wrong = Vec::new();
    for room in &rooms {
        filled(&browser, room);
        for theme in ["light", "dark"] {
            if browser.script("return document.documentElement.dataset.theme ?? 'light'") != theme {
                browser.click("#theme");
            }
            let _ = browser.picture(&format!("{room}-{theme}"));
            let faint = browser.script(CONTRAST);
            wrong.extend(
                faint
                    .as_array()
                    .unwrap()
                    .iter()
                    .map(|text| format!("{room}, {theme}, contrast {text}")),
            );
        }
        let nameless = browser.script(NAMELESS);
        wrong.extend(
            nameless
                .as_array()
                .unwrap()
                .iter()
                .map(|text| format!("{room}, without a name: {text}")),
        );
        browser.resize(420, 900);
        let wide = browser.script("return document.scrollingElement.scrollWidth - innerWidth");
        if wide.as_f64().unwrap() > 0.0 {
            wrong.push(format!("{room} is {wide} px too wide for a narrow window"));
        }
        let _ = browser.picture(&format!("{room}-narrow"));
        browser.resize(WIDTH, HEIGHT);
    }
    assert_eq!(wrong, Vec::<String>::new());
    assert_eq!(browser.complaints(), Vec::<String>::new());
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
