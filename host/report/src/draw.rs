//! Draws plots, one or stacked over a shared x axis, as SVG.

use super::axis::{Axis, Ticks};
use super::colour::standalone_css;
use super::curve::{self, Map, Samples, Shape};
use super::embed;
use super::layout::{self, Entry, Placed, ROW, SWATCH, WIDTH};
use super::plot::{Dash, Legend, Panels, Plot, Series, Style};
use super::svg::{Svg, TEXT, text_width, title_lines, wrap};

/// Whether a picture is a file of its own or a part of a page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// A file: brings its own style sheet.
    File,
    /// In a page that has the style sheet.
    Page,
}

/// A picture and what a page needs to make it answer.
#[derive(Debug)]
pub(super) struct Drawing {
    /// The picture.
    pub svg: String,
    /// Its height, user units.
    pub height: f64,
    /// Data for the page's script, JSON; `None` for a picture that cannot be zoomed.
    pub data: Option<String>,
    /// What was left out of the picture, in words.
    pub note: Option<String>,
}

/// What a figure says of itself.
pub(super) struct Heading<'a> {
    pub title: &'a str,
    pub summary: &'a str,
    /// Unique among the figures of a page.
    pub id: &'a str,
}

/// One plot with everything placed.
pub(super) struct Frame<'a> {
    pub plot: &'a Plot,
    pub x: Map,
    pub y: Map,
    pub y_exponent: i32,
    pub samples: Vec<Samples>,
    y_ticks: Ticks,
    y_title: Vec<String>,
    entries: Vec<Entry>,
    strip: Vec<Placed>,
    /// Top of the block, including titles and legends.
    top: f64,
    titled: bool,
}

impl Frame<'_> {
    /// Height of everything above the drawing area.
    fn head(&self) -> f64 {
        let title = if self.titled { ROW + 2.0 } else { 0.0 };
        title + self.legend_height() + ROW * self.strip_rows() as f64 + 5.0
    }

    fn legend_height(&self) -> f64 {
        match self.plot.legend {
            Legend::Above => ROW * self.entries.last().map_or(0.0, |e| e.row as f64 + 1.0),
            _ => 0.0,
        }
    }

    fn strip_rows(&self) -> usize {
        self.strip.iter().filter_map(|p| p.row).max().map_or(0, |row| row + 1)
    }
}

/// Draws a plot alone.
pub(super) fn plot(plot: &Plot, id: &str, place: Place) -> Drawing {
    let heading = Heading { title: &plot.title, summary: &plot.summary, id };
    draw(&heading, std::slice::from_ref(plot), false, place)
}

/// Draws stacked plots.
pub(super) fn panels(panels: &Panels, id: &str, place: Place) -> Drawing {
    let heading = Heading { title: &panels.title, summary: &panels.summary, id };
    draw(&heading, &panels.plots, true, place)
}

