//! How the printed figures came out, by the kind of evidence.

use super::{Chapter, Check, Comparison, Evidence};

/// How the figures of one kind of evidence came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tally {
    /// The kind of evidence.
    pub evidence: Evidence,
    /// Number of figures.
    pub figures: usize,
    /// Within half of the last printed digit.
    pub exact: usize,
    /// Within what is allowed.
    pub agree: usize,
}

/// The comparisons of all chapters, in the order of the text.
pub fn comparisons(chapters: &[Chapter]) -> impl Iterator<Item = &Comparison> {
    chapters.iter().flat_map(|chapter| &chapter.comparisons)
}

/// The kinds of evidence that the chapters have.
#[must_use]
pub fn tallies(chapters: &[Chapter]) -> Vec<Tally> {
    let of = |evidence: Evidence| {
        let checks = || {
            comparisons(chapters)
                .filter(move |comparison| comparison.evidence == evidence)
                .flat_map(|comparison| &comparison.checks)
        };
        let count = |passes: fn(&Check) -> bool| checks().filter(|check| passes(check)).count();
        Tally {
            evidence,
            figures: checks().count(),
            exact: count(Check::is_exact),
            agree: count(Check::agrees),
        }
    };
    Evidence::ALL.map(of).into_iter().filter(|tally| tally.figures > 0).collect()
}
