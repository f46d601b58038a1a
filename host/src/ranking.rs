//! Every base law on a data set.

use palpate_fit::ranking::{Ranking, rank as ranked};
use palpate_model::{Laws, Separation, TERMS};
use palpate_trace::FORCE;

use crate::work::{Asked, Question};
use crate::{DataSet, Error};

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
pub fn rank(set: &DataSet) -> Asked<'_, EveryLaw> {
    let (laws, separation) = (Laws::library(), Separation::default());
    Asked::new(EveryLaw { laws, signal: FORCE.into(), terms: TERMS, separation }, set)
}

/// Every base law, fitted and put in order.
pub struct EveryLaw {
    laws: Laws,
    signal: String,
    terms: usize,
    separation: Separation,
}

impl Asked<'_, EveryLaw> {
    /// Fits these laws instead of those of the library.
    pub fn laws(mut self, laws: Laws) -> Self {
        self.question.laws = laws;
        self
    }

    /// Fits this column instead of `force_N`.
    pub fn signal(mut self, column: &str) -> Self {
        self.question.signal = column.into();
        self
    }

    /// This many exponentials or branches, 1 to 4, in laws that have a choice; 2 if not given.
    pub fn terms(mut self, terms: usize) -> Self {
        self.question.terms = terms;
        self
    }

    /// What happens when contact breaks.
    pub fn separation(mut self, separation: Separation) -> Self {
        self.question.separation = separation;
        self
    }
}

impl Question for EveryLaw {
    type Answer = Ranking;

    fn of(self, set: &DataSet) -> Result<Ranking, Error> {
        let Self { laws, signal, terms, separation } = self;
        Ok(ranked(&laws, set.traces(), &signal, terms, separation)?)
    }
}