fn draw(heading: &Heading<'_>, plots: &[Plot], titled: bool, place: Place) -> Drawing {
    let axis = plots.last().map(|p| p.x.clone()).unwrap_or_default();
    let fixed = plots.iter().rev().find_map(|p| Axis { scale: axis.scale, ..p.x.clone() }.fixed());
    let axis = Axis { range: fixed, ..axis };
    let all_x = plots.iter().flat_map(|p| &p.series).flat_map(|s| s.x.iter().copied());
    let x_range = axis.cover(all_x, if plots.iter().all(only_markers) { 0.04 } else { 0.0 });
    let x_exponent = axis.thousands(x_range);

    let mut frames: Vec<_> = plots.iter().map(|p| frame(p, &axis, x_range, titled)).collect();
    let left = frames.iter().map(left_margin).fold(24.0, f64::max);
    let right = plots.iter().map(right_margin).fold(18.0, f64::max);
    let area = (left, WIDTH - right);
    let x_ticks = layout::horizontal_ticks(&axis, x_range, area.1 - area.0, x_exponent);

    let title = title_lines(heading.title, WIDTH - 24.0);
    let mut top = if title.is_empty() { 6.0 } else { 12.0 + 20.0 * title.len() as f64 };
    for frame in &mut frames {
        top = place_frame(frame, area, top) + 10.0;
    }
    let height =
        (top + ROW + if axis.title(x_exponent).is_empty() { 0.0 } else { ROW } + 4.0).ceil();

    let label = description(heading, &axis, plots);
    let mut svg = Svg::default();
    begin(&mut svg, heading, &label, height, place);
    for (row, line) in title.iter().enumerate() {
        let y = 22.0 + 20.0 * row as f64;
        svg.element("text").class("pl-title").length("x", 12.0).length("y", y).text(line);
    }
    for (index, frame) in frames.iter().enumerate() {
        let clip = format!("{}-clip{index}", heading.id);
        let last = index + 1 == frames.len();
        panel(&mut svg, frame, index, &clip, &x_ticks, last);
    }
    if let Some(last) = frames.last() {
        let y = last.y.drawn.0 + 2.0 * ROW + 3.0;
        let centre = 0.5 * (area.0 + area.1);
        centred(&mut svg, "pl-text", centre, y, &axis.title(x_exponent));
    }
    let thinned = frames.iter().flat_map(|f| &f.samples).filter(|s| s.x.len() < s.of);
    let note = thinned.max_by_key(|s| s.of).map(|s| {
        format!(
            "Up to {} samples a line, thinned to {} that keep every extreme at this size.",
            s.of,
            s.x.len()
        )
    });
    Drawing { svg: svg.finish(), height, data: Some(embed::json(&axis, x_exponent, &frames)), note }
}

fn only_markers(plot: &Plot) -> bool {
    let marked = |s: &Series| matches!(s.style, Style::Points | Style::ErrorBars { .. });
    !plot.series.is_empty() && plot.series.iter().all(marked)
}

/// Everything about a plot that does not depend on where it is.
fn frame<'a>(plot: &'a Plot, axis: &Axis, x_range: (f64, f64), titled: bool) -> Frame<'a> {
    let x = Map { scale: axis.scale, range: x_range, drawn: (0.0, 1.0) };
    let seen =
        |s: &'a Series| (0..s.x.len()).filter(move |i| x.holds(s.x[*i])).flat_map(|i| s.extent(i));
    let values = plot.series.iter().flat_map(seen).chain(plot.levels.iter().map(|l| l.y));
    let range = plot.y.cover(values, 0.05);
    let exponent = plot.y.thousands(range);
    let height = plot.area_height();
    let y = Map { scale: plot.y.scale, range, drawn: (height, 0.0) };
    Frame {
        plot,
        x,
        y,
        y_exponent: exponent,
        samples: plot.series.iter().map(|s| curve::samples(s, &x, &y)).collect(),
        y_ticks: layout::vertical_ticks(&plot.y, range, height, exponent),
        y_title: wrap(&plot.y.title(exponent), TEXT, height.max(60.0)),
        entries: Vec::new(),
        strip: Vec::new(),
        top: 0.0,
        titled: titled && !plot.title.is_empty(),
    }
}

fn left_margin(frame: &Frame<'_>) -> f64 {
    let labels = frame.y_ticks.major.iter().map(|(_, label)| text_width(label, TEXT));
    labels.fold(0.0, f64::max) + 12.0 + (TEXT + 5.0) * frame.y_title.len() as f64 + 4.0
}

/// A legend, or the names of levels, stand right of the drawing area.
fn right_margin(plot: &Plot) -> f64 {
    let lines = plot.levels.iter().flat_map(|level| level_lines(&level.label));
    let names = lines.map(|line| text_width(&line, TEXT) + 12.0);
    match plot.legend {
        Legend::Right => layout::legend_width(plot) + 28.0,
        _ => names.fold(18.0, f64::max),
    }
}

/// Width of the name of a level, at which it goes on in the next line, user units.
const LEVEL_NAME: f64 = 56.0;

