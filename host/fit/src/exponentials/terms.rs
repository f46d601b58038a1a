//! How many exponentials: fits with one to four terms side by side, and a criterion that decides
//! (appendices A and B).

use super::fit::{Fit, Note, Parameter};

/// Standard errors that a coefficient must be away from 0 to count as identified.
pub const SIGNIFICANCE: f64 = 2.0;

/// The fit with one number of terms.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The fit; its sum of squares, R² and parameters are what appendix A lists.
    pub fit: Fit,
    /// Bayesian information criterion, m ln(RSS / m) + k ln m for m samples and k free
    /// parameters: the smaller the better; differences above 10 are very strong evidence. Where the fit
    /// allows for the correlation of neighbours, m is reduced to m (1 − ρ)/(1 + ρ), ρ the least
    /// correlation that any number of terms leaves.
    pub bic: f64,
    /// Whether the data tell every term: none is at a bound, vanishes or coincides with another,
    /// and every coefficient is at least [`SIGNIFICANCE`] standard errors from 0.
    pub identified: bool,
}

/// Fits with one to four terms to one trace.
#[derive(Clone, Debug, PartialEq)]
pub struct Terms {
    /// One row for each number of terms, from 1.
    pub rows: Vec<Row>,
    /// Number of terms with the lowest criterion among the identified; 1 where none is.
    pub chosen: usize,
}

impl Terms {
    pub(super) fn new(fits: Vec<Fit>) -> Self {
        // One count of independent samples for all, from the fit that leaves least to correlate.
        let neighbours = |fit: &Fit| fit.correlated.as_ref().map(|c| c.neighbours);
        let neighbours = fits.iter().filter_map(neighbours).fold(f64::INFINITY, f64::min);
        let neighbours = if neighbours.is_finite() { neighbours.clamp(0.0, 0.999) } else { 0.0 };
        let share = (1.0 - neighbours) / (1.0 + neighbours);
        let rows: Vec<Row> = fits.into_iter().map(|fit| Row::new(fit, share)).collect();
        let best = rows.iter().filter(|row| row.identified).min_by(|a, b| a.bic.total_cmp(&b.bic));
        let chosen = best.map_or(1, |row| row.fit.sum.terms.len());
        Self { rows, chosen }
    }

    /// The fit with the chosen number of terms.
    #[must_use]
    pub fn best(&self) -> &Fit {
        &self.rows[self.chosen - 1].fit
    }
}

impl Terms {
    /// The same with standard errors and a criterion that allow for the correlation of residuals with
    /// their neighbours ([`Fit::allowing_for_correlation`]).
    #[must_use]
    pub fn allowing_for_correlation(self, times: &[f64], values: &[f64]) -> Self {
        let allowing = |row: Row| row.fit.allowing_for_correlation(times, values);
        Self::new(self.rows.into_iter().map(allowing).collect())
    }
}

impl Row {
    /// The row of a fit of which this share of the samples counts as independent.
    fn new(fit: Fit, share: f64) -> Self {
        let samples = fit.samples as f64 * share;
        // A perfect fit has no logarithm; rounding is as small as a sum of squares can be.
        let rss = fit.rss.max(f64::MIN_POSITIVE);
        let bic = samples * (rss / samples).ln() + fit.free as f64 * samples.ln();
        let held = fit.notes.iter().any(|note| *note != Note::ScaleNearZero);
        let terms = 1..=fit.sum.terms.len();
        let significant = terms.map(Parameter::Coefficient).all(|parameter| {
            let value = fit.value(parameter).unwrap_or(0.0).abs();
            fit.standard_error(parameter).is_some_and(|error| value >= SIGNIFICANCE * error)
        });
        Self { fit, bic, identified: !held && significant }
    }
}
