//! Samples to SVG paths.

use std::fmt::Write as _;

use super::axis::Scale;
use super::decimate;
use super::plot::{Series, Style};
use super::svg::{coordinate, hundredths};

/// From data units to user units along one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Map {
    /// Linear or logarithmic.
    pub scale: Scale,
    /// First and last value, data units.
    pub range: (f64, f64),
    /// Where these two are drawn, user units.
    pub drawn: (f64, f64),
}

impl Map {
    /// Share of the axis at which a value lies: 0 at its beginning, 1 at its end, NaN where it cannot
    /// be drawn.
    pub(super) fn share(&self, value: f64) -> f64 {
        let (low, high) = self.range;
        match self.scale {
            Scale::Linear => (value - low) / (high - low),
            Scale::Log if value > 0.0 => (value / low).ln() / (high / low).ln(),
            Scale::Log => f64::NAN,
        }
    }

    /// Where a value is drawn, user units, also beyond the range.
    pub(super) fn at(&self, value: f64) -> f64 {
        self.drawn.0 + self.share(value) * (self.drawn.1 - self.drawn.0)
    }

    /// Whether a value lies in the range.
    pub(super) fn holds(&self, value: f64) -> bool {
        (-1e-9..=1.0 + 1e-9).contains(&self.share(value))
    }
}

/// The samples of a series that are drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Samples {
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    /// Upper edge of a band, or the error of each sample; empty for other styles.
    pub other: Vec<f64>,
    /// Number of samples before they were thinned out.
    pub of: usize,
}

/// Picks the samples that are drawn over the given axes.
pub(super) fn samples(series: &Series, x: &Map, y: &Map) -> Samples {
    let visible = visible(&series.x, x.range);
    let (xs, ys) = (&series.x[visible.clone()], &series.y[visible.clone()]);
    let other = match &series.style {
        Style::Band { upper } => &upper[visible.clone()],
        Style::ErrorBars { error } => &error[visible.clone()],
        _ => &[],
    };
    let kept = match &series.style {
        Style::Line | Style::Step => decimate::line(xs, ys, |v| x.share(v)),
        Style::Points | Style::ErrorBars { .. } => {
            decimate::points(xs.len(), |i| (x.share(xs[i]), y.share(ys[i])))
        }
        Style::Band { .. } => {
            let mut kept = decimate::line(xs, ys, |v| x.share(v));
            kept.extend(decimate::line(xs, other, |v| x.share(v)));
            kept.sort_unstable();
            kept.dedup();
            kept
        }
    };
    let pick = |values: &[f64]| match values {
        [] => Vec::new(),
        values => kept.iter().map(|i| values[*i]).collect(),
    };
    Samples { x: pick(xs), y: pick(ys), other: pick(other), of: xs.len() }
}

/// The samples within a range of x and one neighbour on each side; all, where x goes back.
fn visible(x: &[f64], (low, high): (f64, f64)) -> std::ops::Range<usize> {
    if x.iter().any(|v| v.is_nan()) || !x.is_sorted() {
        return 0..x.len();
    }
    let from = x.partition_point(|v| *v < low).saturating_sub(1);
    let to = (x.partition_point(|v| *v <= high) + 1).min(x.len());
    from..to.max(from)
}

/// A part of a series as path data.
#[derive(Debug, PartialEq)]
pub(super) enum Shape {
    /// To be stroked.
    Stroke(String),
    /// Markers, to be filled.
    Dots(String),
    /// A band, to be filled.
    Fill(String),
}

/// The paths that draw a series.
pub(super) fn shapes(series: &Series, samples: &Samples, x: &Map, y: &Map) -> Vec<Shape> {
    let points = samples.x.iter().zip(&samples.y).map(|(a, b)| (x.at(*a), y.at(*b)));
    match &series.style {
        Style::Line => vec![Shape::Stroke(line(points))],
        Style::Step => vec![Shape::Stroke(line(stairs(points)))],
        Style::Points => vec![Shape::Dots(dots(points, &marker(series, samples)))],
        Style::Band { .. } => {
            let upper = samples.other.iter().map(|v| y.at(*v));
            vec![Shape::Fill(band(
                &points.zip(upper).map(|((x, y), u)| (x, y, u)).collect::<Vec<_>>(),
            ))]
        }
        Style::ErrorBars { .. } => {
            let reach = samples.y.iter().zip(&samples.other);
            let bars = samples
                .x
                .iter()
                .zip(reach)
                .map(|(a, (b, e))| (x.at(*a), y.at(b - e.abs()), y.at(b + e.abs())));
            vec![
                Shape::Stroke(error_bars(bars)),
                Shape::Dots(dots(points, &marker(series, samples))),
            ]
        }
    }
}

