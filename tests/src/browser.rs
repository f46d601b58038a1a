//! A browser that does what its user does: looks, points, clicks, types.
//!
//! Chromium is driven by chromedriver; `cargo xtask browser` installs both. What cannot be done fails the test that asks
//! for it, with what the page showed.
#![allow(clippy::missing_panics_doc)]

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use fantoccini::actions::{InputSource, KeyAction, KeyActions, MouseActions, PointerAction};
use fantoccini::elements::Element;
use fantoccini::wd::PrintConfiguration;
use fantoccini::{Client, ClientBuilder, Locator};
use hyper_util::client::legacy::connect::HttpConnector;
use serde_json::{Value, json};
use tokio::runtime::Runtime;

use crate::workspace;

/// The program that drives the browser; Debian has it in `chromium-driver`.
pub const DRIVER: &str = "chromedriver";
/// How long anything may take to appear.
const PATIENCE: Duration = Duration::from_secs(180);
const LOOK: Duration = Duration::from_millis(50);

/// A window with a page in it.
pub struct Browser {
    runtime: Runtime,
    client: Client,
    driver: Child,
    _profile: tempfile::TempDir,
}

/// How often the driver is started until it says its port.
const STARTS: u32 = 5;

/// Starts the driver; none where it ends at once. The port that it takes on IPv4 may be another program's on IPv6, and then it gives up.
fn drive() -> Option<(Child, String)> {
    let mut driver = Command::new(DRIVER)
        .arg("--port=0")
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("chromedriver is there: cargo xtask browser installs it");
    let mut lines = BufReader::new(driver.stdout.take().expect("it is piped")).lines();
    let port = lines.find_map(|line| {
        let line = line.ok()?;
        let (_, port) = line.split_once("started successfully on port ")?;
        Some(port.trim_end_matches('.').to_owned())
    });
    let Some(port) = port else {
        let _ = driver.wait();
        return None;
    };
    // What it says later is read, so that it does not wait for a reader.
    std::thread::spawn(move || lines.for_each(drop));
    Some((driver, port))
}

impl Browser {
    /// Opens an address in a window of this size, px.
    #[must_use]
    pub fn open(url: &str, width: u32, height: u32) -> Self {
        let profile = tempfile::tempdir().expect("a folder for the browser");
        let (driver, port) = (0..STARTS).find_map(|_| drive()).expect("chromedriver says its port");
        let options = json!({
            "browserName": "chrome",
            "goog:chromeOptions": { "args": [
                "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
                "--disable-background-networking", "--disable-component-update", "--disable-sync",
                "--hide-scrollbars", "--disable-dev-shm-usage",
                format!("--user-data-dir={}", profile.path().display()),
                format!("--window-size={width},{height}"),
            ] },
            "goog:loggingPrefs": { "browser": "ALL" },
            // A script may wait for something as long as a test does.
            "timeouts": { "script": PATIENCE.as_millis(), "pageLoad": PATIENCE.as_millis() },
        });
        let Value::Object(capabilities) = options else { unreachable!("it is an object") };
        let runtime =
            tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
        let client = runtime.block_on(async {
            let mut builder = ClientBuilder::new(HttpConnector::new());
            let client = builder.capabilities(capabilities);
            client.connect(&format!("http://127.0.0.1:{port}")).await.expect("Chromium starts")
        });
        let browser = Self { runtime, client, driver, _profile: profile };
        browser.go(url);
        browser
    }

    /// Opens an address.
    pub fn go(&self, url: &str) {
        self.runtime.block_on(self.client.goto(url)).expect("the page opens");
    }

    /// What a script gives, run as the body of a function.
    #[must_use]
    pub fn script(&self, body: &str) -> Value {
        let outcome = self.runtime.block_on(self.client.execute(body, Vec::new()));
        outcome.unwrap_or_else(|error| panic!("{body}: {error}"))
    }

    /// What an asynchronous script gives, run as the body of a function.
    #[must_use]
    pub fn later(&self, body: &str) -> Value {
        let script = format!(
            "const done = arguments[arguments.length - 1]; (async () => {{ {body} }})().then(done, (e) => done({{ failed: String(e) }}))"
        );
        let outcome = self.runtime.block_on(self.client.execute_async(&script, Vec::new()));
        let value = outcome.unwrap_or_else(|error| panic!("{body}: {error}"));
        assert!(value.get("failed").is_none(), "{body}: {value}");
        value
    }

