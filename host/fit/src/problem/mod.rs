//! A chain over a data set as a problem of least squares.
//!
//! The search runs over the simulated force, never over differentiated measurements, in the coordinates
//! of the base law ([`super::coordinates`]) and the parameters of the effects as they are. Derivatives by
//! the coordinates of a linear base law are carried along (`carried.rs`); all others are differences,
//! so that a law is one plain function.
//!
//! - `run`: the chain at a point over the stretches, in order.
//! - `slopes`: its derivatives, stretch by stretch.
//! - `normal`: the normal equations that these make.
//! - `whiten`: what makes the noise of a stretch white, and what a mean stands for.
//! - `block`: the normal equations of the parts of the data.
//! - `errors`: errors by trace, and on traces left out.

mod block;
mod errors;
mod normal;
mod run;
mod slopes;
#[cfg(test)]
mod tests;
mod whiten;

use std::sync::Arc;

use super::carried::logarithms;
use super::compression::Compressed;
use super::coordinates::Coordinates;
use super::data::{Data, Piece};
use super::fold::Fold;
use super::least_squares::{HARDLY, LeastSquares, Normal, bounded_step_of};
use super::means::Means;
use super::meant::Meant;
use super::remembering::Reached;
use super::spare::Spare;
use super::whitening::Whitening;
use palpate_model::{Chain, Coordinate};

pub use block::Block;
pub use errors::{Apart, Residuals};
pub use slopes::Columns;

/// Residuals of a chain over a data set.
pub struct Problem<'a> {
    /// The chain.
    pub chain: &'a Chain,
    data: &'a Data<'a>,
    /// ln(x/X) of the commanded compression at every sample, where the data set keeps what it knows.
    logarithms: Arc<Vec<Vec<f64>>>,
    spare: Arc<Spare>,
    whitening: &'a Whitening,
    /// By what each sample of a stretch is multiplied; by one where there is no such stretch.
    roots: Vec<&'a [f64]>,
    /// Sum of squares that no point changes.
    constant: f64,
    /// What means tell of each stretch beside their values; empty where the data are samples.
    means: Arc<Vec<Meant>>,
    /// Traces that are predicted but not fitted.
    left_out: Option<Fold>,
    /// Whether a search goes over shape and rates alone, the forces being always the best.
    projects: bool,
    coordinates: Coordinates,
    bounds: Vec<(f64, f64)>,
}

impl<'a> Problem<'a> {
    /// The residuals of `chain`, whitened, on every trace but those left out.
    #[must_use]
    pub fn new(
        chain: &'a Chain,
        data: &'a Data<'a>,
        whitening: &'a Whitening,
        left_out: Option<Fold>,
    ) -> Self {
        let coordinates = Coordinates::new(chain.base, data.largest_compression());
        let logarithms_of = |piece: &Piece| {
            let mut values = Vec::new();
            logarithms(&piece.motion.displacement, coordinates.reference(), &mut values);
            values
        };
        let kept: &[Piece] = if data.keeps() { &data.pieces } else { &[] };
        let logarithms = kept.iter().map(logarithms_of).collect();
        Self {
            chain,
            data,
            logarithms: Arc::new(logarithms),
            spare: Arc::default(),
            whitening,
            roots: Vec::new(),
            constant: 0.0,
            means: Arc::default(),
            left_out,
            projects: false,
            bounds: bounds(&coordinates, chain, data),
            coordinates,
        }
    }

