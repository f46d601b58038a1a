//! `palpate dissertation`: every printed figure beside the one computed here.

use serde::Serialize;

use super::finite;
use crate::dissertation::{
    Chapter, Check, Comparison, Counterpart, Evidence, Tally, comparisons, counterparts, tallies,
};

/// The dissertation recomputed.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct DissertationAnswer {
    /// Version of this answer.
    pub palpate_dissertation: u32,
    /// How the figures of each kind of evidence came out.
    pub kinds: Vec<EvidenceTally>,
    /// Printed figures beside those computed here, in the order of the text.
    pub comparisons: Vec<PrintedComparison>,
    /// The figures of the text and where they are drawn again.
    pub figures: Vec<PrintedFigure>,
}

/// What the agreement of a computed figure with a printed one shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum EvidenceKind {
    /// The figure follows from other printed numbers.
    Derived,
    /// It was fed into a rebuilt or simulated recording and found again in it.
    FoundAgain,
    /// The model was fitted to the printed figures themselves.
    Fitted,
    /// The text says it in words, without a number.
    Said,
    /// It does not follow, or its recording was not published.
    NotReproduced,
}

/// How the figures of one kind of evidence came out.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct EvidenceTally {
    /// The kind of evidence.
    pub evidence: EvidenceKind,
    /// Number of figures.
    pub figures: usize,
    /// Number of these that agree within half of the last printed digit.
    pub within_half_of_the_last_digit: usize,
    /// Number of these that agree within what is allowed.
    pub agree: usize,
    /// What their agreement shows.
    pub shows: String,
}

/// Printed figures of one place, beside those computed here.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct PrintedComparison {
    /// Where the figures are printed.
    pub printed_in: String,
    /// The kind of evidence.
    pub evidence: EvidenceKind,
    /// What is allowed, or why they are not reproduced.
    pub reason: String,
    /// Each figure.
    pub checks: Vec<PrintedNumber>,
}

/// A printed number beside the one computed here.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct PrintedNumber {
    /// The quantity.
    pub quantity: String,
    /// Its unit; empty for a pure number.
    pub unit: String,
    /// The number as it is printed.
    pub printed: f64,
    /// One unit of its last printed digit.
    pub last_digit: f64,
    /// The number as it is computed here; null where it cannot be.
    pub recomputed: Option<f64>,
    /// How far the two may lie apart.
    pub allowed: f64,
    /// Whether they lie no farther apart.
    pub agrees: bool,
}

/// A figure of the text.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct PrintedFigure {
    /// Its number.
    pub figure: String,
    /// What it shows.
    pub of: String,
    /// Where it is drawn again; empty where it is not.
    pub drawn: Vec<DrawnFigure>,
    /// Why it is not drawn again; null where it is.
    pub reason: Option<String>,
}

/// A figure of the report that draws one of the text again.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct DrawnFigure {
    /// Its chapter in the report.
    pub chapter: String,
    /// Its title or caption.
    pub figure: String,
}

impl DissertationAnswer {
    /// What the chapters say together.
    #[must_use]
    pub fn of(chapters: &[Chapter]) -> Self {
        Self {
            palpate_dissertation: 1,
            kinds: tallies(chapters).iter().map(EvidenceTally::from).collect(),
            comparisons: comparisons(chapters).map(PrintedComparison::from).collect(),
            figures: counterparts(chapters).into_iter().map(PrintedFigure::from).collect(),
        }
    }
}

impl From<Evidence> for EvidenceKind {
    fn from(evidence: Evidence) -> Self {
        match evidence {
            Evidence::Derived => Self::Derived,
            Evidence::FoundAgain => Self::FoundAgain,
            Evidence::Fitted => Self::Fitted,
            Evidence::Said => Self::Said,
            Evidence::NotReproduced => Self::NotReproduced,
        }
    }
}

impl From<&Tally> for EvidenceTally {
    fn from(tally: &Tally) -> Self {
        Self {
            evidence: tally.evidence.into(),
            figures: tally.figures,
            within_half_of_the_last_digit: tally.exact,
            agree: tally.agree,
            shows: tally.evidence.shows().to_owned(),
        }
    }
}

impl From<&Comparison> for PrintedComparison {
    fn from(comparison: &Comparison) -> Self {
        Self {
            printed_in: comparison.source.to_owned(),
            evidence: comparison.evidence.into(),
            reason: comparison.reason.clone(),
            checks: comparison.checks.iter().map(PrintedNumber::from).collect(),
        }
    }
}

impl From<&Check> for PrintedNumber {
    fn from(check: &Check) -> Self {
        Self {
            quantity: check.quantity.clone(),
            unit: check.unit.to_owned(),
            printed: check.printed,
            last_digit: check.digit,
            recomputed: finite(check.recomputed),
            allowed: check.tolerance,
            agrees: check.agrees(),
        }
    }
}

impl From<Counterpart> for PrintedFigure {
    fn from(figure: Counterpart) -> Self {
        let drawn =
            |(chapter, figure): (&str, String)| DrawnFigure { chapter: chapter.to_owned(), figure };
        Self {
            figure: figure.number.to_owned(),
            of: figure.subject.to_owned(),
            drawn: figure.drawn.into_iter().map(drawn).collect(),
            reason: figure.reason.map(ToOwned::to_owned),
        }
    }
}
