//! The level of each trace as noise.
//!
//! Flicker noise runs on through the pauses between traces, so that each trace stands a little higher or
//! lower than the ones before. What no single trace is long enough to whiten is taken as one random
//! level for each trace, normally distributed with a known covariance, and integrated out: the normal
//! equations lose what the levels could explain as cheaply as noise does.

use nalgebra::{DMatrix, DVector};

use super::least_squares::Normal;

/// The distribution of the levels of the traces of a data set.
#[derive(Clone, Debug, PartialEq)]
pub struct Levels {
    /// Inverse of their covariance, per squared unit of the signal.
    precision: DMatrix<f64>,
}

/// Inner products of whitened columns with the whitened unit level of each trace.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelSums {
    /// Of every coordinate's derivative: coordinates × traces.
    pub along: DMatrix<f64>,
    /// Of the residual.
    pub residual: DVector<f64>,
    /// Of the level itself.
    pub unit: DVector<f64>,
}

/// Part of the variance that is added to every level by itself, so that the covariance has an inverse.
const RIDGE: f64 = 1e-6;

impl Levels {
    /// Levels with this covariance, in squared units of the signal; none where there is no variance.
    #[must_use]
    pub fn new(covariance: &DMatrix<f64>) -> Option<Self> {
        let largest = covariance.diagonal().max();
        let ridged = covariance
            + DMatrix::identity(covariance.nrows(), covariance.nrows()) * (RIDGE * largest);
        let precision = ridged.cholesky()?.inverse();
        (largest > 0.0).then_some(Self { precision })
    }

    /// Of slow processes of this standard deviation each, with these times, seen at these instants.
    #[must_use]
    pub fn of_processes(deviation: f64, times: &[f64], instants: &[f64]) -> Option<Self> {
        let covariance = |i: usize, j: usize| {
            let apart = (instants[i] - instants[j]).abs();
            deviation.powi(2) * times.iter().map(|time| (-apart / time).exp()).sum::<f64>()
        };
        Self::new(&DMatrix::from_fn(instants.len(), instants.len(), covariance))
    }

    /// Number of traces.
    #[must_use]
    pub fn traces(&self) -> usize {
        self.precision.nrows()
    }

    /// Takes out of normal equations what the levels could explain.
    pub fn marginalise(&self, sums: &LevelSums, normal: &mut Normal) {
        let Some(factor) = (&self.precision + DMatrix::from_diagonal(&sums.unit)).cholesky() else {
            return;
        };
        let of_residual = factor.solve(&sums.residual);
        normal.cost -= sums.residual.dot(&of_residual);
        normal.gradient -= &sums.along * &of_residual;
        normal.curvature -= &sums.along * factor.solve(&sums.along.transpose());
    }

    /// What the levels could explain of the inner products of columns.
    #[must_use]
    pub fn explained(&self, sums: &LevelSums) -> DMatrix<f64> {
        match (&self.precision + DMatrix::from_diagonal(&sums.unit)).cholesky() {
            Some(factor) => &sums.along * factor.solve(&sums.along.transpose()),
            None => DMatrix::zeros(sums.along.nrows(), sums.along.nrows()),
        }
    }

    /// Sum of squares of the whitened residual of one trace without what its level could explain.
    #[must_use]
    pub fn of_one(&self, trace: usize, square: f64, along: f64, unit: f64) -> f64 {
        square - along * along / (unit + self.precision[(trace, trace)])
    }
}

impl LevelSums {
    /// All zero.
    #[must_use]
    pub fn zeros(coordinates: usize, traces: usize) -> Self {
        Self {
            along: DMatrix::zeros(coordinates, traces),
            residual: DVector::zeros(traces),
            unit: DVector::zeros(traces),
        }
    }

    /// Adds whitened samples of one trace: those of its unit level, of derivatives, and of the residual.
    pub fn add(
        &mut self,
        trace: usize,
        unit: &[f64],
        columns: &[(usize, Vec<f64>)],
        residual: &[f64],
        from: usize,
    ) {
        let dot = |column: &[f64]| unit.iter().zip(column).map(|(a, b)| a * b).sum::<f64>();
        for (coordinate, column) in columns {
            self.along[(*coordinate, trace)] += dot(&column[from..from + unit.len()]);
        }
        self.residual[trace] += dot(residual.get(from..from + unit.len()).unwrap_or_default());
        self.unit[trace] += dot(unit);
    }

    /// Adds the sums of other samples, each counted so many times.
    pub fn add_weighted(&mut self, other: &Self, weight: f64) {
        self.along += &other.along * weight;
        self.residual += &other.residual * weight;
        self.unit += &other.unit * weight;
    }
}
