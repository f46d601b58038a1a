//! Covariance of (N, c0 … cn, v1 … vn) at a minimum, conditional on what is held there.

use super::fit::{ExponentialSum, MOST_PARAMETERS, Normalisation, Term};
use super::point::Problem;
use super::refine::{Cholesky, Refined};

/// Covariance for noise of standard deviation 1; rows and columns N, c0 … cn, v1 … vn.
pub(super) type Matrix = [[f64; MOST_PARAMETERS]; MOST_PARAMETERS];

/// The minimum in the terms of eq. 3.3, terms from the fastest to the slowest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Described<const N: usize> {
    pub scale: f64,
    pub constant: f64,
    pub coefficients: [f64; N],
    pub rates: [f64; N],
    /// Place of each term at the minimum, where they are ascending.
    pub order: [usize; N],
    pub covariance: Matrix,
}

impl<const N: usize> Described<N> {
    /// As a function of time.
    pub fn sum(&self) -> ExponentialSum {
        let terms = self.coefficients.into_iter().zip(self.rates);
        ExponentialSum {
            scale: self.scale,
            constant: self.constant,
            terms: terms.map(|(coefficient, rate)| Term { coefficient, rate }).collect(),
        }
    }
}

/// Amplitudes and logarithms of rates, or their change with one unit of noise.
#[derive(Clone, Copy)]
struct Amplitudes<const N: usize> {
    constant: f64,
    terms: [f64; N],
    u: [f64; N],
}

/// Takes a minimum to the coordinates of eq. 3.3 and its covariance there by the delta method:
/// noise along each direction that the model can follow moves the parameters by one column.
pub(super) fn describe<const N: usize, const R: usize>(
    problem: &Problem<R>,
    refined: &Refined<N, R>,
    normalisation: Normalisation,
) -> Described<N> {
    let point = &refined.point;
    let sum: f64 = point.amplitudes.iter().sum();
    let scale = match normalisation {
        Normalisation::Initial => point.constant + sum,
        Normalisation::Asymptotic => point.constant,
    };
    let order: [usize; N] = std::array::from_fn(|i| N - 1 - i);
    let mut described = Described {
        scale,
        constant: point.constant / scale,
        coefficients: order.map(|i| point.amplitudes[i] / scale),
        rates: order.map(|i| point.u[i].exp()),
        order,
        covariance: [[0.0; MOST_PARAMETERS]; MOST_PARAMETERS],
    };
    columns(problem, refined, |change| {
        let sum: f64 = change.terms.iter().sum();
        let scale_change = match normalisation {
            Normalisation::Initial => change.constant + sum,
            Normalisation::Asymptotic => change.constant,
        };
        let mut column = [0.0; MOST_PARAMETERS];
        column[0] = scale_change;
        column[1] = (change.constant - described.constant * scale_change) / scale;
        for (k, i) in order.into_iter().enumerate() {
            let change_here = change.terms[i] - described.coefficients[k] * scale_change;
            column[2 + k] = change_here / scale;
            column[2 + N + k] = described.rates[k] * change.u[i];
        }
        for i in 0..2 + 2 * N {
            for j in 0..=i {
                described.covariance[i][j] += column[i] * column[j];
            }
        }
    });
    for i in 0..2 + 2 * N {
        for j in 0..i {
            described.covariance[j][i] = described.covariance[i][j];
        }
    }
    described
}

/// By how many variances of the noise the sum of squares would rise, in the linear theory, if the
/// least significant term were left out or merged with its neighbour.
pub(super) fn significance<const N: usize, const R: usize>(
    problem: &Problem<R>,
    refined: &Refined<N, R>,
) -> f64 {
    let mut amplitudes = [0.0; N];
    let mut ratios = [0.0; N];
    columns(problem, refined, |change| {
        for i in 0..N {
            amplitudes[i] += change.terms[i] * change.terms[i];
            if i > 0 {
                let ratio = change.u[i] - change.u[i - 1];
                ratios[i] += ratio * ratio;
            }
        }
    });
    let point = &refined.point;
    let mut least = f64::INFINITY;
    for i in 0..N {
        if !point.face.terms[i] || refined.curvature.directions.of[i].is_none() {
            return 0.0;
        }
        least = least.min(point.amplitudes[i] * point.amplitudes[i] / amplitudes[i]);
        if i > 0 {
            let ratio = point.u[i] - point.u[i - 1];
            least = least.min(ratio * ratio / ratios[i]);
        }
    }
    if least.is_nan() { 0.0 } else { least }
}

/// Independent changes of the amplitudes and rates whose outer products sum to the covariance.
#[inline]
fn columns<const N: usize, const R: usize>(
    problem: &Problem<R>,
    refined: &Refined<N, R>,
    mut add: impl FnMut(&Amplitudes<N>),
) {
    let point = &refined.point;
    // The constant follows from the mean of what the terms leave.
    let level = |terms: &[f64; N], u: &[f64; N]| {
        let mut level = 0.0;
        for i in 0..N {
            level -= terms[i] * point.values[i][0];
            level -= point.amplitudes[i] * u[i] * point.slopes[i][0];
        }
        if point.face.constant { level / problem.constant_norm } else { 0.0 }
    };
    if point.face.constant {
        let constant = 1.0 / problem.constant_norm;
        add(&Amplitudes { constant, terms: [0.0; N], u: [0.0; N] });
    }
    for i in 0..N {
        if point.face.terms[i] {
            let mut unit = [0.0; N];
            unit[i] = 1.0;
            let terms = point.back_substitute(unit);
            add(&Amplitudes { constant: level(&terms, &[0.0; N]), terms, u: [0.0; N] });
        }
    }
    let curvature = &refined.curvature;
    let directions = curvature.directions;
    let Some(factor) = Cholesky::new(&curvature.hessian, directions.count) else { return };
    for a in 0..directions.count {
        let mut unit = [0.0; N];
        unit[a] = 1.0;
        let step = factor.solve_transposed(unit);
        let u: [f64; N] =
            std::array::from_fn(|i| directions.of[i].map_or(0.0, |direction| step[direction]));
        let along = std::array::from_fn(|j| {
            -(0..N).map(|i| curvature.parts[j][i] * point.amplitudes[i] * u[i]).sum::<f64>()
        });
        let terms = point.back_substitute(along);
        add(&Amplitudes { constant: level(&terms, &u), terms, u });
    }
}
