//! Columns of a few samples at a time, and the inner products of all pairs of them.
//!
//! A block of samples is short enough to stay at hand in the cache while every pair of its columns is multiplied, and each product of
//! two columns stays in registers until its block is over.

/// Samples of a block.
pub const BLOCK: usize = 64;
/// Sums that are kept beside one another, so that no addition waits for the one before.
const LANES: usize = 4;

/// One quantity at each sample of a block.
#[derive(Clone, Copy, Debug)]
#[repr(align(16))]
pub struct Column(pub [f64; BLOCK]);

/// Sums of products of pairs of columns.
#[derive(Clone, Debug)]
pub struct Products {
    width: usize,
    /// Row by row, each from its own column on.
    sums: Vec<f64>,
}

impl Column {
    /// All zero.
    pub const ZERO: Self = Self([0.0; BLOCK]);
}

impl Products {
    /// Of so many columns, over no samples.
    pub fn zeros(width: usize) -> Self {
        Self { width, sums: vec![0.0; width * (width + 1) / 2] }
    }

    /// Adds the samples of a block: as many columns as there are sums of.
    pub fn add(&mut self, columns: &[Column]) {
        let mut rest = &mut self.sums[..];
        for (a, column) in columns.iter().enumerate() {
            let (own, later) = rest.split_at_mut(columns.len() - a);
            rest = later;
            let (pairs, single) = columns[a..].as_chunks::<2>();
            let (sums, last) = own.as_chunks_mut::<2>();
            for (sums, others) in sums.iter_mut().zip(pairs) {
                add_products(sums, column, others);
            }
            for (sum, other) in last.iter_mut().zip(single) {
                add_products(std::array::from_mut(sum), column, std::array::from_ref(other));
            }
        }
    }

    /// Adds to the product of the last column with itself.
    pub fn add_to_last(&mut self, square: f64) {
        if let Some(last) = self.sums.last_mut() {
            *last += square;
        }
    }

    /// The product of two columns.
    pub fn of(&self, a: usize, b: usize) -> f64 {
        let (a, b) = (a.min(b), a.max(b));
        self.sums[a * self.width - a * (a + 1) / 2 + b]
    }
}

/// Adds the products of a column with `K` others.
fn add_products<const K: usize>(sums: &mut [f64; K], column: &Column, others: &[Column; K]) {
    let mut lanes = [[0.0; LANES]; K];
    for begin in (0..BLOCK).step_by(LANES) {
        for (lanes, other) in lanes.iter_mut().zip(others) {
            for (lane, sum) in lanes.iter_mut().enumerate() {
                *sum += column.0[begin + lane] * other.0[begin + lane];
            }
        }
    }
    for (sum, lanes) in sums.iter_mut().zip(lanes) {
        *sum += (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_has_its_product() {
        for width in 1..8 {
            let column =
                |a: usize| Column(std::array::from_fn(|k| 0.1 * k as f64 + (a as f64 + 1.0).sin()));
            let columns: Vec<Column> = (0..width).map(column).collect();
            let mut products = Products::zeros(width);
            products.add(&columns);
            products.add(&columns);
            for a in 0..width {
                for b in 0..width {
                    let pairs = columns[a].0.iter().zip(&columns[b].0);
                    let expected = 2.0 * pairs.map(|(a, b)| a * b).sum::<f64>();
                    assert!((products.of(a, b) / expected - 1.0).abs() < 1e-14, "{a}, {b}");
                }
            }
            let before = products.of(width - 1, width - 1);
            products.add_to_last(1.0);
            assert_eq!(products.of(width - 1, width - 1), before + 1.0);
        }
    }
}
