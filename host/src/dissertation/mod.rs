//! The dissertation, chapter by chapter: what it prints beside what is computed here, its figures redrawn
//! in kind, its slips noted.
//!
//! Chia-Hung Dylan Tsai, *Nonlinear Modeling on Viscoelastic Contact Interface: Theoretical Study and
//! Experimental Validation* (doctoral dissertation).

mod appendices;
mod base_laws;
mod comparison;
mod contact_mechanics;
mod creep;
mod grasp_stability;
mod latency;
mod loading_rates;
mod relaxation;
mod relaxation_tables;
mod segments;
mod simulated;
mod strain_rate;
mod tactile_sensor;

pub use comparison::{Check, Comparison};
pub use relaxation_tables::{
    EQUATION_3_5, EQUATION_3_6, RelaxationRow, Statistic, TABLE_3_1, TABLE_3_2, TABLE_3_3,
    TABLE_3_4,
};

use rayon::prelude::*;

use crate::report::Section;
use crate::sensor::SensorError;

/// One chapter of the report: what a reader sees of it.
#[derive(Clone, Debug)]
pub struct Chapter {
    /// Printed figures beside those computed here.
    pub comparisons: Vec<Comparison>,
    /// Text, tables and figures.
    pub sections: Vec<Section>,
}

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
    const CHAPTERS: [fn() -> Result<Chapter, ChapterError>; 11] = [
        || Ok(base_laws::chapter()),
        || Ok(relaxation::chapter()),
        || Ok(latency::chapter()),
        || Ok(loading_rates::chapter()),
        || Ok(creep::chapter()),
        || Ok(grasp_stability::chapter()),
        || Ok(strain_rate::chapter()),
        || Ok(segments::chapter()),
        || Ok(tactile_sensor::chapter()?),
        || Ok(contact_mechanics::chapter()?),
        || Ok(appendices::chapter()),
    ];
    CHAPTERS.par_iter().map(|chapter| chapter()).collect()
}
