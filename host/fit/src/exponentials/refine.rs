//! From a start to the nearest minimum: Levenberg–Marquardt on the projected problem (Kaufman's
//! Jacobian, whose gradient is exact), rates within their limits by an active set.

use super::point::{Point, Problem};
use super::vector::dot;

/// Two rates are never closer than this in ln v. Nearer, the amplitudes grow without bound and
/// the sum of squares no longer changes: the limit is A t e^(−v t).
pub(super) const fn separation(terms: usize) -> f64 {
    // Amplitudes grow with its inverse to the power terms − 1, and with them what interpolation
    // leaves of the sum of squares.
    if terms < 4 { 1e-3 } else { 1e-2 }
}

/// A step that would lower the sum of squares by a smaller share of it is not taken.
const CONVERGED: f64 = 1e-10;
/// Share of the target's sum of squares that counts as nothing: rounding and interpolation.
const NOTHING: f64 = 1e-24;
/// Shortest and longest step in ln v.
const SHORTEST: f64 = 1e-11;
const STRIDE: f64 = 1.5;
/// A pivot below this share of its diagonal makes a matrix singular.
const SINGULAR: f64 = 1e-14;
const MOST_ITERATIONS: u32 = 300;
const MOST_DAMPING: f64 = 1e12;

/// Why the iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// No step promises to lower the sum of squared residuals by more than 1e-10 of it.
    Converged,
    /// No step, however short, lowers the sum of squared residuals: rounding is all there is.
    Rounding,
    /// The limit of 300 iterations; the values may still improve.
    Iterations,
}

/// Directions in which rates can move: each rate belongs to one or to none.
#[derive(Clone, Copy, Debug)]
pub(super) struct Directions<const N: usize> {
    /// For each rate the direction that moves it; none where it stays.
    pub of: [Option<usize>; N],
    pub count: usize,
}

/// Where an iteration ended.
#[derive(Clone, Copy, Debug)]
pub(super) struct Refined<const N: usize, const R: usize> {
    pub point: Point<N, R>,
    pub curvature: Curvature<N, R>,
    pub iterations: u32,
    pub stop: Stop,
}

/// First and approximate second derivative of half the sum of squares along the directions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Curvature<const N: usize, const R: usize> {
    pub directions: Directions<N>,
    /// Descent along each direction.
    gradient: [f64; N],
    /// Gauss–Newton matrix.
    pub hessian: [[f64; N]; N],
    /// Part of each slope in the span of the free amplitudes.
    pub parts: [[f64; N]; N],
}

/// Moves from `u` to a minimum.
pub(super) fn refine<const N: usize, const R: usize>(
    problem: &Problem<R>,
    u: [f64; N],
) -> Refined<N, R> {
    let limits = (problem.table.lowest, problem.table.highest);
    let nothing = NOTHING * dot(problem.target, problem.target);
    let mut point = problem.point(within(u, limits));
    let mut curvature = Curvature::new(&point, limits);
    let mut damping = 0.0;
    let mut iterations = 0;
    let stop = loop {
        if iterations == MOST_ITERATIONS {
            break Stop::Iterations;
        }
        let Some((step, promised)) = curvature.step(damping) else {
            damping = f64::max(10.0 * damping, 1e-6);
            if damping > MOST_DAMPING {
                break Stop::Rounding;
            }
            continue;
        };
        // A strongly damped step promises little because it is short: only its length counts.
        if damping <= 1.0 {
            if promised <= CONVERGED * point.rss + nothing {
                break Stop::Converged;
            }
        } else if step.iter().all(|part| part.abs() < SHORTEST) {
            break Stop::Rounding;
        }
        iterations += 1;
        let mut u = point.u;
        for (u, direction) in u.iter_mut().zip(curvature.directions.of) {
            if let Some(direction) = direction {
                *u += step[direction].clamp(-STRIDE, STRIDE);
            }
        }
        let trial = problem.point(within(u, limits));
        if trial.rss < point.rss {
            point = trial;
            curvature = Curvature::new(&point, limits);
            damping = if damping < 1e-6 { 0.0 } else { 0.1 * damping };
        } else {
            damping = f64::max(10.0 * damping, 1e-3);
        }
    };
    Refined { point, curvature, iterations, stop }
}

/// Rates in ascending order, within the limits and apart.
fn within<const N: usize>(mut u: [f64; N], (lowest, highest): (f64, f64)) -> [f64; N] {
    let apart = separation(N);
    for u in &mut u {
        *u = u.clamp(lowest, highest);
    }
    u.sort_unstable_by(f64::total_cmp);
    for i in 1..N {
        if u[i] - u[i - 1] < apart {
            let middle = 0.5 * (u[i] + u[i - 1]);
            u[i - 1] = middle - 0.5 * apart;
            u[i] = middle + 0.5 * apart;
        }
    }
    // Pushed apart, some may be out again.
    for i in 0..N {
        let least = if i == 0 { lowest } else { u[i - 1] + apart };
        u[i] = u[i].max(least);
    }
    for i in (0..N).rev() {
        let most = if i + 1 == N { highest } else { u[i + 1] - apart };
        u[i] = u[i].min(most);
    }
    u
}

