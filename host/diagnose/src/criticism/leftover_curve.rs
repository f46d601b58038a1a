//! What a model leaves as a curve over one quantity, each way of the motion by itself: a law to begin with
//! where no effect of the library explains the rest.

use nalgebra::{DMatrix, DVector};

use super::dependence::{Bin, binned};
use super::residuals::{Residuals, Values};
use palpate_model::covariate::Covariate;

/// A residual over one quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftoverCurve {
    /// The quantity.
    pub covariate: Covariate,
    /// Mean residual (measured minus predicted) while the specimen is pressed, by rising quantity.
    pub loading: Vec<Bin>,
    /// The same while it is released.
    pub unloading: Vec<Bin>,
    /// Its cubics as an expression of the parameter `k`, which is 1 for the curve as it is.
    pub expression: String,
    /// Share of the residual's mean square that the cubics explain, 0 to 1.
    pub explained: f64,
}

/// Order of the polynomials.
const ORDER: i32 = 3;
/// Singular values below this part of the largest are none.
const SINGULAR: f64 = 1e-10;

impl LeftoverCurve {
    /// The curve over a quantity; none where it is missing or constant, or an expression cannot hold it.
    #[must_use]
    pub fn of(left: &Residuals, covariate: Covariate) -> Option<Self> {
        // An expression counts the temperature from a reference that the residual does not know.
        if covariate == Covariate::Temperature {
            return None;
        }
        let values = left.covariate(covariate)?;
        let ways = left.covariate(Covariate::Direction)?;
        Self::over(covariate, &left.values(), (&values, &ways))
    }

    fn over(
        covariate: Covariate,
        residuals: &[Vec<f64>],
        (values, ways): (&Values, &Values),
    ) -> Option<Self> {
        let scale =
            values.iter().flat_map(|v| v.iter()).fold(0.0, |most: f64, v| most.max(v.abs()));
        if scale <= 0.0 {
            return None;
        }
        let samples = || {
            let all = residuals.iter().zip(values).zip(ways);
            all.flat_map(|((r, v), w)| {
                r.iter().zip(&v[..]).zip(&w[..]).map(|((r, v), w)| (*r, *v, *w))
            })
        };
        let by_direction = covariate != Covariate::Direction;
        let row = |value: f64, way: f64| -> Vec<f64> {
            let powers = |share: f64| (0..=ORDER).map(move |n| share * (value / scale).powi(n));
            match by_direction {
                true => powers(0.5 * (1.0 + way)).chain(powers(0.5 * (1.0 - way))).collect(),
                false => vec![1.0, way],
            }
        };
        let count = row(0.0, 0.0).len();
        let (mut products, mut along, mut square) =
            (DMatrix::zeros(count, count), DVector::zeros(count), 0.0);
        for (r, v, w) in samples() {
            let row = DVector::from(row(v, w));
            products.ger(1.0, &row, &row, 1.0);
            along.axpy(r, &row, 1.0);
            square += r * r;
        }
        let found = products.svd(true, true);
        let least = SINGULAR * found.singular_values.max();
        let coefficients = found.solve(&along, least).ok()?;
        let one_way = |pressed: bool| -> Vec<Bin> {
            let (r, v) = samples()
                .filter(|(.., w)| if pressed { *w > 0.0 } else { *w < 0.0 })
                .map(|(r, v, _)| (r, v))
                .unzip();
            binned(r, v).unwrap_or_default()
        };
        Some(Self {
            covariate,
            loading: one_way(true),
            unloading: one_way(false),
            expression: expression(covariate, scale, coefficients.as_slice()),
            explained: if square > 0.0 { coefficients.dot(&along) / square } else { 0.0 },
        })
    }
}

/// A number to four significant digits.
pub(crate) fn rounded(number: f64) -> f64 {
    format!("{number:.3e}").parse().unwrap_or(number)
}

/// The cubics in the words of a law of one's own.
fn expression(covariate: Covariate, scale: f64, coefficients: &[f64]) -> String {
    if covariate == Covariate::Direction {
        let [mean, way] = [coefficients[0], coefficients[1]].map(rounded);
        return format!("k * ({mean} + {way} * sign(v))");
    }
    let unit = format!("({} / {})", covariate.symbol(), rounded(scale));
    let cubic = |coefficients: &[f64]| {
        let term = |(n, c): (usize, &f64)| match n {
            0 => rounded(*c).to_string(),
            1 => format!("{} * {unit}", rounded(*c)),
            n => format!("{} * {unit}^{n}", rounded(*c)),
        };
        coefficients.iter().enumerate().map(term).collect::<Vec<_>>().join(" + ")
    };
    let (pressed, released) = coefficients.split_at(coefficients.len() / 2);
    format!(
        "k * (0.5 * (1 + sign(v)) * ({}) + 0.5 * (1 - sign(v)) * ({}))",
        cubic(pressed),
        cubic(released)
    )
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use super::*;
    use palpate_model::Expression;

    /// A press and a release that leave 0.3 x² on the way in and −0.1 x on the way out.
    fn curve(covariate: Covariate) -> Option<LeftoverCurve> {
        let x: Vec<f64> = (0..200)
            .map(|k| if k < 100 { f64::from(k) } else { f64::from(200 - k) } * 0.02)
            .collect();
        let way: Vec<f64> = (0..200).map(|k| if k < 100 { 1.0 } else { -1.0 }).collect();
        let left = x.iter().zip(&way).map(|(x, w)| if *w > 0.0 { 0.3 * x * x } else { -0.1 * x });
        let (left, way) = ([left.collect()], [way.into()]);
        LeftoverCurve::over(covariate, &left, (&[x.into()], &way))
    }

    #[test]
    fn a_curve_is_told_each_way_by_itself_and_as_an_expression() {
        let curve = curve(Covariate::Displacement).unwrap();
        assert!(curve.explained > 0.999_999, "{curve:?}");
        let last = curve.loading.last().unwrap();
        assert!((last.mean - 0.3 * last.at * last.at).abs() < 0.02, "{last:?}");
        assert!(curve.unloading.iter().all(|bin| (bin.mean + 0.1 * bin.at).abs() < 1e-6));
        assert!(Expression::parse(&curve.expression, &["k"]).is_ok(), "{}", curve.expression);
    }

    #[test]
    fn a_quantity_that_does_not_vary_has_no_curve() {
        let none = [Cow::from(vec![0.0; 3])];
        let curve = LeftoverCurve::over(Covariate::Velocity, &[vec![1.0; 3]], (&none, &none));
        assert_eq!(curve, None);
    }
}