    /// The same chain on the block means of its data, in the same coordinates within the same bounds.
    #[must_use]
    pub fn on_means<'b>(&self, compressed: &'b Compressed, means: &'b Data<'b>) -> Problem<'b>
    where
        'a: 'b,
    {
        Problem { roots: compressed.roots(), constant: compressed.within, ..self.on(means) }
    }

    /// The same chain on the means of its data that effects see. Its sums of squares and its normal equations are those of all
    /// samples, as far as nothing bends within a block.
    #[must_use]
    pub fn on_weighted_means<'b>(&self, means: &Means, data: &'b Data<'b>) -> Problem<'b>
    where
        'a: 'b,
    {
        let means = Arc::new(Meant::of(means, self.data, self.whitening));
        Problem { means, ..self.on(data) }
    }

    /// The same chain on other data of the same motions, in the same coordinates within the same bounds.
    fn on<'b>(&self, data: &'b Data<'b>) -> Problem<'b>
    where
        'a: 'b,
    {
        let mut problem = Problem::new(self.chain, data, self.whitening, self.left_out);
        let reference = self.coordinates.reference();
        for (kept, piece) in Arc::make_mut(&mut problem.logarithms).iter_mut().zip(&data.pieces) {
            logarithms(&piece.motion.displacement, reference, kept);
        }
        Problem { coordinates: self.coordinates.clone(), bounds: self.bounds.clone(), ..problem }
    }

    /// The same for a search from afar: it goes over shape and rates alone where the law is linear in its forces, and these are always
    /// the best. A valley that is bent in all coordinates is straight in those.
    #[must_use]
    pub fn projecting(mut self) -> Self {
        self.projects = true;
        self
    }

    /// The same without the residuals of some traces.
    #[must_use]
    pub fn leaving_out(&self, fold: Fold) -> Self {
        Self {
            left_out: Some(fold),
            coordinates: self.coordinates.clone(),
            bounds: self.bounds.clone(),
            ..self.with_chain(self.chain)
        }
    }

    /// The same with every residual multiplied by the root of its sample's weight, stretch by stretch.
    #[must_use]
    pub(crate) fn weighted<'b>(&self, roots: &'b [Vec<f64>]) -> Problem<'b>
    where
        'a: 'b,
    {
        Problem {
            roots: roots.iter().map(Vec::as_slice).collect(),
            coordinates: self.coordinates.clone(),
            bounds: self.bounds.clone(),
            ..self.with_chain(self.chain)
        }
    }

    /// The same data with another chain.
    #[must_use]
    pub fn with_chain<'b>(&self, chain: &'b Chain) -> Problem<'b>
    where
        'a: 'b,
    {
        let coordinates = self.coordinates.of(chain.base);
        Problem {
            chain,
            data: self.data,
            logarithms: self.logarithms.clone(),
            spare: self.spare.clone(),
            whitening: self.whitening,
            roots: self.roots.clone(),
            constant: self.constant,
            means: self.means.clone(),
            left_out: self.left_out,
            projects: self.projects,
            bounds: bounds(&coordinates, chain, self.data),
            coordinates,
        }
    }

    /// The data set whose residuals these are.
    #[must_use]
    pub const fn data(&self) -> &'a Data<'a> {
        self.data
    }

    /// The coordinates of the base law.
    #[must_use]
    pub fn coordinates(&self) -> &Coordinates {
        &self.coordinates
    }

    /// The chain's parameters from coordinates.
    #[must_use]
    pub fn declared(&self, point: &[f64]) -> Vec<f64> {
        let (base, effects) = point.split_at(self.coordinates.count());
        let mut declared = self.coordinates.declared(base);
        declared.extend_from_slice(effects);
        declared
    }

    /// Coordinates of these parameters.
    #[must_use]
    pub fn point(&self, declared: &[f64]) -> Vec<f64> {
        let (base, effects) = declared.split_at(self.coordinates.count());
        let mut point = self.coordinates.point(base);
        point.extend_from_slice(effects);
        point
    }

    pub(super) fn fitted(&self, piece: &Piece) -> bool {
        self.left_out.is_none_or(|fold| !fold.holds(piece.trace))
    }
}

