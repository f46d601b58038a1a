//! A chain over a data set as a problem of least squares.
//!
//! The search runs over the simulated force, never over differentiated measurements, in the coordinates
//! of the base law ([`super::coordinates`]) and the parameters of the effects as they are. Derivatives are
//! differences, so that a law is one plain function.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::coordinates::Coordinates;
use super::data::{Data, Piece};
use super::least_squares::{LeastSquares, Normal};
use super::levels::LevelSums;
use super::whitening::Whitening;
use crate::model::{Chain, Elasticity, History, Scene};

/// Residuals of a chain over a data set.
pub struct Problem<'a> {
    /// The chain.
    pub chain: &'a Chain,
    data: &'a Data<'a>,
    /// What is known at every sample; made anew for every run where there are too many to keep.
    scenes: Arc<Vec<Scene<'a>>>,
    whitening: &'a Whitening,
    /// A trace that is predicted but not fitted.
    left_out: Option<usize>,
    coordinates: Coordinates,
    bounds: Vec<(f64, f64)>,
}

/// Samples up to which scenes are kept: some 100 MB.
const KEPT: usize = 1_500_000;
/// Step of a derivative, relative to the coordinate and to its range.
const STEP: (f64, f64) = (1e-6, 1e-8);

impl<'a> Problem<'a> {
    /// The residuals of `chain`, whitened, on every trace but the one left out.
    #[must_use]
    pub fn new(
        chain: &'a Chain,
        data: &'a Data<'a>,
        whitening: &'a Whitening,
        left_out: Option<usize>,
    ) -> Self {
        let keep = data.samples() <= KEPT;
        let scenes =
            if keep { data.pieces.iter().map(|piece| data.scene(piece)).collect() } else { vec![] };
        let coordinates = Coordinates::new(chain.base, data.largest_compression());
        let bounds = bounds(&coordinates, chain, data);
        Self { chain, data, scenes: Arc::new(scenes), whitening, left_out, coordinates, bounds }
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
            scenes: self.scenes.clone(),
            whitening: self.whitening,
            left_out: self.left_out,
            bounds: bounds(&coordinates, chain, self.data),
            coordinates,
        }
    }

    /// The same with one trace predicted but not fitted.
    #[must_use]
    pub fn leaving_out(&self, trace: usize) -> Self {
        Self {
            chain: self.chain,
            data: self.data,
            scenes: self.scenes.clone(),
            whitening: self.whitening,
            left_out: Some(trace),
            coordinates: self.coordinates.clone(),
            bounds: self.bounds.clone(),
        }
    }

    /// Whitens the residual of a stretch.
    pub fn whiten(&self, residual: &mut [f64]) {
        self.whitening.apply(residual);
    }

    /// The whitened sum of squares over the traces that are fitted, and the residuals (predicted minus
    /// measured) of the stretches of `trace`.
    #[must_use]
    pub fn apart(&self, point: &[f64], trace: usize) -> (f64, Vec<StretchResidual>) {
        let (mut normal, mut apart) = (Normal::zeros(0), Vec::new());
        let mut sums = self.level_sums(0);
        self.each_piece(&[point.to_vec()], |piece, forces| {
            let mut residual: Vec<f64> =
                forces[0].iter().zip(piece.measured).map(|(f, y)| f - y).collect();
            if piece.trace == trace {
                let touch = piece.motion.displacement.iter().position(|&x| x > 0.0);
                apart.push(StretchResidual {
                    residual: residual.clone(),
                    touch: touch.unwrap_or(0),
                });
            }
            if self.fitted(piece) {
                self.whitening.apply(&mut residual);
                if let Some(sums) = &mut sums {
                    sums.add(piece.trace, &self.unit_level(residual.len()), &[], &residual, 0);
                }
                normal.cost += residual.iter().map(|r| r * r).sum::<f64>();
            }
        });
        self.marginalise(sums.as_ref(), &mut normal);
        (normal.cost, apart)
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

    fn scene(&self, index: usize) -> Cow<'_, Scene<'a>> {
        match self.scenes.get(index) {
            Some(scene) => Cow::Borrowed(scene),
            None => Cow::Owned(self.data.scene(&self.data.pieces[index])),
        }
    }

    /// Runs the chain at several points over every stretch and hands over, stretch by stretch, what
    /// each predicts. The runs are over all stretches in order: what is remembered stays right.
    pub fn each_piece(&self, points: &[Vec<f64>], mut sink: impl FnMut(&Piece, &[Vec<f64>])) {
        let declared: Vec<Vec<f64>> = points.iter().map(|point| self.declared(point)).collect();
        let mut histories = vec![History::default(); points.len()];
        let mut forces = vec![Vec::new(); points.len()];
        let mut elasticity = Elasticity::default();
        for (index, piece) in self.data.pieces.iter().enumerate() {
            let scene = self.scene(index);
            for ((parameters, history), force) in
                declared.iter().zip(&mut histories).zip(&mut forces)
            {
                self.chain.run(parameters, &scene, history, &mut elasticity, force);
            }
            sink(piece, &forces);
        }
    }

    /// Predicted signal of every stretch.
    #[must_use]
    pub fn predict(&self, point: &[f64]) -> Vec<Vec<f64>> {
        let mut found = Vec::new();
        self.each_piece(&[point.to_vec()], |_, forces| found.push(forces[0].clone()));
        found
    }

    /// Residuals (measured minus predicted) of every stretch.
    #[must_use]
    pub fn residuals(&self, point: &[f64]) -> Vec<Vec<f64>> {
        let mut found = Vec::new();
        self.each_piece(&[point.to_vec()], |piece, forces| {
            found.push(piece.measured.iter().zip(&forces[0]).map(|(y, f)| y - f).collect());
        });
        found
    }

    /// Steps of the derivatives at a point, within the bounds.
    fn steps(&self, point: &[f64]) -> Vec<f64> {
        let step = |(&value, &(lower, upper)): (&f64, &(f64, f64))| {
            let range = upper - lower;
            let range = if range.is_finite() { range } else { 1.0 };
            let step = STEP.0 * value.abs() + STEP.1 * range;
            if value + step > upper { -step } else { step }
        };
        point.iter().zip(&self.bounds).map(step).collect()
    }

    /// Hands over, stretch by stretch, the residual (predicted minus measured) and its derivatives, not
    /// whitened: a column for each coordinate that the stretch depends on. The others have none.
    pub fn derivatives(&self, point: &[f64], mut sink: impl FnMut(&Piece, Vec<f64>, Columns)) {
        let steps = self.steps(point);
        let moved = |j: usize| {
            let mut moved = point.to_vec();
            moved[j] += steps[j];
            self.declared(&moved)
        };
        let owned: Vec<Vec<usize>> =
            (0..self.data.labels.len()).map(|trace| self.chain.own_of_trace(trace)).collect();
        let moves = |&j: &usize| self.bounds[j].0 < self.bounds[j].1;
        let shared: Vec<(usize, Vec<f64>)> = (0..point.len())
            .filter(moves)
            .filter(|j| owned.iter().all(|own| !own.contains(j)))
            .map(|j| (j, moved(j)))
            .collect();
        let at_point = self.declared(point);
        let mut history = History::default();
        let mut histories = vec![History::default(); shared.len()];
        let mut elasticity = Elasticity::default();
        let (mut base, mut force) = (Vec::new(), Vec::new());
        for (index, piece) in self.data.pieces.iter().enumerate() {
            let scene = self.scene(index);
            let before = history.clone();
            self.chain.run(&at_point, &scene, &mut history, &mut elasticity, &mut base);
            let slope = |j: usize, force: &[f64]| -> (usize, Vec<f64>) {
                let change = |(moved, at): (&f64, &f64)| (moved - at) / steps[j];
                (j, force.iter().zip(&base).map(change).collect())
            };
            let mut columns = Columns::with_capacity(shared.len());
            for ((j, parameters), history) in shared.iter().zip(&mut histories) {
                self.chain.run(parameters, &scene, history, &mut elasticity, &mut force);
                columns.push(slope(*j, &force));
            }
            // What belongs to this trace alone begins where the others have left it.
            for &j in owned[piece.trace].iter().filter(|j| moves(j)) {
                let mut history = before.clone();
                self.chain.run(&moved(j), &scene, &mut history, &mut elasticity, &mut force);
                columns.push(slope(j, &force));
            }
            let residual = base.iter().zip(piece.measured).map(|(f, y)| f - y).collect();
            sink(piece, residual, columns);
        }
    }

    /// The normal equations of every block of the data, whitened and as they are. A block is a trace,
    /// or a part of one where there are few.
    #[must_use]
    pub fn blocks(&self, point: &[f64]) -> Vec<Block> {
        let parts = FEWEST_BLOCKS.div_ceil(self.data.pieces.len().max(1));
        let mut blocks = Vec::new();
        self.derivatives(point, |piece, mut residual, mut columns| {
            let count = residual.len();
            let size = count.div_ceil(parts).max(1);
            let first = blocks.len();
            for begin in (0..count).step_by(size) {
                let mut block = Block::new(piece.trace, point.len());
                block.levels = self.level_sums(point.len());
                let range = begin..(begin + size).min(count);
                block.samples = range.len();
                block.raw.add(&columns, &residual, range.clone());
                blocks.push(block);
            }
            let unit = self.unit_level(count);
            self.whitening.apply(&mut residual);
            for (_, column) in &mut columns {
                self.whitening.apply(column);
            }
            for (block, begin) in blocks[first..].iter_mut().zip((0..count).step_by(size)) {
                let range = begin..(begin + size).min(count);
                block.slow = sums_of_neighbours(&residual[range.clone()]);
                if let Some(sums) = &mut block.levels {
                    sums.add(piece.trace, &unit[range.clone()], &columns, &residual, range.start);
                }
                block.white.add(&columns, &residual, range);
            }
        });
        blocks
    }

    /// Sum of squares and number of samples of every trace, not whitened.
    #[must_use]
    pub fn trace_squares(&self, point: &[f64]) -> Vec<(f64, usize)> {
        let mut sums = vec![(0.0, 0); self.data.labels.len()];
        self.each_piece(&[point.to_vec()], |piece, forces| {
            let (sum, count) = &mut sums[piece.trace];
            *sum += forces[0].iter().zip(piece.measured).map(|(f, y)| (f - y).powi(2)).sum::<f64>();
            *count += piece.measured.len();
        });
        sums
    }

    /// Sum of products of neighbouring residuals over the sum of squares, not whitened.
    #[must_use]
    pub fn autocorrelation(&self, point: &[f64]) -> f64 {
        let (mut product, mut square) = (0.0, 0.0);
        self.each_piece(&[point.to_vec()], |piece, forces| {
            let residual: Vec<f64> =
                forces[0].iter().zip(piece.measured).map(|(f, y)| f - y).collect();
            product += residual.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>();
            square += residual.iter().map(|r| r * r).sum::<f64>();
        });
        if square > 0.0 { product / square } else { 0.0 }
    }

    /// Sums over no samples, where slow noise moves the levels of the traces.
    fn level_sums(&self, coordinates: usize) -> Option<LevelSums> {
        self.whitening.levels().map(|levels| LevelSums::zeros(coordinates, levels.traces()))
    }

    /// The whitened unit level of a stretch; empty where nothing moves the levels.
    fn unit_level(&self, samples: usize) -> Vec<f64> {
        self.whitening.levels().map_or(Vec::new(), |_| self.whitening.unit_level(samples))
    }

    /// Takes out of normal equations what the levels of the traces could explain.
    pub fn marginalise(&self, sums: Option<&LevelSums>, normal: &mut Normal) {
        if let (Some(levels), Some(sums)) = (self.whitening.levels(), sums) {
            levels.marginalise(sums, normal);
        }
    }

    /// Sum of squares of the whitened residual of one trace, from that of its stretches, without what
    /// its level could explain.
    #[must_use]
    pub fn whitened_square(&self, trace: usize, stretches: &mut [Vec<f64>]) -> f64 {
        let (mut square, mut along, mut of_unit) = (0.0, 0.0, 0.0);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for residual in stretches {
            let unit = self.unit_level(residual.len());
            self.whitening.apply(residual);
            square += dot(residual, residual);
            along += dot(&unit, residual);
            of_unit += dot(&unit, &unit);
        }
        match self.whitening.levels() {
            Some(levels) => levels.of_one(trace, square, along, of_unit),
            None => square,
        }
    }

    fn fitted(&self, piece: &Piece) -> bool {
        self.left_out != Some(piece.trace)
    }
}

