//! What the base law cannot make up for by other values of its own parameters.

use palpate_fit::data::Data;
use palpate_fit::problem::Problem;
use palpate_fit::whitening::Whitening;
use palpate_fit::whole_motion::{predict, refit};
use palpate_model::{Chain, Elasticity, History, Scene};

/// A base law at its parameters over a data set, with the directions in which it can move.
pub struct Ground<'a> {
    chain: &'a Chain,
    values: &'a [f64],
    data: &'a Data<'a>,
    scenes: Vec<Scene<'a>>,
    predicted: Vec<f64>,
    /// Orthonormal: the derivatives to the parameters, all samples of the set one after the other.
    own: Vec<Vec<f64>>,
}

/// What an effect does to the prediction of a set.
#[derive(Clone, Copy, Debug)]
pub struct Misfit {
    /// Root mean square of the whole change.
    pub whole: f64,
    /// Root mean square that remains when the base law is refitted.
    pub left: f64,
}

impl<'a> Ground<'a> {
    /// The base law at these values.
    #[must_use]
    pub fn new(chain: &'a Chain, values: &'a [f64], data: &'a Data<'a>) -> Self {
        let white = Whitening::none();
        let problem = Problem::new(chain, data, &white, None);
        let mut own: Vec<Vec<f64>> = vec![Vec::new(); values.len()];
        problem.derivatives(&problem.point(values), |_, _, columns| {
            // The base law alone has every coordinate in every stretch.
            for (index, column) in columns {
                own[index].extend(column);
            }
        });
        for index in 0..own.len() {
            let (before, rest) = own.split_at_mut(index);
            let column = &mut rest[0];
            // Twice, so that rounding leaves nothing of the others.
            for other in before.iter().chain(before.iter()) {
                take_off(column, other);
            }
            let size = dot(column, column).sqrt();
            let scale = if size > 0.0 { 1.0 / size } else { 0.0 };
            column.iter_mut().for_each(|value| *value *= scale);
        }
        Self {
            chain,
            values,
            data,
            scenes: data.pieces.iter().map(|piece| data.scene(piece)).collect(),
            predicted: predict(chain, values, data).concat(),
            own,
        }
    }

    /// Root mean square that remains of the chain with these effects' parameters when the base law is
    /// refitted to it in earnest.
    #[must_use]
    pub fn refitted(&self, chain: &Chain, effects: &[f64]) -> Option<f64> {
        let forces = self.forces(chain, effects);
        let mut data: Data<'_> = self.data.clone();
        for (piece, force) in data.pieces.iter_mut().zip(&forces) {
            piece.measured = force;
        }
        refit(self.chain, self.values, &data).ok().map(|fit| fit.rms())
    }

    /// The force of every stretch.
    fn forces(&self, chain: &Chain, effects: &[f64]) -> Vec<Vec<f64>> {
        let parameters = [self.values, effects].concat();
        let (mut history, mut elasticity) = (History::default(), Elasticity::default());
        let mut force = Vec::new();
        let stretch = |scene| {
            chain.run(&parameters, scene, &mut history, &mut elasticity, &mut force);
            force.clone()
        };
        self.scenes.iter().map(stretch).collect()
    }

    /// What the chain with these effects' parameters leaves, as far as the base law is straight.
    #[must_use]
    pub fn misfit(&self, chain: &Chain, effects: &[f64]) -> Misfit {
        let mut change = self.forces(chain, effects).concat();
        for (change, predicted) in change.iter_mut().zip(&self.predicted) {
            *change -= predicted;
        }
        let count = change.len() as f64;
        let whole = (dot(&change, &change) / count).sqrt();
        for own in &self.own {
            take_off(&mut change, own);
        }
        Misfit { whole, left: (dot(&change, &change) / count).sqrt() }
    }
}

/// Takes off `column` what lies along `other`, which has length one.
fn take_off(column: &mut [f64], other: &[f64]) {
    let along = dot(column, other);
    for (value, other) in column.iter_mut().zip(other) {
        *value -= along * other;
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
