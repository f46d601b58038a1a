//! Where the parts of a figure go: legends in rows, names of spans in a strip, ticks without overlap.

use super::axis::{Axis, Ticks, ticks};
use super::plot::{Legend, Plot};
use super::svg::{TEXT, text_width};

/// Width of every figure, user units.
pub(super) const WIDTH: f64 = 640.0;
/// Height of one row of text, user units.
pub(super) const ROW: f64 = 18.0;
/// Length of the sample of a line in a legend, user units.
pub(super) const SWATCH: f64 = 26.0;

/// A place for one entry of a legend: index of the series, position of its swatch's left end relative
/// to the legend's own corner.
pub(super) struct Entry {
    pub series: usize,
    pub x: f64,
    pub row: usize,
}

/// Series that have a place in the legend.
fn named(plot: &Plot) -> Vec<usize> {
    let named: Vec<_> =
        (0..plot.series.len()).filter(|i| !plot.series[*i].name.is_empty()).collect();
    match plot.legend {
        Legend::Hidden => Vec::new(),
        Legend::Above if named.len() < 2 => Vec::new(),
        _ => named,
    }
}

fn entry_width(plot: &Plot, series: usize) -> f64 {
    SWATCH + 6.0 + text_width(&plot.series[series].name, TEXT)
}

/// Entries of a legend, in rows of at most a width (above) or one in each row (right, inside).
pub(super) fn legend(plot: &Plot, width: f64) -> Vec<Entry> {
    let (mut x, mut row) = (0.0, 0);
    let mut entries = Vec::new();
    for (count, series) in named(plot).into_iter().enumerate() {
        let wide = entry_width(plot, series);
        if plot.legend != Legend::Above {
            (x, row) = (0.0, count);
        } else if x > 0.0 && x + wide > width {
            (x, row) = (0.0, row + 1);
        }
        entries.push(Entry { series, x, row });
        x += wide + 18.0;
    }
    entries
}

/// Width of a legend that has one entry in each row, user units.
pub(super) fn legend_width(plot: &Plot) -> f64 {
    named(plot).into_iter().map(|i| entry_width(plot, i)).fold(0.0, f64::max)
}

/// A text with a centre and a row in the strip above a plot; `row` is `None` where there is no room.
#[derive(Debug, PartialEq)]
pub(super) struct Placed {
    pub centre: f64,
    pub row: Option<usize>,
}

/// Places texts, given as wanted centre and width, into as few of `rows` rows as keep them apart
/// within `from` … `to`.
pub(super) fn strip(texts: &[(f64, f64)], rows: usize, (from, to): (f64, f64)) -> Vec<Placed> {
    let mut taken: Vec<Vec<(f64, f64)>> = vec![Vec::new(); rows];
    let place = |&(wanted, width): &(f64, f64)| {
        let half = 0.5 * width;
        let centre = wanted.min(to - half).max(from + half);
        let free = |row: &Vec<(f64, f64)>| {
            row.iter().all(|(a, b)| centre + half + 6.0 <= *a || centre - half - 6.0 >= *b)
        };
        let row = taken.iter().position(free);
        if let Some(row) = row {
            taken[row].push((centre - half, centre + half));
        }
        Placed { centre, row }
    };
    texts.iter().map(place).collect()
}

/// Ticks of a horizontal axis of a given length, as many as its labels leave room for.
pub(super) fn horizontal_ticks(
    axis: &Axis,
    range: (f64, f64),
    length: f64,
    exponent: i32,
) -> Ticks {
    let fits = |ticks: &Ticks| {
        let widest = ticks.major.iter().map(|(_, l)| text_width(l, TEXT)).fold(0.0, f64::max);
        let gaps = ticks.major.len().saturating_sub(1).max(1) as f64;
        gaps * (widest + 16.0) <= length
    };
    let most = ((length / 70.0) as usize).max(2);
    (2..=most)
        .rev()
        .map(|target| ticks(axis.scale, range, target, exponent))
        .find(fits)
        .unwrap_or_else(|| {
            // Too narrow for any regular choice: the outermost labels, or one.
            let mut fewest = ticks(axis.scale, range, 2, exponent);
            if fewest.major.len() > 2 {
                fewest.major.drain(1..fewest.major.len() - 1);
            }
            if !fits(&fewest) {
                fewest.major.truncate(1);
            }
            fewest
        })
}

/// Ticks of a vertical axis of a given height.
pub(super) fn vertical_ticks(axis: &Axis, range: (f64, f64), height: f64, exponent: i32) -> Ticks {
    let most = ((height / 34.0) as usize).max(2);
    (2..=most)
        .rev()
        .map(|target| ticks(axis.scale, range, target, exponent))
        .find(|ticks| ticks.major.len() as f64 * (TEXT + 6.0) <= height + TEXT)
        .unwrap_or_else(|| ticks(axis.scale, range, 2, exponent))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Series;

    #[test]
    fn names_that_would_touch_go_to_the_next_row_and_then_are_left_out() {
        let row = |texts: &[(f64, f64)]| {
            strip(texts, 2, (0.0, 100.0)).into_iter().map(|p| p.row).collect::<Vec<_>>()
        };
        assert_eq!(row(&[(20.0, 20.0), (60.0, 20.0)]), [Some(0), Some(0)]);
        assert_eq!(row(&[(20.0, 20.0), (25.0, 20.0), (30.0, 20.0)]), [Some(0), Some(1), None]);
        assert_eq!(strip(&[(0.0, 20.0)], 1, (0.0, 100.0))[0].centre, 10.0);
    }

    #[test]
    fn labels_of_ticks_never_overlap() {
        let axis = Axis::new("t", "s");
        for (range, length) in
            [((0.0, 86_400.0), 150.0), ((0.0, 1e-1), 560.0), ((99_990.0, 99_991.0), 90.0)]
        {
            let ticks = horizontal_ticks(&axis, range, length, 0);
            let place = |v: f64| (v - range.0) / (range.1 - range.0) * length;
            for pair in ticks.major.windows(2) {
                let half = |l: &str| 0.5 * text_width(l, TEXT);
                let gap = place(pair[1].0) - place(pair[0].0) - half(&pair[0].1) - half(&pair[1].1);
                assert!(gap > 0.0, "{ticks:?}");
            }
        }
    }

    #[test]
    fn a_long_legend_wraps_and_a_lone_series_needs_none() {
        let axis = || Axis::new("", "");
        let mut plot = Plot::new("", axis(), axis());
        for _ in 0..6 {
            plot = plot.series(Series::line("a rather long name of a series", vec![], vec![]));
        }
        let rows: Vec<_> = legend(&plot, 560.0).iter().map(|e| e.row).collect();
        assert_eq!(rows, [0, 0, 1, 1, 2, 2]);
        plot.series.truncate(1);
        assert!(legend(&plot, 560.0).is_empty());
    }
}
