//! The dissertation, chapter by chapter: what it prints beside what is computed here, its figures redrawn
//! in kind, its slips noted.
//!
//! Chia-Hung Dylan Tsai, *Nonlinear Modeling on Viscoelastic Contact Interface: Theoretical Study and
//! Experimental Validation* (doctoral dissertation).

mod comparison;
pub mod contact_mechanics;
pub mod grasp_stability;
mod relaxation_tables;
pub mod tactile_sensor;

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
