//! The Cramér–Rao bound: the least standard errors that any unbiased fit can have.

use super::fit::Normalisation;
use super::{Error, ExponentialSum, MOST_TERMS, Parameter};
use nalgebra::{DMatrix, DVector};

/// Rows of the Jacobian that are reduced at a time.
const ROWS: usize = 512;
/// A column this near to the span of the others, relative to its length, is dependent on them.
const DEPENDENT: f64 = 1e-13;

/// The Cramér–Rao bound of every parameter of a sum.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    terms: usize,
    covariance: DMatrix<f64>,
}

impl Bound {
    /// The bound for samples of `sum` at `times` (s since the first sample) with independent
    /// Gaussian noise of standard deviation `noise`, in the unit of the signal.
    ///
    /// # Errors
    /// When the noise is not positive, the sum has not 1 to 4 terms with rates above 0, there
    /// are too few times, or they do not determine the parameters at all.
    pub fn new(
        sum: &ExponentialSum,
        times: impl IntoIterator<Item = f64>,
        noise: f64,
        normalisation: Normalisation,
    ) -> Result<Self, Error> {
        let terms = sum.terms.len();
        if !(1..=MOST_TERMS).contains(&terms) {
            return Err(Error::Terms { terms });
        }
        if !(noise > 0.0 && noise.is_finite()) {
            return Err(Error::Argument { what: "the noise", value: noise, wanted: "positive" });
        }
        if let Some(term) = sum.terms.iter().find(|term| term.rate.is_nan() || term.rate <= 0.0) {
            return Err(Error::Argument { what: "a rate", value: term.rate, wanted: "positive" });
        }
        let (factor, samples) = triangle(sum, times);
        if samples < 2 * terms + 1 {
            return Err(Error::TooFewSamples { samples, terms, needed: 2 * terms + 1 });
        }
        let lengths: Vec<f64> = factor.column_iter().map(|column| column.norm()).collect();
        let dependent = (0..lengths.len())
            .any(|k| !(factor[(k, k)].abs() > DEPENDENT * lengths[k] && lengths[k].is_finite()));
        let inverse = factor.try_inverse().filter(|_| !dependent).ok_or(Error::Indeterminate)?;
        let transform = transform(sum, normalisation) * inverse * noise;
        Ok(Self { terms, covariance: &transform * transform.transpose() })
    }

    /// Least standard error of a parameter, in its unit; none where there is no such parameter.
    #[must_use]
    pub fn standard_error(&self, parameter: Parameter) -> Option<f64> {
        self.covariance(parameter, parameter).map(f64::sqrt)
    }

    /// Covariance at the bound.
    #[must_use]
    pub fn covariance(&self, a: Parameter, b: Parameter) -> Option<f64> {
        Some(self.covariance[(a.place(self.terms)?, b.place(self.terms)?)])
    }

    /// Least standard error relative to the size of the parameter in `sum`.
    #[must_use]
    pub fn relative(&self, sum: &ExponentialSum, parameter: Parameter) -> Option<f64> {
        let value = sum.value(parameter).filter(|value| *value != 0.0)?;
        self.standard_error(parameter).map(|error| error / value.abs())
    }
}

/// Upper triangle of the Jacobian in (A0, A_i, ln v_i), and the number of rows it had.
fn triangle(sum: &ExponentialSum, times: impl IntoIterator<Item = f64>) -> (DMatrix<f64>, usize) {
    let size = 2 * sum.terms.len() + 1;
    let mut block = DMatrix::zeros(size + ROWS, size);
    let mut filled = size;
    let mut samples = 0;
    let mut times = times.into_iter().peekable();
    while let Some(time) = times.next() {
        samples += 1;
        let mut row = block.row_mut(filled);
        row[0] = 1.0;
        for (i, term) in sum.terms.iter().enumerate() {
            let value = (-term.rate * time).exp();
            row[1 + i] = value;
            row[1 + sum.terms.len() + i] = -sum.scale * term.coefficient * term.rate * time * value;
        }
        filled += 1;
        if filled == size + ROWS || times.peek().is_none() {
            let factor = block.rows(0, filled).into_owned().qr().unpack_r();
            block.fill(0.0);
            block.view_mut((0, 0), (factor.nrows(), size)).copy_from(&factor);
            filled = size;
        }
    }
    (block.rows(0, size).into_owned(), samples)
}

/// Derivatives of (N, c0 … cn, v1 … vn) by (A0, A_i, ln v_i).
fn transform(sum: &ExponentialSum, normalisation: Normalisation) -> DMatrix<f64> {
    let terms = sum.terms.len();
    let mut transform = DMatrix::zeros(2 * terms + 2, 2 * terms + 1);
    let scale_by = DVector::from_fn(2 * terms + 1, |k, _| match normalisation {
        Normalisation::Initial if k <= terms => 1.0,
        Normalisation::Asymptotic if k == 0 => 1.0,
        _ => 0.0,
    });
    for k in 0..=terms {
        transform[(0, k)] = scale_by[k];
        for i in 0..=terms {
            let coefficient = if i == 0 { sum.constant } else { sum.terms[i - 1].coefficient };
            let own = if i == k { 1.0 } else { 0.0 };
            transform[(1 + i, k)] = (own - coefficient * scale_by[k]) / sum.scale;
        }
    }
    for (i, term) in sum.terms.iter().enumerate() {
        transform[(2 + terms + i, 1 + terms + i)] = term.rate;
    }
    transform
}
