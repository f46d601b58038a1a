//! A small writer of SVG: escaped text, short coordinates, the same bytes every run.

use std::fmt::Write as _;

use super::symbol::{self, Part};

/// Size of ordinary text, user units; at 640 units over 16 cm it is 9.2 pt.
pub(super) const TEXT: f64 = 13.0;
/// Size of a figure's title, user units.
pub(super) const TITLE: f64 = 15.0;

/// An SVG document, or part of one, being written.
#[derive(Debug, Default)]
pub(super) struct Svg {
    out: String,
    open: Vec<&'static str>,
}

impl Svg {
    /// Begins an element; finish it with [`Element::leaf`], [`Element::open`] or [`Element::text`].
    pub(super) fn element(&mut self, name: &'static str) -> Element<'_> {
        self.out.push('<');
        self.out.push_str(name);
        Element { svg: self, name }
    }

    /// Closes the element opened last.
    pub(super) fn close(&mut self) {
        if let Some(name) = self.open.pop() {
            let _ = write!(self.out, "</{name}>");
            if name != "text" {
                self.out.push('\n');
            }
        }
    }

    /// Adds text that is already markup: a style sheet of our own.
    pub(super) fn raw(&mut self, markup: &str) {
        self.out.push_str(markup);
    }

    /// The markup written so far, with every open element closed.
    pub(super) fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.close();
        }
        self.out
    }
}

/// An element whose attributes are being written.
#[derive(Debug)]
pub(super) struct Element<'a> {
    svg: &'a mut Svg,
    name: &'static str,
}

impl Element<'_> {
    /// Adds an attribute; its value is escaped.
    pub(super) fn attribute(self, name: &str, value: &str) -> Self {
        let _ = write!(self.svg.out, " {name}=\"{}\"", escape(value));
        self
    }

    /// Adds the class attribute.
    pub(super) fn class(self, value: &str) -> Self {
        self.attribute("class", value)
    }

    /// Adds a coordinate or length in user units, to a hundredth.
    pub(super) fn length(self, name: &str, value: f64) -> Self {
        let _ = write!(self.svg.out, " {name}=\"{}\"", coordinate(value));
        self
    }

    /// Adds a position as `transform="translate(x,y)"`.
    pub(super) fn at(self, x: f64, y: f64) -> Self {
        let _ =
            write!(self.svg.out, " transform=\"translate({},{})\"", coordinate(x), coordinate(y));
        self
    }

    /// Adds a number of the data, in full precision, for the page's script.
    pub(super) fn data(self, name: &str, value: f64) -> Self {
        let _ = write!(self.svg.out, " data-{name}=\"{value}\"");
        self
    }

    /// Ends an element without content.
    pub(super) fn leaf(self) {
        self.svg.out.push_str("/>\n");
    }

    /// Ends the start tag; what is written next is inside, until [`Svg::close`].
    pub(super) fn open(self) {
        self.svg.out.push('>');
        self.svg.open.push(self.name);
    }

    /// Ends the element with escaped text as its only content.
    pub(super) fn text(self, text: &str) {
        // What a screen reader is told has no indices.
        let set: String = if self.name == "text" {
            symbol::parts(text).iter().map(set).collect()
        } else {
            escape(text)
        };
        let _ = writeln!(self.svg.out, ">{set}</{}>", self.name);
    }
}

/// A part of a text; an index or a power in small letters, of which the next part takes back the way down or up.
fn set(part: &Part) -> String {
    let text = escape(part.text);
    let moved = |by: i32| {
        let back = -by;
        format!(
            "<tspan dy=\"{by}\" font-size=\"75%\">{text}</tspan><tspan dy=\"{back}\">\u{200b}</tspan>"
        )
    };
    match part.place {
        symbol::Place::Line => text,
        symbol::Place::Index => moved(3),
        symbol::Place::Power => moved(-5),
    }
}

