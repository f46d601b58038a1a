//! Long work on a data set: how far it has come, and a way to end it.

use std::sync::Arc;
use std::time::Duration;

use palpate_fit::watch::{Stage, Watch, looked_at, under};

use crate::{DataSet, Error};

/// How often a caller is told how far the work has come.
const UPDATE_INTERVAL: Duration = Duration::from_millis(100);

/// A way to end work from another thread. Clones end the same work.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<Watch>);

impl Cancel {
    /// Asks the work to end: it returns [`Error::Cancelled`] soon.
    pub fn cancel(&self) {
        self.0.end();
    }
}

/// What can be asked of a data set, with its options.
pub trait Question: Send {
    /// What it is answered with.
    type Answer: Send;

    /// Answers it.
    ///
    /// # Errors
    /// When the traces do not go with what is asked.
    fn of(self, set: &DataSet) -> Result<Self::Answer, Error>;
}

/// A question to a data set that is about to be answered: [`fit`](crate::fit()), [`diagnose`](crate::diagnose()) and
/// [`rank`](crate::rank) begin one.
#[must_use = "nothing is done before `run`"]
pub struct Asked<'a, Q> {
    pub(crate) question: Q,
    set: &'a DataSet,
    tell: Option<Box<dyn FnMut(Stage) + Send + 'a>>,
    cancel: Option<Cancel>,
}

impl<'a, Q: Question> Asked<'a, Q> {
    pub(crate) fn new(question: Q, set: &'a DataSet) -> Self {
        Self { question, set, tell: None, cancel: None }
    }

    /// Tells how far the work has come, ten times a second, from a thread of its own.
    pub fn on_progress(mut self, tell: impl FnMut(Stage) + Send + 'a) -> Self {
        self.tell = Some(Box::new(tell));
        self
    }

    /// Lets another thread end the work.
    pub fn cancel(mut self, cancel: &Cancel) -> Self {
        self.cancel = Some(cancel.clone());
        self
    }

    /// Answers it.
    ///
    /// # Errors
    /// When options, model or traces cannot be used together, nothing better than a constant was found, or the work was
    /// cancelled.
    pub fn run(self) -> Result<Q::Answer, Error> {
        let Self { question, set, tell, cancel } = self;
        let work = || question.of(set);
        if tell.is_none() && cancel.is_none() {
            return work();
        }
        let Cancel(watch) = cancel.unwrap_or_default();
        let found = match tell {
            Some(mut tell) => {
                let look = |watch: &Watch| watch.stage().into_iter().for_each(&mut tell);
                looked_at(&watch, UPDATE_INTERVAL, look, work)
            }
            None => under(&watch, work),
        };
        if watch.ended() { Err(Error::Cancelled) } else { found.map_err(Error::Threads)? }
    }
}
