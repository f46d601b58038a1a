//! The dissertation, chapter by chapter: what it prints beside what is computed here, its figures redrawn
//! in kind, its slips noted.
//!
//! Chia-Hung Dylan Tsai, *Nonlinear Modeling on Viscoelastic Contact Interface: Theoretical Study and
//! Experimental Validation* (doctoral dissertation).

mod appendices;
mod base_laws;
mod comparison;
mod conclusions;
mod contact_mechanics;
mod creep;
mod figures;
mod force_control;
mod grasp_courses;
mod grasp_stability;
mod latency;
mod loading_rates;
mod markers;
mod motion;
mod relaxation;
mod relaxation_tables;
mod segments;
mod simulated;
mod strain_inside;
mod strain_rate;
mod tactile_sensor;
mod tally;

pub use comparison::{Check, Comparison, Evidence};
pub use figures::{Counterpart, counterparts};
pub use relaxation_tables::{
    EQUATION_3_5, RelaxationRow, Statistic, TABLE_3_1, TABLE_3_2, TABLE_3_3, TABLE_3_4,
};
pub use tally::{Tally, comparisons, tallies};

use rayon::prelude::*;

use palpate_contact::sensor::SensorError;
use palpate_report::Section;

/// One chapter of the report: what a reader sees of it.
#[derive(Clone, Debug)]
pub struct Chapter {
    /// Its number and subject.
    pub title: &'static str,
    /// Printed figures beside those computed here.
    pub comparisons: Vec<Comparison>,
    /// Text, tables and figures.
    pub sections: Vec<Section>,
}

/// Slips of the text: where, and what is right. Each is explained in its chapter.
pub const SLIPS: [(&str, &str); 9] = [
    ("4.2.2, footnote", "the equilibrium follows for t → ∞, not for t → 0"),
    ("4.4.3", "with force over displacement the loop that loses work runs clockwise, as in 6.4.2"),
    ("5.4.1", "ε = k_s σ in passing; eq. 5.7 has ε = σ/k_s"),
    (
        "Eq. 6.10",
        "x counts from the middle, over the half length: the pressure vanishes at the edge",
    ),
    ("Eqs 6.10 and 8.2", "C_k of eq. 8.2 is that of a round contact; the strip has its own"),
    ("Eq. 7.7 and 7.4", "d from one side there, d/2 on each face here"),
    (
        "Table A.1",
        "the last entry, 11628 s, is that of unrounded coefficients; the printed 8.5e-5 gives 11765 s",
    ),
    ("Table B.1, R²", "0.9162 for one exponential does not follow from the curves (B.1) and (B.2)"),
    ("Table B.1, n = 3", "v3 < v2, and neither is identifiable from 9.5 s of data"),
];

/// Why a chapter could not be computed: a fault of this program.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum ChapterError {
    #[error("8.2.1: {0}")]
    Sensor(#[from] SensorError),
    #[error("8.2.2: {0}")]
    Contact(#[from] contact_mechanics::ContactError),
}

/// Every chapter, in the order of the text; computed side by side.
///
/// # Errors
/// When a specimen cannot be simulated.
pub fn chapters() -> Result<Vec<Chapter>, ChapterError> {
    const CHAPTERS: [fn() -> Result<Chapter, ChapterError>; 12] = [
        || Ok(base_laws::chapter()),
        || Ok(relaxation::chapter()),
        || Ok(latency::chapter()),
        || Ok(loading_rates::chapter()),
        || Ok(creep::chapter()),
        || Ok(grasp_stability::chapter()),
        || Ok(strain_rate::chapter()),
        || Ok(segments::chapter()),
        || Ok(conclusions::chapter()),
        || Ok(tactile_sensor::chapter()?),
        || Ok(contact_mechanics::chapter()?),
        || Ok(appendices::chapter()),
    ];
    CHAPTERS.par_iter().map(|chapter| chapter()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_printed_figure_agrees_or_is_named_with_its_reason() {
        let chapters = chapters().unwrap();
        let comparisons = || chapters.iter().flat_map(|chapter| &chapter.comparisons);
        for comparison in comparisons() {
            let missed: Vec<&Check> = comparison.missed().collect();
            assert!(missed.is_empty(), "{}: {missed:#?}", comparison.source);
        }
        // What does not follow is named, not left out.
        for (source, kind) in [
            ("Table B.1, R² for n = 1", Evidence::NotReproduced),
            ("Eq. B.1", Evidence::NotReproduced),
            ("Fig. 6.10, length at last", Evidence::NotReproduced),
            ("Fig. 4.6 and Table 5.2", Evidence::NotReproduced),
            ("Eq. A.3", Evidence::NotReproduced),
            ("Eq. A.4", Evidence::NotReproduced),
            ("Table 3.1", Evidence::FoundAgain),
            ("Table 3.4", Evidence::Derived),
        ] {
            let found = comparisons().find(|comparison| comparison.source == source);
            assert_eq!(found.map(|found| found.evidence), Some(kind), "{source}");
        }
        // Nothing is left out by accident: 30 rows of 7 figures in Tables 3.1 to 3.3 alone.
        let count = |source: &str| {
            let of = comparisons().filter(|comparison| comparison.source == source);
            of.map(|comparison| comparison.checks.len()).sum::<usize>()
        };
        let tables = [
            ("Eqs 3.5–3.10", 21),
            ("Table 3.1", 70),
            ("Table 3.2", 70),
            ("Table 3.3", 70),
            ("Table 3.4", 30),
            ("Table 5.2", 4),
            ("Table 7.1", 10),
            ("Table 7.2", 10),
            ("Table 8.3", 6),
            ("Table A.1", 10),
            ("Table B.1", 15),
        ];
        for (table, figures) in tables {
            assert_eq!(count(table), figures, "{table}");
        }
    }
}