/// The residual of one stretch.
#[derive(Clone, Debug)]
pub struct StretchResidual {
    /// Predicted minus measured.
    pub residual: Vec<f64>,
    /// Number of samples before the touch; 0 where it is not touched.
    pub touch: usize,
}

/// Derivatives of one stretch: coordinates and their columns.
pub type Columns = Vec<(usize, Vec<f64>)>;

/// Fewest blocks that data are taken apart into.
const FEWEST_BLOCKS: usize = 8;

/// The normal equations of one part of the data.
#[derive(Clone, Debug)]
pub struct Block {
    /// The trace it is of.
    pub trace: usize,
    /// Number of samples.
    pub samples: usize,
    /// Whitened.
    pub white: Normal,
    /// As they are.
    pub raw: Normal,
    /// Sum over runs of neighbours of the squared sum of their whitened residuals, over their number:
    /// the sum of squares times the number of samples that count as one.
    pub slow: f64,
    /// What the levels of the traces have in common with it, where slow noise moves them.
    pub levels: Option<LevelSums>,
}

/// Least and largest number of neighbours whose residuals are summed.
const NEIGHBOURS: (usize, usize) = (8, 216);

fn sums_of_neighbours(residual: &[f64]) -> f64 {
    let length = (residual.len() / 16).clamp(NEIGHBOURS.0, NEIGHBOURS.1);
    let run = |run: &[f64]| run.iter().sum::<f64>().powi(2) / run.len() as f64;
    residual.chunks(length).map(run).sum()
}

