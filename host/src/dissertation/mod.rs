//! The figures that the dissertation prints, by the number of their table or equation.
//!
//! Chia-Hung Dylan Tsai, *Nonlinear Modeling on Viscoelastic Contact Interface: Theoretical Study and
//! Experimental Validation* (doctoral dissertation).

mod relaxation_tables;

pub use relaxation_tables::{
    EQUATION_3_5, EQUATION_3_6, RelaxationRow, Statistic, TABLE_3_1, TABLE_3_2, TABLE_3_3,
    TABLE_3_4,
};
