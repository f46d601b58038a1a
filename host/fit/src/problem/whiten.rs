//! What makes the noise of a stretch white, how many samples a value stands for, and what slow noise does to levels.

use std::ops::Range;

use super::Problem;
use crate::least_squares::Normal;
use crate::levels::LevelSums;

impl Problem<'_> {
    /// Whether the data are means that stand for their samples, with all that these tell.
    #[must_use]
    pub fn stands_for_samples(&self) -> bool {
        !self.means.is_empty()
    }

    /// Number of samples that the data stand for.
    #[must_use]
    pub fn rows(&self) -> usize {
        (0..self.data.pieces.len()).map(|index| self.rows_of(index, 0..usize::MAX)).sum()
    }

    /// Number of samples that a range of a stretch stands for.
    pub(super) fn rows_of(&self, index: usize, range: Range<usize>) -> usize {
        let count = self.data.pieces[index].measured.len();
        let range = range.start..range.end.min(count);
        self.means.get(index).map_or(range.len(), |means| means.rows(range))
    }

    /// The sum of squares of whitened samples that their means do not show, the same at every point.
    #[must_use]
    pub fn unseen(&self) -> f64 {
        let fitted =
            self.means.iter().zip(&self.data.pieces).filter(|(_, piece)| self.fitted(piece));
        self.constant + fitted.map(|(means, _)| means.white.iter().sum::<f64>()).sum::<f64>()
    }

    /// The parts of a stretch that stand for about as many samples each.
    #[must_use]
    pub fn parts(&self, index: usize, parts: usize) -> Vec<Range<usize>> {
        let count = self.data.pieces[index].measured.len();
        let size = self.rows_of(index, 0..count).div_ceil(parts).max(1);
        let Some(means) = self.means.get(index) else {
            return (0..count).step_by(size).map(|k| k..(k + size).min(count)).collect();
        };
        let mut found: Vec<Range<usize>> = Vec::new();
        let (mut begin, mut rows) = (0, 0);
        for k in 0..count {
            rows += means.rows(k..k + 1);
            if rows >= size || k + 1 == count {
                found.push(begin..k + 1);
                (begin, rows) = (k + 1, 0);
            }
        }
        found
    }

    /// Sum of squares of the samples that each mean of a stretch does not show, as they are; empty where the data are samples.
    #[must_use]
    pub fn scatter(&self, index: usize) -> &[f64] {
        self.means.get(index).map_or(&[], |means| &means.raw)
    }

    /// Gives every value of a stretch the weight of the samples that it stands for.
    pub fn weigh(&self, index: usize, values: &mut [f64]) {
        if let Some(means) = self.means.get(index) {
            values.iter_mut().zip(&means.roots).for_each(|(value, root)| *value *= root);
        }
    }

    /// Makes the noise of the residual (predicted minus measured) of the stretch with this index white.
    pub fn whiten_residual(&self, index: usize, residual: &mut [f64]) {
        self.whiten_at(index, residual);
        if let Some(means) = self.means.get(index) {
            residual.iter_mut().zip(&means.shift).for_each(|(value, shift)| *value -= shift);
        }
    }

    /// Makes the noise of a derivative of the stretch with this index white.
    pub fn whiten_at(&self, index: usize, values: &mut [f64]) {
        match self.means.get(index) {
            Some(means) => means.filter.apply(values),
            None => self.whitening.apply(values),
        }
        for (value, root) in
            values.iter_mut().zip(self.roots.get(index).copied().unwrap_or_default())
        {
            *value *= root;
        }
    }

    /// The whitened unit level of the stretch with this index; empty where nothing moves the levels.
    #[must_use]
    pub fn unit_level(&self, index: usize) -> Vec<f64> {
        if self.whitening.levels().is_none() {
            return Vec::new();
        }
        let mut unit = vec![1.0; self.data.pieces[index].measured.len()];
        self.whiten_at(index, &mut unit);
        unit
    }

    /// Sums over no samples, where slow noise moves the levels of the traces.
    pub(super) fn level_sums(&self, coordinates: usize) -> Option<LevelSums> {
        self.whitening.levels().map(|levels| LevelSums::zeros(coordinates, levels.traces()))
    }

    /// Takes out of normal equations what the levels of the traces could explain.
    pub fn marginalise(&self, sums: Option<&LevelSums>, normal: &mut Normal) {
        if let (Some(levels), Some(sums)) = (self.whitening.levels(), sums) {
            levels.marginalise(sums, normal);
        }
    }
}
