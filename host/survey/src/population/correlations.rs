//! How what varies goes together over the specimens: the covariance of the population by the global two-stage method (Steimer,
//! Mallet, Golmard and Boisvieux 1984), an expectation-maximisation over specimens whose estimates have known covariances.

use nalgebra::{DMatrix, DVector};

/// Estimates of one specimen, with their covariance.
#[derive(Clone, Debug)]
pub(super) struct Estimated {
    pub(super) values: DVector<f64>,
    pub(super) covariance: DMatrix<f64>,
}

/// Most rounds.
const ROUNDS: usize = 200;
/// Change of a correlation below which it has settled.
const SETTLED: f64 = 1e-4;
/// Specimens that suffice; of more, every so many-th is taken.
const ENOUGH: usize = 5_000;

/// Correlations between the true values over the specimens; none where a covariance is singular.
pub(super) fn correlations(specimens: &[Estimated]) -> Option<DMatrix<f64>> {
    let each = specimens.len().div_ceil(ENOUGH).max(1);
    let specimens: Vec<&Estimated> = specimens.iter().step_by(each).collect();
    let size = specimens.first()?.values.len();
    let count = specimens.len() as f64;
    let mut mean = specimens.iter().fold(DVector::zeros(size), |sum, it| sum + &it.values) / count;
    let off = |mean: &DVector<f64>, it: &Estimated| &it.values - mean;
    let mut spread = specimens.iter().fold(DMatrix::zeros(size, size), |sum, it| {
        let off = off(&mean, it);
        sum + &off * off.transpose()
    }) / count;
    let mut found = correlation_of(&spread);
    for _ in 0..ROUNDS {
        let mut weights = DMatrix::zeros(size, size);
        let mut along = DVector::zeros(size);
        let mut inverses = Vec::with_capacity(specimens.len());
        for it in &specimens {
            let inverse = (&spread + &it.covariance).cholesky()?.inverse();
            weights += &inverse;
            along += &inverse * &it.values;
            inverses.push(inverse);
        }
        let own = weights.cholesky()?;
        mean = own.solve(&along);
        // What the mean is unsure by counts as spread: the restricted likelihood.
        let unsure = own.inverse();
        let mut next = DMatrix::zeros(size, size);
        for (it, inverse) in specimens.iter().zip(&inverses) {
            let gain = &spread * inverse;
            let likeliest = &gain * off(&mean, it);
            next += &likeliest * likeliest.transpose() + &spread - &gain * &spread
                + &gain * &unsure * gain.transpose();
        }
        spread = next / count;
        spread = (&spread + spread.transpose()) * 0.5;
        let now = correlation_of(&spread);
        let moved = (&now - &found).abs().max();
        found = now;
        if moved < SETTLED {
            break;
        }
    }
    found.iter().all(|value| value.is_finite()).then_some(found)
}

fn correlation_of(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let scale = covariance.diagonal().map(|v| 1.0 / v.sqrt());
    DMatrix::from_fn(covariance.nrows(), covariance.ncols(), |i, j| {
        if i == j { 1.0 } else { covariance[(i, j)] * scale[i] * scale[j] }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Errors of fits go together strongly; what specimens are goes together the other way.
    #[test]
    fn errors_of_the_fits_are_taken_off() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let error = DMatrix::from_row_slice(2, 2, &[1.0, 0.9, 0.9, 1.0]);
        let specimen = DMatrix::from_row_slice(2, 2, &[1.0, -0.5, -0.5, 1.0]);
        let roots = [&error, &specimen].map(|it| it.clone().cholesky().unwrap().l());
        let mut draw = |root: &DMatrix<f64>| {
            root * DVector::from_fn(2, |_, _| StandardNormal.sample(&mut random))
        };
        let specimens: Vec<Estimated> = (0..2_000)
            .map(|_| Estimated {
                values: draw(&roots[1]) + draw(&roots[0]),
                covariance: error.clone(),
            })
            .collect();
        let found = correlations(&specimens).unwrap();
        assert!((found[(0, 1)] + 0.5).abs() < 0.1, "{found}");
        let mean_product =
            specimens.iter().map(|it| it.values[0] * it.values[1]).sum::<f64>() / 4_000.0;
        assert!(mean_product > 0.1, "the values themselves go together: {mean_product}");
    }
}
