//! Every base law on a data set.

use palpate_fit::ranking::{Ranking, rank as ranked};
use palpate_fit::watch::Stage;
use palpate_model::{Laws, Separation, TERMS};
use palpate_trace::FORCE;

use crate::work::Work;
use crate::{Cancel, DataSet, Error};

/// Fits every base law to a data set and puts them in order: by the error on traces left out in turn, for a single trace by the
/// Bayesian information criterion.
///
/// ```
/// # fn main() -> Result<(), palpate::Error> {
/// # let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/traces/press.csv");
/// let set = palpate::DataSet::read(folder)?;
/// let ranking = palpate::rank(&set).run()?;
/// println!("{}", ranking.places[0].fit.chain.base.in_words());
/// # Ok(())
/// # }
/// ```
pub fn rank(set: &DataSet) -> RankingOf<'_> {
    let (laws, separation) = (Laws::library(), Separation::default());
    RankingOf { set, laws, signal: FORCE.into(), terms: TERMS, separation, work: Work::default() }
}

/// A ranking that is about to be made.
#[must_use = "nothing is fitted before `run`"]
pub struct RankingOf<'a> {
    set: &'a DataSet,
    laws: Laws,
    signal: String,
    terms: usize,
    separation: Separation,
    work: Work<'a>,
}

impl<'a> RankingOf<'a> {
    /// Fits these laws instead of those of the library.
    pub fn laws(mut self, laws: Laws) -> Self {
        self.laws = laws;
        self
    }

    /// Fits this column instead of `force_N`.
    pub fn signal(mut self, column: &str) -> Self {
        self.signal = column.into();
        self
    }

    /// This many exponentials or branches, 1 to 4, in laws that have a choice; 2 if not given.
    pub fn terms(mut self, terms: usize) -> Self {
        self.terms = terms;
        self
    }

    /// What happens when contact breaks.
    pub fn separation(mut self, separation: Separation) -> Self {
        self.separation = separation;
        self
    }

    /// Tells how far the work has come, ten times a second, from a thread of its own.
    pub fn on_progress(mut self, tell: impl FnMut(Stage) + Send + 'a) -> Self {
        self.work.tell = Some(Box::new(tell));
        self
    }

    /// Lets another thread end the work.
    pub fn cancel(mut self, cancel: &Cancel) -> Self {
        self.work.cancel = Some(cancel.clone());
        self
    }

    /// Fits them all.
    ///
    /// # Errors
    /// When the traces cannot be fitted, or the work was cancelled.
    pub fn run(self) -> Result<Ranking, Error> {
        let (laws, traces) = (self.laws, self.set.traces());
        let (signal, terms, separation) = (self.signal, self.terms, self.separation);
        Ok(self.work.run(|| ranked(&laws, traces, &signal, terms, separation))??)
    }
}
