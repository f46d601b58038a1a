//! From a free curve to laws: the shapes that come nearest to it, with the values of their parameters, as starts for a refit.
//!
//! Nearness is what the data make of it: the rise of their sum of squares where the shape's values at the knots stand in the place of
//! the curve's, the other parameters following. No sample is looked at again.

use nalgebra::{DMatrix, DVector};

use super::grammar::Term;
use palpate_fit::least_squares::{Normal, Solution};

/// Shapes that are kept of a curve.
const KEPT: usize = 3;
/// Part of what a curve explains that a shape must explain in its place.
const LEAST: f64 = 0.5;
/// Values of each parameter of a shape that are tried in all combinations.
const TRIED: usize = 12;
/// Rounds in which the best of them is changed by ever smaller steps.
const ROUNDS: usize = 40;
/// Bounds this many times apart are gone through by factors.
const WIDE: f64 = 20.0;

/// A law near a free curve.
#[derive(Clone, Debug)]
pub(super) struct Near {
    /// Which term.
    pub term: usize,
    /// Its strength.
    pub strength: f64,
    /// Its other parameters.
    pub shapes: Vec<f64>,
    /// Fall of the sum of squares that it keeps of the curve's.
    pub gain: f64,
}

/// A free curve as a few steps of a fit found it.
pub(super) struct Found {
    heights: DVector<f64>,
    /// How the sum of squares rises with the heights, the other coordinates following.
    curvature: DMatrix<f64>,
}

impl Found {
    /// The curve whose heights are the last coordinates of a fit.
    pub fn of(fit: &Solution, heights: usize) -> Self {
        let base = fit.point.len() - heights;
        Self {
            heights: DVector::from_column_slice(&fit.point[base..]),
            curvature: beside(&fit.normal, base),
        }
    }

    /// Fall of the sum of squares through the curve.
    fn gain(&self) -> f64 {
        self.heights.dot(&(&self.curvature * &self.heights))
    }

    /// Fall of the sum of squares through a shape with these values at the knots, and its strength.
    fn through(&self, values: &DVector<f64>) -> (f64, f64) {
        let felt = &self.curvature * values;
        let (along, own) = (felt.dot(&self.heights), felt.dot(values));
        let usable = own.is_finite() && own > 0.0 && along.is_finite();
        if usable { (along * along / own, along / own) } else { (0.0, 0.0) }
    }

    /// The laws nearest to the curve of a term among those that depend on the same quantity, the nearest first.
    pub fn near(&self, curve: &Term, terms: &[Term]) -> Vec<Near> {
        let Some(at) = curve.knots.as_ref().map(|knots| &knots.at) else { return Vec::new() };
        let own = terms.iter().enumerate().filter(|(_, term)| term.beside(curve));
        let mut near: Vec<Near> = own.filter_map(|(k, term)| self.nearest(k, term, at)).collect();
        near.retain(|it| it.gain >= LEAST * self.gain());
        near.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        near.truncate(KEPT);
        near
    }

    /// The parameters with which a term comes nearest.
    fn nearest(&self, index: usize, term: &Term, at: &[f64]) -> Option<Near> {
        let value = term.shape.value?;
        let form = term.candidate.forms.first()?;
        let bounds: Vec<(f64, f64)> = form.applied.parameters[form.applied.strengths..]
            .iter()
            .map(|parameter| (parameter.lower, parameter.upper))
            .collect();
        let weigh = |shapes: &[f64]| {
            let values = at.iter().map(|place| value(*place, shapes));
            self.through(&DVector::from_iterator(at.len(), values))
        };
        let starts = combinations(&bounds);
        let start = starts.into_iter().max_by(|a, b| weigh(a).0.total_cmp(&weigh(b).0))?;
        let shapes = climbed(start, &bounds, |shapes| weigh(shapes).0);
        let (gain, strength) = weigh(&shapes);
        Some(Near { term: index, strength, shapes, gain })
    }
}

