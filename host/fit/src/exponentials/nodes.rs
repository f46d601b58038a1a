//! Times reduced to a few nodes with weights, on which sums of exponentials are as good as on all samples.
//!
//! Samples are cut into blocks, short where the fast terms live, each later one a little longer than all before it. Over a block an
//! exponential is a polynomial of eleventh degree as far as it matters, and the product of two is summed up exactly by twelve
//! nodes: Gauss's quadrature of the samples themselves (Golub and Welsch, 1969). A trace comes to the nodes by the polynomials
//! that are orthonormal over the samples. Nothing is tabulated, so that this is soon done; but the coordinates are several
//! times as many as those of [`super::basis`], and each exponential is computed anew.

use std::ops::Range;

use nalgebra::SMatrix;

use super::basis::{Basis, Block, WIDTH, product};
use super::table::Table;
use super::vector::{add_scaled, dot};

/// Fastest rate times the duration of the first block: eleventh degree leaves 1e-6 of such a decay.
const FIRST: f64 = 5.0;
/// End of a block over its beginning.
const GROWTH: f64 = 2.2;
/// Samples below which rounding is taken out of the polynomials once more.
const FEW: usize = 128;
/// Length of what a polynomial adds to those before, over one, below which there is none of that degree.
const NONE: f64 = 1e-7;

/// One block: polynomials that are orthonormal over its samples, and how they stand at its nodes.
struct Polynomials {
    /// Each at every sample, times the root of the weight.
    vectors: Vec<Vec<f64>>,
    /// Times of the nodes since the first sample, s.
    times: [f64; WIDTH],
    /// Row j holds polynomial j at the nodes, times the roots of their weights.
    at_nodes: [[f64; WIDTH]; WIDTH],
    /// Roots of the weights of the nodes.
    roots: [f64; WIDTH],
}

/// The basis and the exponentials between two rates, 1/s, on times since the first sample, s; `roots` holds the root of each weight or is
/// empty. None where `R` nodes are not enough.
pub(super) fn on_nodes<const R: usize>(
    times: &[f64],
    roots: Vec<f64>,
    (slowest, fastest): (f64, f64),
) -> Option<(Basis<R>, Table<R>)> {
    let ranges = blocks(times, FIRST / fastest);
    if ranges.len() * WIDTH > R {
        return None;
    }
    let (mut node_times, mut node_roots) = ([0.0; R], [0.0; R]);
    let mut found = Vec::new();
    for (block, range) in ranges.into_iter().enumerate() {
        let own = roots.get(range.clone()).unwrap_or_default();
        let polynomials = Polynomials::new(&times[range], own);
        let nodes = block * WIDTH..(block + 1) * WIDTH;
        node_times[nodes.clone()].copy_from_slice(&polynomials.times);
        node_roots[nodes].copy_from_slice(&polynomials.roots);
        found.push(polynomials);
    }
    let constant_norm = dot(&node_roots, &node_roots).sqrt();
    // The constant becomes the first coordinate by a reflection.
    let mut mirror = node_roots.map(|root| root / constant_norm);
    mirror[0] -= 1.0;
    let length = dot(&mirror, &mirror).sqrt().max(f64::MIN_POSITIVE);
    mirror.iter_mut().for_each(|value| *value /= length);
    let block = |(index, polynomials): (usize, Polynomials)| {
        let mut rows = vec![[0.0; WIDTH]; polynomials.vectors[0].len()];
        for (column, vector) in polynomials.vectors.iter().enumerate() {
            for (row, value) in rows.iter_mut().zip(vector) {
                row[column] = *value;
            }
        }
        let merge = polynomials.at_nodes.map(|at_nodes| {
            let mut row = [0.0; R];
            row[index * WIDTH..(index + 1) * WIDTH].copy_from_slice(&at_nodes);
            reflect(&mut row, &mirror);
            row
        });
        Block { rows, merge: Box::new(merge) }
    };
    let blocks = found.into_iter().enumerate().map(block).collect();
    let table = Table::exact(node_times, node_roots, mirror, (slowest.ln(), fastest.ln()));
    Some((Basis::of(blocks, roots, constant_norm), table))
}

/// Takes a vector to its mirror image.
#[inline]
pub(super) fn reflect<const R: usize>(vector: &mut [f64; R], mirror: &[f64; R]) {
    let along = dot(vector, mirror);
    add_scaled(vector, -2.0 * along, mirror);
}

/// Samples block by block, the first lasting so long, s; each has as many samples as it has nodes.
fn blocks(times: &[f64], first: f64) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut begin = 0;
    while begin < times.len() {
        let until = first.max(GROWTH * times[begin]);
        let end = begin + times[begin..].partition_point(|time| *time < until);
        let mut end = end.max(begin + WIDTH).min(times.len());
        // Too few for a block of their own.
        if times.len() - end < WIDTH {
            end = times.len();
        }
        found.push(begin..end);
        begin = end;
    }
    found
}

impl Polynomials {
    fn new(times: &[f64], roots: &[f64]) -> Self {
        let (first, last) = (times[0], times[times.len() - 1]);
        let (middle, half) = (0.5 * (first + last), (0.5 * (last - first)).max(f64::MIN_POSITIVE));
        let scaled: Vec<f64> = times.iter().map(|time| (time - middle) / half).collect();
        let mut next = if roots.is_empty() { vec![1.0; times.len()] } else { roots.to_vec() };
        let norm = product(&next, &next).sqrt();
        let mut vectors: Vec<Vec<f64>> = Vec::new();
        // Of those that a block with few weights lacks, the nodes stand out of the way and count for nothing.
        let mut jacobi = SMatrix::<f64, WIDTH, WIDTH>::zeros();
        (0..WIDTH).for_each(|k| jacobi[(k, k)] = 2.0 + k as f64);
        let (mut length, mut least) = (norm, 0.0);
        for degree in 0..WIDTH {
            if length <= least {
                break;
            }
            least = NONE;
            next.iter_mut().for_each(|value| *value /= length);
            if degree > 0 {
                jacobi[(degree, degree - 1)] = length;
                jacobi[(degree - 1, degree)] = length;
            }
            let own = next;
            next = own.iter().zip(&scaled).map(|(value, time)| value * time).collect();
            let along = product(&next, &own);
            jacobi[(degree, degree)] = along;
            subtract(&mut next, along, &own);
            if let Some(before) = vectors.last() {
                subtract(&mut next, length, before);
            }
            vectors.push(own);
            if times.len() < FEW {
                for vector in &vectors {
                    let along = product(&next, vector);
                    subtract(&mut next, along, vector);
                }
            }
            length = product(&next, &next).sqrt();
        }
        vectors.resize(WIDTH, vec![0.0; times.len()]);
        let eigen = jacobi.symmetric_eigen();
        let sign = |node: usize| if eigen.eigenvectors[(0, node)] < 0.0 { -1.0 } else { 1.0 };
        let at = |degree: usize, node: usize| sign(node) * eigen.eigenvectors[(degree, node)];
        Self {
            vectors,
            times: std::array::from_fn(|node| {
                middle + half * eigen.eigenvalues[node].clamp(-1.0, 1.0)
            }),
            at_nodes: std::array::from_fn(|degree| std::array::from_fn(|node| at(degree, node))),
            roots: std::array::from_fn(|node| norm * at(0, node)),
        }
    }
}

/// `a -= factor · b`.
fn subtract(a: &mut [f64], factor: f64, b: &[f64]) {
    for (a, b) in a.iter_mut().zip(b) {
        *a -= factor * b;
    }
}