fn level_lines(label: &str) -> Vec<String> {
    wrap(label, TEXT, LEVEL_NAME)
}

/// Gives a frame its place below `top`; returns the bottom of its drawing area.
fn place_frame(frame: &mut Frame<'_>, area: (f64, f64), top: f64) -> f64 {
    frame.x.drawn = area;
    frame.entries = layout::legend(frame.plot, area.1 - area.0);
    let spans = frame.plot.spans.iter().filter_map(|s| {
        let from = s.from.max(frame.x.range.0);
        let to = s.to.min(frame.x.range.1);
        (from < to).then(|| (0.5 * (frame.x.at(from) + frame.x.at(to)), &s.label))
    });
    let marks = frame.plot.marks.iter().filter(|m| frame.x.holds(m.x));
    let texts = spans.chain(marks.map(|m| (frame.x.at(m.x), &m.label)));
    let texts: Vec<_> = texts.map(|(x, label)| (x, text_width(label, TEXT))).collect();
    frame.strip = layout::strip(&texts, 3, (area.0, WIDTH - 4.0));
    frame.top = top;
    let begin = top + frame.head();
    frame.y.drawn = (begin + frame.plot.area_height(), begin);
    frame.y.drawn.0
}

/// Opens the picture: root, description, style, ground.
pub(super) fn begin(svg: &mut Svg, heading: &Heading<'_>, label: &str, height: f64, place: Place) {
    let root = svg
        .element("svg")
        .attribute("xmlns", "http://www.w3.org/2000/svg")
        .class("pl")
        .attribute("viewBox", &format!("0 0 {WIDTH} {height}"))
        .length("width", WIDTH)
        .length("height", height)
        .attribute("role", "img")
        .attribute("aria-label", label);
    root.open();
    if place == Place::File {
        svg.element("title").text(heading.title);
        svg.element("style").open();
        svg.raw(&standalone_css());
        svg.close();
    }
    svg.element("rect").class("pl-bg").length("width", WIDTH).length("height", height).leaf();
}

/// Title, summary and contents of a figure in words.
fn description(heading: &Heading<'_>, x: &Axis, plots: &[Plot]) -> String {
    let list = |plot: &Plot| {
        let names: Vec<_> =
            plot.series.iter().map(|s| s.name.as_str()).filter(|n| !n.is_empty()).collect();
        let names =
            if names.is_empty() { String::new() } else { format!(": {}", names.join(", ")) };
        format!("{} over {}{names}.", plot.y.title(0), x.title(0))
    };
    let parts = [heading.title.to_owned(), heading.summary.to_owned()];
    let parts = parts
        .into_iter()
        .filter(|p| !p.is_empty())
        .map(|p| if p.ends_with(['.', '?', '!']) { p } else { p + "." });
    parts.chain(plots.iter().map(list)).collect::<Vec<_>>().join(" ")
}

pub(super) fn centred(svg: &mut Svg, class: &str, x: f64, y: f64, text: &str) {
    anchored(svg, class, x, y, "middle", text);
}

pub(super) fn anchored(svg: &mut Svg, class: &str, x: f64, y: f64, anchor: &str, text: &str) {
    if !text.is_empty() {
        let element = svg.element("text").class(class).length("x", x).length("y", y);
        let element =
            if anchor == "start" { element } else { element.attribute("text-anchor", anchor) };
        element.text(text);
    }
}

pub(super) fn segment(svg: &mut Svg, class: &str, from: (f64, f64), to: (f64, f64)) {
    let line = svg.element("line").class(class).length("x1", from.0).length("y1", from.1);
    line.length("x2", to.0).length("y2", to.1).leaf();
}

