//! A search that remembers where a set-up that yields came to: the next point is near, and so is where it yields to there.

use std::cell::{RefCell, RefMut};

use palpate_model::Elasticity;

use super::least_squares::{LeastSquares, Normal};
use super::problem::{Block, Problem};

/// Where a set-up that yields came to in the last run over the data.
#[derive(Debug)]
pub(crate) enum Reached {
    /// In the last stretch alone.
    Last(Elasticity),
    /// In every stretch, so that the next run over all of them begins there.
    All(Vec<Elasticity>),
}

impl Default for Reached {
    fn default() -> Self {
        Self::Last(Elasticity::default())
    }
}

impl Reached {
    /// The next run is at the same point: what is known of every stretch is left as it is.
    fn stay(&mut self) {
        if let Self::All(all) = self {
            all.iter_mut().for_each(Elasticity::stay);
        }
    }

    /// What is known of the stretch with this index.
    pub(crate) fn in_stretch(&mut self, index: usize) -> &mut Elasticity {
        match self {
            Self::Last(last) => last,
            Self::All(all) => {
                if all.len() <= index {
                    all.resize_with(index + 1, Elasticity::default);
                }
                &mut all[index]
            }
        }
    }
}

/// A problem for one search, whose points come one after the other.
pub struct Remembering<'p, 'a> {
    problem: &'p Problem<'a>,
    reached: RefCell<Reached>,
    /// The last point.
    last: RefCell<Vec<f64>>,
}

impl<'p, 'a> Remembering<'p, 'a> {
    /// Nothing is known yet.
    #[must_use]
    pub fn new(problem: &'p Problem<'a>) -> Self {
        let yields = problem.chain.yields();
        let reached = if yields { Reached::All(Vec::new()) } else { Reached::default() };
        Self { problem, reached: RefCell::new(reached), last: RefCell::default() }
    }

    /// What is known before a run at a point. At the last point again, all stays where it came to: a law that jumps may come elsewhere
    /// from there.
    fn before(&self, point: &[f64]) -> RefMut<'_, Reached> {
        let mut reached = self.reached.borrow_mut();
        let mut last = self.last.borrow_mut();
        if *last == point {
            reached.stay();
        } else {
            last.clear();
            last.extend_from_slice(point);
        }
        reached
    }

    /// [`Problem::blocks`] where the search ended.
    #[must_use]
    pub fn blocks(&self, point: &[f64]) -> Vec<Block> {
        self.problem.blocks_from(point, &mut self.before(point))
    }
}

impl LeastSquares for Remembering<'_, '_> {
    fn bounds(&self) -> &[(f64, f64)] {
        self.problem.bounds()
    }

    fn cost(&self, point: &[f64]) -> f64 {
        self.problem.cost_from(point, &mut self.before(point))
    }

    fn tried(&self, point: &mut [f64]) -> (f64, Option<Normal>) {
        let mut before = self.before(point);
        self.problem.tried_from(point, &mut before)
    }

    fn normal(&self, point: &[f64]) -> Normal {
        self.problem.normal_from(point, &mut self.before(point))
    }
}