/// Half the width of the cap on an error bar, user units.
pub(super) const CAP: f64 = 3.0;

/// Relative path of the marker of a series: smaller where there are many.
pub(super) fn marker(series: &Series, samples: &Samples) -> String {
    let r = match samples.x.len() {
        0..=100 => 3.2,
        101..=600 => 2.2,
        _ => 1.4,
    };
    let c = |factor: f64| coordinate(factor * r);
    match series.colour.marker() {
        0 => format!("m-{r} 0a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0-{d} 0z", r = c(1.0), d = c(2.0)),
        1 => format!("m-{r}-{r}h{d}v{d}h-{d}z", r = c(0.9), d = c(1.8)),
        2 => format!("m0-{a}l{b} {h}h-{d}z", a = c(1.2), b = c(1.1), h = c(2.0), d = c(2.2)),
        3 => format!("m0-{a}l{a} {a}-{a} {a}-{a}-{a}z", a = c(1.3)),
        4 => format!("m0 {a}l{b}-{h}h-{d}z", a = c(1.2), b = c(1.1), h = c(2.0), d = c(2.2)),
        _ => format!("m-{a}-{b}h{d}v{e}h-{d}z", a = c(1.3), b = c(0.6), d = c(2.6), e = c(1.2)),
    }
}

/// Path data with relative steps in whole hundredths, so rounding does not add up.
#[derive(Default)]
struct Path {
    data: String,
    at: (i64, i64),
    /// Points since the pen was set down; 0 while it is up.
    run: usize,
}

impl Path {
    fn point(&mut self, x: f64, y: f64) {
        if !(x.is_finite() && y.is_finite()) {
            return self.lift();
        }
        let here = (hundredths(x), hundredths(y));
        if self.run == 0 {
            let _ = write!(self.data, "M{}", pair(here.0, here.1));
        } else {
            let separator = if self.run == 1 { "l" } else { " " };
            let step = pair(here.0 - self.at.0, here.1 - self.at.1);
            let separator = if separator == " " && step.starts_with('-') { "" } else { separator };
            let _ = write!(self.data, "{separator}{step}");
        }
        self.at = here;
        self.run += 1;
    }

    /// Ends a run; a single point becomes a short line, or nothing would be seen.
    fn lift(&mut self) {
        if self.run == 1 {
            self.data.push_str("m-1 0h2");
        }
        self.run = 0;
    }
}

fn pair(x: i64, y: i64) -> String {
    let (x, y) = (coordinate(x as f64 / 100.0), coordinate(y as f64 / 100.0));
    if y.starts_with('-') { format!("{x}{y}") } else { format!("{x} {y}") }
}

fn line(points: impl Iterator<Item = (f64, f64)>) -> String {
    let mut path = Path::default();
    points.for_each(|(x, y)| path.point(x, y));
    path.lift();
    path.data
}

/// Adds, before each sample, the value that held until then.
fn stairs(points: impl Iterator<Item = (f64, f64)>) -> impl Iterator<Item = (f64, f64)> {
    let mut before = f64::NAN;
    points.flat_map(move |(x, y)| {
        let held = std::mem::replace(&mut before, y);
        let corner = held.is_finite() && y.is_finite();
        corner.then_some((x, held)).into_iter().chain([(x, y)])
    })
}

fn dots(points: impl Iterator<Item = (f64, f64)>, marker: &str) -> String {
    let mut data = String::new();
    for (x, y) in points.filter(|(x, y)| x.is_finite() && y.is_finite()) {
        let _ = write!(data, "M{}{marker}", pair(hundredths(x), hundredths(y)));
    }
    data
}

