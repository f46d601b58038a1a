//! Profile-likelihood intervals: all values of a parameter at which the best fit of all others is
//! not significantly worse. They need no linear theory, so they hold at high noise, where the sum
//! of squares is far from a parabola and intervals from standard errors are too short.

use super::fit::{Fit, Normalisation, Parameter, quantile};
use super::point::{Problem, Signs};
use super::refine::separation;
use nalgebra::{DMatrix, DVector};

/// A confidence interval; an end that is none is not bounded by the data within the limits of
/// the rates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub lower: Option<f64>,
    /// Upper end.
    pub upper: Option<f64>,
}

impl Interval {
    /// Whether a value lies within.
    #[must_use]
    pub fn covers(&self, value: f64) -> bool {
        self.lower.is_none_or(|lower| lower <= value)
            && self.upper.is_none_or(|upper| value <= upper)
    }
}

/// Doublings of the first step in search of an end.
const MOST_DOUBLINGS: usize = 14;
/// Refinements of an end between two values, and when they are enough: in standard errors.
const MOST_REFINEMENTS: usize = 40;
const PRECISION: f64 = 1e-3;
const MOST_ITERATIONS: usize = 60;

/// What one parameter is held at while all others are fitted.
#[derive(Clone, Copy, Debug)]
enum Hold {
    /// Logarithm of the rate at this place, ascending.
    Rate(usize),
    /// N.
    Scale,
    /// c_i of the term at this place, ascending from 1; 0 is the constant.
    Coefficient(usize),
}

/// The profile of one parameter.
struct Profile<'a, const R: usize> {
    problem: &'a Problem<'a, R>,
    normalisation: Normalisation,
    hold: Hold,
    /// Logarithms of the rates at the minimum, ascending.
    best: Vec<f64>,
    least: f64,
    variance: f64,
}

/// The interval of one parameter around a fit; none where the level is not a probability or the
/// fit has no such parameter.
pub(super) fn interval<const R: usize>(
    problem: &Problem<R>,
    fit: &Fit,
    normalisation: Normalisation,
    parameter: Parameter,
    level: f64,
) -> Option<Interval> {
    let terms = fit.sum.terms.len();
    parameter.place(terms)?;
    let wanted = quantile(fit.degrees_of_freedom, level)?;
    let value = fit.value(parameter)?;
    // Terms are listed from the fastest, places are ascending.
    let (hold, centre) = match parameter {
        Parameter::Scale => (Hold::Scale, value),
        Parameter::Coefficient(0) => (Hold::Coefficient(0), value),
        Parameter::Coefficient(i) => (Hold::Coefficient(terms + 1 - i), value),
        Parameter::Rate(i) => (Hold::Rate(terms - i), value.ln()),
    };
    if matches!(hold, Hold::Coefficient(0)) && normalisation == Normalisation::Asymptotic {
        return Some(Interval { lower: Some(1.0), upper: Some(1.0) });
    }
    let profile = Profile {
        problem,
        normalisation,
        hold,
        best: fit.sum.terms.iter().rev().map(|term| term.rate.ln()).collect(),
        least: fit.rss,
        variance: (fit.rss / fit.degrees_of_freedom as f64).max(f64::MIN_POSITIVE),
    };
    let error = fit.standard_error(parameter).filter(|error| *error > 0.0);
    let step = match (parameter, error) {
        (Parameter::Rate(_), Some(error)) => wanted * error / value,
        (_, Some(error)) => wanted * error,
        (Parameter::Rate(_), None) => 0.2,
        (_, None) => 0.1 * value.abs().max(1e-3),
    };
    let end = |step: f64| {
        let end = profile.end(centre, step, wanted)?;
        Some(if matches!(hold, Hold::Rate(_)) { end.exp() } else { end })
    };
    Some(Interval { lower: end(-step), upper: end(step) })
}

