//! Groups of horizontal bars: the error at each rung of the ladder, on traces fitted and held out.

use super::axis::{Axis, Scale};
use super::colour::Colour;
use super::curve::{CAP, Map};
use super::draw::{Drawing, Heading, Place, anchored, begin, centred, segment};
use super::layout::{ROW, SWATCH, WIDTH, horizontal_ticks};
use super::number::{significant, typographic, with_error};
use super::plot::Level;
use super::svg::{Svg, TEXT, shorten, text_width, title_lines};

/// One bar in each group.
#[derive(Clone, Debug, PartialEq)]
pub struct BarSeries {
    /// Name in the legend.
    pub name: String,
    /// One value for each group, data units; NaN leaves the bar out.
    pub values: Vec<f64>,
    /// Standard error of each value, data units; empty for none.
    pub errors: Vec<f64>,
    /// Colour. The first series is filled, the others are ever lighter with an outline.
    pub colour: Colour,
}

/// Groups of bars that start from zero, or on a logarithmic axis from its left end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bars {
    /// Title; empty for none.
    pub title: String,
    /// What it shows in a sentence, for people who cannot see it.
    pub summary: String,
    /// Axis of the values.
    pub axis: Axis,
    /// Name of each group, from top to bottom.
    pub groups: Vec<String>,
    /// The bars of each group, from top to bottom.
    pub series: Vec<BarSeries>,
    /// Reference values, drawn as vertical lines: the noise floor.
    pub levels: Vec<Level>,
}

const BAR: f64 = 15.0;

impl Bars {
    /// The bars as an SVG file that needs nothing else and suits light and dark.
    #[must_use]
    pub fn to_svg(&self) -> String {
        self.draw("figure", Place::File).svg
    }

    fn extents(&self) -> impl Iterator<Item = f64> {
        self.series.iter().flat_map(|s| {
            s.values.iter().enumerate().flat_map(|(i, v)| {
                let error = s.errors.get(i).copied().filter(|e| e.is_finite()).unwrap_or(0.0).abs();
                [v - error, v + error]
            })
        })
    }

    fn range(&self) -> (f64, f64) {
        let values = self.extents().chain(self.levels.iter().map(|l| l.y));
        if self.axis.scale == Scale::Log {
            return self.axis.cover(values, 0.1);
        }
        let (low, high) = self.axis.cover(values.chain([0.0]), 0.0);
        match self.axis.fixed() {
            Some(fixed) => fixed,
            // Room for the number at the end of the longest bar.
            None => (
                if low < 0.0 { 1.18 * low } else { 0.0 },
                if high > 0.0 { 1.18 * high } else { 0.0 },
            ),
        }
    }

    fn label(series: &BarSeries, group: usize) -> String {
        let value = series.values.get(group).copied().unwrap_or(f64::NAN);
        match series.errors.get(group) {
            Some(error) if error.is_finite() && *error != 0.0 => {
                typographic(&with_error(value, *error))
            }
            _ => typographic(&significant(value, 3)),
        }
    }