    /// Waits until a script gives `true`.
    pub fn until(&self, what: &str, condition: &str) {
        self.until_so(what, || self.script(&format!("return {condition}")) == true);
    }

    /// Waits until it is so.
    pub fn until_so(&self, what: &str, mut is_so: impl FnMut() -> bool) {
        let begun = Instant::now();
        while !is_so() {
            if begun.elapsed() > PATIENCE {
                // Tests run beside each other: each has a thread of its name.
                let test = std::thread::current().name().unwrap_or("a test").replace("::", "-");
                let file = self.picture(&format!("failed-{test}"));
                let text = self.script("return document.body.innerText");
                panic!(
                    "it never came to this: {what}; see {}; the page said {text}",
                    file.display()
                );
            }
            std::thread::sleep(LOOK);
        }
    }

    /// The one element of a selector that can be seen.
    fn element(&self, css: &str) -> Element {
        self.until_so(css, || {
            self.runtime.block_on(async {
                let Ok(element) = self.client.find(Locator::Css(css)).await else { return false };
                element.is_displayed().await.unwrap_or(false)
            })
        });
        self.runtime.block_on(self.client.find(Locator::Css(css))).expect("it was there")
    }

    /// What is written in an element.
    #[must_use]
    pub fn text(&self, css: &str) -> String {
        self.element(css);
        let text = self.script(&format!("return document.querySelector({}).innerText", json!(css)));
        text.as_str().unwrap_or_default().to_owned()
    }

    /// Waits until an element says this.
    pub fn says(&self, css: &str, words: &str) {
        let condition = format!(
            "(document.querySelector({})?.innerText ?? '').includes({})",
            json!(css),
            json!(words)
        );
        self.until(&format!("{css} says {words:?}"), &condition);
    }

    /// Clicks an element as soon as another says this. The page itself looks: what passes within a second may be over before the
    /// driver has asked twice.
    pub fn click_when(&self, click: &str, css: &str, words: &str) {
        let _ = self.later(&format!(
            "const says = () => (document.querySelector({css})?.innerText ?? '').includes({words});
             await new Promise((done) => {{
               const look = () => says() && (watch.disconnect(), done());
               const watch = new MutationObserver(look);
               watch.observe(document.body, {{ subtree: true, childList: true, characterData: true }});
               look();
             }});
             document.querySelector({click}).click();
             return null",
            css = json!(css),
            words = json!(words),
            click = json!(click),
        ));
    }

    /// How many elements there are.
    #[must_use]
    pub fn count(&self, css: &str) -> u64 {
        let count =
            self.script(&format!("return document.querySelectorAll({}).length", json!(css)));
        count.as_u64().unwrap_or_default()
    }

    /// Clicks with the mouse, when the element can be clicked.
    pub fn click(&self, css: &str) {
        self.until_so(&format!("a click on {css}"), || {
            // An element that was drawn anew in between is looked for again.
            self.runtime.block_on(async {
                match self.client.find(Locator::Css(css)).await {
                    Ok(element) => {
                        element.is_enabled().await.unwrap_or(false) && element.click().await.is_ok()
                    }
                    Err(_) => false,
                }
            })
        });
    }

    /// Puts the pointer over an element.
    pub fn point(&self, css: &str) {
        let element = self.element(css);
        let mouse = MouseActions::new("mouse".into()).then(PointerAction::MoveToElement {
            element,
            duration: None,
            x: 0.0,
            y: 0.0,
        });
        self.runtime.block_on(self.client.perform_actions(mouse)).expect("the pointer moves");
    }

    /// Points at an element, and again where it has moved since, until another says these words.
    pub fn point_until(&self, at: &str, css: &str, words: &str) {
        self.until_so(&format!("{css} says {words:?}"), || {
            self.point(at);
            self.text(css).contains(words)
        });
    }

    /// Drags over an element, from one part of its width to another.
    pub fn drag(&self, css: &str, from: f64, to: f64) {
        let element = self.element(css);
        let (_, _, width, _) = self.runtime.block_on(element.rectangle()).expect("it has a size");
        let at = |part: f64| PointerAction::MoveToElement {
            element: element.clone(),
            duration: Some(Duration::from_millis(100)),
            x: (part - 0.5) * width,
            y: 0.0,
        };
        let mouse = MouseActions::new("mouse".into())
            .then(at(from))
            .then(PointerAction::Down { button: 0 })
            .then(at(to))
            .then(PointerAction::Up { button: 0 });
        self.runtime.block_on(self.client.perform_actions(mouse)).expect("the pointer drags");
    }

