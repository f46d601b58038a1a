//! Watching over long work from outside: how far it has come, and a way to end it early.
//!
//! Work runs [`under`] a watch on threads of its own, all of which know it, so that nothing between needs
//! to hand it on. Every search for a minimum counts its steps there, and ends where the watch says so;
//! what comes out of work that was ended means nothing. Where so many alike are to be done one after the
//! other, that is a stage, and each of them is counted.

use std::cell::RefCell;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, Thread};
use std::time::Duration;

use rayon::{ThreadPoolBuildError, ThreadPoolBuilder};

/// How far a piece of work has come, and whether it is to end.
#[derive(Debug, Default)]
pub struct Watch {
    outer: Option<Arc<Watch>>,
    ended: AtomicBool,
    searches: AtomicUsize,
    steps: AtomicUsize,
    evaluations: AtomicUsize,
    stage: Mutex<Option<Stage>>,
}

/// Things to be done that are alike, as far as they are done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stage {
    /// What they are, in words.
    pub what: &'static str,
    /// How many they are.
    pub of: usize,
    /// How many are done.
    pub done: usize,
}

thread_local! {
    static WATCH: RefCell<Option<Arc<Watch>>> = const { RefCell::new(None) };
}

impl Watch {
    /// A watch over part of the work at hand: it ends with the whole, and has stages of its own.
    #[must_use]
    pub fn within() -> Self {
        Self { outer: current(), ..Self::default() }
    }

    /// Asks the work to end.
    pub fn end(&self) {
        self.ended.store(true, Ordering::Relaxed);
    }

    /// Whether the work was asked to end.
    #[must_use]
    pub fn ended(&self) -> bool {
        self.ended.load(Ordering::Relaxed) || self.outer.as_deref().is_some_and(Watch::ended)
    }

    /// Searches for a minimum that were begun, and steps that were tried in all of them.
    #[must_use]
    pub fn progress(&self) -> (usize, usize) {
        (self.searches.load(Ordering::Relaxed), self.steps.load(Ordering::Relaxed))
    }

    /// Samples that a model has predicted, in all its runs: the cost of the work, whatever the machine.
    #[must_use]
    pub fn evaluations(&self) -> usize {
        self.evaluations.load(Ordering::Relaxed)
    }

    /// What is being done, where it is known how much there is of it.
    #[must_use]
    pub fn stage(&self) -> Option<Stage> {
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// One more of the stage is done; with the last the stage ends.
    pub fn done(&self) {
        let next = |stage: Stage| {
            let done = stage.done + 1;
            (done < stage.of).then_some(Stage { done, ..stage })
        };
        self.set_stage(|stage| stage.and_then(next));
    }

    fn set_stage(&self, change: impl FnOnce(Option<Stage>) -> Option<Stage>) {
        let mut stage = self.stage.lock().unwrap_or_else(PoisonError::into_inner);
        *stage = change(*stage);
    }
}

/// Does work on threads of its own, under a watch.
///
/// # Errors
/// When the system gives no threads.
pub fn under<T: Send>(
    watch: &Arc<Watch>,
    work: impl FnOnce() -> T + Send,
) -> Result<T, ThreadPoolBuildError> {
    let watch = watch.clone();
    let pool =
        ThreadPoolBuilder::new().start_handler(move |_| WATCH.set(Some(watch.clone()))).build()?;
    Ok(pool.install(work))
}

/// The same, while `look` is shown the watch every so often, from a thread of its own.
///
/// # Errors
/// When the system gives no threads.
pub fn looked_at<T: Send>(
    watch: &Arc<Watch>,
    every: Duration,
    mut look: impl FnMut(&Watch) + Send,
    work: impl FnOnce() -> T + Send,
) -> Result<T, ThreadPoolBuildError> {
    let done = AtomicBool::new(false);
    thread::scope(|scope| {
        let looker = scope.spawn(|| {
            while !done.load(Ordering::Relaxed) {
                look(watch);
                thread::park_timeout(every);
            }
        });
        // Also where the work panics, or the looker would go on for ever.
        let _over = Over { done: &done, looker: looker.thread().clone() };
        under(watch, work)
    })
}

/// Ends a looker when it goes.
struct Over<'a> {
    done: &'a AtomicBool,
    looker: Thread,
}

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.done.store(true, Ordering::Relaxed);
        self.looker.unpark();
    }
}

