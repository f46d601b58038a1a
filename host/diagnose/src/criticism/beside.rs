//! Directions beside what a model can do by itself: how far a change, whitened, would lower the sum of squares after
//! the model's own coordinates have moved along with it.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use palpate_fit::whitening::Whitening;

/// Part of a direction's size, as a square, that the model's own derivatives must leave of it.
const LEFT: f64 = 1e-3;

/// Inner products of the model's derivatives with each other and with the residual, and of the level of each trace
/// where slow noise moves it: as many more directions, which take at least what the noise does.
pub(super) struct Own<'a> {
    whitening: &'a Whitening,
    /// Place of the first level: the number of derivatives.
    levels: usize,
    products: DMatrix<f64>,
    residual: DVector<f64>,
}

/// Whitened columns of one stretch.
pub(super) struct Stretch<'a> {
    whitening: &'a Whitening,
    size: usize,
    columns: Vec<(usize, Vec<f64>)>,
    residual: Vec<f64>,
}

/// Inner products of a whitened direction.
#[derive(Clone)]
pub(super) struct Products {
    own: f64,
    residual: f64,
    beside: DVector<f64>,
}

/// What a model can do by itself, solved.
pub(super) struct Beside {
    scale: DVector<f64>,
    factor: Cholesky<f64, Dyn>,
    /// How it moves by the residual alone, in units where its diagonal is one.
    moved: DVector<f64>,
}

impl<'a> Own<'a> {
    /// Nothing yet, for so many derivatives and traces.
    pub(super) fn new(derivatives: usize, traces: usize, whitening: &'a Whitening) -> Self {
        let size = derivatives + if whitening.levels().is_some() { traces } else { 0 };
        let (products, residual) = (DMatrix::zeros(size, size), DVector::zeros(size));
        Self { whitening, levels: derivatives, products, residual }
    }

    /// Adds a stretch of a trace: its residual (measured minus predicted) and its derivatives, not whitened.
    pub(super) fn add(
        &mut self,
        trace: usize,
        mut residual: Vec<f64>,
        mut columns: Vec<(usize, Vec<f64>)>,
    ) -> Stretch<'a> {
        if self.whitening.levels().is_some() {
            columns.push((self.levels + trace, vec![1.0; residual.len()]));
        }
        self.whitening.apply(&mut residual);
        columns.iter_mut().for_each(|(_, column)| self.whitening.apply(column));
        for (i, column) in &columns {
            self.residual[*i] += dot(column, &residual);
            for (j, other) in &columns {
                self.products[(*i, *j)] += dot(column, other);
            }
        }
        Stretch { whitening: self.whitening, size: self.residual.len(), columns, residual }
    }

    /// Solves for what the model can do; none where its derivatives are no numbers.
    pub(super) fn solved(self) -> Option<Beside> {
        let scale = self.products.diagonal().map(|v| if v > 0.0 { 1.0 / v.sqrt() } else { 0.0 });
        let scaled = DMatrix::from_fn(scale.len(), scale.len(), |i, j| {
            let value = self.products[(i, j)] * scale[i] * scale[j];
            if i == j { value.max(1.0) * (1.0 + 1e-9) } else { value }
        });
        let factor = scaled.cholesky()?;
        let moved = factor.solve(&self.residual.component_mul(&scale));
        Some(Beside { scale, factor, moved })
    }
}

impl Stretch<'_> {
    /// Inner products of a direction over this stretch, which is whitened first.
    pub(super) fn products(&self, mut direction: Vec<f64>) -> Products {
        self.whitening.apply(&mut direction);
        let mut beside = DVector::zeros(self.size);
        for (place, column) in &self.columns {
            beside[*place] += dot(column, &direction);
        }
        let (own, residual) = (dot(&direction, &direction), dot(&direction, &self.residual));
        Products { own, residual, beside }
    }
}

impl Products {
    /// Adds those over another stretch.
    pub(super) fn add(&mut self, other: &Self) {
        self.own += other.own;
        self.residual += other.residual;
        self.beside += &other.beside;
    }
}

impl Beside {
    /// Size of a change and the fall of the sum of squares with it; none where the model does the same by itself.
    pub(super) fn judge(&self, products: &Products) -> Option<(f64, f64)> {
        let beside = products.beside.component_mul(&self.scale);
        let left = products.own - beside.dot(&self.factor.solve(&beside));
        let along = products.residual - beside.dot(&self.moved);
        (left > LEFT * products.own).then(|| (along / left, along * along / left))
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
