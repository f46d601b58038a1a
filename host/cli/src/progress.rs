//! Progress bars, where a person waits: on standard error, and only if that is a terminal.

use std::io::IsTerminal;
use std::sync::Arc;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use super::Failure;
use palpate_fit::watch::{self, Watch};

/// How often what is shown is made anew.
const TICK: Duration = Duration::from_millis(100);

/// A bar over `steps` steps of `what`; none where the caller watches over the work by other means.
pub fn bar(steps: usize, what: &str) -> ProgressBar {
    if watch::watched() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{msg:<28} {bar:32} {pos}/{len} {eta}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(steps as u64).with_style(style).with_message(what.to_owned())
}

/// A moving mark while `what` is done, where the number of steps is not known; none where the caller watches.
pub fn spinner(what: &str) -> ProgressBar {
    if watch::watched() {
        return ProgressBar::hidden();
    }
    let spinner = ProgressBar::new_spinner().with_message(what.to_owned());
    spinner.enable_steady_tick(TICK);
    spinner
}

/// Does long work and shows what of it is being done, how much of that is left and how long it will take.
///
/// # Errors
/// When the system gives no threads.
pub fn watched<T: Send>(what: &str, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
    if watch::watched() || !std::io::stderr().is_terminal() {
        return Ok(work());
    }
    let watch = Arc::new(Watch::default());
    let mark = spinner(what);
    let found = watch::looked_at(&watch, TICK, |watch| tell(&mark, what, watch), work);
    mark.finish_and_clear();
    found.map_err(Failure::work)
}

/// Shows the stage that the work has come to: a bar where its length is known.
fn tell(mark: &ProgressBar, what: &str, watch: &Watch) {
    let Some(stage) = watch.stage() else {
        mark.set_message(what.to_owned());
        return;
    };
    if mark.message() != stage.what {
        let style = ProgressStyle::with_template("{spinner} {msg} {bar:24} {pos}/{len} {eta}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        mark.set_style(style);
        mark.reset();
        mark.set_message(stage.what);
    }
    mark.set_length(stage.of as u64);
    mark.set_position(stage.done as u64);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_tells_the_stage_and_what_is_left_of_it() {
        let seen = Arc::new(Watch::default());
        let mark = ProgressBar::hidden();
        watch::under(&seen, || {
            watch::stage("laws refitted", 5);
            watch::done();
            watch::done();
            tell(&mark, "looking", &seen);
        })
        .unwrap();
        assert_eq!((mark.message().as_str(), mark.position()), ("laws refitted", 2));
        assert_eq!(mark.length(), Some(5));
    }
}
