//! What the data say of each parameter: covariance from the curvature at the minimum.

use nalgebra::{DMatrix, DVector};

/// Covariance of coordinates, and the directions that the data do not determine.
#[derive(Clone, Debug)]
pub struct Uncertainty {
    /// Covariance in the units of the coordinates; zero rows where a coordinate was held.
    pub covariance: DMatrix<f64>,
    /// Directions in which the coordinates, over `scale`, can move without changing the prediction.
    flat: Vec<DVector<f64>>,
    /// Units in which every coordinate has the curvature one.
    scale: DVector<f64>,
}

impl Uncertainty {
    /// Variance of a quantity with this slope to the coordinates; none where the data do not
    /// determine it.
    #[must_use]
    pub fn variance(&self, slope: &DVector<f64>) -> Option<f64> {
        let scaled = slope.component_mul(&self.scale);
        let moves = |direction: &DVector<f64>| scaled.dot(direction).abs() > 1e-3 * scaled.norm();
        let variance = slope.dot(&(&self.covariance * slope));
        (!self.flat.iter().any(moves) && variance > 0.0).then_some(variance)
    }
}

/// Below this share of the largest curvature (in units where every coordinate has curvature one) a
/// direction counts as undetermined.
const FLAT: f64 = 1e-10;

/// Inverts the curvature JᵀJ over the coordinates that are not `held`, times `variance` of a
/// residual. Directions without curvature are left out of the inverse and remembered.
#[must_use]
pub fn uncertainty(curvature: &DMatrix<f64>, held: &[bool], variance: f64) -> Uncertainty {
    let dimension = held.len();
    let mut covariance = DMatrix::zeros(dimension, dimension);
    let mut flat = Vec::new();
    let free: Vec<usize> = (0..dimension).filter(|&j| !held[j]).collect();
    let scale = curvature.diagonal().map(|size| if size > 0.0 { 1.0 / size.sqrt() } else { 1.0 });
    let scaled = DMatrix::from_fn(free.len(), free.len(), |a, b| {
        curvature[(free[a], free[b])] * scale[free[a]] * scale[free[b]]
    });
    let eigen = scaled.symmetric_eigen();
    let largest = eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
    for (k, &value) in eigen.eigenvalues.iter().enumerate() {
        let direction = eigen.eigenvectors.column(k);
        if value <= FLAT * largest {
            let mut along = DVector::zeros(dimension);
            for (a, &j) in free.iter().enumerate() {
                along[j] = direction[a];
            }
            flat.push(along);
            continue;
        }
        for (a, &i) in free.iter().enumerate() {
            for (b, &j) in free.iter().enumerate() {
                covariance[(i, j)] +=
                    variance * direction[a] * direction[b] * scale[i] * scale[j] / value;
            }
        }
    }
    Uncertainty { covariance, flat, scale }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn along(slope: [f64; 3]) -> DVector<f64> {
        DVector::from_column_slice(&slope)
    }

    #[test]
    fn inverts_what_is_determined() {
        let curvature = DMatrix::from_row_slice(2, 2, &[4.0, 1.0, 1.0, 900.0]);
        let found = uncertainty(&curvature, &[false, false], 2.0);
        let expected = curvature.try_inverse().unwrap() * 2.0;
        assert!((&found.covariance - &expected).norm() < 1e-14);
        let sum = DVector::from_column_slice(&[1.0, 1.0]);
        assert!((found.variance(&sum).unwrap() - expected.sum()).abs() < 1e-14);
    }

    #[test]
    fn what_trades_off_has_no_error_but_the_sum_has() {
        // Only the sum of the first two matters.
        let curvature = DMatrix::from_row_slice(3, 3, &[1., 1., 0., 1., 1., 0., 0., 0., 5.]);
        let found = uncertainty(&curvature, &[false; 3], 1.0);
        assert_eq!(found.variance(&along([1.0, 0.0, 0.0])), None);
        assert_eq!(found.variance(&along([0.0, 1.0, 0.0])), None);
        assert!((found.variance(&along([1.0, 1.0, 0.0])).unwrap() - 1.0).abs() < 1e-14);
        assert!((found.variance(&along([0.0, 0.0, 1.0])).unwrap() - 0.2).abs() < 1e-14);
    }

    #[test]
    fn a_held_coordinate_has_no_error() {
        let curvature = DMatrix::from_row_slice(2, 2, &[4.0, 1.0, 1.0, 9.0]);
        let found = uncertainty(&curvature, &[true, false], 1.0);
        assert_eq!(found.variance(&DVector::from_column_slice(&[1.0, 0.0])), None);
        assert!((found.covariance[(1, 1)] - 1.0 / 9.0).abs() < 1e-15);
    }
}
