//! Relaxation during the holds of a recording (eq. 3.4), one fit for each hold.

use std::ops::Range;

use shared::phase::RelaxationType;

use super::exponentials::{
    self, Fit, MOST_TERMS, Normalisation, Options, Parameter, Prepared, Row, Sign,
};
use crate::trace::{DISPLACEMENT, SignalError, Trace, holds};

/// The relaxation of one hold.
#[derive(Clone, Debug)]
pub struct HoldFit {
    /// Name of the trace.
    pub trace: String,
    /// Samples of the hold in the trace.
    pub range: Range<usize>,
    /// When it began, s.
    pub from_s: f64,
    /// How long it lasted, s.
    pub duration_s: f64,
    /// Displacement during the hold, mm, where it was recorded.
    pub displacement: Option<f64>,
    /// Which way the signal went (4.2.1): Type I falls towards its equilibrium, Type II rises.
    pub relaxation: RelaxationType,
    /// Eq. 3.4 with its parameters.
    pub fit: Fit,
    /// The fits with one to four exponentials among which this one was chosen; empty where the
    /// number was given.
    pub candidates: Vec<Row>,
}

/// How many exponentials to fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Terms {
    /// So many.
    Fixed(usize),
    /// As many as the data show (appendix A).
    Auto,
}

/// Why a hold cannot be fitted.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum HoldError {
    #[error(transparent)]
    Signal(#[from] SignalError),
    #[error("{trace}: the hold from {from_s:.3} s: {source}")]
    Fit { trace: String, from_s: f64, source: exponentials::Error },
}

/// Fits every hold of a trace, in order.
///
/// With `signs`, every ci has the sign of its type and c0 is not negative; otherwise only Σ c = 1.
///
/// # Errors
/// When the trace lacks the signal or a hold, or a hold is too short or constant.
pub fn fit_holds(
    trace: &Trace,
    signal: &str,
    terms: Terms,
    signs: bool,
) -> Result<Vec<HoldFit>, HoldError> {
    let values = trace.changing(signal)?;
    let ranges = holds(trace, signal)?;
    ranges.into_iter().map(|range| fit_hold(trace, values, range, terms, signs)).collect()
}

fn fit_hold(
    trace: &Trace,
    values: &[f64],
    range: Range<usize>,
    terms: Terms,
    signs: bool,
) -> Result<HoldFit, HoldError> {
    let (time, values) = (&trace.time[range.clone()], &values[range.clone()]);
    let from_s = time[0];
    let failed = |source| HoldError::Fit { trace: trace.label(), from_s, source };
    let trend = trend(values);
    let options = options(terms, if signs { Some(trend) } else { None });
    let prepared = Prepared::new(time, &options).map_err(failed)?;
    let (fit, candidates) = match terms {
        Terms::Fixed(_) => (prepared.fit(values).map_err(failed)?, Vec::new()),
        Terms::Auto => {
            let compared = prepared.compare_terms(values).map_err(failed)?;
            (compared.best().clone(), compared.rows)
        }
    };
    let relaxation = direction(&fit).unwrap_or(trend);
    let displacement = trace.column(DISPLACEMENT).map(|x| mean(&x[range.clone()]));
    let duration_s = time[time.len() - 1] - from_s;
    let trace = trace.label();
    Ok(HoldFit { trace, range, from_s, duration_s, displacement, relaxation, fit, candidates })
}

fn options(terms: Terms, signs: Option<RelaxationType>) -> Options {
    let terms = match terms {
        Terms::Fixed(terms) => terms,
        Terms::Auto => MOST_TERMS,
    };
    let (sign, constant_sign) = match signs {
        None | Some(RelaxationType::None) => (Sign::Free, Sign::Free),
        Some(RelaxationType::TypeI) => (Sign::NotNegative, Sign::NotNegative),
        Some(RelaxationType::TypeII) => (Sign::NotPositive, Sign::NotNegative),
    };
    let normalisation = Normalisation::Initial;
    Options { terms, sign, constant_sign, normalisation, ..Options::default() }
}

/// Which way the signal goes from its first tenth to its last.
fn trend(values: &[f64]) -> RelaxationType {
    let tenth = (values.len() / 10).max(1);
    let first = mean(&values[..tenth]);
    let last = mean(&values[values.len() - tenth..]);
    // A tension recorded as negative numbers relaxes upwards, towards zero.
    let falls = if first + last >= 0.0 { last <= first } else { last >= first };
    if falls { RelaxationType::TypeI } else { RelaxationType::TypeII }
}

/// Which way the fitted function goes, where its terms agree.
fn direction(fit: &Fit) -> Option<RelaxationType> {
    let terms = &fit.sum.terms;
    if terms.iter().all(|term| term.coefficient >= 0.0) {
        Some(RelaxationType::TypeI)
    } else if terms.iter().all(|term| term.coefficient <= 0.0) {
        Some(RelaxationType::TypeII)
    } else {
        None
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// One coefficient over the holds at one compression: Table 3.4.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// Displacement of the holds, mm, where it was recorded.
    pub displacement: Option<f64>,
    /// The coefficient.
    pub parameter: Parameter,
    /// Number of holds.
    pub holds: usize,
    /// Mean over the holds.
    pub mean: f64,
    /// Sample standard deviation (n − 1) over the holds.
    pub deviation: f64,
    /// Root mean square of the standard errors: how much scatter the noise alone would make.
    pub expected: Option<f64>,
}

/// Holds count as repeats when their displacements differ by less than this, relatively.
const SAME_DISPLACEMENT: f64 = 0.02;

/// Mean and scatter of every coefficient over the Type I holds at the same compression, two or more.
#[must_use]
pub fn spreads(fits: &[HoldFit]) -> Vec<Spread> {
    let mut groups: Vec<Vec<&HoldFit>> = Vec::new();
    for fit in fits.iter().filter(|fit| fit.relaxation == RelaxationType::TypeI) {
        let same = |group: &&mut Vec<&HoldFit>| alike(group[0], fit);
        match groups.iter_mut().find(same) {
            Some(group) => group.push(fit),
            None => groups.push(vec![fit]),
        }
    }
    groups.retain(|group| group.len() > 1);
    groups.iter().flat_map(|group| group_spreads(group)).collect()
}

fn alike(a: &HoldFit, b: &HoldFit) -> bool {
    let same_place = match (a.displacement, b.displacement) {
        (Some(a), Some(b)) => (a - b).abs() <= SAME_DISPLACEMENT * a.abs().max(b.abs()),
        (None, None) => true,
        _ => false,
    };
    same_place && a.fit.sum.terms.len() == b.fit.sum.terms.len()
}

fn group_spreads(group: &[&HoldFit]) -> Vec<Spread> {
    let holds = group.len();
    let spread = |parameter| {
        let values: Vec<f64> = group.iter().filter_map(|hold| hold.fit.value(parameter)).collect();
        let errors: Option<Vec<f64>> =
            group.iter().map(|hold| hold.fit.standard_error(parameter)).collect();
        let mean = mean(&values);
        let square: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        Spread {
            displacement: group[0].displacement,
            parameter,
            holds,
            mean,
            deviation: (square / (holds - 1) as f64).sqrt(),
            expected: errors.map(|errors| {
                (errors.iter().map(|error| error * error).sum::<f64>() / holds as f64).sqrt()
            }),
        }
    };
    group[0].fit.parameters().map(spread).collect()
}
