//! Nonlinear least squares of a curve with few parameters, its derivatives by differences.

use nalgebra::{DMatrix, DVector};

use super::least_squares::{Effort, LeastSquares, Normal, Solution, minimise_with};

/// Residuals as a function of parameters that are all about one in size.
struct Problem<'a, F> {
    bounds: &'a [(f64, f64)],
    residuals: F,
}

/// Half the step of the differences.
const STEP: f64 = 1e-6;
/// Slopes to either side that differ by this factor are those of a jump.
const JUMP: f64 = 2.0;

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
            let slope = |step: f64| {
                let mut moved = point.to_vec();
                moved[j] += step;
                (DVector::from((self.residuals)(&moved)) - &residuals) / step
            };
            let (up, down) = (slope(STEP), slope(-STEP));
            // Across a jump a difference says nothing of the slope: the side without one does.
            let (larger, smaller) = if up.norm() > down.norm() { (up, down) } else { (down, up) };
            let jumps = larger.norm() > JUMP * smaller.norm() && smaller.norm() > 0.0;
            let column = if jumps { smaller } else { 0.5 * (larger + smaller) };
            jacobian.set_column(j, &column);
        }
        Normal {
            cost: residuals.norm_squared(),
            gradient: jacobian.tr_mul(&residuals),
            curvature: jacobian.tr_mul(&jacobian),
        }
    }
}

/// A solution with its covariance.
pub struct Fitted {
    /// The parameters, and how the search ended.
    pub solution: Solution,
    /// Standard error of each parameter; infinite where the data do not tell it.
    pub standard_errors: Vec<f64>,
    /// Covariance of the parameters; none where the data do not tell them all.
    pub covariance: Option<DMatrix<f64>>,
    /// Root mean square of the residuals, per degree of freedom.
    pub rms: f64,
}

/// The least squares within bounds, from a start, of `residuals` with `samples` of them.
pub fn least_squares(
    bounds: &[(f64, f64)],
    start: &[f64],
    samples: usize,
    effort: Effort,
    residuals: impl Fn(&[f64]) -> Vec<f64>,
) -> Fitted {
    let solution = minimise_with(&Problem { bounds, residuals }, start, effort);
    let freedom = samples.saturating_sub(start.len()).max(1) as f64;
    let variance = solution.normal.cost / freedom;
    let mut fitted =
        Fitted { solution, standard_errors: Vec::new(), covariance: None, rms: variance.sqrt() };
    fitted.tell(&(0..start.len()).collect::<Vec<usize>>());
    fitted
}

impl Fitted {
    /// The same with a parameter held where it is: one that the data do not tell takes the errors of the others with it.
    pub fn holding(mut self, place: usize) -> Self {
        let free: Vec<usize> = (0..self.standard_errors.len()).filter(|&j| j != place).collect();
        self.tell(&free);
        self
    }

    /// Covariance and standard errors of the free parameters; those of the others are infinite.
    fn tell(&mut self, free: &[usize]) {
        let curvature = &self.solution.normal.curvature;
        let count = self.solution.point.len();
        let part = DMatrix::from_fn(free.len(), free.len(), |i, j| curvature[(free[i], free[j])]);
        let inverse = part.cholesky().map(|root| root.inverse() * self.rms.powi(2));
        self.standard_errors = vec![f64::INFINITY; count];
        self.covariance = inverse.map(|inverse| {
            let mut whole = DMatrix::zeros(count, count);
            for (i, &a) in free.iter().enumerate() {
                for (j, &b) in free.iter().enumerate() {
                    whole[(a, b)] = inverse[(i, j)];
                }
                self.standard_errors[a] = inverse[(i, i)].max(0.0).sqrt();
            }
            whole
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_beside_the_solution_does_not_pass_for_a_slope() {
        let residuals = |p: &[f64]| {
            let jump = if p[0] > 0.5 + 0.5 * STEP { 3.0 } else { 0.0 };
            vec![p[0] - 0.4, p[0] - 0.6, jump]
        };
        let fitted = least_squares(&[(0.0, 1.0)], &[0.5], 3, Effort::FULL, residuals);
        // Two samples of slope 1 about their mean.
        let error = fitted.rms / 2f64.sqrt();
        assert!(
            (fitted.standard_errors[0] / error - 1.0).abs() < 1e-6,
            "{:?}",
            fitted.standard_errors
        );
    }

    #[test]
    fn a_parameter_that_nothing_tells_can_be_held() {
        let residuals = |p: &[f64]| vec![p[0] - 0.4, p[0] - 0.6, 0.0 * p[1]];
        let fitted = least_squares(&[(0.0, 1.0); 2], &[0.5, 0.5], 3, Effort::FULL, residuals);
        assert!(fitted.covariance.is_none() && fitted.standard_errors[0].is_infinite());
        let fitted = fitted.holding(1);
        assert!((fitted.standard_errors[0] / (fitted.rms / 2f64.sqrt()) - 1.0).abs() < 1e-6);
        assert!(fitted.standard_errors[1].is_infinite());
    }
}