    pub(super) fn draw(&self, id: &str, place: Place) -> Drawing {
        let range = self.range();
        let exponent = self.axis.thousands(range);
        let names = self.groups.iter().map(|g| text_width(g, TEXT));
        let left = names.fold(0.0, f64::max).min(0.4 * WIDTH) + 24.0;
        let label_room = if self.series.iter().any(|s| !s.errors.is_empty()) { 72.0 } else { 24.0 };
        let map = Map { scale: self.axis.scale, range, drawn: (left, WIDTH - label_room) };
        let title = title_lines(&self.title, WIDTH - 24.0);
        let legend_top = 12.0 + 20.0 * title.len() as f64;
        let named_levels = self.levels.iter().any(|l| !l.label.is_empty() && map.holds(l.y));
        let legend_rows = usize::from(self.series.len() > 1) + usize::from(named_levels);
        let top = legend_top + ROW * legend_rows as f64 + 4.0;
        let group = BAR * self.series.len().max(1) as f64 + 12.0;
        let bottom = top + group * self.groups.len() as f64;
        let heading = Heading { title: &self.title, summary: &self.summary, id };
        let mut svg = Svg::default();
        let height = (bottom + 2.0 * ROW + 12.0).ceil();
        begin(&mut svg, &heading, &self.description(), height, place);
        for (row, line) in title.iter().enumerate() {
            anchored(&mut svg, "pl-title", 12.0, 22.0 + 20.0 * row as f64, "start", line);
        }
        if self.series.len() > 1 {
            self.legend(&mut svg, left, legend_top);
        }
        self.axis_lines(&mut svg, &map, exponent, (top, bottom));
        for (index, name) in self.groups.iter().enumerate() {
            let y = top + group * index as f64 + 6.0;
            let middle = y + 0.5 * (group - 12.0) + 4.5;
            anchored(
                &mut svg,
                "pl-text",
                left - 10.0,
                middle,
                "end",
                &shorten(name, TEXT, left - 24.0),
            );
            for (place, series) in self.series.iter().enumerate() {
                bar(&mut svg, &map, series, (index, place), y + BAR * place as f64);
            }
        }
        self.level_lines(&mut svg, &map, (top, bottom));
        Drawing { svg: svg.finish(), height, data: None, note: None }
    }

    fn axis_lines(&self, svg: &mut Svg, map: &Map, exponent: i32, (top, bottom): (f64, f64)) {
        let (left, right) = map.drawn;
        let ticks = horizontal_ticks(&self.axis, map.range, right - left, exponent);
        for (value, label) in &ticks.major {
            let x = map.at(*value);
            segment(svg, "pl-grid", (x, top), (x, bottom));
            segment(svg, "pl-axis", (x, bottom), (x, bottom + 5.0));
            centred(svg, "pl-text pl-num", x, bottom + ROW + 1.0, label);
        }
        let zero = if map.holds(0.0) { map.at(0.0) } else { left };
        segment(svg, "pl-axis", (zero, top), (zero, bottom));
        segment(svg, "pl-axis", (left, bottom), (right, bottom));
        let y = bottom + 2.0 * ROW + 3.0;
        centred(svg, "pl-text", 0.5 * (left + right), y, &self.axis.title(exponent));
    }

    fn level_lines(&self, svg: &mut Svg, map: &Map, (top, bottom): (f64, f64)) {
        let mut levels: Vec<&Level> = self.levels.iter().filter(|l| map.holds(l.y)).collect();
        levels.sort_by(|a, b| a.y.total_cmp(&b.y));
        // Names stand over their lines, or beside the name before where lines are close.
        let mut taken = f64::NEG_INFINITY;
        for level in levels {
            let x = map.at(level.y);
            segment(svg, "pl-level", (x, top), (x, bottom));
            let half = 0.5 * text_width(&level.label, TEXT);
            let centre = x.max(map.drawn.0 + half - 20.0).max(taken + half).min(WIDTH - 6.0 - half);
            centred(svg, "pl-note", centre, top - 5.0, &level.label);
            taken = centre + half + 10.0;
        }
    }

    fn legend(&self, svg: &mut Svg, left: f64, top: f64) {
        let mut x = left;
        for (place, series) in self.series.iter().enumerate() {
            let rect = fill(svg, series, place).length("x", x).length("y", top + 4.0);
            rect.length("width", SWATCH).length("height", 10.0).leaf();
            svg.close();
            anchored(svg, "pl-text", x + SWATCH + 6.0, top + TEXT + 0.5, "start", &series.name);
            x += SWATCH + 24.0 + text_width(&series.name, TEXT);
        }
    }

