//! Every figure of the text: where its counterpart is drawn, or why there is none.
//!
//! Where a figure is drawn is not said here but found: a figure of the report that says "Fig. 6.3" in its title or caption is
//! the counterpart of Fig. 6.3.

use std::collections::BTreeSet;

use super::Chapter;
use palpate_report::{Block, Figure};

/// What becomes of a figure of the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Here {
    /// It is computed and drawn.
    Drawn,
    /// It is not, for this reason.
    Not(&'static str),
}

use Here::{Drawn, Not};

const PHOTO: &str = "a photograph of an apparatus";
const STILLS: &str = "photographs of a grasp; what was measured in it is Fig. 3.4";

/// Every figure of the text: number, subject, and what becomes of it.
pub const FIGURES: [(&str, &str, Here); 65] = [
    (
        "2.1",
        "Kelvin–Voigt model",
        Not(
            "a drawing of a spring and a damper; the law itself is drawn in chapter 2, over a press",
        ),
    ),
    (
        "2.2",
        "Maxwell model",
        Not(
            "a drawing of a spring and a damper; the law itself is drawn in chapter 2, over a press",
        ),
    ),
    ("3.1", "three phases of a grasp", Not(STILLS)),
    ("3.2", "the gripper", Not(PHOTO)),
    ("3.3", "three instants of a grasp", Not(STILLS)),
    ("3.4", "force over time at 4, 8 and 12 mm", Drawn),
    ("3.5", "a grasp of 12 mm", Drawn),
    ("3.6", "a grasp of 8 mm", Drawn),
    ("3.7", "a grasp of 4 mm", Drawn),
    ("3.8", "the fit to a hold", Drawn),
    ("3.9", "the fit and its asymptote", Drawn),
    ("3.10", "six regions of a grasp", Drawn),
    ("4.1", "the latency model, node by node", Drawn),
    ("4.2", "relaxation of Type I and Type II", Drawn),
    ("4.3", "strain rate over strain", Drawn),
    ("4.4", "a simulation with both types", Drawn),
    ("4.5", "the testing machine", Not(PHOTO)),
    ("4.6", "a gap between markers that opens in a hold", Drawn),
    ("4.7", "the force of that hold", Drawn),
    ("4.8", "loading and unloading by turns", Drawn),
    ("4.9", "its sequence in force over displacement", Drawn),
    ("4.10", "loops of Type II", Drawn),
    ("5.1", "gripper, camera and lights", Not(PHOTO)),
    ("5.2", "the gripper's motion and inertial force", Drawn),
    ("5.3", "the two silicones", Not("a photograph of the specimens")),
    ("5.4", "markers that move while the gripper stands", Drawn),
    ("5.5", "force, displacement and their loop", Drawn),
    ("5.6", "soft silicone at five rates", Drawn),
    ("5.7", "hard silicone at five rates", Drawn),
    ("5.8", "the soft one at the end of loading", Drawn),
    ("5.9", "the hard one at the end of loading", Drawn),
    ("5.10", "the soft one at the end of the hold", Drawn),
    ("5.11", "the hard one at the end of the hold", Drawn),
    (
        "5.12",
        "how a cylinder widens",
        Not("a drawing; the area of (5.5) that it explains is in every force of chapter 5"),
    ),
    ("5.13", "strain of the surface while it is loaded", Drawn),
    ("5.14", "strain of the surface while it is held", Drawn),
    ("5.15", "strain inside at a high and a low rate", Drawn),
    ("6.1", "gripper, camera and lights", Not(PHOTO)),
    (
        "6.2",
        "a block with four markers",
        Not("a photograph of the specimen; what its markers do is in Figs 6.3 and 6.4"),
    ),
    ("6.3", "creep after loading at 1.96 N/s", Drawn),
    ("6.4", "creep after loading at 2.71 N/s", Drawn),
    ("6.5", "4 N and 2 N by turns at 0.092 N/s", Drawn),
    ("6.6", "4 N and 2 N by turns at 0.85 N/s", Drawn),
    ("6.7", "creep of Type I and Type II", Drawn),
    ("6.8", "loops at several rates", Drawn),
    (
        "6.9",
        "a contact and its centre of rotation",
        Not("a drawing of the geometry; the surface that it explains is Fig. 6.10"),
    ),
    ("6.10", "the limit surface as the contact creeps", Drawn),
    ("7.1", "both types, and the linear law behind them", Drawn),
    ("7.2", "the nonlinear law", Drawn),
    ("7.3", "the testing machine", Not(PHOTO)),
    ("7.4", "a ball loaded and unloaded in steps", Drawn),
    ("7.5", "a ball between two jaws", Not("a drawing of the geometry of (7.7)")),
    ("7.6", "strain rate over strain of the ball", Drawn),
    ("7.7", "a ball in segments", Drawn),
    ("7.8", "the ball simulated", Drawn),
    ("8.1", "receptors of the skin", Not("a drawing from anatomy")),
    ("8.2", "how the tactile sensor is made", Not("photographs of a mould")),
    (
        "8.3",
        "a sharp and a blunt indenter",
        Not("a drawing of two tips; here they have radii of 0.5 and 5 mm"),
    ),
    ("8.4", "a gauge under both", Drawn),
    ("8.5", "the cochlea", Not("a drawing from anatomy")),
    ("8.6", "the atomic force microscope", Not("a drawing of the principle")),
    ("8.7", "pressure for several k", Drawn),
    ("8.8", "the latency model as the contact of a tip", Drawn),
    ("A.1", "one to four exponentials in a relaxation", Drawn),
    ("B.1", "one to three exponentials in a creep", Drawn),
];

