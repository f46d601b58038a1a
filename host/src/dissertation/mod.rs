//! The dissertation, chapter by chapter: what it prints beside what is computed here, its figures redrawn
//! in kind, its slips noted.
//!
//! Chia-Hung Dylan Tsai, *Nonlinear Modeling on Viscoelastic Contact Interface: Theoretical Study and
//! Experimental Validation* (doctoral dissertation).

mod appendices;
mod base_laws;
mod comparison;
mod creep;
mod grasp_stability;
mod latency;
mod loading_rates;
mod relaxation;
mod relaxation_tables;
mod segments;
mod simulated;
mod strain_rate;

pub use comparison::{Check, Comparison};
pub use relaxation_tables::{
    EQUATION_3_5, EQUATION_3_6, RelaxationRow, Statistic, TABLE_3_1, TABLE_3_2, TABLE_3_3,
    TABLE_3_4,
};

use crate::report::Section;

/// One chapter of the report: what a reader sees of it.
#[derive(Clone, Debug)]
pub struct Chapter {
    /// Printed figures beside those computed here.
    pub comparisons: Vec<Comparison>,
    /// Text, tables and figures.
    pub sections: Vec<Section>,
}

/// Every chapter, in the order of the text; computed side by side.
#[must_use]
pub fn chapters() -> Vec<Chapter> {
    use rayon::prelude::*;
    const CHAPTERS: [fn() -> Chapter; 9] = [
        base_laws::chapter,
        relaxation::chapter,
        latency::chapter,
        loading_rates::chapter,
        creep::chapter,
        grasp_stability::chapter,
        strain_rate::chapter,
        segments::chapter,
        appendices::chapter,
    ];
    CHAPTERS.par_iter().map(|chapter| chapter()).collect()
}
