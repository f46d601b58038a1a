//! Figures one below the other in one file.

use super::draw::{Heading, Place, begin};
use super::figure::Figure;
use super::svg::Svg;

/// Figures below each other, for one page.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// What it is.
    pub title: String,
    /// An SVG file that needs nothing else and suits light and dark.
    pub svg: String,
    /// How high it is, in units of which the sheet is 640 wide.
    pub height: f64,
}

/// Several figures below each other as one sheet.
#[must_use]
pub fn stacked(title: &str, summary: &str, figures: &[Figure]) -> Sheet {
    let drawings: Vec<_> = figures
        .iter()
        .enumerate()
        .map(|(index, figure)| figure.draw(&format!("figure-{index}"), Place::Page))
        .collect();
    let height = drawings.iter().map(|drawing| drawing.height).sum();
    let mut svg = Svg::default();
    let heading = Heading { title, summary, id: "figure" };
    begin(&mut svg, &heading, &format!("{title}. {summary}"), height, Place::File);
    let mut top = 0.0;
    for drawing in &drawings {
        svg.element("g").at(0.0, top).open();
        svg.raw(&drawing.svg);
        svg.close();
        top += drawing.height;
    }
    Sheet { title: title.into(), svg: svg.finish(), height }
}