/// How a sum of squares rises with its last coordinates where those before follow.
fn beside(normal: &Normal, base: usize) -> DMatrix<f64> {
    let size = normal.curvature.nrows();
    let count = size - base;
    let own = normal.curvature.view((base, base), (count, count)).into_owned();
    let cross = normal.curvature.view((0, base), (base, count));
    let scale: Vec<f64> = (0..base)
        .map(|j| normal.curvature[(j, j)].max(0.0).sqrt())
        .map(|size| if size > 0.0 { 1.0 / size } else { 0.0 })
        .collect();
    let scaled = DMatrix::from_fn(base, base, |i, j| {
        let value = normal.curvature[(i, j)] * scale[i] * scale[j];
        if i == j { value.max(1.0) + 1e-9 } else { value }
    });
    let right = DMatrix::from_fn(base, count, |i, j| scale[i] * cross[(i, j)]);
    match scaled.cholesky() {
        Some(factor) => own - right.tr_mul(&factor.solve(&right)),
        None => own,
    }
}

/// Values between bounds, in all combinations.
fn combinations(bounds: &[(f64, f64)]) -> Vec<Vec<f64>> {
    let between = |(lower, upper): (f64, f64), part: f64| match lower > 0.0 && upper > WIDE * lower
    {
        true => lower * (upper / lower).powf(part),
        false => lower + part * (upper - lower),
    };
    bounds.iter().fold(vec![Vec::new()], |points, bound| {
        let values = (0..TRIED).map(|k| between(*bound, (k as f64 + 0.5) / TRIED as f64));
        let values: Vec<f64> = values.collect();
        let longer = |point: &Vec<f64>| {
            let point = point.clone();
            values.clone().into_iter().map(move |value| [&point[..], &[value]].concat())
        };
        points.iter().flat_map(longer).collect()
    })
}

/// The point changed in one coordinate at a time, by steps that halve where none helps.
fn climbed(mut point: Vec<f64>, bounds: &[(f64, f64)], worth: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    let mut best = worth(&point);
    let mut part = 0.5 / TRIED as f64;
    for _ in 0..ROUNDS {
        let before = best;
        for (j, (lower, upper)) in bounds.iter().enumerate() {
            let wide = *lower > 0.0 && *upper > WIDE * lower;
            for step in [part, -part] {
                let mut moved = point.clone();
                moved[j] = match wide {
                    true => point[j] * (upper / lower).powf(step),
                    false => point[j] + step * (upper - lower),
                }
                .clamp(*lower, *upper);
                let value = worth(&moved);
                if value > best {
                    (point, best) = (moved, value);
                }
            }
        }
        if best <= before {
            part *= 0.5;
        }
    }
    point
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_that_is_a_bump_is_told_as_one() {
        let at: Vec<f64> = (0..10).map(f64::from).collect();
        let bump = |x: f64| 0.3 * (-((x - 4.2) / 1.5).powi(2)).exp();
        let heights = DVector::from_iterator(10, at.iter().map(|x| bump(*x)));
        let found = Found { heights, curvature: DMatrix::identity(10, 10) };
        let value = |x: f64, of: &[f64]| (-((x - of[0]) / of[1]).powi(2)).exp();
        let bounds = [(0.0, 9.0), (0.05, 18.0)];
        let weigh = |shapes: &[f64]| {
            found.through(&DVector::from_iterator(10, at.iter().map(|x| value(*x, shapes))))
        };
        let best = |a: &Vec<f64>, b: &Vec<f64>| weigh(a).0.total_cmp(&weigh(b).0);
        let start = combinations(&bounds).into_iter().max_by(best).unwrap();
        let shapes = climbed(start, &bounds, |shapes| weigh(shapes).0);
        assert!((shapes[0] - 4.2).abs() < 1e-3 && (shapes[1] - 1.5).abs() < 1e-3, "{shapes:?}");
        assert!((weigh(&shapes).1 - 0.3).abs() < 1e-3);
    }
}
