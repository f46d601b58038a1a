//! Traces that are left out of a fit together.

/// Most fits that leave traces out: up to so many traces each is left out alone, more in so many folds. A prime, so that folds
/// do not follow the order in which a protocol repeats its speeds and depths.
const MOST: usize = 13;

/// Every `of`-th trace from the `index`-th on: what one fit leaves out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fold {
    index: usize,
    of: usize,
}

impl Fold {
    /// The folds of so many traces: each trace alone, or the traces in [`Self::count`] folds.
    #[must_use]
    pub fn all(traces: usize) -> Vec<Self> {
        let of = Self::count(traces);
        (0..of).map(|index| Self { index, of }).collect()
    }

    /// The number of folds of so many traces.
    #[must_use]
    pub fn count(traces: usize) -> usize {
        traces.min(MOST)
    }

    /// One trace alone.
    #[must_use]
    pub fn alone(trace: usize) -> Self {
        Self { index: trace, of: usize::MAX }
    }

    /// Whether a trace is left out.
    #[must_use]
    pub fn holds(self, trace: usize) -> bool {
        trace % self.of == self.index
    }

    /// The traces that are left out, of so many.
    pub fn traces(self, count: usize) -> impl Iterator<Item = usize> {
        (self.index..count).step_by(self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_trace_is_left_out_once_and_alone_where_they_are_few() {
        for count in [2, 5, 13, 14, 64, 1000] {
            let mut times = vec![0; count];
            for fold in Fold::all(count) {
                let traces: Vec<usize> = fold.traces(count).collect();
                assert!((0..count).all(|trace| fold.holds(trace) == traces.contains(&trace)));
                assert!(count > MOST || traces.len() == 1);
                traces.iter().for_each(|&trace| times[trace] += 1);
            }
            assert_eq!(times, vec![1; count]);
        }
        let alone = Fold::alone(7);
        assert_eq!(alone.traces(9).collect::<Vec<_>>(), [7]);
        assert!(alone.holds(7) && !alone.holds(8));
    }
}
