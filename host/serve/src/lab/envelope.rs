//! A long line as few points as a plot is wide: the least and the greatest value of every column, so that a
//! spike of one sample stays visible.

use std::ops::Range;

use rayon::prelude::*;

/// Samples of a bin of the lowest level.
const BLOCK: usize = 64;
/// Bins of a level that one of the next holds.
const FACTOR: usize = 8;

/// Least and greatest value; the other way round where there is none.
type Extremes = (f64, f64);

/// Of nothing.
const NONE: Extremes = (f64::INFINITY, f64::NEG_INFINITY);

/// The extremes of a line in bins of 64 samples, of 512, and so on: any stretch of it, however long, is put
/// together from a few bins of each level and the samples at its ends. Takes 4 % of the line's memory.
#[derive(Clone, Debug, Default)]
pub struct Envelope {
    levels: Vec<Vec<Extremes>>,
}

impl Envelope {
    /// Of these values. One that is not finite is a gap.
    #[must_use]
    pub fn new(values: &[f64]) -> Self {
        let mut levels = Vec::new();
        let mut level: Vec<Extremes> = values.par_chunks(BLOCK).map(extremes).collect();
        while level.len() > FACTOR {
            let next = level.chunks(FACTOR).map(widest).collect();
            levels.push(std::mem::replace(&mut level, next));
        }
        levels.push(level);
        Self { levels }
    }

    /// Two values that stand for a range of the samples that this was made of, in the order in which the
    /// line passes them: its extremes; gaps where it has none.
    #[must_use]
    pub fn pair(&self, values: &[f64], range: Range<usize>) -> [f64; 2] {
        let (least, greatest) = self.over(values, range.clone());
        if least > greatest {
            return [f64::NAN; 2];
        }
        let first = values[range.start];
        if (first - least).abs() <= (first - greatest).abs() {
            [least, greatest]
        } else {
            [greatest, least]
        }
    }

    fn over(&self, values: &[f64], range: Range<usize>) -> Extremes {
        let (first, last) = (range.start.div_ceil(BLOCK), range.end / BLOCK);
        if first >= last {
            return extremes(&values[range]);
        }
        let before = extremes(&values[range.start..first * BLOCK]);
        let after = extremes(&values[last * BLOCK..range.end]);
        wider(wider(before, after), self.bins(0, first..last))
    }

    /// The extremes of a range of bins of a level.
    fn bins(&self, level: usize, range: Range<usize>) -> Extremes {
        let bins = &self.levels[level];
        let (first, last) = (range.start.div_ceil(FACTOR), range.end / FACTOR);
        if first >= last || level + 1 == self.levels.len() {
            return widest(&bins[range]);
        }
        let before = widest(&bins[range.start..first * FACTOR]);
        let after = widest(&bins[last * FACTOR..range.end]);
        wider(wider(before, after), self.bins(level + 1, first..last))
    }
}

fn extremes(values: &[f64]) -> Extremes {
    let finite = values.iter().filter(|value| value.is_finite());
    finite.map(|&value| (value, value)).fold(NONE, wider)
}

fn widest(bins: &[Extremes]) -> Extremes {
    bins.iter().copied().fold(NONE, wider)
}

fn wider(a: Extremes, b: Extremes) -> Extremes {
    (a.0.min(b.0), a.1.max(b.1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_gap_is_no_extreme_and_nothing_but_gaps_is_a_gap() {
        let values = [f64::NAN, 2.0, -1.0, f64::NAN];
        let envelope = Envelope::new(&values);
        assert_eq!(envelope.over(&values, 0..4), (-1.0, 2.0));
        assert!(envelope.pair(&values, 3..4)[0].is_nan());
    }

    #[test]
    fn two_values_stand_in_the_order_in_which_the_line_passes_them() {
        let values: Vec<f64> = (0..1000).map(f64::from).collect();
        let falling: Vec<f64> = values.iter().rev().copied().collect();
        assert_eq!(Envelope::new(&values).pair(&values, 100..900), [100.0, 899.0]);
        assert_eq!(Envelope::new(&falling).pair(&falling, 100..900), [899.0, 100.0]);
    }

    proptest! {
        #[test]
        fn the_extremes_of_any_range_are_those_of_its_samples(
            values in proptest::collection::vec(prop_oneof![20 => -1e3..1e3_f64, 1 => Just(f64::NAN)], 1..9000), ends: [u16; 2]
        ) {
            let at = |end: u16| end as usize % (values.len() + 1);
            let range = at(ends[0]).min(at(ends[1]))..at(ends[0]).max(at(ends[1]));
            let envelope = Envelope::new(&values);
            prop_assert_eq!(envelope.over(&values, range.clone()), extremes(&values[range]));
        }
    }
}