/// The shortest text of a coordinate to a hundredth of a user unit.
pub(super) fn coordinate(value: f64) -> String {
    let hundredths = hundredths(value);
    let sign = if hundredths < 0 { "-" } else { "" };
    let (whole, rest) = (hundredths.abs() / 100, hundredths.abs() % 100);
    match (whole, rest) {
        (_, 0) => format!("{sign}{whole}"),
        (0, _) if rest % 10 == 0 => format!("{sign}.{}", rest / 10),
        (0, _) => format!("{sign}.{rest:02}"),
        (_, _) if rest % 10 == 0 => format!("{sign}{whole}.{}", rest / 10),
        _ => format!("{sign}{whole}.{rest:02}"),
    }
}

/// A coordinate in hundredths, kept within what every viewer can draw.
pub(super) fn hundredths(value: f64) -> i64 {
    (value.clamp(-1e5, 1e5) * 100.0).round() as i64
}

/// Replaces the five characters that mean something in XML and drops control characters it forbids.
pub(super) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\n' | '\t' => out.push(' '),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => {}
            c => out.push(c),
        }
    }
    out
}

/// Width of text, user units: a rough upper estimate over the usual system fonts, since a file
/// drawn here may be shown with any of them.
pub(super) fn text_width(text: &str, size: f64) -> f64 {
    let em = |c: char| match c {
        'i' | 'j' | 'l' | '.' | ',' | ':' | ';' | '\'' | '|' | '!' | ' ' => 0.31,
        'f' | 't' | 'r' | '(' | ')' | '[' | ']' | '/' | '-' => 0.40,
        'm' | 'w' | 'M' | 'W' | '@' | '%' => 0.92,
        '⁰' | '¹' | '²' | '³' | '⁴'..='⁹' | '⁻' => 0.42,
        '−' | '±' | '×' => 0.68,
        c if c.is_ascii_digit() => 0.61,
        c if c.is_ascii_uppercase() => 0.70,
        c if c.is_ascii() => 0.58,
        c if (c as u32) < 0x1100 => 0.66,
        _ => 1.05,
    };
    size * text.chars().map(em).sum::<f64>()
}

/// Shortens text to a width by leaving out its middle, where names of files differ least.
pub(super) fn shorten(text: &str, size: f64, width: f64) -> String {
    // A width that was measured on this very text may have lost its last digit.
    if text_width(text, size) <= width + 1e-6 {
        return text.to_owned();
    }
    let characters: Vec<char> = text.chars().collect();
    let shortened = |kept: usize| {
        let head = kept / 2;
        let tail = &characters[characters.len() - (kept - head)..];
        characters[..head].iter().chain(&['…']).chain(tail).collect::<String>()
    };
    (0..characters.len())
        .rev()
        .map(shortened)
        .find(|candidate| text_width(candidate, size) <= width)
        .unwrap_or_else(|| "…".to_owned())
}

/// A title, which is bold, in lines of at most a width.
pub(super) fn title_lines(text: &str, width: f64) -> Vec<String> {
    /// How much wider bold letters are, at most.
    const BOLD: f64 = 1.12;
    wrap(text, BOLD * TITLE, width)
}

/// Breaks text into lines of at most a width, at spaces.
pub(super) fn wrap(text: &str, size: f64, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if text_width(&format!("{line} {word}"), size) <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_and_attributes_are_escaped() {
        let mut svg = Svg::default();
        svg.element("text").attribute("aria-label", "a\"<b>").text("<script>&'\u{0}\n");
        assert_eq!(
            svg.finish(),
            "<text aria-label=\"a&quot;&lt;b&gt;\">&lt;script&gt;&amp;&#39; </text>\n"
        );
    }

    #[test]
    fn coordinates_are_short_and_never_negative_zero() {
        let text: Vec<_> = [0.0, -0.001, 0.5, -0.25, 12.345, 7.1, -3.0, f64::INFINITY]
            .into_iter()
            .map(coordinate)
            .collect();
        assert_eq!(text, ["0", "0", ".5", "-.25", "12.35", "7.1", "-3", "100000"]);
    }

    #[test]
    fn long_names_lose_their_middle() {
        let short = shorten("press-12mm-at-20mm-per-s-take-3.csv", 13.0, 120.0);
        assert!(short.starts_with("press") && short.ends_with(".csv") && short.contains('…'));
        assert!(text_width(&short, 13.0) <= 120.0);
        assert_eq!(shorten("OA", 13.0, 120.0), "OA");
    }
}