fn band(points: &[(f64, f64, f64)]) -> String {
    let drawn = |p: &(f64, f64, f64)| p.0.is_finite() && p.1.is_finite() && p.2.is_finite();
    let mut data = String::new();
    for run in points.split(|p| !drawn(p)).filter(|run| !run.is_empty()) {
        let lower = run.iter().map(|p| (p.0, p.1));
        let upper = run.iter().rev().map(|p| (p.0, p.2));
        data.push_str(&line(lower.chain(upper)));
        data.push('z');
    }
    data
}

fn error_bars(bars: impl Iterator<Item = (f64, f64, f64)>) -> String {
    let mut data = String::new();
    for (x, low, high) in bars {
        let ends = [low, high].map(hundredths);
        if x.is_finite() && low.is_finite() && high.is_finite() {
            let [left, centre, right] = [x - CAP, x, x + CAP].map(hundredths);
            for (from, to) in [
                ((left, ends[0]), (right, ends[0])),
                ((left, ends[1]), (right, ends[1])),
                ((centre, ends[0]), (centre, ends[1])),
            ] {
                let _ = write!(data, "M{}L{}", pair(from.0, from.1), pair(to.0, to.1));
            }
        }
    }
    data
}

#[cfg(test)]
mod tests {
    use super::*;

    fn maps() -> (Map, Map) {
        let map = |range, drawn| Map { scale: Scale::Linear, range, drawn };
        (map((0.0, 10.0), (0.0, 100.0)), map((0.0, 1.0), (100.0, 0.0)))
    }

    fn stroke(series: &Series) -> String {
        let (x, y) = maps();
        match shapes(series, &samples(series, &x, &y), &x, &y).remove(0) {
            Shape::Stroke(data) | Shape::Dots(data) | Shape::Fill(data) => data,
        }
    }

    #[test]
    fn a_gap_breaks_the_line_and_a_lone_sample_stays_visible() {
        let series = Series::line(
            "F",
            vec![0.0, 1.0, 2.0, 3.0, 4.0],
            vec![0.0, 0.5, f64::NAN, 1.0, f64::NAN],
        );
        assert_eq!(stroke(&series), "M0 100l10-50M30 0m-1 0h2");
        assert_eq!(stroke(&Series::line("F", vec![], vec![])), "");
    }

    #[test]
    fn steps_hold_their_value_and_bands_close() {
        let step = Series::step("n", vec![0.0, 1.0], vec![0.0, 1.0]);
        assert_eq!(stroke(&step), "M0 100l10 0 0-100");
        let band = Series::band("b", vec![0.0, 1.0], vec![0.0, 0.0], vec![1.0, 0.5]);
        assert_eq!(stroke(&band), "M0 100l10 0 0-50-10-50z");
    }

    #[test]
    fn rounding_of_relative_steps_does_not_add_up() {
        let x: Vec<f64> = (0..3001).map(|i| f64::from(i) * 10.0 / 3000.0).collect();
        let y = vec![0.5; 3001];
        let path = stroke(&Series::line("F", x, y));
        let steps = path.split('l').nth(1).unwrap();
        let total: f64 = steps.split(' ').step_by(2).map(|dx| dx.parse::<f64>().unwrap()).sum();
        assert!((total - 100.0).abs() < 0.006, "{total}");
    }

    #[test]
    fn what_a_logarithmic_axis_cannot_show_is_a_gap() {
        let map = Map { scale: Scale::Log, range: (0.1, 10.0), drawn: (0.0, 100.0) };
        assert_eq!(map.at(1.0), 50.0);
        assert!(map.at(0.0).is_nan() && !map.holds(-1.0));
    }

    #[test]
    fn a_fixed_range_keeps_the_neighbours_that_lines_leave_through() {
        assert_eq!(visible(&[0.0, 1.0, 2.0, 3.0, 4.0], (1.5, 2.5)), 1..4);
        assert_eq!(visible(&[0.0, 2.0, 1.0], (1.5, 2.5)), 0..3);
        assert_eq!(visible(&[0.0, 1.0], (5.0, 6.0)), 1..2);
        assert_eq!(visible(&[], (0.0, 1.0)), 0..0);
    }
}
