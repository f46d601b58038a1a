//! The Live room: what a fingertip feels, while it feels it and afterwards.

use std::time::{Duration, Instant};

use palpate::model::{BaseLaw, Model, Separation};
use palpate_tests::browser::Browser;
use palpate_tests::bundled;
#[cfg(target_os = "linux")]
use palpate_tests::server::memory_mb;
use palpate_tests::server::{Server, simulate};
use serde_json::{Value, json};

use crate::opened;
use crate::plots::kept;

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn a_replayed_press_is_drawn_and_can_be_paused_and_zoomed_into() {
    let (_server, browser) = paused_press();
    browser.says(".gauge .reading", "µε, settles at");
    browser.says(".health", "replayed");
    assert_eq!(browser.count(".gauge canvas"), 4);
    let (from, to) = seen(&browser);
    browser.drag(".gauge .u-over", 0.4, 0.6);
    browser.until(
        "it is zoomed",
        &format!("!document.querySelector('.live .where').innerText.startsWith('{from:.2}')"),
    );
    let (closer_from, closer_to) = seen(&browser);
    let share = (closer_to - closer_from) / (to - from);
    assert!((share - 0.2).abs() < 0.02 && closer_from > from && closer_to < to, "{share}");
    let columns = kept(&browser, ".save-picture", ".save-data");
    assert!(columns.starts_with("time_s,gauge1_ustrain,gauge2_ustrain"), "{columns}");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// Rows of a millisecond each, the same in all signals, go into a window of 1 s in 4 bins.
const WINDOW: &str = r"
  const { Window } = await import('/live/window.js');
  const rows = (first, times, value) => ({
    first, count: times.length, times: Float64Array.from(times), gaps: new Float64Array(times.length),
    values: Array.from({ length: 20 }, () => Float32Array.from(times, value)),
  });
  const steps = (from, count) => Array.from({ length: count }, (_, row) => from + row / 1000);
  const seen = new Window(1, 4);
";

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn a_fall_is_drawn_as_it_came_and_the_number_beside_it_is_its_last_value() {
    let server = Server::simulated();
    let browser = opened(&server);
    let drawn = browser.later(&format!(
        "{WINDOW} seen.take(rows(0, steps(0, 900), (t) => -1000 * t));
         return {{ last: seen.value(0), y: [...seen.columns().values[0]] }}"
    ));
    assert_eq!(drawn["last"], -899.0);
    let y: Vec<f64> = drawn["y"].as_array().unwrap().iter().map(|y| y.as_f64().unwrap()).collect();
    assert!(y.len() >= 8 && y.windows(2).all(|pair| pair[0] >= pair[1]), "{y:?}");
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn the_line_breaks_where_nothing_is_known_and_where_the_page_was_sent_nothing() {
    let server = Server::simulated();
    let browser = opened(&server);
    let drawn = browser.later(&format!(
        "{WINDOW} const stopped = rows(100, steps(0.5, 100), () => 2);
         stopped.gaps[0] = 0.401;
         return [stopped, rows(500, steps(0.5, 100), () => 2)].map((later) => {{
           seen.resize(1, 4);
           seen.take(rows(0, steps(0, 100), () => 1));
           seen.take(later);
           const {{ x, breaks }} = seen.columns();
           return breaks.flatMap((point) => [x[point - 1], x[point]]);
         }})"
    ));
    for ends in drawn.as_array().unwrap() {
        assert_eq!(ends, &json!([0.099, 0.5]));
    }
}

/// How many of the columns of px between two times have a coloured line, on the plot of the first gauge. Regions are
/// transparent, axes and the signal itself grey.
fn columns_with_a_line(browser: &Browser, from: f64, to: f64) -> f64 {
    let (first, last) = seen(browser);
    let script = format!(
        "const canvas = document.querySelector('.gauge canvas'), over = document.querySelector('.gauge .u-over');
         const [frame, plot] = [canvas.getBoundingClientRect(), over.getBoundingClientRect()];
         const scale = canvas.width / frame.width;
         const at = (t) => Math.round(scale * (plot.left - frame.left + plot.width * (t - {first}) / ({last} - {first})));
         const [left, right] = [at({from}) + 4, at({to}) - 4];
         const {{ data, width, height }} = canvas.getContext('2d').getImageData(left, 0, right - left, canvas.height);
         let found = 0;
         for (let x = 0; x < width; x++) {{
           for (let y = 0; y < height; y++) {{
             const [r, g, b, opaque] = data.subarray(4 * (y * width + x));
             if (opaque > 120 && Math.max(r, g, b) - Math.min(r, g, b) > 60) {{ found++; break; }}
           }}
         }}
         return found / width"
    );
    browser.script(&script).as_f64().unwrap()
}

/// The stretch that a paused room shows, s.
fn seen(browser: &Browser) -> (f64, f64) {
    let text = browser.text(".live .where");
    let (from, to) = text.trim_end_matches(" s").split_once(" … ").expect("a stretch");
    (from.parse().unwrap(), to.parse().unwrap())
}

/// Rows that the page was told of.
const ROWS: &str = "Number([...document.querySelectorAll('.health dt')].find((term) => term.textContent === 'rows')?.nextSibling.textContent.replaceAll(',', ''))";

/// Waits until the page was told of so many more rows than it knows now.
fn more_rows_come(browser: &Browser, more: u32) {
    browser.until("the device is told of", &format!("{ROWS} >= 0"));
    let before = browser.script(&format!("return {ROWS}"));
    browser.until("rows come", &format!("{ROWS} > {before} + {more}"));
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn no_line_is_drawn_over_the_time_between_two_streams() {
    let server = Server::simulated();
    let browser = opened(&server);
    browser.says(".health .state", "Streaming");
    std::thread::sleep(Duration::from_secs(2));
    assert_eq!(server.wish(&json!("stop")).0, 200);
    std::thread::sleep(Duration::from_secs(3));
    assert_eq!(server.wish(&json!("start")).0, 200);
    std::thread::sleep(Duration::from_secs(2));
    let events = server.json("/api/live/events?from=0&to=1e6");
    let gap = events.as_array().unwrap().iter().find(|event| event["kind"] == "gap").unwrap();
    let [from, to] = ["from_s", "to_s"].map(|end| gap[end].as_f64().unwrap());
    assert!(to - from > 2.5, "{gap}");
    // The last ten seconds, and less of them, in other bins.
    for again in [false, true] {
        if again {
            browser.drag(".gauge .u-over", 0.01, 0.99);
        } else {
            browser.click(".live .tools button");
        }
        browser.says(".live .where", "…");
        std::thread::sleep(Duration::from_millis(500));
        let (first, last) = seen(&browser);
        assert_eq!(columns_with_a_line(&browser, from, to), 0.0);
        assert!(columns_with_a_line(&browser, first.max(from - 1.5), from) > 0.9);
        assert!(columns_with_a_line(&browser, to, last.min(to + 1.5)) > 0.9);
    }
}

/// A bundled press, replayed until region CD is there, and paused.
fn paused_press() -> (Server, Browser) {
    let press = bundled("press.csv").display().to_string();
    let server = Server::begin(&["--replay", &press, "--speed", "2"]);
    let browser = opened(&server);
    browser.click_when(".live .tools button", ".gauge .reading", "CD");
    browser.says(".live .where", "…");
    (server, browser)
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn the_values_under_the_pointer_stand_beside_it_and_differences_from_a_mark() {
    let (_server, browser) = paused_press();
    browser.point(".gauge .u-over");
    browser.says(".plot-reading", "signal");
    let seen = browser.text(".plot-reading");
    assert!(
        ["FA", "SA", "equilibrium", "µε"].into_iter().all(|word| seen.contains(word)),
        "{seen}"
    );
    // What stands there is what is drawn: FA and SA make the signal.
    let value = |name: &str| -> f64 {
        let after = seen.split_once(&format!("{name}\n")).expect(name).1;
        after.split(' ').next().unwrap().replace('−', "-").parse().unwrap()
    };
    assert!((value("FA") + value("SA") - value("signal")).abs() <= 0.11, "{seen}");
    browser.click(".gauge .u-over");
    browser.says(".plot-reading", "Δ 0 s");
    browser.click(".gauge .u-over");
    browser.until(
        "the mark is gone",
        "!document.querySelector('.plot-reading').innerText.includes('Δ')",
    );
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn the_wheel_zooms_about_the_pointer_and_moves_along() {
    let (_server, browser) = paused_press();
    let wheel = |keys: &str, by: i32| {
        let _ = browser.script(&format!(
            "const over = document.querySelector('.gauge .u-over'), place = over.getBoundingClientRect();
             over.dispatchEvent(new WheelEvent('wheel', {{ bubbles: true, cancelable: true, {keys}, deltaY: {by},
               clientX: place.left + place.width / 2, clientY: place.top + place.height / 2 }}));
             return 0"
        ));
    };
    let (from, to) = seen(&browser);
    wheel("ctrlKey: true", -400);
    let (closer_from, closer_to) = seen(&browser);
    let share = (closer_to - closer_from) / (to - from);
    assert!((share - (-1_f64).exp()).abs() < 0.02, "{share}");
    assert!((closer_from + closer_to - from - to).abs() < 0.05 * (to - from));
    // Later, not earlier: the session may have begun just now.
    wheel("shiftKey: true", 200);
    let (later_from, later_to) = seen(&browser);
    assert!(
        later_from > closer_from && (later_to - later_from - closer_to + closer_from).abs() < 0.03
    );
    // Without a key it scrolls the page.
    wheel("altKey: false", -200);
    assert_eq!(seen(&browser), (later_from, later_to));
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
    more_rows_come(&browser, 500);
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
    let holes: Vec<&[f64]> = times.windows(2).filter(|pair| pair[1] - pair[0] >= 0.05).collect();
    assert!(
        holes.is_empty(),
        "the session has holes: {holes:?} of {count} bins to {:?} s",
        times.last()
    );
}

/// The part of values that is not greater.
#[cfg(target_os = "linux")]
fn quantile(values: &[f64], part: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[(part * (sorted.len() - 1) as f64) as usize]
}

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
    // What the page says may be some seconds old on a busy machine.
    let behind = rows as f64 / 1_000.0 - passed;
    assert!(behind.abs() < 5.0 + 0.01 * passed, "{rows} rows in {passed} s");
    // The session that can be looked back at takes 9 MB when it is full.
    assert!(memory[memory.len() - 1] - memory[0] < 10.0, "{memory:?}");
    assert_eq!(browser.complaints(), Vec::<String>::new());
    device.kill().unwrap();
    device.wait().unwrap();
}

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn the_page_says_that_the_model_fails_now_and_that_it_holds() {
    let folder = tempfile::tempdir().unwrap();
    let values = [0.07, 1.0, 0.2472, 0.15, 3.981, 0.5325];
    let law = BaseLaw::fung(2, Separation::Free);
    let model = Model::of(&law, "force_N", &values, &[None; 6]);
    model.write(&folder.path().join("model.toml")).unwrap();
    let server = Server::begin_in(folder, &["--simulate", "--model", "model.toml"]);
    let browser = opened(&server);
    browser.says(".foretold-words", "The model fails now, in region CD, since");
    browser.says(".foretold-law", "model.toml: g(t) = 0.603");
    assert_eq!(browser.count(".foretold canvas"), 1);
    let lit = "[...document.querySelectorAll('.tip-slow')].map((of) => Number(of.getAttribute('fill-opacity')))";
    browser.until("the gauges light up", &format!("Math.max(...{lit}) > 0.5"));
    let _ = browser.picture("live-fails");
    let curve = browser.later(
        "const { foretold } = await import('/live/foretold.js');
         const hold = { gauge: 1, from_s: 1, to_s: 2, level: 10, parts: [[5, 1], [2, 0]] };
         return [0, 1].map((gauge) => foretold(Float64Array.of(0, 1, 2, 3), [hold], gauge))",
    );
    assert_eq!(curve[0], json!([null, null, null, null]));
    assert_eq!((&curve[1][0], &curve[1][3]), (&Value::Null, &Value::Null));
    for (point, value) in [(1, 17.0), (2, 12.0 + 5.0 * (-1_f64).exp())] {
        let drawn = curve[1][point].as_f64().unwrap();
        assert!((drawn - value).abs() < 1e-12, "{curve}");
    }
    assert_eq!(browser.complaints(), Vec::<String>::new());

    let server = Server::simulated();
    let browser = opened(&server);
    browser.says(".foretold-words", "The model holds: what is left is within the noise.");
    browser.says(".foretold-law", "The device's filter: g(t) = 0.485");
}
