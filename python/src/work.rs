//! Long work beside a live interpreter.

use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use palpate::fit::watch::{Watch, under};
use pyo3::prelude::*;

use crate::error::broken;

/// How often signals are looked for and progress is told.
const TICK: Duration = Duration::from_millis(50);

/// Does work on threads of its own while the interpreter is free; `tell(what, done, of)` is called now and then. Where a
/// signal's handler or `tell` raises, as Ctrl-C does, the work is asked to end and the exception goes on at once.
pub fn work<T: Send + 'static>(
    py: Python<'_>,
    tell: Option<&Bound<'_, PyAny>>,
    job: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let watch = Arc::new(Watch::default());
    let theirs = watch.clone();
    let (give, mut take) = channel();
    let start = std::thread::Builder::new().name("palpate".into());
    let run = move || drop(give.send(under(&theirs, job)));
    start.spawn(run).map_err(broken)?;
    loop {
        let found;
        (found, take) = py.detach(move || (take.recv_timeout(TICK), take));
        match found {
            Ok(found) => return found.map_err(broken),
            Err(RecvTimeoutError::Disconnected) => {
                return Err(broken("the work broke off: this is a fault of palpate"));
            }
            Err(RecvTimeoutError::Timeout) => {
                if let Err(raised) = py.check_signals().and_then(|()| show(tell, &watch)) {
                    watch.end();
                    return Err(raised);
                }
            }
        }
    }
}

/// Tells how far the work has come, where that is known.
fn show(tell: Option<&Bound<'_, PyAny>>, watch: &Watch) -> PyResult<()> {
    match (tell, watch.stage()) {
        (Some(tell), Some(stage)) => tell.call1((stage.what, stage.done, stage.of)).map(drop),
        _ => Ok(()),
    }
}
