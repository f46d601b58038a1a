//! The Device room: calibration, settings, self-test.

use palpate_tests::answer;
use palpate_tests::server::Server;

use crate::opened;

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
