//! Directions beside what a model can do by itself: how far a change, whitened, would lower the sum of squares after
//! the model's own coordinates have moved along with it.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use palpate_fit::data::Piece;
use palpate_fit::problem::{Columns, Problem};

/// Part of a direction's size, as a square, that the model's own derivatives must leave of it.
const LEFT: f64 = 1e-3;

/// Inner products of the model's derivatives with each other and with the residual, and of the level of each trace
/// where slow noise moves it: as many more directions, which take at least what the noise does.
struct Own {
    /// Place of the first level: the number of derivatives.
    levels: usize,
    products: DMatrix<f64>,
    residual: DVector<f64>,
}

/// One stretch of the data and the model's whitened columns over it.
pub(super) struct Stretch<'a> {
    problem: &'a Problem<'a>,
    /// Its place in the data set.
    pub(super) index: usize,
    /// What the model says of it.
    pub(super) predicted: Vec<f64>,
    size: usize,
    columns: Columns,
    /// Measured minus predicted.
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

impl Own {
    /// Nothing yet, for so many derivatives and traces.
    fn new(derivatives: usize, traces: usize) -> Self {
        let size = derivatives + traces;
        let (products, residual) = (DMatrix::zeros(size, size), DVector::zeros(size));
        Self { levels: derivatives, products, residual }
    }

    /// Adds a stretch by its index, with its residual (predicted minus measured) and the derivatives of that, not whitened.
    fn add<'a>(
        &mut self,
        problem: &'a Problem<'a>,
        (index, piece): (usize, &Piece),
        mut residual: Vec<f64>,
        mut columns: Columns,
    ) -> Stretch<'a> {
        let predicted = residual.iter().zip(piece.measured).map(|(r, y)| r + y).collect();
        problem.whiten_residual(index, &mut residual);
        residual.iter_mut().for_each(|r| *r = -*r);
        columns.iter_mut().for_each(|(_, column)| problem.whiten_at(index, column));
        let unit = problem.unit_level(index);
        if !unit.is_empty() {
            columns.push((self.levels + piece.trace, unit));
        }
        for (i, column) in &columns {
            self.residual[*i] += dot(column, &residual);
            for (j, other) in &columns {
                self.products[(*i, *j)] += dot(column, other);
            }
        }
        Stretch { problem, index, predicted, size: self.residual.len(), columns, residual }
    }

    /// What these directions alone take off the sum of squares; none where they are no numbers.
    fn explained(&self, places: &[usize]) -> Option<f64> {
        let products = self.products.select_rows(places).select_columns(places);
        let residual = self.residual.select_rows(places);
        let of = Self { levels: self.levels, products, residual: residual.clone() };
        let Beside { scale, moved, .. } = of.solved()?;
        Some(moved.dot(&residual.component_mul(&scale)))
    }

    /// Solves for what the model can do; none where its derivatives are no numbers.
    fn solved(self) -> Option<Beside> {
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
        self.problem.whiten_at(self.index, &mut direction);
        let mut beside = DVector::zeros(self.size);
        for (place, column) in &self.columns {
            beside[*place] += dot(column, &direction);
        }
        let (own, residual) = (dot(&direction, &direction), dot(&direction, &self.residual));
        Products { own, residual, beside }
    }
}

impl Products {
    /// Those with the same direction's over another stretch.
    pub(super) fn with(&self, other: Option<&Self>) -> Self {
        let mut sum = self.clone();
        if let Some(other) = other {
            sum.own += other.own;
            sum.residual += other.residual;
            sum.beside += &other.beside;
        }
        sum
    }
}

impl Beside {
    /// What a problem's chain can do by itself at a point; none where its derivatives are no numbers. `seen` gets every stretch on the
    /// way, where the products of directions over it are taken.
    pub(super) fn of(
        problem: &Problem,
        point: &[f64],
        mut seen: impl FnMut(&Piece, &Stretch),
    ) -> Option<Self> {
        let mut own = Own::new(point.len(), problem.data().labels.len());
        let mut index = 0;
        problem.derivatives(point, |piece, residual, columns| {
            seen(piece, &own.add(problem, (index, piece), residual, columns));
            index += 1;
        });
        own.solved()
    }

    /// Size of a change and the fall of the sum of squares with it; none where the model does the same by itself.
    pub(super) fn judge(&self, products: &Products) -> Option<(f64, f64)> {
        let beside = products.beside.component_mul(&self.scale);
        let left = products.own - beside.dot(&self.factor.solve(&beside));
        let along = products.residual - beside.dot(&self.moved);
        (left > LEFT * products.own).then(|| (along / left, along * along / left))
    }
}

/// Falls of the sum of squares with more directions beside what a problem's chain can do by itself.
pub(super) struct Falls {
    own: Own,
    /// Place of the first of the directions.
    first: usize,
    /// What the model does by itself.
    alone: f64,
}

/// Prepares so many more directions: `more` gives those of a stretch, by its index and the times of its samples, s, each with its place
/// among them; none where the model's derivatives are no numbers.
pub(super) fn sum_of_squares_falls(
    problem: &Problem,
    point: &[f64],
    count: usize,
    more: impl Fn(usize, &[f64]) -> Columns,
) -> Option<Falls> {
    let traces = problem.data().labels.len();
    let mut own = Own::new(point.len(), traces + count);
    let first = point.len() + traces;
    let mut index = 0;
    problem.derivatives(point, |piece, residual, mut columns| {
        let more = more(index, &piece.motion.time).into_iter();
        columns.extend(more.map(|(place, column)| (first + place, column)));
        let _ = own.add(problem, (index, piece), residual, columns);
        index += 1;
    });
    let alone = own.explained(&(0..first).collect::<Vec<_>>())?;
    Some(Falls { own, first, alone })
}

impl Falls {
    /// Fall of the sum of squares with these directions at once; none where they are no numbers, or the model does the same by itself.
    pub(super) fn with(&self, chosen: &[usize]) -> Option<f64> {
        let more = chosen.iter().map(|place| self.first + place);
        let both: Vec<usize> = (0..self.first).chain(more).collect();
        Some(self.own.explained(&both)? - self.alone)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