    /// Types into a field instead of what is there.
    pub fn write(&self, css: &str, text: &str) {
        let element = self.element(css);
        self.runtime.block_on(async {
            element.clear().await.expect("it can be emptied");
            element.send_keys(text).await.expect("it can be written into");
        });
    }

    /// Presses a key, wherever the focus is.
    pub fn press(&self, key: char) {
        let stroke = KeyActions::new("keys".into())
            .then(KeyAction::Down { value: key })
            .then(KeyAction::Up { value: key });
        self.runtime.block_on(self.client.perform_actions(stroke)).expect("the key is pressed");
    }

    /// Makes the window so large, px.
    pub fn resize(&self, width: u32, height: u32) {
        let resized = self.client.set_window_size(width, height);
        self.runtime.block_on(resized).expect("the window has a size");
    }

    /// Waits until the page is no wider than its window.
    pub fn fits(&self, what: &str) {
        let condition = "(({ scrollWidth, clientWidth }) => scrollWidth <= clientWidth)(document.scrollingElement)";
        self.until(&format!("{what} is no wider than its window"), condition);
    }

    /// Keeps a picture of the window in `target/browser/`.
    #[must_use]
    pub fn picture(&self, name: &str) -> PathBuf {
        let folder = workspace().join("target/browser");
        let file = folder.join(format!("{name}.png"));
        let png = self.runtime.block_on(self.client.screenshot()).expect("a picture");
        std::fs::create_dir_all(&folder).expect("a folder for pictures");
        std::fs::write(&file, png).expect("a picture can be kept");
        file
    }

    /// Keeps a picture of the whole page in a window of this width, px, however far it would have to be scrolled.
    #[must_use]
    pub fn whole_picture(&self, name: &str, width: u32) -> PathBuf {
        self.resize(width, 900);
        self.settled();
        let high = self.script(
            "return document.scrollingElement.scrollHeight + outerHeight - innerHeight + 8",
        );
        self.resize(width, high.as_u64().and_then(|high| u32::try_from(high).ok()).unwrap_or(900));
        self.settled();
        self.picture(name)
    }

    /// Waits until what was asked of the page is laid out and drawn.
    fn settled(&self) {
        let _ = self.later(
            "await new Promise((done) => setTimeout(done, 300));
             await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
             return true",
        );
    }

    /// How many pages of A4 it is on paper.
    #[must_use]
    pub fn printed_pages(&self) -> usize {
        let paper = PrintConfiguration::default();
        let pdf = self.runtime.block_on(self.client.print(paper)).expect("it can be printed");
        let object = b"/Type /Page\n";
        pdf.windows(object.len()).filter(|bytes| *bytes == object).count()
    }

    /// Errors and warnings that the browser's console was told.
    #[must_use]
    pub fn complaints(&self) -> Vec<String> {
        let told = self.runtime.block_on(self.client.issue_cmd(log::Take)).expect("a log");
        let entries = told.as_array().cloned().unwrap_or_default();
        let grave = |entry: &&Value| matches!(entry["level"].as_str(), Some("SEVERE" | "WARNING"));
        entries.iter().filter(grave).map(|entry| entry["message"].to_string()).collect()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Whatever is left of it ends with the driver.
        let _ = self.runtime.block_on(self.client.clone().close());
        let _ = self.driver.kill();
        let _ = self.driver.wait();
    }
}

/// Chromium's own command for the lines of its console.
mod log {
    use fantoccini::wd::WebDriverCompatibleCommand;
    use url::{ParseError, Url};

    #[derive(Debug)]
    pub struct Take;

    impl WebDriverCompatibleCommand for Take {
        fn endpoint(&self, base: &Url, session: Option<&str>) -> Result<Url, ParseError> {
            base.join(&format!("session/{}/se/log", session.unwrap_or_default()))
        }

        fn method_and_body(&self, _: &Url) -> (http::Method, Option<String>) {
            (http::Method::POST, Some(r#"{"type":"browser"}"#.into()))
        }
    }
}
