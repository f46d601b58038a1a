//! The normal equations of the parts of the data.

use nalgebra::DVector;

use super::{Columns, Problem};
use crate::least_squares::Normal;
use crate::levels::LevelSums;
use crate::remembering::Reached;

/// The normal equations of one part of the data.
#[derive(Clone, Debug)]
pub struct Block {
    /// The trace it is of.
    pub trace: usize,
    /// Number of samples.
    pub samples: usize,
    /// The coordinates that it depends on: what other traces have of their own is not among them.
    pub coordinates: Vec<usize>,
    /// The normal equations of those, whitened.
    pub white: Normal,
    /// As they are.
    pub raw: Normal,
    /// Sum over runs of neighbours of the squared sum of their whitened residuals, over their number:
    /// the sum of squares times the number of samples that count as one.
    pub slow: f64,
    /// What the levels of the traces have in common with it, where slow noise moves them.
    pub levels: Option<LevelSums>,
}

impl Block {
    fn new(trace: usize, coordinates: Vec<usize>) -> Self {
        let zeros = || Normal::zeros(coordinates.len());
        let (white, raw) = (zeros(), zeros());
        Self { trace, samples: 0, coordinates, white, raw, slow: 0.0, levels: None }
    }

    /// Its sums of squares after a step of all coordinates, as they are and whitened, as the straight line of the step foretells.
    #[must_use]
    pub fn foretold(&self, step: &DVector<f64>) -> (f64, f64) {
        let own = DVector::from_iterator(
            self.coordinates.len(),
            self.coordinates.iter().map(|&j| step[j]),
        );
        let after = |normal: &Normal| (normal.cost + normal.raised_by(&own)).max(0.0);
        (after(&self.raw), after(&self.white))
    }
}

/// Fewest blocks that data are taken apart into.
const FEWEST_BLOCKS: usize = 8;
/// Least and largest number of neighbours whose residuals are summed.
const NEIGHBOURS: (usize, usize) = (8, 216);

impl Problem<'_> {
    /// The normal equations of every trace by itself, as it is.
    #[must_use]
    pub fn by_trace(&self, point: &[f64]) -> Vec<(Normal, usize)> {
        let traces = self.data.labels.len();
        if self.roots.is_empty()
            && let Some(normals) = self.in_one_pass(point, traces, |piece| Some(piece.trace))
        {
            let samples = |trace: usize| {
                let own = self.data.pieces.iter().filter(|piece| piece.trace == trace);
                own.map(|piece| piece.measured.len()).sum()
            };
            return normals
                .into_iter()
                .enumerate()
                .map(|(k, normal)| (normal, samples(k)))
                .collect();
        }
        let mut found = vec![(Normal::zeros(point.len()), 0); traces];
        self.slopes(point, &mut Reached::default(), |piece, residual, columns| {
            let (normal, samples) = &mut found[piece.trace];
            normal.add(columns, residual, 0..residual.len());
            *samples += residual.len();
        });
        found
    }

    /// The normal equations of every block of the data, whitened and as they are. A block is a trace,
    /// or a part of one where there are few.
    #[must_use]
    pub fn blocks(&self, point: &[f64]) -> Vec<Block> {
        self.blocks_from(point, &mut Reached::default())
    }

    /// The same from where a set-up that yields came to before.
    pub(crate) fn blocks_from(&self, point: &[f64], reached: &mut Reached) -> Vec<Block> {
        let parts = FEWEST_BLOCKS.div_ceil(self.data.pieces.len().max(1));
        let mut blocks = Vec::new();
        let mut index = 0;
        self.slopes(point, reached, |piece, residual, columns| {
            let first = blocks.len();
            let ranges = self.parts(index, parts);
            let coordinates: Vec<usize> = columns.iter().map(|(j, _)| *j).collect();
            let mut weighted: Columns =
                columns.iter().enumerate().map(|(at, (_, column))| (at, column.clone())).collect();
            weighted.iter_mut().for_each(|(_, column)| self.weigh(index, column));
            let mut weighted_residual = residual.clone();
            self.weigh(index, &mut weighted_residual);
            for range in &ranges {
                let mut block = Block::new(piece.trace, coordinates.clone());
                block.levels = self.level_sums(point.len());
                block.samples = self.rows_of(index, range.clone());
                block.raw.add(&weighted, &weighted_residual, range.clone());
                blocks.push(block);
            }
            let unit = self.unit_level(index);
            self.whiten_residual(index, residual);
            for (_, column) in columns.iter_mut() {
                self.whiten_at(index, column);
            }
            for (block, range) in blocks[first..].iter_mut().zip(&ranges) {
                if let Some(sums) = &mut block.levels {
                    sums.add(piece.trace, &unit[range.clone()], columns, residual, range.start);
                }
            }
            columns.iter_mut().enumerate().for_each(|(at, (coordinate, _))| *coordinate = at);
            for (block, range) in blocks[first..].iter_mut().zip(ranges) {
                block.slow = self.sums_of_neighbours(index, &residual[range.clone()], range.start);
                block.white.add(columns, residual, range.clone());
                if let Some(means) = self.means.get(index) {
                    block.raw.cost += means.raw[range.clone()].iter().sum::<f64>();
                    block.white.cost += means.white[range].iter().sum::<f64>();
                }
            }
            index += 1;
        });
        blocks
    }

    /// Sum over runs of neighbours of the squared sum of their whitened residuals, over their number; `from` is where they
    /// begin in their stretch.
    fn sums_of_neighbours(&self, index: usize, residual: &[f64], from: usize) -> f64 {
        let rows = self.rows_of(index, from..from + residual.len());
        let length = (rows / 16).clamp(NEIGHBOURS.0, NEIGHBOURS.1);
        let Some(means) = self.means.get(index) else {
            let run = |run: &[f64]| run.iter().sum::<f64>().powi(2) / run.len() as f64;
            return residual.chunks(length).map(run).sum();
        };
        let (mut sum, mut count, mut total) = (0.0, 0usize, 0.0);
        for (k, value) in residual.iter().enumerate() {
            let own = means.rows(from + k..from + k + 1);
            sum += means.roots[from + k] * value;
            count += own;
            // A mean of many runs shows their common part alone; what scatters within it scatters between them.
            let more = own.saturating_sub(length) as f64 / length as f64;
            total += more * means.white[from + k] / own as f64;
            if count >= length || k + 1 == residual.len() {
                total += sum * sum / count as f64;
                (sum, count) = (0.0, 0);
            }
        }
        total
    }
}