/// Whether a rate and the next are as close as they may be.
pub(super) fn touching<const N: usize>(u: &[f64; N], lower: usize) -> bool {
    u[lower + 1] - u[lower] <= separation(N) * (1.0 + 1e-6)
}

impl<const N: usize, const R: usize> Curvature<N, R> {
    pub fn new(point: &Point<N, R>, limits: (f64, f64)) -> Self {
        let (rest, parts) = point.outside_slopes();
        let mut descent = [0.0; N];
        let mut full = [[0.0; N]; N];
        for i in 0..N {
            descent[i] = point.amplitudes[i] * dot(&rest[i], &point.residual);
            for j in 0..=i {
                full[i][j] = point.amplitudes[i] * point.amplitudes[j] * dot(&rest[i], &rest[j]);
                full[j][i] = full[i][j];
            }
        }
        let directions = directions(point, &descent, limits);
        let mut gradient = [0.0; N];
        let mut hessian = [[0.0; N]; N];
        for i in 0..N {
            let Some(a) = directions.of[i] else { continue };
            gradient[a] += descent[i];
            for j in 0..N {
                if let Some(b) = directions.of[j] {
                    hessian[a][b] += full[i][j];
                }
            }
        }
        Self { directions, gradient, hessian, parts }
    }

    /// Damped Gauss–Newton step and how much it promises to lower the sum of squares; nothing
    /// where the matrix is singular.
    #[inline]
    fn step(&self, damping: f64) -> Option<([f64; N], f64)> {
        let mut matrix = self.hessian;
        for (i, row) in matrix.iter_mut().enumerate() {
            row[i] *= 1.0 + damping;
        }
        let factor = Cholesky::new(&matrix, self.directions.count)?;
        let step = factor.solve(self.gradient);
        // 2 g·δ − δ·H·δ with (H + λD) δ = g.
        let promised = (0..self.directions.count)
            .map(|i| {
                let damped = damping * self.hessian[i][i] * step[i] * step[i];
                step[i] * self.gradient[i] + damped
            })
            .sum();
        Some((step, promised))
    }
}

/// Holds rates that would leave their limits, ties those that would merge.
#[inline]
fn directions<const N: usize, const R: usize>(
    point: &Point<N, R>,
    descent: &[f64; N],
    (lowest, highest): (f64, f64),
) -> Directions<N> {
    let mut of = [None; N];
    let mut count = 0;
    let mut i = 0;
    while i < N {
        // A chain of rates that touch and press on one another moves as one.
        let mut end = i + 1;
        while end < N && touching(&point.u, end - 1) && descent[end - 1] >= descent[end] {
            end += 1;
        }
        let pull: f64 = descent[i..end].iter().sum();
        let at_lowest = point.u[i] <= lowest && pull <= 0.0;
        let at_highest = point.u[end - 1] >= highest && pull >= 0.0;
        let free = point.face.terms[i..end].iter().any(|free| *free);
        if free && !at_lowest && !at_highest {
            of[i..end].fill(Some(count));
            count += 1;
        }
        i = end;
    }
    Directions { of, count }
}

/// Lower triangle L with L Lᵀ = matrix, of the first rows only.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cholesky<const N: usize> {
    lower: [[f64; N]; N],
    count: usize,
}

impl<const N: usize> Cholesky<N> {
    #[inline]
    pub fn new(matrix: &[[f64; N]; N], count: usize) -> Option<Self> {
        let mut lower = [[0.0; N]; N];
        for i in 0..count {
            for j in 0..=i {
                let mut sum = matrix[i][j];
                for k in 0..j {
                    sum -= lower[i][k] * lower[j][k];
                }
                if i == j {
                    if sum.is_nan() || sum <= SINGULAR * matrix[i][i] {
                        return None;
                    }
                    lower[i][i] = sum.sqrt();
                } else {
                    lower[i][j] = sum / lower[j][j];
                }
            }
        }
        Some(Self { lower, count })
    }

    #[inline]
    pub fn solve(&self, mut b: [f64; N]) -> [f64; N] {
        for i in 0..self.count {
            for j in 0..i {
                b[i] -= self.lower[i][j] * b[j];
            }
            b[i] /= self.lower[i][i];
        }
        self.solve_transposed(b)
    }

    /// Solves Lᵀ x = b.
    #[inline]
    pub fn solve_transposed(&self, mut b: [f64; N]) -> [f64; N] {
        for i in (0..self.count).rev() {
            for j in i + 1..self.count {
                b[i] -= self.lower[j][i] * b[j];
            }
            b[i] /= self.lower[i][i];
        }
        b
    }
}
