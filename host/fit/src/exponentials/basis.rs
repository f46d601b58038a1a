//! A few orthonormal vectors that span every decaying exponential of interest on the sample times.
//!
//! Exponentials with rates between two limits are nearly linearly dependent: some twenty vectors
//! span them all to 1e-10. A trace is projected onto these once, and the search for rates then
//! works on some twenty numbers instead of on the samples. The projection has two stages. The
//! trace is cut into blocks, short where the fast terms live and long where only slow ones are
//! left, each spanned by [`WIDTH`] vectors of its own; the coordinates of all blocks together are
//! then reduced to the common ones. That needs half the arithmetic of one stage.

use super::family::{Family, Shapes};
use super::vector::add_scaled;
use nalgebra::DMatrix;

/// Vectors that span the exponentials within one block: six SSE registers of sums.
pub(super) const WIDTH: usize = 12;
/// Longest block, so that preparing a long trace needs little memory.
const LONGEST: usize = 4096;
/// Root-mean-square error allowed in spanning an exponential of amplitude 1.
pub(super) const TOLERANCE: f64 = 1e-10;

/// Sum of squares that rounding leaves of a difference, as a share of what was subtracted.
const CANCELLED: f64 = 1e-9;

/// One run of samples with a basis of its own.
#[derive(Clone, Debug)]
pub(super) struct Block<const R: usize> {
    /// Row k holds the block's basis at sample k, times the root of its weight.
    pub rows: Vec<[f64; WIDTH]>,
    /// Row j takes the block's coordinate j to the common coordinates.
    pub merge: Box<[[f64; R]; WIDTH]>,
}

/// The common basis; coordinate 0 belongs to the constant.
#[derive(Clone, Debug)]
pub(super) struct Basis<const R: usize> {
    blocks: Vec<Block<R>>,
    /// Roots of the weights; empty where all are 1.
    roots: Vec<f64>,
    /// Norm of the constant function 1, √Σw.
    pub constant_norm: f64,
}

/// A trace on the basis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Projection<const R: usize> {
    /// Coordinates.
    pub coordinates: [f64; R],
    /// Weighted sum of squares of what the basis does not span.
    pub outside: f64,
}

/// Exponentials and their derivatives in common coordinates, one entry for each rate.
pub(super) type Coordinates<const R: usize> = Vec<[[f64; R]; 3]>;

/// Most coordinates of a common basis.
pub(super) const MOST_COORDINATES: usize = 96;

/// What the exponentials of a family are spanned by, before it is known how many common coordinates an engine has.
pub(super) struct Spanned {
    blocks: Vec<Draft>,
    /// All columns of the family in the coordinates of all blocks.
    stacked: DMatrix<f64>,
    /// The common basis in these.
    common: DMatrix<f64>,
    constant_norm: f64,
}

impl Spanned {
    /// By the constant and the exponentials of `family`; `roots` holds the root of each weight or is empty. None where more than
    /// [`MOST_COORDINATES`] are needed.
    pub fn new(family: &Family, roots: &[f64]) -> Option<Self> {
        let total: f64 = match roots.len() {
            0 => family.times.len() as f64,
            _ => roots.iter().map(|root| root * root).sum(),
        };
        let constant_norm = total.sqrt();
        let tolerance = TOLERANCE * constant_norm;
        let mut blocks = Vec::new();
        draft(family, roots, 0..family.times.len(), 0.3 * tolerance, &mut blocks);

        let mut stacked = DMatrix::zeros(blocks.len() * WIDTH, family.columns());
        for (index, draft) in blocks.iter().enumerate() {
            for (column, values) in draft.coordinates.iter().enumerate() {
                for (row, value) in values.iter().enumerate() {
                    stacked[(index * WIDTH + row, column)] = *value;
                }
            }
        }
        let common = common_basis(&stacked, family, tolerance)?;
        Some(Self { blocks, stacked, common, constant_norm })
    }

    /// How many common coordinates there are.
    pub fn width(&self) -> usize {
        self.common.ncols()
    }
}

/// A block before the common basis is known.
struct Draft {
    samples: usize,
    vectors: Vec<Vec<f64>>,
    /// Coordinates of all columns of the family.
    coordinates: Vec<[f64; WIDTH]>,
}

impl<const R: usize> Basis<R> {
    /// Of what spans a family of exponentials, at most `R` wide; `roots` are those it was spanned with. Returns the family in the
    /// common coordinates too.
    pub fn new(family: &Family, spanned: &Spanned, roots: Vec<f64>) -> (Self, Coordinates<R>) {
        let Spanned { blocks, stacked, common, constant_norm } = spanned;
        let reduced = common.transpose() * stacked;
        let coordinates = (0..family.rates.len())
            .map(|rate| {
                let mut shapes = [[0.0; R]; 3];
                for (order, shape) in shapes.iter_mut().enumerate() {
                    for (row, value) in shape.iter_mut().enumerate().take(common.ncols()) {
                        *value = reduced[(row, family.column(rate, order))];
                    }
                }
                shapes
            })
            .collect();
        let blocks = blocks.iter().enumerate();
        let blocks = blocks.map(|(index, draft)| finish(draft, index, common)).collect();
        (Self::of(blocks, roots, *constant_norm), coordinates)
    }

