//! Variable projection: for given rates the best amplitudes follow by linear least squares, so
//! the search is over rates alone.

use super::table::Table;
use super::vector::{add_scaled, dot, scale};

/// Columns closer to the span of the others than this share of their length are left out: their
/// amplitudes would be so large that what interpolation leaves of them exceeds the noise. Four
/// slow terms get there.
const fn dependent(terms: usize) -> f64 {
    if terms < 4 { 1e-10 } else { 1e-7 }
}

/// Signs that the amplitudes may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Signs {
    /// Of every exponential: +1 for not negative, −1 for not positive, 0 for any.
    pub terms: f64,
    /// Of the constant.
    pub constant: f64,
}

impl Signs {
    /// Any sign.
    pub const FREE: Self = Self { terms: 0.0, constant: 0.0 };
}

/// One trace to be fitted, in common coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Problem<'a, const R: usize> {
    pub table: &'a Table<R>,
    /// Coordinates of the trace; 0 belongs to the constant.
    pub target: &'a [f64; R],
    /// Sum of squares that no exponential explains.
    pub outside: f64,
    /// Norm of the constant function.
    pub constant_norm: f64,
    pub signs: Signs,
}

/// Which amplitudes are not held at 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Face<const N: usize> {
    pub terms: [bool; N],
    pub constant: bool,
}

impl<const N: usize> Face<N> {
    /// No amplitude held at 0.
    pub const FULL: Self = Self { terms: [true; N], constant: true };
}

/// The best amplitudes for given rates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point<const N: usize, const R: usize> {
    /// Logarithms of the rates, ascending.
    pub u: [f64; N],
    pub face: Face<N>,
    /// Exponentials, and their derivatives in u.
    pub values: [[f64; R]; N],
    pub slopes: [[f64; R]; N],
    /// Orthonormal vectors of the free exponentials (after the constant), 0 for those held at 0.
    pub q: [[f64; R]; N],
    /// Upper triangle with `values = q · r`.
    pub r: [[f64; N]; N],
    /// Amplitudes of the exponentials.
    pub amplitudes: [f64; N],
    /// Amplitude of the constant.
    pub constant: f64,
    /// What is left of the target.
    pub residual: [f64; R],
    /// Sum of squared residuals of all samples.
    pub rss: f64,
}

impl<const R: usize> Problem<'_, R> {
    /// Best amplitudes of the allowed signs.
    #[inline]
    pub fn point<const N: usize>(&self, u: [f64; N]) -> Point<N, R> {
        let mut point = self.unsigned(u);
        if self.signs != Signs::FREE && !self.allows(&point) {
            self.best_face(&mut point);
        }
        point
    }

    /// Best amplitudes whatever their signs.
    #[inline]
    pub fn unsigned<const N: usize>(&self, u: [f64; N]) -> Point<N, R> {
        let mut point = Point {
            u,
            face: Face::FULL,
            values: [[0.0; R]; N],
            slopes: [[0.0; R]; N],
            q: [[0.0; R]; N],
            r: [[0.0; N]; N],
            amplitudes: [0.0; N],
            constant: 0.0,
            residual: [0.0; R],
            rss: 0.0,
        };
        for (i, u) in u.into_iter().enumerate() {
            let exponential = self.table.at(u);
            point.values[i] = exponential.value;
            point.slopes[i] = exponential.slope;
        }
        self.solve(&mut point, Face::FULL);
        point
    }

    /// Whether all amplitudes have an allowed sign.
    pub fn allows<const N: usize>(&self, point: &Point<N, R>) -> bool {
        self.signs.constant * point.constant >= 0.0
            && point.amplitudes.iter().all(|amplitude| self.signs.terms * amplitude >= 0.0)
    }

    /// Tries every set of amplitudes held at 0 and keeps the best that is allowed: with at most
    /// five amplitudes that is exact and simple.
    fn best_face<const N: usize>(&self, point: &mut Point<N, R>) {
        let mut best: Option<Face<N>> = None;
        let mut least = f64::INFINITY;
        for code in 0_u32..1 << (N + 1) {
            let held = |bit: usize| code >> bit & 1 == 1;
            let constant = !held(N);
            if (!constant && self.signs.constant == 0.0)
                || (self.signs.terms == 0.0 && (0..N).any(held))
            {
                continue;
            }
            let face = Face { terms: std::array::from_fn(|i| !held(i)), constant };
            self.solve(point, face);
            if point.rss < least && self.allows(point) {
                least = point.rss;
                best = Some(face);
            }
        }
        // With every amplitude at 0 no sign is wrong, except that terms of any sign are never
        // held; then the constant alone can be.
        let none = Face { terms: [self.signs.terms == 0.0; N], constant: false };
        self.solve(point, best.unwrap_or(none));
    }

    /// Linear least squares on one face, by Gram–Schmidt.
    #[inline]
    pub fn solve<const N: usize>(&self, point: &mut Point<N, R>, face: Face<N>) {
        // The constant is along coordinate 0: with that left out, it takes what is best.
        let keep = if face.constant { 0.0 } else { 1.0 };
        point.face = face;
        point.residual = *self.target;
        point.residual[0] *= keep;
        let mut along = [0.0; N];
        for i in 0..N {
            let mut q = point.values[i];
            q[0] *= keep;
            let length = dot(&q, &q).sqrt();
            for j in 0..i {
                point.r[j][i] = dot(&point.q[j], &q);
                let factor = -point.r[j][i];
                add_scaled(&mut q, factor, &point.q[j]);
            }
            let norm = dot(&q, &q).sqrt();
            if face.terms[i] && norm > dependent(N) * length {
                point.r[i][i] = norm;
                scale(&mut q, 1.0 / norm);
                along[i] = dot(&q, &point.residual);
                add_scaled(&mut point.residual, -along[i], &q);
                point.q[i] = q;
            } else {
                point.face.terms[i] = false;
                point.r[i] = [0.0; N];
                point.r[i][i] = 1.0;
                for row in point.r.iter_mut().take(i) {
                    row[i] = 0.0;
                }
                point.q[i] = [0.0; R];
            }
        }
        point.amplitudes = point.back_substitute(along);
        let mut level = self.target[0];
        for (amplitude, value) in point.amplitudes.iter().zip(&point.values) {
            level -= amplitude * value[0];
        }
        point.constant = if face.constant { level / self.constant_norm } else { 0.0 };
        point.rss = self.outside + dot(&point.residual, &point.residual);
    }
}

impl<const N: usize, const R: usize> Point<N, R> {
    /// Solves `r x = b`.
    #[inline]
    pub fn back_substitute(&self, b: [f64; N]) -> [f64; N] {
        let mut x = b;
        for i in (0..N).rev() {
            for j in i + 1..N {
                x[i] -= self.r[i][j] * x[j];
            }
            x[i] /= self.r[i][i];
        }
        x
    }

    /// Slopes without their part in the span of the free amplitudes, and that part.
    #[inline]
    pub fn outside_slopes(&self) -> ([[f64; R]; N], [[f64; N]; N]) {
        let mut rest = self.slopes;
        let mut parts = [[0.0; N]; N];
        for i in 0..N {
            if self.face.constant {
                rest[i][0] = 0.0;
            }
            for j in 0..N {
                parts[j][i] = dot(&self.q[j], &rest[i]);
                add_scaled(&mut rest[i], -parts[j][i], &self.q[j]);
            }
        }
        (rest, parts)
    }
}
