//! How many exponentials a hold shows.

use palpate_analysis::terms::{Row, Terms};
use serde::Serialize;

/// Fits with one to four exponentials, and which number the criteria choose.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct TermsAnswer {
    /// Number with the least Bayesian information criterion among those whose every term is identifiable.
    pub by_criterion: usize,
    /// Least number whose held-out error is within one standard error of the best; null where the samples are too few to hold
    /// any out.
    pub by_held_out: Option<usize>,
    /// The number that is used: the lesser of the two.
    pub decided: usize,
    /// A row for each number of exponentials, from 1.
    pub rows: Vec<NumberAnswer>,
}

/// A fit with one number of exponentials.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct NumberAnswer {
    /// Number of exponentials.
    pub exponentials: usize,
    /// Coefficient of determination.
    pub r_squared: f64,
    /// Bayesian information criterion; the least is the best.
    pub bic: f64,
    /// Root mean square error on blocks of samples that were left out of the fit, in the unit of the signal; null where the samples
    /// are too few.
    pub held_out_rms: Option<f64>,
    /// Root mean square error on the last third of the hold of a fit to the first two, in the unit of the signal; null where that
    /// cannot be fitted.
    pub forecast_rms: Option<f64>,
    /// Time constant of each exponential, s, fast first.
    pub time_constants_s: Vec<f64>,
    /// Whether every term is identifiable.
    pub identified: bool,
    /// What is held at a bound or not identifiable.
    pub notes: Vec<String>,
}

impl From<&Terms> for TermsAnswer {
    fn from(terms: &Terms) -> Self {
        Self {
            by_criterion: terms.by_criterion,
            by_held_out: terms.by_held_out,
            decided: terms.decided(),
            rows: terms.rows.iter().map(NumberAnswer::from).collect(),
        }
    }
}

impl From<&Row> for NumberAnswer {
    fn from(row: &Row) -> Self {
        let sum = &row.fit.sum;
        Self {
            exponentials: sum.terms.len(),
            r_squared: row.fit.r_squared,
            bic: row.bic,
            held_out_rms: row.held_out_rms,
            forecast_rms: row.forecast_rms,
            time_constants_s: sum.terms.iter().map(|term| 1.0 / term.rate).collect(),
            identified: row.identified,
            notes: row.fit.notes.iter().map(ToString::to_string).collect(),
        }
    }
}