    fn description(&self) -> String {
        let group = |(index, name): (usize, &String)| {
            let values =
                self.series.iter().map(|s| format!("{} {}", s.name, Self::label(s, index)));
            format!("{name}: {}.", values.collect::<Vec<_>>().join(", "))
        };
        let head = [self.title.clone(), self.summary.clone(), self.axis.title(0)];
        let parts = head.into_iter().filter(|p| !p.is_empty());
        parts.chain(self.groups.iter().enumerate().map(group)).collect::<Vec<_>>().join(" ")
    }
}

/// A bar's rectangle, inside a group that carries its colour; the caller closes the group.
fn fill<'a>(svg: &'a mut Svg, series: &BarSeries, place: usize) -> super::svg::Element<'a> {
    svg.element("g").class(&series.colour.class()).open();
    let opacity = ["0.85", "0.25", "0"][place.min(2)];
    svg.element("rect").class("pl-bar").attribute("fill-opacity", opacity)
}

fn bar(svg: &mut Svg, map: &Map, series: &BarSeries, (group, place): (usize, usize), y: f64) {
    let value = series.values.get(group).copied().unwrap_or(f64::NAN);
    let origin = if map.holds(0.0) { map.at(0.0) } else { map.drawn.0 };
    let end = map.at(value).clamp(map.drawn.0, map.drawn.1);
    if !end.is_finite() {
        return anchored(svg, "pl-note", origin + 6.0, y + 12.0, "start", "–");
    }
    let rect = fill(svg, series, place).length("x", origin.min(end)).length("y", y + 1.5);
    rect.length("width", (end - origin).abs()).length("height", BAR - 3.0).leaf();
    svg.close();
    let error = series.errors.get(group).copied().unwrap_or(f64::NAN).abs();
    let mut outer = end;
    if error.is_finite() && error > 0.0 {
        let ends = [value - error, value + error].map(|v| map.at(v));
        let [from, to] = ends.map(|x| if x.is_nan() { map.drawn.0 } else { x.max(map.drawn.0) });
        let middle = y + 0.5 * BAR;
        svg.element("g").class("pl-ink").open();
        segment(svg, "pl-line", (from, middle), (to, middle));
        segment(svg, "pl-line", (to, middle - CAP), (to, middle + CAP));
        segment(svg, "pl-line", (from, middle - CAP), (from, middle + CAP));
        svg.close();
        outer = if value < 0.0 { from } else { to };
    }
    let (x, anchor) = if value < 0.0 { (outer - 6.0, "end") } else { (outer + 6.0, "start") };
    anchored(svg, "pl-text pl-num pl-halo", x, y + 12.0, anchor, &Bars::label(series, group));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ladder() -> Bars {
        let series = |name: &str, values: [f64; 2], hue| BarSeries {
            name: name.into(),
            values: values.into(),
            errors: vec![0.004, 0.001],
            colour: Colour::Hue(hue),
        };
        Bars {
            title: "Ladder".into(),
            axis: Axis::new("Residual RMS", "N"),
            groups: vec!["fung".into(), "+ mullins".into()],
            series: vec![
                series("fitted", [0.131, 0.021], 0),
                series("held out", [0.14, f64::NAN], 0),
            ],
            levels: vec![Level { y: 0.02, label: "noise".into() }],
            ..Bars::default()
        }
    }

    #[test]
    fn bars_start_at_zero_and_print_their_value_with_its_error() {
        assert_eq!(ladder().range().0, 0.0);
        let svg = ladder().to_svg();
        assert!(svg.contains(">0.1310 ± 0.0040</text>"), "{svg}");
        assert!(svg.contains(">–</text>") && !svg.contains("NaN"));
    }

    #[test]
    fn a_logarithmic_ladder_and_an_empty_one_can_be_drawn() {
        let log = Bars { axis: Axis::new("RMS", "N").log(), ..ladder() }.to_svg();
        assert!(!log.contains("NaN") && log.contains(">noise</text>"));
        assert!(Bars::default().to_svg().starts_with("<svg"));
    }
}