impl<const R: usize> Profile<'_, R> {
    /// Where the profile's root reaches `wanted`, searched from `centre` in the direction of
    /// `step`.
    fn end(&self, centre: f64, step: f64, wanted: f64) -> Option<f64> {
        let limits = self.limits();
        let mut rates = self.best.clone();
        let (mut inner, mut inner_root) = (centre, 0.0);
        let mut stride = step;
        let (mut outer, mut outer_root) = (centre, 0.0);
        for doubling in 0..=MOST_DOUBLINGS {
            outer = (inner + stride).clamp(limits.0, limits.1);
            outer_root = self.root(outer, &mut rates);
            if outer_root >= wanted {
                break;
            }
            if outer == limits.0 || outer == limits.1 {
                // A coefficient ends at the bound of its sign; a rate's limit is no finding.
                return (!matches!(self.hold, Hold::Rate(_))).then_some(outer);
            }
            if doubling == MOST_DOUBLINGS {
                return None;
            }
            (inner, inner_root) = (outer, outer_root);
            stride *= 2.0;
        }
        for _ in 0..MOST_REFINEMENTS {
            if (outer_root - wanted).abs() < PRECISION || (outer - inner).abs() < 1e-9 * step.abs()
            {
                break;
            }
            // The root is nearly a straight line in the parameter.
            let share = (wanted - inner_root) / (outer_root - inner_root);
            let share = if outer_root.is_finite() { share.clamp(0.05, 0.95) } else { 0.5 };
            let middle = inner + share * (outer - inner);
            let root = self.root(middle, &mut rates);
            if root >= wanted {
                (outer, outer_root) = (middle, root);
            } else {
                (inner, inner_root) = (middle, root);
                if wanted - root < PRECISION {
                    return Some(middle);
                }
            }
        }
        Some(outer)
    }

    /// Values that the parameter may take.
    fn limits(&self) -> (f64, f64) {
        let sign = |sign: f64| match sign {
            sign if sign > 0.0 => (0.0, f64::INFINITY),
            sign if sign < 0.0 => (f64::NEG_INFINITY, 0.0),
            _ => (f64::NEG_INFINITY, f64::INFINITY),
        };
        // Signs are those of the amplitudes, the coefficients' are relative to the mean.
        let orientation = if self.problem.target[0] < 0.0 { -1.0 } else { 1.0 };
        match self.hold {
            Hold::Rate(place) => {
                let apart = separation(self.best.len());
                let above = (self.best.len() - 1 - place) as f64;
                (
                    self.problem.table.lowest + place as f64 * apart,
                    self.problem.table.highest - above * apart,
                )
            }
            Hold::Scale => sign(0.0),
            Hold::Coefficient(0) => sign(orientation * self.problem.signs.constant),
            Hold::Coefficient(_) => sign(orientation * self.problem.signs.terms),
        }
    }

    /// √((RSS − least) / variance) at a value; starts from the rates of the value before and from
    /// those of the minimum, and leaves its own in `rates`.
    fn root(&self, value: f64, rates: &mut Vec<f64>) -> f64 {
        let near = self.minimum(value, rates.clone());
        let far = self.minimum(value, self.best.clone());
        let (rss, found) = if far.0 < near.0 { far } else { near };
        if rss.is_finite() {
            *rates = found;
        }
        ((rss - self.least).max(0.0) / self.variance).sqrt()
    }

    /// Least sum of squares with the parameter held, by variable projection and
    /// Levenberg–Marquardt over the rates; infinite where no amplitudes are allowed.
    fn minimum(&self, value: f64, start: Vec<f64>) -> (f64, Vec<f64>) {
        let mut u = self.within(start, value);
        let Some(mut linear) = self.linear(&u, value) else { return (f64::INFINITY, u) };
        let mut damping = 1e-4;
        for _ in 0..MOST_ITERATIONS {
            let Some((step, promised)) = self.step(&u, &linear, damping) else { break };
            if promised <= 1e-9 * linear.rss {
                break;
            }
            let moved = u.iter().zip(step.iter()).map(|(u, step)| u + step.clamp(-1.0, 1.0));
            let trial = self.within(moved.collect(), value);
            match self.linear(&trial, value) {
                Some(next) if next.rss < linear.rss => {
                    (u, linear) = (trial, next);
                    damping *= 0.1;
                }
                _ => damping *= 10.0,
            }
            if damping > 1e10 {
                break;
            }
        }
        (linear.rss, u)
    }

    /// Rates ascending, apart and within the limits; the held one at its value.
    fn within(&self, mut u: Vec<f64>, value: f64) -> Vec<f64> {
        let held = if let Hold::Rate(place) = self.hold { Some(place) } else { None };
        let count = u.len();
        let apart = separation(count);
        for (i, u) in u.iter_mut().enumerate() {
            let (mut lowest, mut highest) = (self.problem.table.lowest, self.problem.table.highest);
            match held {
                Some(place) if i == place => (lowest, highest) = (value, value),
                Some(place) if i < place => highest = value - (place - i) as f64 * apart,
                Some(place) => lowest = value + (i - place) as f64 * apart,
                None => {}
            }
            *u = u.max(lowest).min(highest);
        }
        for i in 1..count {
            if Some(i) != held {
                u[i] = u[i].max(u[i - 1] + apart);
            }
        }
        for i in (0..count - 1).rev() {
            if Some(i) != held {
                u[i] = u[i].min(u[i + 1] - apart);
            }
        }
        u
    }

    /// Damped Gauss–Newton step of the rates and what it promises.
    fn step(&self, u: &[f64], linear: &Linear, damping: f64) -> Option<(DVector<f64>, f64)> {
        let terms = u.len();
        let mut columns = DMatrix::zeros(R, terms);
        for (i, u) in u.iter().enumerate() {
            let slope = self.problem.table.at(*u).slope;
            let column = DVector::from_column_slice(&slope) * linear.amplitudes[1 + i];
            let along = linear.span.transpose() * &column;
            columns.set_column(i, &(column - &linear.span * along));
        }
        let mut gradient = columns.transpose() * &linear.residual;
        let mut matrix = columns.transpose() * &columns;
        for i in 0..terms {
            let held = matches!(self.hold, Hold::Rate(place) if place == i);
            let stuck = (u[i] <= self.problem.table.lowest && gradient[i] <= 0.0)
                || (u[i] >= self.problem.table.highest && gradient[i] >= 0.0);
            if held || stuck || matrix[(i, i)] <= 0.0 {
                gradient[i] = 0.0;
                matrix.row_mut(i).fill(0.0);
                matrix.column_mut(i).fill(0.0);
                matrix[(i, i)] = 1.0;
            } else {
                matrix[(i, i)] *= 1.0 + damping;
            }
        }
        let step = matrix.cholesky()?.solve(&gradient);
        let promised = gradient.dot(&step);
        Some((step, promised))
    }

    /// Best amplitudes (constant first) for given rates with the parameter held.
    fn linear(&self, u: &[f64], value: f64) -> Option<Linear> {
        let size = u.len() + 1;
        let mut columns = DMatrix::zeros(R, size);
        columns[(0, 0)] = self.problem.constant_norm;
        for (i, u) in u.iter().enumerate() {
            columns.column_mut(1 + i).copy_from_slice(&self.problem.table.at(*u).value);
        }
        let all = vec![true; size];
        let free = self.linear_on(&columns, value, &all)?;
        if self.problem.signs == Signs::FREE || self.allows(&free.amplitudes) {
            return Some(free);
        }
        (1_u32..1 << size)
            .filter_map(|code| {
                let face: Vec<bool> = (0..size).map(|bit| code >> bit & 1 == 1).collect();
                let found = self.linear_on(&columns, value, &face)?;
                self.allows(&found.amplitudes).then_some(found)
            })
            .min_by(|a, b| a.rss.total_cmp(&b.rss))
    }

    fn allows(&self, amplitudes: &DVector<f64>) -> bool {
        let signs = &self.problem.signs;
        // Rounding may leave a held amplitude a trace on the wrong side.
        let slack = -1e-12 * amplitudes.amax();
        signs.constant * amplitudes[0] >= slack
            && amplitudes.iter().skip(1).all(|amplitude| signs.terms * amplitude >= slack)
    }

    /// Least squares in the amplitudes of one face with a·A = s where the parameter asks it.
    fn linear_on(&self, columns: &DMatrix<f64>, value: f64, face: &[bool]) -> Option<Linear> {
        let chosen: Vec<usize> = (0..face.len()).filter(|k| face[*k]).collect();
        let own = columns.select_columns(&chosen);
        let target = DVector::from_column_slice(self.problem.target);
        let condition = self.condition(value, face.len());
        let (fixed, directions) = match condition {
            None => (DVector::zeros(chosen.len()), DMatrix::identity(chosen.len(), chosen.len())),
            Some((normal, sum)) => {
                let normal = normal.select_rows(&chosen);
                let length = normal.norm();
                if length < 1e-12 {
                    return None;
                }
                (&normal * (sum / (length * length)), across(&(normal / length)))
            }
        };
        let rest = &target - &own * &fixed;
        let qr = (&own * &directions).qr();
        let (span, factor) = (qr.q(), qr.r());
        let along = span.transpose() * &rest;
        let free = factor.solve_upper_triangular(&along)?;
        let residual = rest - &span * along;
        let mut amplitudes = DVector::zeros(face.len());
        for (k, amplitude) in chosen.iter().zip((fixed + directions * free).iter()) {
            amplitudes[*k] = *amplitude;
        }
        let rss = self.problem.outside + residual.norm_squared();
        rss.is_finite().then_some(Linear { amplitudes, span, residual, rss })
    }

    /// The linear condition on the amplitudes that holds N or a coefficient.
    fn condition(&self, value: f64, size: usize) -> Option<(DVector<f64>, f64)> {
        let scale = DVector::from_fn(size, |k, _| match self.normalisation {
            Normalisation::Initial => 1.0,
            Normalisation::Asymptotic if k == 0 => 1.0,
            Normalisation::Asymptotic => 0.0,
        });
        match self.hold {
            Hold::Rate(_) => None,
            Hold::Scale => Some((scale, value)),
            Hold::Coefficient(i) => {
                let mut normal = -value * scale;
                normal[i] += 1.0;
                Some((normal, 0.0))
            }
        }
    }
}

/// The best amplitudes with a parameter held.
struct Linear {
    /// Constant first.
    amplitudes: DVector<f64>,
    /// Orthonormal vectors of what free amplitudes can reach.
    span: DMatrix<f64>,
    residual: DVector<f64>,
    rss: f64,
}

/// Orthonormal vectors across a unit vector, by a Householder reflection that takes it to an axis.
fn across(normal: &DVector<f64>) -> DMatrix<f64> {
    let size = normal.len();
    let mut mirror = normal.clone();
    mirror[0] += if normal[0] < 0.0 { -1.0 } else { 1.0 };
    let length = mirror.norm_squared();
    let reflection = DMatrix::identity(size, size) - &mirror * mirror.transpose() * (2.0 / length);
    reflection.columns(1, size - 1).into_owned()
}
