//! A table of numbers as colours, the numbers printed in it: share of the excess error for each trace and
//! region.

use super::draw::{Drawing, Heading, Place, anchored, begin, centred};
use super::layout::WIDTH;
use super::number::{share, significant, typographic};
use super::svg::{Svg, TEXT, shorten, text_width, title_lines};

/// How the numbers of a heat map are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CellFormat {
    /// A fraction as a percentage: `61 %`.
    #[default]
    Percent,
    /// Plain, to this many significant digits.
    Significant(usize),
}

/// Numbers by row and column. Positive ones are blue, negative ones vermilion, the stronger the further
/// from zero.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeatMap {
    /// Title; empty for none.
    pub title: String,
    /// What it shows in a sentence, for people who cannot see it.
    pub summary: String,
    /// What the rows are: `Trace`.
    pub row_label: String,
    /// What the columns are, with the unit of the numbers: `Region`.
    pub column_label: String,
    /// Name of each row.
    pub rows: Vec<String>,
    /// Name of each column.
    pub columns: Vec<String>,
    /// One row of values for each row; NaN, or a missing value, is an empty cell.
    pub values: Vec<Vec<f64>>,
    /// How the numbers are written.
    pub format: CellFormat,
    /// The number of the strongest colour; the largest in the map where absent.
    pub strongest: Option<f64>,
}

const CELL: f64 = 26.0;

impl HeatMap {
    /// The map as an SVG file that needs nothing else and suits light and dark.
    #[must_use]
    pub fn to_svg(&self) -> String {
        self.draw("figure", Place::File).svg
    }

    fn value(&self, row: usize, column: usize) -> f64 {
        self.values.get(row).and_then(|r| r.get(column)).copied().unwrap_or(f64::NAN)
    }

    fn text(&self, value: f64) -> String {
        match self.format {
            _ if !value.is_finite() => "–".to_owned(),
            CellFormat::Percent => typographic(&share(value)),
            CellFormat::Significant(digits) => typographic(&significant(value, digits)),
        }
    }

    pub(super) fn draw(&self, id: &str, place: Place) -> Drawing {
        let names = self.rows.iter().map(|r| text_width(r, TEXT));
        let left = names.fold(text_width(&self.row_label, TEXT), f64::max).min(0.38 * WIDTH) + 24.0;
        let cell = (WIDTH - 12.0 - left) / self.columns.len().max(1) as f64;
        let title = title_lines(&self.title, WIDTH - 24.0);
        let top = 20.0 * title.len() as f64 + 56.0;
        let height = (top + CELL * self.rows.len() as f64 + 10.0).ceil();
        let heading = Heading { title: &self.title, summary: &self.summary, id };
        let mut svg = Svg::default();
        begin(&mut svg, &heading, &self.description(), height, place);
        for (row, line) in title.iter().enumerate() {
            anchored(&mut svg, "pl-title", 12.0, 22.0 + 20.0 * row as f64, "start", line);
        }
        anchored(&mut svg, "pl-note", 12.0, top - 8.0, "start", &self.row_label);
        centred(&mut svg, "pl-note", 0.5 * (left + WIDTH - 12.0), top - 30.0, &self.column_label);
        for (column, name) in self.columns.iter().enumerate() {
            let x = left + cell * (column as f64 + 0.5);
            centred(&mut svg, "pl-text", x, top - 8.0, &shorten(name, TEXT, cell - 4.0));
        }
        for (row, name) in self.rows.iter().enumerate() {
            let y = top + CELL * row as f64;
            anchored(
                &mut svg,
                "pl-text",
                12.0,
                y + 17.5,
                "start",
                &shorten(name, TEXT, left - 24.0),
            );
            for column in 0..self.columns.len() {
                self.cell(&mut svg, (row, column), (left + cell * column as f64, y), cell);
            }
        }
        Drawing { svg: svg.finish(), height, data: None, note: None }
    }

    fn cell(&self, svg: &mut Svg, (row, column): (usize, usize), (x, y): (f64, f64), width: f64) {
        let value = self.value(row, column);
        let all = self.values.iter().flatten().filter(|v| v.is_finite());
        let largest =
            self.strongest.unwrap_or_else(|| all.fold(0.0f64, |most, v| most.max(v.abs())));
        svg.element("g").open();
        svg.element("title").text(&format!(
            "{}, {}: {}",
            self.rows[row],
            self.columns[column],
            self.text(value)
        ));
        // At half strength of colour, text keeps a contrast of 4.5 : 1 in both themes.
        let share = if value.is_finite() && largest > 0.0 {
            (0.5 * value.abs() / largest).min(0.5)
        } else {
            0.0
        };
        let class = if value < 0.0 { "pl-cold" } else { "pl-heat" };
        let rect =
            svg.element("rect").class(class).attribute("fill-opacity", &format!("{share:.3}"));
        let rect = rect.length("x", x + 1.0).length("y", y + 1.0);
        rect.length("width", width - 2.0).length("height", CELL - 2.0).leaf();
        let text = shorten(&self.text(value), TEXT, width);
        centred(svg, "pl-text pl-num", x + 0.5 * width, y + 17.5, &text);
        svg.close();
    }

    fn description(&self) -> String {
        let cells = (0..self.rows.len()).flat_map(|r| (0..self.columns.len()).map(move |c| (r, c)));
        let largest = cells
            .filter(|&(r, c)| self.value(r, c).is_finite())
            .max_by(|a, b| self.value(a.0, a.1).abs().total_cmp(&self.value(b.0, b.1).abs()));
        let largest = largest.map(|(r, c)| {
            let text = self.text(self.value(r, c));
            format!("Largest: {text} at {}, {}.", self.rows[r], self.columns[c])
        });
        let parts = [self.title.clone(), self.summary.clone(), largest.unwrap_or_default()];
        parts.into_iter().filter(|p| !p.is_empty()).collect::<Vec<_>>().join(" ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_prints_its_value_and_missing_ones_a_dash() {
        let map = HeatMap {
            title: "Where the excess error is".into(),
            rows: vec!["a<b.csv".into(), "c.csv".into()],
            columns: vec!["OA".into(), "AB".into()],
            values: vec![vec![0.61, 0.004], vec![f64::NAN]],
            ..HeatMap::default()
        };
        let svg = map.to_svg();
        assert!(svg.contains(">61 %</text>") && svg.contains(">0.4 %</text>"));
        assert_eq!(svg.matches(">–</text>").count(), 2);
        assert!(svg.contains("a&lt;b.csv") && !svg.contains("a<b.csv"));
        assert!(svg.contains("Largest: 61 % at a&lt;b.csv, OA."));
    }

    #[test]
    fn an_empty_map_is_a_picture_too() {
        let svg = HeatMap::default().to_svg();
        assert!(svg.starts_with("<svg") && !svg.contains("NaN"));
    }
}