fn panel(svg: &mut Svg, frame: &Frame<'_>, index: usize, clip: &str, x_ticks: &Ticks, last: bool) {
    let ((left, right), (bottom, top)) = (frame.x.drawn, frame.y.drawn);
    svg.element("g").attribute("data-panel", &index.to_string()).open();
    svg.element("clipPath").attribute("id", clip).open();
    let room = svg.element("rect").length("x", left).length("y", top);
    room.length("width", right - left).length("height", bottom - top).leaf();
    svg.close();
    let clip = format!("url(#{clip})");

    svg.element("g").attribute("clip-path", &clip).open();
    spans(svg, frame);
    svg.close();
    axes(svg, frame, x_ticks, last);
    svg.element("g").attribute("clip-path", &clip).open();
    for level in frame.plot.levels.iter().filter(|l| frame.y.holds(l.y)) {
        svg.element("g").data("y", level.y).at(0.0, frame.y.at(level.y)).open();
        segment(svg, "pl-level", (left, 0.0), (right, 0.0));
        svg.close();
    }
    for (index, (series, samples)) in frame.plot.series.iter().zip(&frame.samples).enumerate() {
        curves(svg, frame, index, series, samples);
    }
    for mark in frame.plot.marks.iter().filter(|m| frame.x.holds(m.x)) {
        svg.element("g").data("x", mark.x).at(frame.x.at(mark.x), 0.0).open();
        segment(svg, "pl-mark", (0.0, top), (0.0, bottom));
        svg.close();
    }
    svg.close();
    strip(svg, frame);
    level_labels(svg, frame);
    annotations(svg, frame);
    if frame.titled {
        anchored(svg, "pl-head", left, frame.top + TEXT, "start", &frame.plot.title);
    }
    legend(svg, frame);
    svg.close();
}

fn spans(svg: &mut Svg, frame: &Frame<'_>) {
    let (bottom, top) = frame.y.drawn;
    for (index, span) in frame.plot.spans.iter().enumerate() {
        let (from, to) = (frame.x.at(span.from), frame.x.at(span.to));
        if !(from.is_finite() && to > from) {
            continue;
        }
        let class = if index % 2 == 0 { "pl-span" } else { "pl-bg" };
        let rect = svg.element("rect").class(class).data("from", span.from).data("to", span.to);
        let rect = rect.length("x", from).length("y", top).length("width", to - from);
        rect.length("height", bottom - top).leaf();
    }
}

/// Grid, axes, ticks and their labels; the script of a page draws the same again after a zoom.
fn axes(svg: &mut Svg, frame: &Frame<'_>, x_ticks: &Ticks, last: bool) {
    let ((left, right), (bottom, top)) = (frame.x.drawn, frame.y.drawn);
    svg.element("g").attribute("data-ticks", "y").open();
    for (value, label) in &frame.y_ticks.major {
        let y = frame.y.at(*value);
        segment(svg, "pl-grid", (left, y), (right, y));
        anchored(svg, "pl-text pl-num", left - 8.0, y + 4.5, "end", label);
    }
    for value in &frame.y_ticks.minor {
        let y = frame.y.at(*value);
        segment(svg, "pl-axis", (left - 3.0, y), (left, y));
    }
    svg.close();
    svg.element("g").attribute("data-ticks", "x").open();
    for (value, label) in &x_ticks.major {
        let x = frame.x.at(*value);
        segment(svg, "pl-grid", (x, top), (x, bottom));
        segment(svg, "pl-axis", (x, bottom), (x, bottom + 5.0));
        if last {
            centred(svg, "pl-text pl-num", x, bottom + ROW + 1.0, label);
        }
    }
    for value in &x_ticks.minor {
        let x = frame.x.at(*value);
        segment(svg, "pl-axis", (x, bottom), (x, bottom + 3.0));
    }
    svg.close();
    let corner = svg.element("path").class("pl-axis");
    let [l, r, t, b] = [left, right, top, bottom].map(super::svg::coordinate);
    corner.attribute("d", &format!("M{l} {t}V{b}H{r}")).leaf();
    let lines = frame.y_title.len() as f64;
    for (row, line) in frame.y_title.iter().enumerate() {
        let x = TEXT + 2.0 + (TEXT + 5.0) * (row as f64 - lines + frame.y_title.len() as f64);
        let text = svg.element("text").class("pl-text").attribute("text-anchor", "middle");
        let [x, y] = [x, 0.5 * (top + bottom)].map(super::svg::coordinate);
        text.attribute("transform", &format!("translate({x},{y}) rotate(-90)")).text(line);
    }
}