    /// Of these blocks, whose rows do not have the roots of the weights yet.
    pub fn of(blocks: Vec<Block<R>>, roots: Vec<f64>, constant_norm: f64) -> Self {
        let mut basis = Self { blocks, roots, constant_norm };
        basis.weigh();
        basis
    }

    /// Multiplies the rows by the roots of the weights, which the samples then need not be.
    fn weigh(&mut self) {
        if self.roots.is_empty() {
            return;
        }
        let rows = self.blocks.iter_mut().flat_map(|block| block.rows.iter_mut());
        for (row, root) in rows.zip(&self.roots) {
            for value in row {
                *value *= root;
            }
        }
    }

    /// Projects a trace; its values are taken relative to the first so that an offset costs no
    /// digits. A value that is not finite gives a result that is not finite.
    pub fn project(&self, values: &[f64]) -> Projection<R> {
        let reference = values[0];
        let mut coordinates = [0.0; R];
        let mut rest = values;
        for block in &self.blocks {
            let (now, later) = rest.split_at(block.rows.len());
            rest = later;
            let local = local_coordinates(&block.rows, now, reference);
            for (row, value) in block.merge.iter().zip(local) {
                add_scaled(&mut coordinates, value, row);
            }
        }
        let total = self.sum_of_squares(values, reference);
        let inside: f64 = coordinates.iter().map(|value| value * value).sum();
        let mut outside = total - inside;
        if outside < CANCELLED * total {
            outside = self.outside(values, reference, &coordinates);
        }
        coordinates[0] += reference * self.constant_norm;
        Projection { coordinates, outside }
    }

    /// Weighted sum of squares about a reference.
    fn sum_of_squares(&self, values: &[f64], reference: f64) -> f64 {
        let mut sum = [0.0; 8];
        if self.roots.is_empty() {
            let (chunks, tail) = values.as_chunks::<8>();
            for chunk in chunks {
                for lane in 0..8 {
                    let value = chunk[lane] - reference;
                    sum[lane] += value * value;
                }
            }
            for value in tail {
                sum[0] += (value - reference) * (value - reference);
            }
        } else {
            for (value, root) in values.iter().zip(&self.roots) {
                let value = (value - reference) * root;
                sum[0] += value * value;
            }
        }
        sum.iter().sum()
    }

    /// The same sum of squares from the residuals themselves, for a trace with so little noise
    /// that the difference of two sums of squares has lost its digits.
    fn outside(&self, values: &[f64], reference: f64, coordinates: &[f64; R]) -> f64 {
        let mut sum = 0.0;
        let mut sample = 0;
        for block in &self.blocks {
            let samples = sample..sample + block.rows.len();
            let local = local_coordinates(&block.rows, &values[samples.clone()], reference);
            for (row, value) in block.merge.iter().zip(local) {
                let common: f64 = row.iter().zip(coordinates).map(|(a, b)| a * b).sum();
                sum += (value - common) * (value - common);
            }
            for (row, k) in block.rows.iter().zip(samples) {
                // The rows carry the root of the weight already; the block's vectors do not mix.
                let root = self.roots.get(k).copied().unwrap_or(1.0);
                if root == 0.0 {
                    continue;
                }
                let modelled: f64 = row.iter().zip(local).map(|(a, b)| a * b).sum::<f64>() / root;
                let residual = (values[k] - reference) * root - modelled;
                sum += residual * residual;
            }
            sample += block.rows.len();
        }
        sum
    }
}

/// Coordinates of some samples in their block's basis: six SSE multiply-adds for each sample, in
/// two sets of sums so that no addition waits for the one before.
#[inline]
fn local_coordinates(rows: &[[f64; WIDTH]], values: &[f64], reference: f64) -> [f64; WIDTH] {
    let mut even = [0.0; WIDTH];
    let mut odd = [0.0; WIDTH];
    let (pairs, single) = rows.as_chunks::<2>();
    let (value_pairs, single_value) = values.as_chunks::<2>();
    for (rows, values) in pairs.iter().zip(value_pairs) {
        let (a, b) = (values[0] - reference, values[1] - reference);
        for column in 0..WIDTH {
            even[column] += a * rows[0][column];
        }
        for column in 0..WIDTH {
            odd[column] += b * rows[1][column];
        }
    }
    for (row, value) in single.iter().zip(single_value) {
        for column in 0..WIDTH {
            even[column] += (value - reference) * row[column];
        }
    }
    for column in 0..WIDTH {
        even[column] += odd[column];
    }
    even
}

