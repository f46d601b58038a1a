//! A plot as plain data: axes, series, and what explains them.

use super::axis::Axis;
use super::colour::Colour;

/// How the samples of a series are drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum Style {
    /// Joined by a line; NaN breaks it.
    Line,
    /// Held until the next sample.
    Step,
    /// One marker each.
    Points,
    /// A filled band from `y` up to `upper`, data units, one for each sample.
    Band {
        /// Upper edge of the band.
        upper: Vec<f64>,
    },
    /// A marker with a bar of ± `error`, data units, one for each sample.
    ErrorBars {
        /// Half length of each bar: a standard error, unless the caption says otherwise.
        error: Vec<f64>,
    },
}

/// Whether a line is broken into dashes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Dash {
    /// As the colour says: each hue has its own pattern, so lines differ in black and white too.
    #[default]
    Auto,
    /// Never; for noisy signals, where dashes cannot be told from gaps.
    Solid,
    /// Always.
    Dashed,
}

/// One set of samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name in the legend; empty keeps it out of the legend.
    pub name: String,
    /// How it is drawn.
    pub style: Style,
    /// Position along the x axis, data units.
    pub x: Vec<f64>,
    /// Value, data units; NaN is a gap.
    pub y: Vec<f64>,
    /// Colour.
    pub colour: Colour,
    /// Solid or dashed.
    pub dash: Dash,
    /// Width of the line, user units (640 across the figure).
    pub width: f64,
}

impl Series {
    fn new(name: impl Into<String>, style: Style, x: Vec<f64>, y: Vec<f64>) -> Self {
        assert_eq!(x.len(), y.len(), "x and y of a series must be equally long");
        let colour = Colour::Hue(0);
        Self { name: name.into(), style, x, y, colour, dash: Dash::Auto, width: 1.6 }
    }

    /// Samples joined by a line.
    ///
    /// # Panics
    /// Here and below, if the columns differ in length.
    #[must_use]
    pub fn line(name: impl Into<String>, x: impl Into<Vec<f64>>, y: impl Into<Vec<f64>>) -> Self {
        Self::new(name, Style::Line, x.into(), y.into())
    }

    /// Samples that hold until the next.
    #[must_use]
    pub fn step(name: impl Into<String>, x: impl Into<Vec<f64>>, y: impl Into<Vec<f64>>) -> Self {
        Self::new(name, Style::Step, x.into(), y.into())
    }

    /// One marker for each sample.
    #[must_use]
    pub fn points(name: impl Into<String>, x: impl Into<Vec<f64>>, y: impl Into<Vec<f64>>) -> Self {
        Self::new(name, Style::Points, x.into(), y.into())
    }

    /// A band between two curves.
    #[must_use]
    pub fn band(
        name: impl Into<String>,
        x: impl Into<Vec<f64>>,
        lower: impl Into<Vec<f64>>,
        upper: impl Into<Vec<f64>>,
    ) -> Self {
        let (x, upper) = (x.into(), upper.into());
        assert_eq!(x.len(), upper.len(), "both edges of a band must be as long as x");
        Self::new(name, Style::Band { upper }, x, lower.into())
    }

    /// Markers with bars of ± `error`.
    #[must_use]
    pub fn error_bars(
        name: impl Into<String>,
        x: impl Into<Vec<f64>>,
        y: impl Into<Vec<f64>>,
        error: impl Into<Vec<f64>>,
    ) -> Self {
        let (x, error) = (x.into(), error.into());
        assert_eq!(x.len(), error.len(), "error bars must be as many as samples");
        Self::new(name, Style::ErrorBars { error }, x, y.into())
    }

    /// The same series in another colour.
    #[must_use]
    pub fn colour(self, colour: Colour) -> Self {
        Self { colour, ..self }
    }

    /// The same series, dashed or solid whatever its colour.
    #[must_use]
    pub fn dash(self, dash: Dash) -> Self {
        Self { dash, ..self }
    }

    /// The same series with lines of another width, user units.
    #[must_use]
    pub fn width(self, width: f64) -> Self {
        Self { width, ..self }
    }

    /// Lowest and highest drawn value of a sample.
    pub(super) fn extent(&self, index: usize) -> [f64; 2] {
        let y = self.y[index];
        match &self.style {
            Style::Band { upper } => [y, upper[index]],
            Style::ErrorBars { error } if error[index].is_finite() => {
                [y - error[index].abs(), y + error[index].abs()]
            }
            _ => [y, y],
        }
    }
}

