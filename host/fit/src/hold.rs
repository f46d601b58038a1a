//! Relaxation (eq. 3.4) or creep (eq. 6.2) during the holds of a recording, one fit for each hold.

use std::ops::Range;

use shared::phase::RelaxationType;

use super::consistency::{Consistency, consistency};
use super::exponentials::{
    self, Fit, MOST_TERMS, Normalisation, Options, Parameter, Prepared, Row, Sign,
};
use palpate_trace::{DISPLACEMENT, SignalError, Trace, holds};

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
    /// Which way the signal went (4.2.1, 6.4.2): Type I relaxes down or creeps up towards its
    /// equilibrium, Type II the other way.
    pub relaxation: RelaxationType,
    /// Eq. 3.4, or 6.2 for creep, with its parameters.
    pub fit: Fit,
    /// The fits with one to four exponentials among which this one was chosen; empty where the
    /// number was given.
    pub candidates: Vec<Row>,
}

/// What answers to what is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Response {
    /// Force to a held displacement: Σ c = 1, N is the value at the start of the hold (3.3).
    Relaxation,
    /// Displacement to a held force: c0 = 1, N is the value after infinite time (6.2).
    Creep,
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

/// What came of the holds of a recording.
#[derive(Debug)]
pub struct Holds<Found> {
    /// The holds that could be fitted, in order.
    pub holds: Vec<Found>,
    /// Why others could not: too short, or constant.
    pub left_out: Vec<HoldError>,
}

impl<Found> Holds<Found> {
    /// Sorts what came of each; an error where nothing could be fitted.
    pub fn of(each: impl IntoIterator<Item = Result<Found, HoldError>>) -> Result<Self, HoldError> {
        let (mut holds, mut left_out) = (Vec::new(), Vec::new());
        for one in each {
            match one {
                Ok(found) => holds.push(found),
                Err(error) => left_out.push(error),
            }
        }
        if holds.is_empty() && !left_out.is_empty() {
            return Err(left_out.swap_remove(0));
        }
        Ok(Self { holds, left_out })
    }
}

/// Fits the relaxation of every hold of a trace, in order.
///
/// With `signs`, every ci has the sign of its type and c0 is not negative; otherwise only Σ c = 1.
///
/// # Errors
/// When the trace lacks the signal or a hold, or every hold is too short or constant.
pub fn fit_holds(
    trace: &Trace,
    signal: &str,
    terms: Terms,
    signs: bool,
) -> Result<Holds<HoldFit>, HoldError> {
    fit_responses(trace, signal, Response::Relaxation, terms, signs)
}

/// Fits the relaxation or creep of every hold of a trace, in order; `signs` as for [`fit_holds`], for
/// creep (6.3) and (6.4).
///
/// # Errors
/// As [`fit_holds`].
pub fn fit_responses(
    trace: &Trace,
    signal: &str,
    response: Response,
    terms: Terms,
    signs: bool,
) -> Result<Holds<HoldFit>, HoldError> {
    let values = trace.changing(signal)?;
    let ranges = holds(trace, signal)?;
    let sense = sense(values);
    let fit = |range| fit_hold(trace, values, sense, range, response, terms, signs);
    Holds::of(ranges.into_iter().map(fit))
}

fn fit_hold(
    trace: &Trace,
    values: &[f64],
    sense: f64,
    range: Range<usize>,
    response: Response,
    terms: Terms,
    signs: bool,
) -> Result<HoldFit, HoldError> {
    let (time, values) = (&trace.elapsed(range.clone())[..], &values[range.clone()]);
    let from_s = trace.time[range.start];
    let failed = |source| HoldError::Fit { trace: trace.label(), from_s, source };
    // Signs are relative to the signal in this hold, the type is relative to the whole recording: a
    // force that crosses zero after unloading still rises.
    let shrinks = falls(values);
    let against = mean(values) * sense < 0.0;
    let trend = response.of_fall(shrinks != against);
    let signs = signs.then(|| response.of_fall(shrinks));
    let options = response.options(terms, signs);
    let prepared = Prepared::for_one(time, &options).map_err(failed)?;
    let (fit, candidates) = match terms {
        Terms::Fixed(_) => {
            let fit = prepared.fit(values).map_err(failed)?;
            (fit.allowing_for_correlation(time, values), Vec::new())
        }
        Terms::Auto => {
            let compared = prepared.compare_terms(values).map_err(failed)?;
            let compared = compared.allowing_for_correlation(time, values);
            (compared.best().clone(), compared.rows)
        }
    };
    let relaxation = direction(&fit, sense).map_or(trend, |falls| response.of_fall(falls));
    let displacement = trace.column(DISPLACEMENT).map(|x| mean(&x[range.clone()]));
    let duration_s = time[time.len() - 1];
    let trace = trace.label();
    Ok(HoldFit { trace, range, from_s, duration_s, displacement, relaxation, fit, candidates })
}