impl Block {
    fn new(trace: usize, dimension: usize) -> Self {
        let zeros = || Normal::zeros(dimension);
        Self { trace, samples: 0, white: zeros(), raw: zeros(), slow: 0.0, levels: None }
    }
}

/// Bounds of every coordinate.
fn bounds(coordinates: &Coordinates, chain: &Chain, data: &Data) -> Vec<(f64, f64)> {
    let mut bounds = coordinates.bounds(data);
    bounds.extend(chain.parameters()[chain.base.count()..].iter().map(|p| (p.lower, p.upper)));
    bounds
}

impl Normal {
    /// Adds a range of samples: derivatives column by column, and residuals.
    pub fn add(&mut self, columns: &Columns, residual: &[f64], range: Range<usize>) {
        let mut entries = Vec::with_capacity(range.len() * columns.len());
        for (_, column) in columns {
            entries.extend_from_slice(&column[range.clone()]);
        }
        let jacobian = DMatrix::from_vec(range.len(), columns.len(), entries);
        let residual = DVector::from_column_slice(&residual[range]);
        let along = jacobian.tr_mul(&residual);
        let products = jacobian.transpose() * &jacobian;
        self.cost += residual.norm_squared();
        for (a, (i, _)) in columns.iter().enumerate() {
            self.gradient[*i] += along[a];
            for (b, (j, _)) in columns.iter().enumerate() {
                self.curvature[(*i, *j)] += products[(a, b)];
            }
        }
    }
}

