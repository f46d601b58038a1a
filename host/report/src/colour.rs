//! Colours, for light and dark: the palette of Okabe and Ito, adjusted so that every line has a
//! contrast of at least 3 : 1 and all text at least 4.5 : 1 with its background.

use std::fmt::Write as _;

/// Colour of a series. Hues differ in lightness as well, and each has its own dash pattern and marker,
/// so that nothing is told by colour alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// The colour of text: what was measured.
    Ink,
    /// Grey: context.
    Muted,
    /// One of the hues, in the order blue, vermilion, green, purple, amber, brown; counted round.
    Hue(usize),
}

impl Colour {
    /// A recorded signal.
    pub const MEASURED: Self = Self::Ink;
    /// What a model says.
    pub const MODEL: Self = Self::Hue(1);
    /// Measured minus model.
    pub const RESIDUAL: Self = Self::Hue(0);
    /// The fast-adapting part of a signal.
    pub const FA: Self = Self::Hue(1);
    /// The slowly adapting part of a signal.
    pub const SA: Self = Self::Hue(0);

    /// Style class of the colour.
    pub(super) fn class(self) -> String {
        match self {
            Self::Ink => "pl-ink".to_owned(),
            Self::Muted => "pl-grey".to_owned(),
            Self::Hue(hue) => format!("pl-c{}", hue % HUES),
        }
    }

    /// Dash pattern that goes with the colour, user units; empty for a solid line.
    pub(super) fn dashes(self) -> &'static str {
        match self {
            Self::Ink => "",
            Self::Muted => "1.5 2.5",
            Self::Hue(hue) => ["", "7 2.5", "3 2", "9 2.5 2 2.5", "5 2", "2 2 5 2"][hue % HUES],
        }
    }

    /// Number of the marker shape that goes with the colour.
    pub(super) fn marker(self) -> usize {
        match self {
            Self::Ink | Self::Muted => 0,
            Self::Hue(hue) => hue % HUES,
        }
    }
}

/// Number of hues.
const HUES: usize = 6;

/// Every colour by its name in the style sheets: light, dark.
const PALETTE: [(&str, &str, &str); 16] = [
    ("bg", "#ffffff", "#14171b"),
    ("ink", "#1b1f24", "#e4e7eb"),
    ("muted", "#59616b", "#a2abb6"),
    ("axis", "#6b737d", "#8b949f"),
    ("grid", "#e6e8eb", "#2a2f36"),
    ("span", "#eef2f6", "#1e242b"),
    ("line", "#c9ced4", "#3a414a"),
    ("heat", "#0072b2", "#56b4e9"),
    ("cold", "#d55e00", "#f0874a"),
    ("c0", "#0072b2", "#56b4e9"),
    ("c1", "#d55e00", "#f0874a"),
    ("c2", "#00875f", "#35c79a"),
    ("c3", "#b4558c", "#e39cc8"),
    ("c4", "#a87400", "#f0c04a"),
    ("c5", "#6d4c36", "#c9ab93"),
    ("panel", "#f6f7f9", "#1b1f24"),
];

/// Rules for everything inside a figure, with colours as variables.
pub(super) const FIGURE_CSS: &str = include_str!("figure.css");

/// Declarations of all colours as variables, one theme.
pub fn variables(dark: bool) -> String {
    PALETTE.iter().fold(String::new(), |mut css, (name, light, night)| {
        let _ = write!(css, "--{name}:{};", if dark { night } else { light });
        css
    })
}

/// Style sheet of a picture that stands alone: literal colours, because many viewers know no
/// variables, and the dark ones again for viewers that say they are dark.
pub(super) fn standalone_css() -> String {
    format!("{}@media (prefers-color-scheme:dark){{{}}}", literal_css(false), literal_css(true))
}

fn literal_css(dark: bool) -> String {
    PALETTE.iter().fold(FIGURE_CSS.to_owned(), |css, (name, light, night)| {
        css.replace(&format!("var(--{name})"), if dark { night } else { light })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn luminance(hex: &str) -> f64 {
        let channel = |at: usize| {
            let level = f64::from(u8::from_str_radix(&hex[at..at + 2], 16).unwrap()) / 255.0;
            if level <= 0.04045 { level / 12.92 } else { ((level + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5)
    }

    fn contrast(a: &str, b: &str) -> f64 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn text_reaches_4_5_to_1_and_lines_3_to_1_on_every_ground_in_both_themes() {
        let find = |name| PALETTE.iter().find(|(n, ..)| *n == name).unwrap();
        for ground in ["bg", "panel", "span"].map(find) {
            for text in ["ink", "muted"].map(find) {
                assert!(contrast(text.1, ground.1) >= 4.5, "{} on {}", text.0, ground.0);
                assert!(contrast(text.2, ground.2) >= 4.5, "{} on {}, dark", text.0, ground.0);
            }
            for line in ["c0", "c1", "c2", "c3", "c4", "c5", "axis"].map(find) {
                assert!(contrast(line.1, ground.1) >= 3.0, "{} on {}", line.0, ground.0);
                assert!(contrast(line.2, ground.2) >= 3.0, "{} on {}, dark", line.0, ground.0);
            }
        }
    }

    #[test]
    fn a_picture_that_stands_alone_has_no_variable_left() {
        let css = standalone_css();
        assert!(!css.contains("var("), "{css}");
        assert!(css.contains("prefers-color-scheme:dark"));
    }
}
