//! The fingers of a hand side by side, with the mouse.

use std::time::Instant;

use palpate_tests::server::{PATIENCE, Server};
use serde_json::Value;

use crate::opened;

/// The largest signal of each finger, µε, when it was, and the time now, s.
const PEAKS: &str = r"
  const { api } = await import('/api.js');
  const { readView } = await import('/live/window.js');
  const peaks = [];
  for (const number of [1, 2, 3]) {
    const { count, from, courses } = readView(await api.of(number).bytes('/live/view?from=0&to=1e6&bins=5000'));
    let most = 0;
    for (let bin = 0; bin < count; bin++) if (courses[0][1][bin] > courses[0][1][most]) most = bin;
    peaks.push([courses[0][1][most], from[most], from[count - 1]]);
  }
  return peaks;
";

#[test]
#[ignore = "needs a browser: cargo xtask browser"]
fn the_fingers_of_a_hand_are_shown_side_by_side_and_recorded_together() {
    let server = Server::begin(&["--simulate", "--fingers", "3"]);
    let browser = opened(&server);
    browser.until("three fingers", "document.querySelectorAll('.finger').length === 3");
    for finger in 1..=3 {
        browser.says(&format!(".finger:nth-child({finger}) .finger-state"), " Hz, 0 rows lost");
    }
    // Each presses more gently than the one before: the rows are those of three devices.
    let begun = Instant::now();
    let peaks = loop {
        let peaks = browser.later(PEAKS);
        let over = |peak: &Value| {
            let [most, at, now] = [0, 1, 2].map(|k| peak[k].as_f64().unwrap());
            most > 300.0 && now > at + 1.0
        };
        if peaks.as_array().unwrap().iter().all(over) {
            break peaks;
        }
        assert!(begun.elapsed() < PATIENCE, "no press has passed: {peaks}");
    };
    let strength = |finger: usize| peaks[finger][0].as_f64().unwrap();
    for finger in [1, 2] {
        let gentler = strength(finger) / strength(finger - 1);
        assert!((0.75..0.95).contains(&gentler), "{peaks}");
    }
    browser.click("[aria-label=\"All fingers\"] button:nth-of-type(4)");
    browser.says(".finger:last-child .finger-state", "Recording");
    browser.click("[aria-label=\"All fingers\"] button:nth-of-type(5)");
    browser.says(".hand .answer", "The recording is written: 3 fingers.");
    let files: Vec<_> =
        server.folder.path().read_dir().unwrap().map(|file| file.unwrap().file_name()).collect();
    let [file] = &files[..] else { panic!("{files:?}") };
    assert!(file.to_string_lossy().starts_with("grasp-"), "{files:?}");

    browser.click(".finger:nth-child(2) a");
    browser.says(".gauge .reading", "settles at");
    assert_eq!(browser.script("return document.querySelector('#finger select').value"), "2");
    let port = server.json("/api/fingers/2/live/about")["port"].as_str().unwrap().to_owned();
    let _ = browser.script("location.hash = 'device/2'; return 0");
    browser.says("[aria-label=\"Devices on this computer\"]", &port);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}