/// What stands in the report for a figure of the text.
#[derive(Clone, Debug, PartialEq)]
pub struct Counterpart {
    /// Number of the figure of the text.
    pub number: &'static str,
    /// What it shows.
    pub subject: &'static str,
    /// The chapters and the titles or captions of the figures of the report that redraw it.
    pub drawn: Vec<(&'static str, String)>,
    /// Why nothing does.
    pub reason: Option<&'static str>,
}

/// The counterparts that the chapters hold, figure by figure.
#[must_use]
pub fn counterparts(chapters: &[Chapter]) -> Vec<Counterpart> {
    let drawn: Vec<(&'static str, String, BTreeSet<String>)> = chapters
        .iter()
        .flat_map(|chapter| {
            let blocks = chapter.sections.iter().flat_map(|section| &section.blocks);
            blocks.filter_map(|block| {
                let Block::Figure { figure, caption } = block else { return None };
                let title = title(figure);
                let mut numbers = mentioned(title);
                numbers.extend(mentioned(caption));
                let words = if title.is_empty() { caption.as_str() } else { title };
                Some((chapter.title, first_sentence(words), numbers))
            })
        })
        .collect();
    let of = |(number, subject, here): &(&'static str, &'static str, Here)| {
        let here_drawn = drawn
            .iter()
            .filter(|(_, _, numbers)| *here == Drawn && numbers.contains(*number))
            .map(|(chapter, words, _)| (*chapter, words.clone()));
        let mut drawn: Vec<_> = here_drawn.collect();
        drawn.dedup();
        Counterpart {
            number,
            subject,
            drawn,
            reason: match here {
                Drawn => None,
                Not(reason) => Some(reason),
            },
        }
    };
    FIGURES.iter().map(of).collect()
}

fn title(figure: &Figure) -> &str {
    match figure {
        Figure::Plot(plot) => &plot.title,
        Figure::Panels(panels) => &panels.title,
        _ => "",
    }
}

/// Up to the colon or full stop that ends the first sentence; not those of "Fig." and of numbers.
fn first_sentence(text: &str) -> String {
    let end = text.find(": ").into_iter().chain(
        text.match_indices(". ").find_map(|(at, _)| (!text[..at].ends_with("Fig")).then_some(at)),
    );
    end.min().map_or(text, |end| &text[..end]).trim_end_matches('.').to_owned()
}

/// The numbers of figures that a text names: "Fig. 3.4", "Figs 4.4 and 4.8", "Figs 5.6–5.9".
fn mentioned(text: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for (at, _) in text.match_indices("Fig") {
        let mut rest = text[at + 3..].trim_start_matches(['s', '.', ' ']);
        let mut last: Option<String> = None;
        let mut through = false;
        while let Some((number, after)) = number(rest) {
            if let Some(first) = last.filter(|_| through) {
                found.extend(between(&first, &number));
            }
            found.insert(number.clone());
            last = Some(number);
            rest = after;
            // The part of a figure, "(a)".
            if rest.starts_with('(') {
                rest = rest.find(')').map_or(rest, |end| &rest[end + 1..]);
            }
            through = rest.starts_with('–');
            let joined = ["–", ", ", " and "].iter().find_map(|by| rest.strip_prefix(by));
            let Some(next) = joined else { break };
            rest = next;
        }
    }
    found
}

/// A number such as 3.10 or A.1 at the beginning of a text, and what follows it.
fn number(text: &str) -> Option<(String, &str)> {
    let (chapter, after) = text.split_once('.')?;
    let known =
        matches!(chapter, "A" | "B") || (chapter.len() == 1 && chapter.parse::<u8>().is_ok());
    let digits = after.bytes().take_while(u8::is_ascii_digit).count();
    (known && digits > 0).then(|| (format!("{chapter}.{}", &after[..digits]), &after[digits..]))
}

/// The numbers from one figure to another of its chapter.
fn between(first: &str, last: &str) -> Vec<String> {
    let parts = |number: &str| -> Option<(String, u32)> {
        let (chapter, figure) = number.split_once('.')?;
        Some((chapter.to_owned(), figure.parse().ok()?))
    };
    match (parts(first), parts(last)) {
        (Some((chapter, from)), Some((other, to))) if chapter == other => {
            (from..=to).map(|figure| format!("{chapter}.{figure}")).collect()
        }
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dissertation::chapters;

    #[test]
    fn numbers_of_figures_are_read_from_a_caption() {
        let set = |numbers: &[&str]| numbers.iter().map(|it| (*it).to_owned()).collect();
        for (text, numbers) in [
            ("Fig. 7.8 in kind: the run of Fig. 7.4(a).", &["7.8", "7.4"][..]),
            ("Figs 4.2, 4.4 and 4.8 in kind, v1 of Table 5.2", &["4.2", "4.4", "4.8"]),
            ("Figs 5.6–5.9", &["5.6", "5.7", "5.8", "5.9"]),
            ("(Figs 3.5, 3.10)", &["3.5", "3.10"]),
            ("Fig. A.1: eq. 6.10 at 5.3 N", &["A.1"]),
            ("Eq. 6.10 with k = 4", &[]),
        ] {
            assert_eq!(mentioned(text), set(numbers), "{text}");
        }
        assert_eq!(first_sentence("Fig. 5.2 in kind. Then more."), "Fig. 5.2 in kind");
    }

    #[test]
    fn every_figure_of_the_text_has_its_counterpart_or_a_reason() {
        // Figures of each chapter, counted in the text.
        let chapters_of_text = [
            ("2", 2),
            ("3", 10),
            ("4", 10),
            ("5", 15),
            ("6", 10),
            ("7", 8),
            ("8", 8),
            ("A", 1),
            ("B", 1),
        ];
        let all: Vec<String> = chapters_of_text
            .iter()
            .flat_map(|(chapter, count)| (1..=*count).map(move |k| format!("{chapter}.{k}")))
            .collect();
        assert_eq!(FIGURES.map(|figure| figure.0.to_owned()).to_vec(), all);
        let found = counterparts(&chapters().unwrap());
        for figure in found {
            assert!(
                figure.reason.is_some() == figure.drawn.is_empty(),
                "{figure:?}: drawn, or a reason, and not both"
            );
        }
    }

    #[test]
    fn every_plot_of_the_report_has_axes_with_names() {
        for chapter in chapters().unwrap() {
            for block in chapter.sections.iter().flat_map(|section| &section.blocks) {
                let Block::Figure { figure, caption } = block else { continue };
                let plots = match &**figure {
                    Figure::Plot(plot) => std::slice::from_ref(plot),
                    Figure::Panels(panels) => &panels.plots[..],
                    _ => &[],
                };
                for plot in plots {
                    let named = !plot.x.label.is_empty() && !plot.y.label.is_empty();
                    assert!(named, "{}: {} {caption}", chapter.title, plot.title);
                }
            }
        }
    }
}