impl Response {
    /// What to fit to a hold; with a type, the signs that go with it.
    #[must_use]
    pub fn options(self, terms: Terms, signs: Option<RelaxationType>) -> Options {
        let terms = match terms {
            Terms::Fixed(terms) => terms,
            Terms::Auto => MOST_TERMS,
        };
        let (falling, rising) = (Sign::NotNegative, Sign::NotPositive);
        let sign = match (signs, self) {
            (None | Some(RelaxationType::None), _) => Sign::Free,
            (Some(RelaxationType::TypeI), Self::Relaxation)
            | (Some(RelaxationType::TypeII), Self::Creep) => falling,
            (Some(RelaxationType::TypeII), Self::Relaxation)
            | (Some(RelaxationType::TypeI), Self::Creep) => rising,
        };
        let constant_sign = if sign == Sign::Free { Sign::Free } else { Sign::NotNegative };
        let normalisation = match self {
            Self::Relaxation => Normalisation::Initial,
            Self::Creep => Normalisation::Asymptotic,
        };
        Options { terms, sign, constant_sign, normalisation, ..Options::default() }
    }

    /// The type of a signal that falls, in size, or rises.
    fn of_fall(self, falls: bool) -> RelaxationType {
        if falls == (self == Self::Relaxation) {
            RelaxationType::TypeI
        } else {
            RelaxationType::TypeII
        }
    }
}

/// Whether the size of the signal falls from its first tenth to its last.
fn falls(values: &[f64]) -> bool {
    let tenth = (values.len() / 10).max(1);
    let first = mean(&values[..tenth]);
    let last = mean(&values[values.len() - tenth..]);
    // A tension recorded as negative numbers relaxes upwards, towards zero.
    if first + last >= 0.0 { last <= first } else { last >= first }
}

/// +1 or −1: the sign of the largest value by size.
fn sense(values: &[f64]) -> f64 {
    values
        .iter()
        .copied()
        .fold(0.0, |most: f64, v| if v.abs() > most.abs() { v } else { most })
        .signum()
}

/// Whether the fitted function falls, seen in the sense of the recording, where its terms agree.
fn direction(fit: &Fit, sense: f64) -> Option<bool> {
    let terms = &fit.sum.terms;
    let sense = sense * fit.sum.scale.signum();
    if terms.iter().all(|term| sense * term.coefficient >= 0.0) {
        Some(true)
    } else if terms.iter().all(|term| sense * term.coefficient <= 0.0) {
        Some(false)
    } else {
        None
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// One coefficient over the holds of one type at one level: Table 3.4.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// What was held, where it was recorded: displacement, mm, or for creep force, N.
    pub level: Option<f64>,
    /// Type of the holds.
    pub relaxation: RelaxationType,
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
    /// Whether the holds differ by more than their standard errors explain.
    pub consistency: Option<Consistency>,
}

/// Holds count as repeats when what was held differs by less than this, relatively.
const SAME_LEVEL: f64 = 0.02;

/// Mean and scatter of every coefficient over the holds of one type at the same compression, two or more.
#[must_use]
pub fn spreads(fits: &[HoldFit]) -> Vec<Spread> {
    spreads_by(fits, |hold| hold.displacement)
}

/// As [`spreads`], over the holds at the same level of any quantity.
#[must_use]
pub fn spreads_by(fits: &[HoldFit], level: impl Fn(&HoldFit) -> Option<f64>) -> Vec<Spread> {
    let mut groups: Vec<Vec<&HoldFit>> = Vec::new();
    for fit in fits {
        let same = |group: &&mut Vec<&HoldFit>| {
            alike(group[0], fit) && same_level(level(group[0]), level(fit))
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.push(fit),
            None => groups.push(vec![fit]),
        }
    }
    groups.retain(|group| group.len() > 1);
    groups.iter().flat_map(|group| group_spreads(group, level(group[0]))).collect()
}

fn alike(a: &HoldFit, b: &HoldFit) -> bool {
    a.relaxation == b.relaxation && a.fit.sum.terms.len() == b.fit.sum.terms.len()
}

fn same_level(a: Option<f64>, b: Option<f64>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() <= SAME_LEVEL * a.abs().max(b.abs()),
        (None, None) => true,
        _ => false,
    }
}

fn group_spreads(group: &[&HoldFit], level: Option<f64>) -> Vec<Spread> {
    let holds = group.len();
    let spread = |parameter| {
        let values: Vec<f64> = group.iter().filter_map(|hold| hold.fit.value(parameter)).collect();
        let errors: Option<Vec<f64>> =
            group.iter().map(|hold| hold.fit.standard_error(parameter)).collect();
        let mean = mean(&values);
        let square: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        Spread {
            level,
            relaxation: group[0].relaxation,
            parameter,
            holds,
            mean,
            deviation: (square / (holds - 1) as f64).sqrt(),
            expected: errors.as_ref().map(|errors| {
                (errors.iter().map(|error| error * error).sum::<f64>() / holds as f64).sqrt()
            }),
            consistency: errors.and_then(|errors| consistency(&values, &errors)),
        }
    };
    group[0].fit.parameters().map(spread).collect()
}