/// A stretch of the x axis with a name: one of the regions OA … EF of a grasp.
#[derive(Clone, Debug, PartialEq)]
pub struct Span {
    /// Where it begins, data units.
    pub from: f64,
    /// Where it ends, data units.
    pub to: f64,
    /// Its name.
    pub label: String,
}

/// A vertical line at one x.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Where, data units.
    pub x: f64,
    /// What it marks; may be empty.
    pub label: String,
}

/// A horizontal reference line: the noise floor, a limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Where, data units.
    pub y: f64,
    /// What it means; may be empty.
    pub label: String,
}

/// A remark at one point.
#[derive(Clone, Debug, PartialEq)]
pub struct Annotation {
    /// Position along the x axis, data units.
    pub x: f64,
    /// Position along the y axis, data units.
    pub y: f64,
    /// The remark.
    pub text: String,
}

/// Where the legend goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Legend {
    /// Above the plot, left out where there is only one series.
    #[default]
    Above,
    /// Right of the plot.
    Right,
    /// Inside, in the upper right corner, on a ground of its own.
    Inside,
    /// Nowhere.
    Hidden,
}

/// One plot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plot {
    /// Title; empty for none.
    pub title: String,
    /// What it shows in a sentence, for people who cannot see it.
    pub summary: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// What is plotted, first below.
    pub series: Vec<Series>,
    /// Shaded stretches of the x axis.
    pub spans: Vec<Span>,
    /// Vertical lines.
    pub marks: Vec<Mark>,
    /// Horizontal lines; the y axis covers them.
    pub levels: Vec<Level>,
    /// Remarks at points.
    pub annotations: Vec<Annotation>,
    /// Where the legend goes.
    pub legend: Legend,
    /// Height of the drawing area, user units (640 across the figure); `None` is 240.
    pub height: Option<f64>,
}

impl Plot {
    /// An empty plot.
    #[must_use]
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Self { title: title.into(), x, y, ..Self::default() }
    }

    /// The same plot with a sentence that says what it shows.
    #[must_use]
    pub fn summary(self, summary: impl Into<String>) -> Self {
        Self { summary: summary.into(), ..self }
    }

    /// The same plot with one more series on top.
    #[must_use]
    pub fn series(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// The same plot with a shaded stretch.
    #[must_use]
    pub fn span(mut self, from: f64, to: f64, label: impl Into<String>) -> Self {
        self.spans.push(Span { from, to, label: label.into() });
        self
    }

    /// The same plot with a vertical line.
    #[must_use]
    pub fn mark(mut self, x: f64, label: impl Into<String>) -> Self {
        self.marks.push(Mark { x, label: label.into() });
        self
    }

    /// The same plot with a horizontal line.
    #[must_use]
    pub fn level(mut self, y: f64, label: impl Into<String>) -> Self {
        self.levels.push(Level { y, label: label.into() });
        self
    }

    /// The same plot with a remark at a point.
    #[must_use]
    pub fn annotation(mut self, x: f64, y: f64, text: impl Into<String>) -> Self {
        self.annotations.push(Annotation { x, y, text: text.into() });
        self
    }

    /// The same plot with its legend elsewhere.
    #[must_use]
    pub fn legend(self, legend: Legend) -> Self {
        Self { legend, ..self }
    }

    /// The same plot with a drawing area of another height, user units.
    #[must_use]
    pub fn height(self, height: f64) -> Self {
        Self { height: Some(height), ..self }
    }

    /// Height of the drawing area, user units.
    pub(super) fn area_height(&self) -> f64 {
        self.height.filter(|h| h.is_finite()).unwrap_or(240.0).clamp(30.0, 2000.0)
    }
}

/// Plots stacked over one x axis, the last plot's: an overlay above its residual, four gauges.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panels {
    /// Title of the whole figure; empty for none.
    pub title: String,
    /// What the figure shows in a sentence, for people who cannot see it.
    pub summary: String,
    /// The plots from top to bottom.
    pub plots: Vec<Plot>,
}

impl Panels {
    /// A figure without plots.
    #[must_use]
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), ..Self::default() }
    }

    /// The same figure with a sentence that says what it shows.
    #[must_use]
    pub fn summary(self, summary: impl Into<String>) -> Self {
        Self { summary: summary.into(), ..self }
    }

    /// The same figure with one more plot below.
    #[must_use]
    pub fn plot(mut self, plot: Plot) -> Self {
        self.plots.push(plot);
        self
    }
}
