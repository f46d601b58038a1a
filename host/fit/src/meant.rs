//! What block means tell of the samples of a stretch beside their values.

use std::ops::Range;

use super::data::{Data, Piece};
use super::means::{Blocks, Means};
use super::whitened_blocks::{Settled, WhitenedBlocks};
use super::whitening::Whitening;

/// The means of one stretch under a model of the noise.
#[derive(Clone, Debug)]
pub(super) struct Meant {
    begins: Vec<usize>,
    /// Root of the number of samples of each.
    pub roots: Vec<f64>,
    /// What makes their noise white.
    pub filter: WhitenedBlocks,
    /// What the scatter of the samples adds to each whitened mean: with correlated noise, that within a block tells of its level.
    pub shift: Vec<f64>,
    /// Sum of squares of the samples of each that the mean does not show, whitened.
    pub white: Vec<f64>,
    /// The same as they are.
    pub raw: Vec<f64>,
}

impl Meant {
    /// Of every stretch of a data set.
    pub fn of(means: &Means, data: &Data, whitening: &Whitening) -> Vec<Self> {
        let mut settled = Settled::default();
        let stretches = data.pieces.iter().zip(means.stretches());
        stretches.map(|(piece, blocks)| Self::new(piece, blocks, whitening, &mut settled)).collect()
    }

    fn new(piece: &Piece, blocks: &Blocks, whitening: &Whitening, settled: &mut Settled) -> Self {
        let begins = blocks.begins.clone();
        let roots = blocks.roots();
        let mut scatter = blocks.scatter(piece);
        let of_blocks = |values: &[f64]| -> Vec<(f64, f64)> {
            let sums = |pair: &[usize]| {
                let values = &values[pair[0]..pair[1]];
                (values.iter().sum(), values.iter().map(|value| value * value).sum())
            };
            begins.windows(2).map(sums).collect()
        };
        let raw = of_blocks(&scatter).into_iter().map(|(_, square)| square).collect();
        whitening.apply(&mut scatter);
        let white = of_blocks(&scatter);
        let shift: Vec<f64> = white.iter().zip(&roots).map(|((sum, _), root)| sum / root).collect();
        let unseen = |((_, square), shift): (&(f64, f64), &f64)| (square - shift * shift).max(0.0);
        Self {
            filter: WhitenedBlocks::new(whitening, &begins, settled),
            white: white.iter().zip(&shift).map(unseen).collect(),
            raw,
            shift,
            roots,
            begins,
        }
    }

    /// Number of samples that a range of means stands for.
    pub fn rows(&self, range: Range<usize>) -> usize {
        self.begins[range.end] - self.begins[range.start]
    }
}
