//! Long work: how far it has come, and a way to end it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use palpate_fit::watch::{Stage, Watch, under};

use crate::Error;

/// How often a caller is told how far the work has come.
const TELL: Duration = Duration::from_millis(100);

/// A way to end work from another thread. Clones end the same work.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<Watch>);

impl Cancel {
    /// Asks the work to end: it returns [`Error::Cancelled`] soon.
    pub fn cancel(&self) {
        self.0.end();
    }
}

/// Who is told how far work has come, and who may end it.
#[derive(Default)]
pub(crate) struct Work<'a> {
    pub(crate) tell: Option<Box<dyn FnMut(Stage) + Send + 'a>>,
    pub(crate) cancel: Option<Cancel>,
}

impl Work<'_> {
    /// Does it.
    pub(crate) fn run<T: Send>(self, work: impl FnOnce() -> T + Send) -> Result<T, Error> {
        if self.tell.is_none() && self.cancel.is_none() {
            return Ok(work());
        }
        let Cancel(watch) = self.cancel.unwrap_or_default();
        let done = AtomicBool::new(false);
        let found = std::thread::scope(|scope| {
            let teller = self.tell.map(|mut tell| {
                let (watch, done) = (&watch, &done);
                scope.spawn(move || {
                    while !done.load(Ordering::Relaxed) {
                        if let Some(stage) = watch.stage() {
                            tell(stage);
                        }
                        std::thread::park_timeout(TELL);
                    }
                })
            });
            let found = under(&watch, work);
            done.store(true, Ordering::Relaxed);
            if let Some(teller) = teller {
                teller.thread().unpark();
            }
            found
        });
        if watch.ended() { Err(Error::Cancelled) } else { found.map_err(Error::Threads) }
    }
}
