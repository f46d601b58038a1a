//! Nonlinear least squares of a curve with few parameters, its derivatives by differences.

use nalgebra::{DMatrix, DVector};

use crate::fit::least_squares::{LeastSquares, Normal, Solution, minimise};

/// Residuals as a function of parameters that are all about one in size.
struct Problem<'a, F> {
    bounds: &'a [(f64, f64)],
    residuals: F,
}

/// Half the step of the differences.
const STEP: f64 = 1e-6;

impl<F: Fn(&[f64]) -> Vec<f64>> LeastSquares for Problem<'_, F> {
    fn bounds(&self) -> &[(f64, f64)] {
        self.bounds
    }

    fn cost(&self, point: &[f64]) -> f64 {
        (self.residuals)(point).iter().map(|r| r * r).sum()
    }

    fn normal(&self, point: &[f64]) -> Normal {
        let residuals = DVector::from((self.residuals)(point));
        let mut jacobian = DMatrix::zeros(residuals.len(), point.len());
        for j in 0..point.len() {
            let moved = |step: f64| {
                let mut moved = point.to_vec();
                moved[j] += step;
                DVector::from((self.residuals)(&moved))
            };
            jacobian.set_column(j, &((moved(STEP) - moved(-STEP)) / (2.0 * STEP)));
        }
        Normal {
            cost: residuals.norm_squared(),
            gradient: jacobian.tr_mul(&residuals),
            curvature: jacobian.tr_mul(&jacobian),
        }
    }
}

/// A solution with its covariance.
pub(super) struct Fitted {
    pub(super) solution: Solution,
    /// Standard error of each parameter; infinite where the data do not tell it.
    pub(super) standard_errors: Vec<f64>,
    /// Root mean square of the residuals, per degree of freedom.
    pub(super) rms: f64,
}

/// The least squares within bounds, from a start, of `residuals` with `samples` of them.
pub(super) fn least_squares(
    bounds: &[(f64, f64)],
    start: &[f64],
    samples: usize,
    residuals: impl Fn(&[f64]) -> Vec<f64>,
) -> Fitted {
    let solution = minimise(&Problem { bounds, residuals }, start);
    let freedom = samples.saturating_sub(start.len()).max(1) as f64;
    let variance = solution.normal.cost / freedom;
    let inverse = solution.normal.curvature.clone().cholesky().map(|root| root.inverse());
    let error = |j: usize| {
        let square = inverse.as_ref().map_or(f64::INFINITY, |inverse| inverse[(j, j)] * variance);
        if square >= 0.0 { square.sqrt() } else { f64::INFINITY }
    };
    let standard_errors = (0..start.len()).map(error).collect();
    Fitted { solution, standard_errors, rms: variance.sqrt() }
}