/// Does work under a watch on one thread: for work of which much is done side by side already.
///
/// # Errors
/// When the system gives no thread.
pub fn alone<T: Send>(
    watch: &Arc<Watch>,
    work: impl FnOnce() -> T + Send,
) -> Result<T, ThreadPoolBuildError> {
    let watch = watch.clone();
    let pool = ThreadPoolBuilder::new().num_threads(1);
    Ok(pool.start_handler(move |_| WATCH.set(Some(watch.clone()))).build()?.install(work))
}

/// A search begins.
pub(super) fn search() {
    seen(|watch| watch.searches.fetch_add(1, Ordering::Relaxed));
}

/// A step is about to be tried; false where the work is to end.
pub(super) fn step() -> bool {
    seen(|watch| watch.steps.fetch_add(1, Ordering::Relaxed));
    !ended()
}

/// A model has predicted so many samples.
pub fn evaluated(samples: usize) {
    seen(|watch| watch.evaluations.fetch_add(samples, Ordering::Relaxed));
}

/// A stage begins: so many alike are to be done.
pub fn stage(what: &'static str, of: usize) {
    seen(|watch| watch.set_stage(|_| Some(Stage { what, of, done: 0 })));
}

/// One more of the stage is done; with the last the stage ends.
pub fn done() {
    seen(Watch::done);
}

/// Whether the work at hand was asked to end; never where nobody watches.
#[must_use]
pub fn ended() -> bool {
    seen(Watch::ended).unwrap_or(false)
}

/// Whether somebody watches over the work at hand.
#[must_use]
pub fn watched() -> bool {
    seen(|_| ()).is_some()
}

/// The watch over the work at hand.
#[must_use]
pub fn current() -> Option<Arc<Watch>> {
    WATCH.with_borrow(Clone::clone)
}

fn seen<T>(look: impl FnOnce(&Watch) -> T) -> Option<T> {
    WATCH.with_borrow(|watch| watch.as_deref().map(look))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_counts_and_ends_under_its_own_watch_alone() {
        let (one, other) = (Arc::new(Watch::default()), Arc::new(Watch::default()));
        one.end();
        let went_on = |watch: &Arc<Watch>| under(watch, || rayon::join(step, step)).unwrap();
        assert_eq!(went_on(&one), (false, false));
        assert_eq!(went_on(&other), (true, true));
        assert_eq!(other.progress(), (0, 2));
        assert_eq!(under(&one, watched).ok(), Some(true));
        assert!(step() && !watched(), "nobody watches here");
    }

    #[test]
    fn a_looker_sees_the_work_and_ends_with_it_also_where_it_panics() {
        let watch = Arc::new(Watch::default());
        let seen = AtomicUsize::new(0);
        let look = |_: &Watch| {
            seen.fetch_add(1, Ordering::Relaxed);
        };
        let every = Duration::from_millis(1);
        // Work that goes on until it was looked at.
        let work = || {
            while seen.load(Ordering::Relaxed) == 0 {
                thread::yield_now();
            }
            7
        };
        assert_eq!(looked_at(&watch, every, look, work).ok(), Some(7));
        let work = || looked_at(&watch, every, look, || panic!("of the test"));
        assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(work)).is_err());
    }

    #[test]
    fn a_stage_counts_what_is_done_and_ends_with_the_last() {
        let watch = Arc::new(Watch::default());
        let seen = under(&watch, || {
            stage("starts", 3);
            let seen = [(), (), ()].map(|()| {
                done();
                watch.stage().map(|stage| (stage.what, stage.of, stage.done))
            });
            done();
            seen
        });
        assert_eq!(seen.unwrap(), [Some(("starts", 3, 1)), Some(("starts", 3, 2)), None]);
        stage("unseen", 1);
        assert_eq!(watch.stage(), None);
    }
}
