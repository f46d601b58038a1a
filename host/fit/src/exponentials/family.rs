//! The exponentials e^(−v t) over a range of rates, and their derivatives in u = ln v.

use std::ops::Range;

use crate::many_exp::exp;

/// Spacing of the tabulated rates in ln v: a quintic between them is exact to 1e-10.
const SPACING: f64 = 0.08;

/// Exponentials at tabulated rates on given times.
#[derive(Clone, Debug)]
pub(super) struct Family {
    /// Times since the first sample, s.
    pub times: Vec<f64>,
    /// Tabulated rates, 1/s, evenly spaced in ln v, both limits included.
    pub rates: Vec<f64>,
    /// Spacing of the tabulated rates in ln v.
    pub spacing: f64,
}

/// The columns of a family on some of its samples, each weighted.
pub(super) struct Shapes {
    /// The constant last; before it, for each rate, value, first and second derivative in u,
    /// the derivatives times the spacing and its square.
    pub columns: Vec<Vec<f64>>,
}

impl Family {
    pub fn new(times: Vec<f64>, slowest: f64, fastest: f64) -> Self {
        let range = (fastest / slowest).ln();
        let intervals = (range / SPACING).ceil().max(1.0);
        let spacing = range / intervals;
        let rates = (0..=intervals as usize)
            .map(|index| (slowest.ln() + spacing * index as f64).exp())
            .collect();
        Self { times, rates, spacing }
    }

    /// Number of columns of [`Shapes`].
    pub fn columns(&self) -> usize {
        3 * self.rates.len() + 1
    }

    /// Column of the derivative of given order at a rate.
    pub fn column(&self, rate: usize, order: usize) -> usize {
        3 * rate + order
    }

    /// Column of the constant.
    pub fn constant(&self) -> usize {
        3 * self.rates.len()
    }

    pub fn shapes(&self, samples: Range<usize>, roots: &[f64]) -> Shapes {
        let times = &self.times[samples.clone()];
        let roots = roots.get(samples).unwrap_or_default();
        let weighted = |mut values: Vec<f64>| {
            values.iter_mut().zip(roots).for_each(|(value, root)| *value *= root);
            values
        };
        let mut columns = Vec::with_capacity(self.columns());
        for rate in &self.rates {
            let values = weighted(times.iter().map(|time| exp(-(rate * time))).collect());
            let each = || times.iter().zip(&values).map(|(time, value)| (rate * time, value));
            let first = each().map(|(x, value)| -x * value * self.spacing).collect();
            let second = each()
                .map(|(x, value)| x * (x - 1.0) * value * self.spacing * self.spacing)
                .collect();
            columns.extend([values, first, second]);
        }
        columns.push(weighted(vec![1.0; times.len()]));
        Shapes { columns }
    }
}

impl Shapes {
    /// What a basis must span: the constant, then the exponentials.
    pub fn spanned(&self) -> impl Iterator<Item = &Vec<f64>> {
        let (constant, rest) = self.columns.split_last().expect("a family holds the constant");
        std::iter::once(constant).chain(rest.iter().step_by(3))
    }
}