/// Cuts samples into blocks that [`WIDTH`] vectors span, by halves.
fn draft(
    family: &Family,
    roots: &[f64],
    samples: std::ops::Range<usize>,
    tolerance: f64,
    drafts: &mut Vec<Draft>,
) {
    if samples.len() <= LONGEST {
        let shapes = family.shapes(samples.clone(), roots);
        if let Some(vectors) = greedy(&shapes, tolerance, samples.len()) {
            let coordinates = shapes
                .columns
                .iter()
                .map(|column| {
                    let mut values = [0.0; WIDTH];
                    for (value, vector) in values.iter_mut().zip(&vectors) {
                        *value = product(vector, column);
                    }
                    values
                })
                .collect();
            drafts.push(Draft { samples: samples.len(), vectors, coordinates });
            return;
        }
    }
    let middle = samples.start + samples.len() / 2;
    draft(family, roots, samples.start..middle, tolerance, drafts);
    draft(family, roots, middle..samples.end, tolerance, drafts);
}

/// Sum of products, in eight partial sums that do not wait for one another.
pub(super) fn product(a: &[f64], b: &[f64]) -> f64 {
    let ((a, end_of_a), (b, end_of_b)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let end: f64 = end_of_a.iter().zip(end_of_b).map(|(a, b)| a * b).sum();
    let [a, b, c, d, e, f, g, h] = sums;
    (((a + b) + (c + d)) + ((e + f) + (g + h))) + end
}

/// Orthonormal vectors that span the constant and all exponentials within a block, the one that
/// is worst spanned added first; nothing when [`WIDTH`] do not suffice.
fn greedy(shapes: &Shapes, tolerance: f64, samples: usize) -> Option<Vec<Vec<f64>>> {
    let mut rest: Vec<Vec<f64>> = shapes.spanned().cloned().collect();
    let mut vectors: Vec<Vec<f64>> = Vec::new();
    // Numbers of size 1 cannot be told from rounding below this.
    let tolerance = tolerance.max(1e-15 * (samples as f64).sqrt());
    loop {
        let (worst, norm) = if vectors.is_empty() {
            (0, product(&rest[0], &rest[0]))
        } else {
            let norms = rest.iter().map(|column| product(column, column)).enumerate();
            norms.max_by(|a, b| a.1.total_cmp(&b.1))?
        };
        if norm.sqrt() <= tolerance {
            return Some(vectors);
        }
        if vectors.len() == WIDTH.min(samples) {
            return None;
        }
        let mut next = rest[worst].clone();
        for vector in &vectors {
            let along = product(vector, &next);
            next.iter_mut().zip(vector).for_each(|(a, b)| *a -= along * b);
        }
        let norm = product(&next, &next).sqrt();
        next.iter_mut().for_each(|value| *value /= norm);
        for column in &mut rest {
            let along = product(&next, column);
            column.iter_mut().zip(&next).for_each(|(a, b)| *a -= along * b);
        }
        vectors.push(next);
    }
}

/// The common basis in stacked coordinates: the constant first, then the singular vectors of what
/// it leaves of the exponentials, as many as the tolerance needs; nothing when that exceeds [`MOST_COORDINATES`].
fn common_basis(stacked: &DMatrix<f64>, family: &Family, tolerance: f64) -> Option<DMatrix<f64>> {
    let constant = stacked.column(family.constant()).normalize();
    let columns: Vec<usize> = (0..family.rates.len()).map(|rate| family.column(rate, 0)).collect();
    let mut rest = stacked.select_columns(&columns);
    for _ in 0..2 {
        rest -= &constant * (constant.transpose() * &rest);
    }
    let vectors = rest.clone().svd(true, false).u?;
    let mut basis = DMatrix::zeros(stacked.nrows(), MOST_COORDINATES);
    basis.set_column(0, &constant);
    let mut width = 1;
    while rest.column_iter().any(|column| column.norm() > tolerance) {
        if width == MOST_COORDINATES || width > vectors.ncols() {
            return None;
        }
        let mut vector = vectors.column(width - 1).into_owned();
        // Singular vectors of small singular values are not quite orthogonal to the constant.
        for _ in 0..2 {
            let before = basis.columns(0, width);
            vector -= before * (before.transpose() * &vector);
            vector.normalize_mut();
        }
        rest -= &vector * (vector.transpose() * &rest);
        basis.set_column(width, &vector);
        width += 1;
    }
    Some(basis.columns(0, width).into_owned())
}

fn finish<const R: usize>(draft: &Draft, index: usize, common: &DMatrix<f64>) -> Block<R> {
    let mut rows = vec![[0.0; WIDTH]; draft.samples];
    for (column, vector) in draft.vectors.iter().enumerate() {
        for (row, value) in rows.iter_mut().zip(vector) {
            row[column] = *value;
        }
    }
    let mut merge = Box::new([[0.0; R]; WIDTH]);
    for (j, row) in merge.iter_mut().enumerate() {
        for (value, common) in row.iter_mut().zip(common.row(index * WIDTH + j).iter()) {
            *value = *common;
        }
    }
    Block { rows, merge }
}
