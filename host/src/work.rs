//! Long work: how far it has come, and a way to end it.

use std::sync::Arc;
use std::time::Duration;

use palpate_fit::watch::{Stage, Watch, looked_at, under};

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
        let found = match self.tell {
            Some(mut tell) => {
                let look = |watch: &Watch| watch.stage().into_iter().for_each(&mut tell);
                looked_at(&watch, TELL, look, work)
            }
            None => under(&watch, work),
        };
        if watch.ended() { Err(Error::Cancelled) } else { found.map_err(Error::Threads) }
    }
}