impl Problem<'_> {
    /// The normal equations in one pass, where they can be had so.
    fn fused(&self, point: &[f64]) -> Option<Normal> {
        let fitted = |piece: &Piece| self.fitted(piece).then_some(0);
        let mut normal = self.in_one_pass(point, 1, fitted)?.pop()?;
        normal.cost += self.constant;
        Some(normal)
    }

    /// Moves a point, with these normal equations, to the best forces where they are always the best; the normal equations there.
    fn projected(&self, point: &mut [f64], normal: &Normal) -> Option<Normal> {
        if !self.projects {
            return None;
        }
        let is_force = |coordinate: &Coordinate| {
            matches!(coordinate, Coordinate::Force(_) | Coordinate::Total | Coordinate::Damping)
        };
        let list = self.coordinates.list();
        let forces = (0..list.len()).filter(|&j| is_force(&list[j]));
        let step = bounded_step_of(forces, normal, HARDLY, point, &self.bounds);
        let best: Vec<f64> = point.iter().zip(step.iter()).map(|(x, dx)| x + dx).collect();
        let there = self.fused(&best).filter(|there| there.cost < normal.cost)?;
        point.copy_from_slice(&best);
        Some(there)
    }

    /// The whitened sum of squares over the traces that are fitted; `seen` gets the residual of every
    /// stretch (predicted minus measured).
    pub(super) fn fitted_cost(
        &self,
        point: &[f64],
        reached: &mut Reached,
        mut seen: impl FnMut(usize, &Piece, &[f64]),
    ) -> f64 {
        let mut normal = Normal::zeros(0);
        normal.cost = self.unseen();
        let mut sums = self.level_sums(0);
        let mut run = self.run_at(point);
        let mut residual = self.spare.take();
        for (index, piece) in self.data.pieces.iter().enumerate() {
            self.advance(&mut run, index, reached.in_stretch(index), &mut residual);
            for (force, measured) in residual.iter_mut().zip(piece.measured) {
                *force -= measured;
            }
            seen(index, piece, &residual);
            if self.fitted(piece) {
                self.whiten_residual(index, &mut residual);
                if let Some(sums) = &mut sums {
                    sums.add(piece.trace, &self.unit_level(index), &[], &residual, 0);
                }
                normal.cost += residual.iter().map(|r| r * r).sum::<f64>();
            }
        }
        self.spare.give([residual]);
        self.marginalise(sums.as_ref(), &mut normal);
        normal.cost
    }

    /// [`LeastSquares::cost`] from where a set-up that yields came to before.
    pub(crate) fn cost_from(&self, point: &[f64], reached: &mut Reached) -> f64 {
        self.fitted_cost(point, reached, |_, _, _| {})
    }

    /// [`LeastSquares::tried`] from there.
    pub(crate) fn tried_from(
        &self,
        point: &mut [f64],
        reached: &mut Reached,
    ) -> (f64, Option<Normal>) {
        let Some(normal) = self.fused(point) else {
            return (self.cost_from(point, reached), None);
        };
        let normal = self.projected(point, &normal).unwrap_or(normal);
        (normal.cost, Some(normal))
    }

    /// [`LeastSquares::normal`] from there.
    pub(crate) fn normal_from(&self, point: &[f64], reached: &mut Reached) -> Normal {
        if let Some(normal) = self.fused(point) {
            return normal;
        }
        let mut normal = Normal::zeros(point.len());
        normal.cost = self.unseen();
        let mut sums = self.level_sums(point.len());
        let mut index = 0;
        self.slopes(point, reached, |piece, residual, columns| {
            if self.fitted(piece) {
                self.whiten_residual(index, residual);
                for (_, column) in columns.iter_mut() {
                    self.whiten_at(index, column);
                }
                if let Some(sums) = &mut sums {
                    let unit = self.unit_level(index);
                    sums.add(piece.trace, &unit, columns, residual, 0);
                }
                normal.add(columns, residual, 0..residual.len());
            }
            index += 1;
        });
        self.marginalise(sums.as_ref(), &mut normal);
        normal
    }
}

/// Bounds of every coordinate.
fn bounds(coordinates: &Coordinates, chain: &Chain, data: &Data) -> Vec<(f64, f64)> {
    let mut bounds = coordinates.bounds(data);
    bounds.extend(chain.parameters()[chain.base.count()..].iter().map(|p| (p.lower, p.upper)));
    bounds
}

impl LeastSquares for Problem<'_> {
    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn cost(&self, point: &[f64]) -> f64 {
        self.cost_from(point, &mut Reached::default())
    }

    fn tried(&self, point: &mut [f64]) -> (f64, Option<Normal>) {
        self.tried_from(point, &mut Reached::default())
    }

    fn normal(&self, point: &[f64]) -> Normal {
        self.normal_from(point, &mut Reached::default())
    }
}
