//! A drawing as PDF, printed by a browser of this computer: with its fonts, as journals ask.

use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::layout::WIDTH;
use super::stack::Sheet;

/// Names a browser that is to print, in place of those that are looked for.
const BROWSER: &str = "PALPATE_BROWSER";
/// Browsers that print without a window, by their names on the path, and where they lie on macOS and Windows.
const BROWSERS: [&str; 9] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "microsoft-edge",
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    r"C:\Program Files\Google\Chrome\Application\chrome.exe",
    r"C:\Program Files (x86)\Microsoft\Edge\Application\msedge.exe",
];
/// Width of a figure on paper, mm: that of a page of text.
const PAPER_MM: f64 = 160.0;
/// A browser that takes longer does not print.
const PRINT_WITHIN: Duration = Duration::from_secs(60);
const LOOK: Duration = Duration::from_millis(20);
/// What the titles of our documents begin with.
const TITLE: &str = "palpate: ";

/// Why there is no PDF.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum PdfError {
    #[error(
        "a PDF needs Chromium, Chrome or Edge to print it, and none was found; name one with {BROWSER}=PROGRAM, or draw an .svg"
    )]
    NoBrowser,
    #[error("{browser} cannot be run: {source}")]
    Run { browser: String, source: io::Error },
    #[error("{browser} did not print within {} s", PRINT_WITHIN.as_secs())]
    Slow { browser: String },
    #[error("{browser} printed nothing: {said}")]
    Nothing { browser: String, said: String },
    #[error("there is no place to print: {0}")]
    Place(#[from] io::Error),
}

/// Prints a sheet on one page of its size.
///
/// # Errors
/// [`PdfError`].
pub fn pdf(sheet: &Sheet) -> Result<Vec<u8>, PdfError> {
    let folder = tempfile::tempdir()?;
    let page = folder.path().join("figure.html");
    std::fs::write(&page, html(sheet))?;
    let named = std::env::var(BROWSER).ok();
    let candidates = named.as_deref().map_or(BROWSERS.to_vec(), |named| vec![named]);
    for browser in candidates.into_iter().filter(|name| named.is_some() || is_there(name)) {
        match printed(browser, folder.path(), &page) {
            Err(PdfError::Run { source, .. })
                if named.is_none() && source.kind() == io::ErrorKind::NotFound => {}
            printed => return printed,
        }
    }
    Err(PdfError::NoBrowser)
}

/// Whether to try a program: one that is named by its place has to be there.
fn is_there(name: &str) -> bool {
    let path = Path::new(name);
    !path.is_absolute() || path.is_file()
}

fn html(Sheet { title, svg, height }: &Sheet) -> String {
    let paper = PAPER_MM * height / WIDTH;
    // A hair more than the figure: a page that is exactly full would be followed by an empty one.
    format!(
        "<!doctype html><html><head><meta charset=\"utf-8\"><meta name=\"color-scheme\" content=\"light\"><title>{TITLE}{title}</title>\
         <style>@page{{size:{PAPER_MM}mm {:.2}mm;margin:0}}body{{margin:0}}svg{{display:block;width:{PAPER_MM}mm;height:{paper:.2}mm}}</style>\
         </head><body>{svg}</body></html>",
        paper + 0.5
    )
}

/// What a browser prints of a page in a folder of its own. A browser that will not run without a sandbox, as for root or in a container,
/// is asked again without: the page is ours, and has no script.
fn printed(browser: &str, folder: &Path, page: &Path) -> Result<Vec<u8>, PdfError> {
    let out = folder.join("figure.pdf");
    let mut said = String::new();
    for more in [&[][..], &["--no-sandbox"]] {
        let child = Command::new(browser)
            .args(["--headless", "--disable-gpu", "--no-first-run", "--no-pdf-header-footer"])
            .args(more)
            .arg(option("--user-data-dir=", &folder.join("profile")))
            .arg(option("--print-to-pdf=", &out))
            .arg(page)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|source| PdfError::Run { browser: browser.into(), source })?;
        said = ended(child, browser)?;
        if let Ok(bytes) = std::fs::read(&out)
            && bytes.starts_with(b"%PDF-")
        {
            return Ok(bytes);
        }
    }
    let said = said.lines().last().unwrap_or("it says nothing").to_owned();
    Err(PdfError::Nothing { browser: browser.into(), said })
}

fn option(name: &str, path: &Path) -> PathBuf {
    let mut option = std::ffi::OsString::from(name);
    option.push(path);
    option.into()
}

/// Waits until a browser has ended, for as long as there is patience: what it said.
fn ended(mut child: Child, browser: &str) -> Result<String, PdfError> {
    let failed = |source| PdfError::Run { browser: browser.into(), source };
    // What it says is read beside, so that it never waits for somebody to read.
    let stderr = child.stderr.take();
    let heard = std::thread::spawn(move || stderr.map(io::read_to_string));
    let begun = Instant::now();
    loop {
        if child.try_wait().map_err(failed)?.is_some() {
            return Ok(heard.join().ok().flatten().and_then(Result::ok).unwrap_or_default());
        }
        if begun.elapsed() > PRINT_WITHIN {
            let _ = child.kill();
            let _ = child.wait();
            return Err(PdfError::Slow { browser: browser.into() });
        }
        std::thread::sleep(LOOK);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_browser_that_is_not_there_is_named() {
        let sheet = Sheet { title: "t".into(), svg: String::new(), height: 10.0 };
        let folder = tempfile::tempdir().unwrap();
        let page = folder.path().join("figure.html");
        std::fs::write(&page, html(&sheet)).unwrap();
        let error = printed("no-such-browser", folder.path(), &page).unwrap_err().to_string();
        assert!(error.contains("no-such-browser cannot be run"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn a_browser_that_prints_nothing_is_no_pdf() {
        let folder = tempfile::tempdir().unwrap();
        let page = folder.path().join("figure.html");
        let error = printed("true", folder.path(), &page).unwrap_err().to_string();
        assert!(error.contains("true printed nothing"), "{error}");
    }
}