/// The dash pattern of a series; empty for a solid line.
fn dashes(series: &Series) -> &'static str {
    match (series.dash, &series.style) {
        (_, Style::ErrorBars { .. }) | (Dash::Solid, _) => "",
        (Dash::Dashed, _) => "6 3",
        (Dash::Auto, _) => series.colour.dashes(),
    }
}

fn curves(svg: &mut Svg, frame: &Frame<'_>, index: usize, series: &Series, samples: &Samples) {
    let class = series.colour.class();
    svg.element("g").class(&class).attribute("data-series", &index.to_string()).open();
    for shape in curve::shapes(series, samples, &frame.x, &frame.y) {
        match shape {
            Shape::Stroke(d) => {
                let path =
                    svg.element("path").class("pl-line").length("stroke-width", series.width);
                let dashes = dashes(series);
                let path = if dashes.is_empty() {
                    path
                } else {
                    path.attribute("stroke-dasharray", dashes)
                };
                path.attribute("d", &d).leaf();
            }
            Shape::Dots(d) => svg.element("path").class("pl-dot").attribute("d", &d).leaf(),
            Shape::Fill(d) => svg.element("path").class("pl-band").attribute("d", &d).leaf(),
        }
    }
    svg.close();
}

/// Names of spans and marks, above the drawing area.
fn strip(svg: &mut Svg, frame: &Frame<'_>) {
    let rows = frame.strip_rows() as f64;
    let base = |row: usize| frame.y.drawn.1 - 5.0 - ROW * (rows - 1.0 - row as f64).max(0.0);
    let spans =
        frame.plot.spans.iter().filter(|s| s.from.max(frame.x.range.0) < s.to.min(frame.x.range.1));
    let marks = frame.plot.marks.iter().filter(|m| frame.x.holds(m.x));
    let spans = spans.map(|s| (&s.label, s.from, s.to));
    for ((label, from, to), placed) in
        spans.chain(marks.map(|m| (&m.label, m.x, m.x))).zip(&frame.strip)
    {
        if let Some(row) = placed.row.filter(|_| !label.is_empty()) {
            let text = svg.element("text").class("pl-note").data("from", from).data("to", to);
            let text = text.length("x", placed.centre).length("y", base(row));
            text.attribute("text-anchor", "middle").text(label);
        }
    }
}

/// Names of levels, right of the drawing area, each at its line, where no other is in the way.
fn level_labels(svg: &mut Svg, frame: &Frame<'_>) {
    let mut taken: Vec<(f64, f64)> = Vec::new();
    for level in frame.plot.levels.iter().filter(|l| frame.y.holds(l.y)) {
        let y = frame.y.at(level.y);
        let lines = level_lines(&level.label);
        let half = 0.5 * (TEXT + 2.0) * lines.len() as f64;
        if taken.iter().any(|(at, other)| (at - y).abs() < half + other) {
            continue;
        }
        taken.push((y, half));
        svg.element("g").data("y", level.y).at(0.0, y).open();
        for (row, line) in lines.iter().enumerate() {
            let base = (TEXT + 2.0) * (row as f64 + 0.8) - half;
            anchored(svg, "pl-note", frame.x.drawn.1 + 6.0, base, "start", line);
        }
        svg.close();
    }
}

