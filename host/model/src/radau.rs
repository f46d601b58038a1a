//! An integrator to test the laws against: Radau IIA of order 5, stiff and implicit, in even steps.

use nalgebra::{DMatrix, DVector};

/// Right-hand side y' = f(t, y).
type Right<'a> = &'a dyn Fn(f64, &DVector<f64>) -> DVector<f64>;

/// What becomes of `y` from one time to another, in so many even steps.
pub(super) fn radau(
    right: Right,
    y: &DVector<f64>,
    (from, to): (f64, f64),
    steps: usize,
) -> DVector<f64> {
    let step = (to - from) / steps as f64;
    (0..steps).fold(y.clone(), |y, k| advance(right, &y, from + k as f64 * step, step))
}

fn advance(right: Right, y: &DVector<f64>, time: f64, step: f64) -> DVector<f64> {
    let root = 6f64.sqrt();
    let nodes = [(4.0 - root) / 10.0, (4.0 + root) / 10.0, 1.0];
    let weights = [
        [(88.0 - 7.0 * root) / 360.0, (296.0 - 169.0 * root) / 1800.0, (-2.0 + 3.0 * root) / 225.0],
        [(296.0 + 169.0 * root) / 1800.0, (88.0 + 7.0 * root) / 360.0, (-2.0 - 3.0 * root) / 225.0],
        [(16.0 - root) / 36.0, (16.0 + root) / 36.0, 1.0 / 9.0],
    ];
    let size = y.len();
    // Stages as one vector z, with z_i = h Σ a_ij f(t + c_j h, y + z_j).
    let residual = |z: &DVector<f64>| {
        let slopes: Vec<_> =
            (0..3).map(|j| right(time + nodes[j] * step, &(y + z.rows(j * size, size)))).collect();
        let mut rest = z.clone();
        for (i, row) in weights.iter().enumerate() {
            for (weight, slope) in row.iter().zip(&slopes) {
                let mut part = rest.rows_mut(i * size, size);
                part -= slope * (step * weight);
            }
        }
        rest
    };
    let mut z = DVector::zeros(3 * size);
    let scale = y.amax().max(1e-6);
    for _ in 0..30 {
        let rest = residual(&z);
        if rest.amax() <= 1e-14 * scale {
            break;
        }
        let slope = |k: usize| {
            let by = 1e-7 * (z[k].abs() + scale);
            let mut moved = z.clone();
            moved[k] += by;
            (residual(&moved) - &rest) / by
        };
        let jacobian = DMatrix::from_columns(&(0..3 * size).map(slope).collect::<Vec<_>>());
        z -= jacobian.lu().solve(&rest).expect("a regular step");
    }
    y + z.rows(2 * size, size)
}
