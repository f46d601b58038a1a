//! Any figure: what a page or a file can show.

use super::bars::Bars;
use super::draw::{self, Drawing, Place};
use super::heatmap::HeatMap;
use super::plot::{Panels, Plot};

/// A figure of a page.
#[derive(Clone, Debug, PartialEq)]
pub enum Figure {
    /// One plot.
    Plot(Plot),
    /// Plots stacked over one x axis.
    Panels(Panels),
    /// A table of numbers as colours.
    HeatMap(HeatMap),
    /// Groups of bars.
    Bars(Bars),
}

impl Figure {
    /// The figure as an SVG file that needs nothing else and suits light and dark.
    #[must_use]
    pub fn to_svg(&self) -> String {
        self.draw("figure", Place::File).svg
    }

    pub(super) fn draw(&self, id: &str, place: Place) -> Drawing {
        match self {
            Self::Plot(plot) => draw::plot(plot, id, place),
            Self::Panels(panels) => draw::panels(panels, id, place),
            Self::HeatMap(map) => map.draw(id, place),
            Self::Bars(bars) => bars.draw(id, place),
        }
    }

    /// The figure's title.
    #[must_use]
    pub fn title(&self) -> &str {
        match self {
            Self::Plot(plot) => &plot.title,
            Self::Panels(panels) => &panels.title,
            Self::HeatMap(map) => &map.title,
            Self::Bars(bars) => &bars.title,
        }
    }
}

impl Plot {
    /// The plot as an SVG file that needs nothing else and suits light and dark.
    #[must_use]
    pub fn to_svg(&self) -> String {
        draw::plot(self, "figure", Place::File).svg
    }
}

impl Panels {
    /// The panels as an SVG file that needs nothing else and suits light and dark.
    #[must_use]
    pub fn to_svg(&self) -> String {
        draw::panels(self, "figure", Place::File).svg
    }
}

impl From<Plot> for Figure {
    fn from(plot: Plot) -> Self {
        Self::Plot(plot)
    }
}

impl From<Panels> for Figure {
    fn from(panels: Panels) -> Self {
        Self::Panels(panels)
    }
}

impl From<HeatMap> for Figure {
    fn from(map: HeatMap) -> Self {
        Self::HeatMap(map)
    }
}

impl From<Bars> for Figure {
    fn from(bars: Bars) -> Self {
        Self::Bars(bars)
    }
}