/// Remarks at points: beside the point where they meet no other remark and stay inside.
fn annotations(svg: &mut Svg, frame: &Frame<'_>) {
    let ((left, right), (bottom, top)) = (frame.x.drawn, frame.y.drawn);
    let mut taken: Vec<[f64; 4]> = Vec::new();
    let inside = |a: &&super::plot::Annotation| frame.x.holds(a.x) && frame.y.holds(a.y);
    for note in frame.plot.annotations.iter().filter(inside) {
        let (x, y) = (frame.x.at(note.x), frame.y.at(note.y));
        let width = text_width(&note.text, TEXT);
        let clear = |(dx, dy, anchor): (f64, f64, &'static str)| {
            let from = x + dx - if anchor == "end" { width } else { 0.0 };
            let rect = [from, y + dy - TEXT, from + width, y + dy + 4.0];
            let apart =
                |t: &[f64; 4]| rect[2] < t[0] || rect[0] > t[2] || rect[3] < t[1] || rect[1] > t[3];
            let within = rect[0] >= left && rect[2] <= right && rect[1] >= top && rect[3] <= bottom;
            (within && taken.iter().all(apart)).then_some((rect, dx, dy, anchor))
        };
        let places =
            [(9.0, -9.0, "start"), (9.0, 18.0, "start"), (-9.0, -9.0, "end"), (-9.0, 18.0, "end")];
        let Some((rect, dx, dy, anchor)) = places.into_iter().find_map(clear) else { continue };
        taken.push(rect);
        svg.element("g").data("x", note.x).data("y", note.y).at(x, y).open();
        svg.element("circle").class("pl-mark").length("r", 3.5).leaf();
        anchored(svg, "pl-text pl-halo", dx, dy, anchor, &note.text);
        svg.close();
    }
}

fn legend(svg: &mut Svg, frame: &Frame<'_>) {
    let ((left, right), (_, top)) = (frame.x.drawn, frame.y.drawn);
    let width = layout::legend_width(frame.plot);
    let title = if frame.titled { ROW + 2.0 } else { 0.0 };
    let (x, y) = match frame.plot.legend {
        Legend::Above | Legend::Hidden => (left, frame.top + title),
        Legend::Right => (right + 16.0, top - 4.0),
        Legend::Inside => (right - width - 14.0, top + 6.0),
    };
    if frame.plot.legend == Legend::Inside && !frame.entries.is_empty() {
        let ground = svg.element("rect").class("pl-bg").length("x", x - 8.0).length("y", y);
        let height = ROW * frame.entries.len() as f64 + 4.0;
        let ground = ground.length("width", width + 16.0).length("height", height);
        ground.attribute("fill-opacity", "0.85").leaf();
    }
    for entry in &frame.entries {
        let series = &frame.plot.series[entry.series];
        svg.element("g")
            .attribute("data-legend", &entry.series.to_string())
            .at(x + entry.x, y + ROW * entry.row as f64)
            .open();
        swatch(svg, series);
        anchored(svg, "pl-text", SWATCH + 6.0, TEXT + 0.5, "start", &series.name);
        svg.close();
    }
}

fn swatch(svg: &mut Svg, series: &Series) {
    svg.element("g").class(&series.colour.class()).open();
    let (middle, centre) = (0.5 * ROW, 0.5 * SWATCH);
    if let Style::Band { .. } = series.style {
        let rect = svg.element("rect").class("pl-band").length("y", middle - 5.0);
        rect.length("width", SWATCH).length("height", 10.0).leaf();
    }
    if let Style::Line | Style::Step = series.style {
        let line =
            svg.element("path").class("pl-line").length("stroke-width", series.width.max(1.4));
        let dashes = dashes(series);
        let line =
            if dashes.is_empty() { line } else { line.attribute("stroke-dasharray", dashes) };
        line.attribute("d", &format!("M0 {middle}h{SWATCH}")).leaf();
    }
    if let Style::ErrorBars { .. } = series.style {
        let line = svg.element("path").class("pl-line").length("stroke-width", series.width);
        line.attribute("d", &format!("M{centre} 2v{}m-3 0h6m-6-{0}h6", ROW - 4.0)).leaf();
    }
    if let Style::Points | Style::ErrorBars { .. } = series.style {
        let marker = curve::marker(series, &Samples::default());
        let dot = svg.element("path").class("pl-dot");
        dot.attribute("d", &format!("M{centre} {middle}{marker}")).leaf();
    }
    svg.close();
}
