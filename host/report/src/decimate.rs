//! Fewer points for the same picture: long series keep, in every column of the picture, their first,
//! least, greatest and last sample, so a spike of one sample stays visible.

/// Columns that a picture is divided into: finer than a screen shows, so a zoom has more to reveal.
pub(super) const COLUMNS: usize = 1000;
/// Series of up to this many samples are drawn whole.
pub(super) const WHOLE: usize = 4 * COLUMNS;

/// Indices, increasing, of the samples that stand for a line of `y` over `x`.
///
/// At most [`WHOLE`] samples are kept whole. Beyond, if `x` never goes back, the picture is divided into
/// columns of equal width after `position` (which maps x to 0…1, linear or logarithmic); otherwise
/// (a loop of force over displacement) the samples are divided in the order in which they came.
/// A gap (x or y not finite) keeps one sample in each part it touches. At most six samples a part are kept.
pub(super) fn line(x: &[f64], y: &[f64], position: impl Fn(f64) -> f64) -> Vec<usize> {
    let count = x.len().min(y.len());
    if count <= WHOLE {
        return (0..count).collect();
    }
    let forward = x[..count].iter().filter(|v| v.is_finite()).is_sorted();
    let mut kept = Vec::with_capacity(WHOLE);
    let mut part = Part::default();
    let mut current = 0;
    for index in 0..count {
        let here = match (forward, x[index].is_finite()) {
            (true, false) => current,
            (true, true) => {
                (position(x[index]) * COLUMNS as f64).clamp(-1.0, COLUMNS as f64) as usize
            }
            (false, _) => index * COLUMNS / count,
        };
        if here != current {
            part.flush(&mut kept);
            current = here;
        }
        part.add(index, x[index], y[index], forward);
    }
    part.flush(&mut kept);
    kept
}

/// Indices of the samples that stand for a cloud of points: one for each cell of a grid of
/// `COLUMNS / 4` by 100 cells over the unit square that `position` maps them to. Samples that
/// cannot be drawn are left out.
pub(super) fn points(count: usize, position: impl Fn(usize) -> (f64, f64)) -> Vec<usize> {
    if count <= WHOLE {
        return (0..count).collect();
    }
    const ACROSS: usize = COLUMNS / 4;
    const UP: usize = 100;
    let mut taken = vec![false; ACROSS * UP];
    let cell = |share: f64, cells: usize| ((share * cells as f64) as usize).min(cells - 1);
    let mut keep = |index: &usize| {
        let (x, y) = position(*index);
        let drawn = (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y);
        drawn && !std::mem::replace(&mut taken[cell(x, ACROSS) * UP + cell(y, UP)], true)
    };
    (0..count).filter(|index| keep(index)).collect()
}

/// The samples of one part of a line that must be kept.
#[derive(Default)]
struct Part {
    first: Option<usize>,
    last: Option<usize>,
    gap: Option<usize>,
    least: Option<(f64, usize)>,
    greatest: Option<(f64, usize)>,
    left: Option<(f64, usize)>,
    right: Option<(f64, usize)>,
}

impl Part {
    fn add(&mut self, index: usize, x: f64, y: f64, forward: bool) {
        if !(x.is_finite() && y.is_finite()) {
            self.gap.get_or_insert(index);
            return;
        }
        self.first.get_or_insert(index);
        self.last = Some(index);
        extreme(&mut self.least, y, index, |new, old| new < old);
        extreme(&mut self.greatest, y, index, |new, old| new > old);
        if !forward {
            extreme(&mut self.left, x, index, |new, old| new < old);
            extreme(&mut self.right, x, index, |new, old| new > old);
        }
    }

    fn flush(&mut self, kept: &mut Vec<usize>) {
        let from = kept.len();
        let extremes = [self.least, self.greatest, self.left, self.right];
        kept.extend(extremes.into_iter().flatten().map(|(_, index)| index));
        kept.extend([self.first, self.last, self.gap].into_iter().flatten());
        kept[from..].sort_unstable();
        kept.dedup();
        *self = Self::default();
    }
}

fn extreme(kept: &mut Option<(f64, usize)>, value: f64, index: usize, beats: fn(f64, f64) -> bool) {
    if kept.is_none_or(|(old, _)| beats(value, old)) {
        *kept = Some((value, index));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn one_spike_in_a_million_samples_survives_and_the_count_is_bounded() {
        let x: Vec<f64> = (0..1_000_000).map(f64::from).collect();
        let mut y: Vec<f64> = x.iter().map(|t| (t * 0.01).sin()).collect();
        y[123_457] = 50.0;
        y[765_431] = -50.0;
        let kept = line(&x, &y, |v| v / 1e6);
        assert!(kept.contains(&123_457) && kept.contains(&765_431));
        assert!(kept.contains(&0) && kept.contains(&999_999));
        assert!(kept.len() <= WHOLE, "{}", kept.len());
        assert!(kept.is_sorted());
    }

    #[test]
    fn a_loop_keeps_its_turning_points() {
        let angle = |i: usize| i as f64 * 1e-3;
        let x: Vec<f64> = (0..100_000).map(|i| angle(i).cos()).collect();
        let y: Vec<f64> = (0..100_000).map(|i| angle(i).sin()).collect();
        let kept = line(&x, &y, |v| 0.5 + 0.5 * v);
        let rightmost = (1..100_000).max_by(|a, b| x[*a].total_cmp(&x[*b])).unwrap();
        assert!(kept.contains(&rightmost));
        assert!(kept.len() <= 6 * COLUMNS);
    }

    #[test]
    fn a_gap_stays_a_gap() {
        let x: Vec<f64> = (0..50_000).map(f64::from).collect();
        let y: Vec<f64> = x
            .iter()
            .map(|&t| if (20_000.0..30_000.0).contains(&t) { f64::NAN } else { t })
            .collect();
        let kept = line(&x, &y, |v| v / 5e4);
        let gaps = kept.iter().filter(|i| y[**i].is_nan()).count();
        assert!((1..=COLUMNS).contains(&gaps));
        assert!(kept.contains(&19_999) && kept.contains(&30_000));
    }

    #[test]
    fn a_dense_cloud_keeps_one_point_in_each_cell_and_short_series_are_whole() {
        let kept = points(200_000, |i| ((i % 1000) as f64 / 1000.0, (i / 1000) as f64 / 200.0));
        assert!(kept.len() <= COLUMNS / 4 * 100);
        assert_eq!(points(10, |_| (f64::NAN, 0.0)).len(), 10);
        assert_eq!(line(&[1.0; 7], &[2.0; 7], |_| 0.5), [0, 1, 2, 3, 4, 5, 6]);
    }

    proptest! {
        #[test]
        fn the_extremes_of_any_line_are_kept(seed in proptest::collection::vec(-1e3..1e3f64, 37), back: bool) {
            let y: Vec<f64> = (0..9000).map(|i| seed[i % 37] + seed[(i / 37) % 37] + 1e-3 * i as f64).collect();
            let x: Vec<f64> = (0..9000).map(|i| if back { y[(i * 7) % 9000] } else { i as f64 }).collect();
            let kept = line(&x, &y, |v| v / 9000.0);
            let of = |pick: fn(f64, f64) -> f64| y.iter().copied().fold(y[0], pick);
            prop_assert!(kept.iter().any(|i| y[*i] == of(f64::max)));
            prop_assert!(kept.iter().any(|i| y[*i] == of(f64::min)));
            prop_assert!(kept.len() <= 6 * COLUMNS);
        }
    }
}
