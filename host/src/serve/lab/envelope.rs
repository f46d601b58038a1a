//! A long line as few points as a plot is wide: the least and the greatest value of every column, so that a
//! spike of one sample stays visible.

use std::ops::Range;

/// Samples whose extremes are kept.
const BLOCK: usize = 256;

/// Values with the extremes of every block of them. A value that is not finite is a gap.
#[derive(Clone, Debug, Default)]
pub struct Envelope {
    values: Vec<f64>,
    blocks: Vec<Option<(f64, f64)>>,
}

impl Envelope {
    /// Lays the blocks.
    #[must_use]
    pub fn new(values: Vec<f64>) -> Self {
        let blocks = values.chunks(BLOCK).map(extremes).collect();
        Self { values, blocks }
    }

    /// The values.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Two values that stand for a range of samples, in the order in which the line passes them: its
    /// extremes; gaps where it has none.
    #[must_use]
    pub fn pair(&self, range: Range<usize>) -> [f64; 2] {
        let Some((least, greatest)) = self.over(range.clone()) else { return [f64::NAN; 2] };
        let first = self.values[range.start];
        if (first - least).abs() <= (first - greatest).abs() {
            [least, greatest]
        } else {
            [greatest, least]
        }
    }

    fn over(&self, range: Range<usize>) -> Option<(f64, f64)> {
        let (first, last) = (range.start.div_ceil(BLOCK), range.end / BLOCK);
        if first >= last {
            return extremes(&self.values[range]);
        }
        let inner = self.blocks[first..last].iter().copied().flatten().reduce(wider);
        let before = extremes(&self.values[range.start..first * BLOCK]);
        let after = extremes(&self.values[last * BLOCK..range.end]);
        [before, inner, after].into_iter().flatten().reduce(wider)
    }
}

fn extremes(values: &[f64]) -> Option<(f64, f64)> {
    values.iter().filter(|value| value.is_finite()).map(|&value| (value, value)).reduce(wider)
}

fn wider(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0.min(b.0), a.1.max(b.1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_gap_is_no_extreme_and_nothing_but_gaps_is_a_gap() {
        let envelope = Envelope::new(vec![f64::NAN, 2.0, -1.0, f64::NAN]);
        assert_eq!(envelope.over(0..4), Some((-1.0, 2.0)));
        assert!(envelope.pair(3..4)[0].is_nan());
    }

    proptest! {
        #[test]
        fn the_extremes_of_any_range_are_those_of_its_samples(
            values in proptest::collection::vec(-1e3..1e3f64, 1..2000), ends: [u16; 2]
        ) {
            let at = |end: u16| end as usize % (values.len() + 1);
            let range = at(ends[0]).min(at(ends[1]))..at(ends[0]).max(at(ends[1]));
            let envelope = Envelope::new(values.clone());
            prop_assert_eq!(envelope.over(range.clone()), extremes(&values[range]));
        }
    }
}
