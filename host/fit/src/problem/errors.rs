//! Errors by trace, and on traces left out.

use super::Problem;
use crate::remembering::Reached;
use palpate_model::Elasticity;

/// What a fit leaves, in a few numbers.
#[derive(Clone, Debug)]
pub struct Residuals {
    /// Sum of products of neighbouring residuals over the sum of squares.
    pub autocorrelation: f64,
    /// Root mean square residual of each trace, in the unit of the signal.
    pub trace_rms: Vec<f64>,
}

/// The error on one trace.
#[derive(Clone, Debug, Default)]
pub struct Apart {
    /// Sum of squares.
    pub square: f64,
    /// Sum of squares of the whitened residual.
    pub whitened: f64,
    /// Number of samples.
    pub samples: usize,
    /// Residual (predicted minus measured) before the touch, each value with the weight of the samples that it stands for.
    pub before: Vec<f64>,
}

impl Problem<'_> {
    /// The whitened sum of squares over the traces that are fitted, and the error on each that is left out, in order.
    #[must_use]
    pub fn apart(&self, point: &[f64]) -> (f64, Vec<Apart>) {
        let count = self.data.labels.len();
        let traces: Vec<usize> = self.left_out.iter().flat_map(|fold| fold.traces(count)).collect();
        let mut aparts = vec![Apart::default(); traces.len()];
        let mut stretches: Vec<Vec<(usize, Vec<f64>)>> = vec![Vec::new(); traces.len()];
        let cost = self.fitted_cost(point, &mut Reached::default(), |index, piece, residual| {
            let Ok(place) = traces.binary_search(&piece.trace) else { return };
            let apart = &mut aparts[place];
            let mut weighted = residual.to_vec();
            self.weigh(index, &mut weighted);
            let scatter: f64 = self.scatter(index).iter().sum();
            apart.square += scatter + weighted.iter().map(|r| r * r).sum::<f64>();
            apart.samples += self.rows_of(index, 0..usize::MAX);
            let touch = self.data.touch(piece);
            apart.before.extend_from_slice(&weighted[..touch.unwrap_or(0)]);
            stretches[place].push((index, residual.to_vec()));
        });
        for ((&trace, apart), stretches) in traces.iter().zip(&mut aparts).zip(&mut stretches) {
            apart.whitened = self.whitened_square(trace, stretches);
        }
        (cost, aparts)
    }

    /// Sum of squares and number of samples, not whitened, of each trace that is left out, in order. What comes after the last of them is
    /// not run.
    #[must_use]
    pub fn left_out_squares(&self, point: &[f64]) -> Vec<(f64, usize)> {
        let Some(fold) = self.left_out else { return Vec::new() };
        let traces: Vec<usize> = fold.traces(self.data.labels.len()).collect();
        let mut sums = vec![(0.0, 0); traces.len()];
        let last = self.data.pieces.iter().rposition(|piece| fold.holds(piece.trace));
        let (mut run, mut elasticity) = (self.run_at(point), Elasticity::default());
        let mut force = self.spare.take();
        for (index, piece) in self.data.pieces.iter().enumerate().take(last.map_or(0, |k| k + 1)) {
            self.advance(&mut run, index, &mut elasticity, &mut force);
            let Ok(place) = traces.binary_search(&piece.trace) else { continue };
            let (sum, count) = &mut sums[place];
            let residual = force.iter().zip(piece.measured).map(|(force, y)| force - y);
            *sum += residual.map(|r| r * r).sum::<f64>();
            *count += piece.measured.len();
        }
        self.spare.give([force]);
        sums
    }

    /// Sum of squares of the whitened residual of one trace, from that of its stretches by their index, without what
    /// its level could explain.
    fn whitened_square(&self, trace: usize, stretches: &mut [(usize, Vec<f64>)]) -> f64 {
        let (mut square, mut along, mut of_unit) = (0.0, 0.0, 0.0);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for (index, residual) in stretches {
            let unit = self.unit_level(*index);
            self.whiten_residual(*index, residual);
            square += dot(residual, residual);
            square += self.means.get(*index).map_or(0.0, |means| means.white.iter().sum());
            along += dot(&unit, residual);
            of_unit += dot(&unit, &unit);
        }
        match self.whitening.levels() {
            Some(levels) => levels.of_one(trace, square, along, of_unit),
            None => square,
        }
    }

    /// Sum of squares and number of samples of every trace, not whitened.
    #[must_use]
    pub fn trace_squares(&self, point: &[f64]) -> Vec<(f64, usize)> {
        let mut sums = vec![(0.0, 0); self.data.labels.len()];
        let mut index = 0;
        self.each_piece(&[point.to_vec()], |piece, forces| {
            let (sum, count) = &mut sums[piece.trace];
            let mut residual: Vec<f64> =
                forces[0].iter().zip(piece.measured).map(|(f, y)| f - y).collect();
            self.weigh(index, &mut residual);
            *sum += residual.iter().map(|r| r * r).sum::<f64>();
            *sum += self.scatter(index).iter().sum::<f64>();
            *count += self.rows_of(index, 0..usize::MAX);
            index += 1;
        });
        sums
    }

    /// Root mean square of the residual, not whitened.
    #[must_use]
    pub fn rms(&self, point: &[f64]) -> f64 {
        let squares: f64 = self.trace_squares(point).iter().map(|(square, _)| square).sum();
        (squares / self.rows() as f64).sqrt()
    }

    /// What is left, not whitened, in a few numbers.
    #[must_use]
    pub fn residuals_in_short(&self, point: &[f64]) -> Residuals {
        let mut traces = vec![(0.0, 0); self.data.labels.len()];
        let mut product = 0.0;
        self.each_piece(&[point.to_vec()], |piece, forces| {
            let (square, count) = &mut traces[piece.trace];
            let mut before = 0.0;
            for (force, measured) in forces[0].iter().zip(piece.measured) {
                let residual = force - measured;
                product += before * residual;
                *square += residual * residual;
                before = residual;
            }
            *count += piece.measured.len();
        });
        let square: f64 = traces.iter().map(|(square, _)| square).sum();
        let rms = |(square, count): &(f64, usize)| (square / (*count as f64).max(1.0)).sqrt();
        Residuals {
            autocorrelation: if square > 0.0 { product / square } else { 0.0 },
            trace_rms: traces.iter().map(rms).collect(),
        }
    }
}