impl LeastSquares for Problem<'_> {
    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn cost(&self, point: &[f64]) -> f64 {
        let mut normal = Normal::zeros(0);
        let mut sums = self.level_sums(0);
        self.each_piece(&[point.to_vec()], |piece, forces| {
            if self.fitted(piece) {
                let mut residual: Vec<f64> =
                    forces[0].iter().zip(piece.measured).map(|(f, y)| f - y).collect();
                self.whitening.apply(&mut residual);
                if let Some(sums) = &mut sums {
                    sums.add(piece.trace, &self.unit_level(residual.len()), &[], &residual, 0);
                }
                normal.cost += residual.iter().map(|r| r * r).sum::<f64>();
            }
        });
        self.marginalise(sums.as_ref(), &mut normal);
        normal.cost
    }

    fn normal(&self, point: &[f64]) -> Normal {
        let mut normal = Normal::zeros(point.len());
        let mut sums = self.level_sums(point.len());
        self.derivatives(point, |piece, mut residual, mut columns| {
            if self.fitted(piece) {
                self.whitening.apply(&mut residual);
                for (_, column) in &mut columns {
                    self.whitening.apply(column);
                }
                if let Some(sums) = &mut sums {
                    let unit = self.unit_level(residual.len());
                    sums.add(piece.trace, &unit, &columns, &residual, 0);
                }
                normal.add(&columns, &residual, 0..residual.len());
            }
        });
        self.marginalise(sums.as_ref(), &mut normal);
        normal
    }
}
