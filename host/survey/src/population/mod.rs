//! What the specimens of a survey have in common, and how much they differ: one model over all of them.
//!
//! The first stage is the survey: each group fitted by itself. The second is here: restricted maximum likelihood over the estimates
//! with their standard errors (`spread.rs`), and their correlations over the specimens (`correlations.rs`). It is the two-stage form of
//! a mixed model, good where each group determines its own parameters; estimates without a standard error are left out.

mod correlations;
mod effects;
mod spread;

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use self::correlations::{Estimated, correlations};
use self::spread::{Known, together};
use super::overview::{Overview, Since};
use super::results::About;
use super::row::{Asked, Estimate, Row, Status};

pub use effects::EffectInAll;
pub use spread::{Between, Spread};

/// Chance of saying of anything that it varies, or of any effect that it is there, where none does and none is.
pub const LEVEL: f64 = 0.05;
/// Relative standard error above which a value is not modelled by its logarithm.
const MOST_RELATIVE: f64 = 0.5;
/// Fewest specimens that say something of a population.
pub const FEWEST: usize = 3;
/// Fewest specimens for each parameter that correlations are told of.
const FEWEST_FOR_CORRELATIONS: usize = 10;

/// What the rows of a survey say of the population that their specimens come from.
#[derive(Clone, Debug)]
pub struct Population {
    /// Number of specimens with an answer.
    pub specimens: usize,
    /// Number of groups with an answer.
    pub groups: usize,
    /// The key that tells occasions of the same specimen apart.
    pub occasions: Option<String>,
    /// Every number with standard errors in enough specimens.
    pub parameters: Vec<InAll>,
    /// Correlations over the specimens between those that vary; none where the survey does not tell them.
    pub correlations: Option<Correlations>,
    /// Effects that are missing, of a survey of diagnoses.
    pub effects: Vec<EffectInAll>,
    /// What was left out, with the reason.
    pub left_out: Vec<(String, &'static str)>,
}

/// One number over the population.
#[derive(Clone, Debug)]
pub struct InAll {
    /// What it is: its name, with the effect that it is of.
    pub name: String,
    /// Its unit; empty for a pure number.
    pub unit: String,
    /// Number of specimens that have it with a standard error.
    pub specimens: usize,
    /// Number of groups.
    pub groups: usize,
    /// Whether the logarithm of the values is taken as normal: then the spreads are parts of the typical value.
    pub relative: bool,
    /// The value of a typical specimen with its 95 % interval.
    pub typical: Between,
    /// How much specimens differ: a standard deviation, in its unit, or relative.
    pub spread: Spread,
    /// How much a specimen differs from one occasion to another; none where each was asked once.
    pub occasions: Option<Spread>,
    /// Root mean square of the standard errors of single groups, as the spreads are told.
    pub error: f64,
    /// Whether the specimens differ in it, at [`LEVEL`] over all numbers (Holm).
    pub varies: bool,
}

/// Correlations over the specimens.
#[derive(Clone, Debug)]
pub struct Correlations {
    /// Names, in the order of the matrix.
    pub order: Vec<String>,
    /// The matrix.
    pub matrix: DMatrix<f64>,
    /// Number of specimens.
    pub specimens: usize,
}

/// One number of a group.
struct Cell<'a> {
    row: usize,
    estimate: &'a Estimate,
}

impl Population {
    /// The population of these rows.
    #[must_use]
    pub fn of(about: &About, rows: &[Row]) -> Self {
        let overview = overview_of(about, rows);
        let specimen: Vec<String> = (0..rows.len()).map(|row| overview.specimen(row)).collect();
        let done: Vec<usize> =
            (0..rows.len()).filter(|&row| rows[row].status == Status::Done).collect();
        let count = |rows: &[usize]| {
            let mut names: Vec<&str> = rows.iter().map(|&row| specimen[row].as_str()).collect();
            names.sort_unstable();
            names.dedup();
            names.len()
        };
        let (mut parameters, mut left_out) = (Vec::new(), Vec::new());
        for (name, cells) in kinds(rows, &done) {
            match in_all(&name, &cells, &specimen) {
                Ok(found) => parameters.push(found),
                Err(reason) => left_out.push((name, reason)),
            }
        }
        let chances: Vec<f64> = parameters.iter().map(|it| it.spread.p_value).collect();
        let varies = holm(&chances, LEVEL);
        parameters.iter_mut().zip(varies).for_each(|(it, varies)| it.varies = varies);
        let once = count(&done) == done.len();
        Self {
            specimens: count(&done),
            groups: done.len(),
            occasions: overview.order().filter(|_| !once).map(str::to_owned),
            correlations: once.then(|| over_specimens(rows, &done, &parameters)).flatten(),
            effects: match about.asked {
                Asked::Diagnose => effects::in_all(&overview, done.len(), count(&done)),
                _ => Vec::new(),
            },
            parameters,
            left_out,
        }
    }
}

fn overview_of(about: &About, rows: &[Row]) -> Overview {
    let mut overview = Overview::new(about);
    rows.iter().for_each(|row| overview.add(row, super::Worked { seconds: 0.0, attempts: 1 }));
    overview.finish();
    overview
}

/// The numbers by what they are, in the order in which they came.
fn kinds<'a>(rows: &'a [Row], done: &[usize]) -> Vec<(String, Vec<Cell<'a>>)> {
    let mut places: BTreeMap<String, usize> = BTreeMap::new();
    let mut found: Vec<(String, Vec<Cell>)> = Vec::new();
    for &row in done {
        for estimate in &rows[row].said.estimates {
            let place = *places.entry(estimate.kind()).or_insert_with_key(|kind| {
                found.push((kind.clone(), Vec::new()));
                found.len() - 1
            });
            found[place].1.push(Cell { row, estimate });
        }
    }
    found
}

/// Whether values with these standard errors are modelled by their logarithm.
fn is_relative(known: &[(f64, f64)]) -> bool {
    known.iter().all(|(value, error)| *value > 0.0 && *error < MOST_RELATIVE * value)
}

fn in_all(name: &str, cells: &[Cell], specimen: &[String]) -> Result<InAll, &'static str> {
    let known: Vec<(usize, f64, f64)> = cells
        .iter()
        .filter_map(|cell| Some((cell.row, cell.estimate.value, cell.estimate.standard_error?)))
        .filter(|(_, value, error)| value.is_finite() && error.is_finite() && *error > 0.0)
        .collect();
    if known.is_empty() {
        return Err("without standard errors");
    }
    let relative =
        is_relative(&known.iter().map(|(_, value, error)| (*value, *error)).collect::<Vec<_>>());
    let scaled = |value: f64, error: f64| match relative {
        true => Known { value: value.ln(), variance: (error / value).powi(2) },
        false => Known { value, variance: error * error },
    };
    let mut by_specimen: BTreeMap<&str, Vec<Known>> = BTreeMap::new();
    for (row, value, error) in &known {
        by_specimen.entry(&specimen[*row]).or_default().push(scaled(*value, *error));
    }
    let specimens: Vec<Vec<Known>> = by_specimen.into_values().collect();
    if specimens.len() < FEWEST {
        return Err("in fewer than three specimens");
    }
    let found = together(&specimens).ok_or("the same in all specimens")?;
    let back = |value: f64| if relative { value.exp() } else { value };
    let mean = found.mean;
    let variances = specimens.iter().flatten().map(|known| known.variance).sum::<f64>();
    Ok(InAll {
        name: name.to_owned(),
        unit: cells[0].estimate.unit.clone(),
        specimens: specimens.len(),
        groups: known.len(),
        relative,
        typical: Between {
            value: back(mean.value),
            lower: back(mean.lower),
            upper: back(mean.upper),
        },
        spread: found.specimens,
        occasions: found.occasions,
        error: (variances / known.len() as f64).sqrt(),
        varies: false,
    })
}

/// Which of several chances are below the level that is held over all of them (Holm 1979).
fn holm(chances: &[f64], level: f64) -> Vec<bool> {
    let mut order: Vec<usize> = (0..chances.len()).collect();
    order.sort_by(|&a, &b| chances[a].total_cmp(&chances[b]));
    let mut below = vec![false; chances.len()];
    for (place, index) in order.into_iter().enumerate() {
        if chances[index] > level / (chances.len() - place) as f64 {
            break;
        }
        below[index] = true;
    }
    below
}

/// Correlations between what varies, of the specimens whose fits tell those of their estimates.
fn over_specimens(rows: &[Row], done: &[usize], parameters: &[InAll]) -> Option<Correlations> {
    let varying: Vec<&InAll> = parameters.iter().filter(|it| it.varies).collect();
    if varying.len() < 2 {
        return None;
    }
    let specimens: Vec<Estimated> =
        done.iter().filter_map(|&row| estimated(&rows[row], &varying)).collect();
    if specimens.len() < FEWEST_FOR_CORRELATIONS * varying.len() {
        return None;
    }
    Some(Correlations {
        order: varying.iter().map(|it| it.name.clone()).collect(),
        matrix: correlations(&specimens)?,
        specimens: specimens.len(),
    })
}

/// The estimates of a row with their covariance, as they are modelled.
fn estimated(row: &Row, wanted: &[&InAll]) -> Option<Estimated> {
    let all = &row.said.estimates;
    let places: Vec<usize> = wanted
        .iter()
        .map(|it| all.iter().position(|estimate| estimate.kind() == it.name))
        .collect::<Option<_>>()?;
    let scale = |k: usize| if wanted[k].relative { 1.0 / all[places[k]].value } else { 1.0 };
    let errors: Vec<f64> = (0..wanted.len())
        .map(|k| Some(all[places[k]].standard_error? * scale(k)))
        .collect::<Option<_>>()?;
    let mut covariance = DMatrix::zeros(wanted.len(), wanted.len());
    for i in 0..wanted.len() {
        for j in 0..wanted.len() {
            let correlation = row.said.correlation_of(places[i], places[j])?;
            covariance[(i, j)] = correlation * errors[i] * errors[j];
        }
    }
    let value = |k: usize| match wanted[k].relative {
        true => all[places[k]].value.ln(),
        false => all[places[k]].value,
    };
    let values = DVector::from_fn(wanted.len(), |k, _| value(k));
    values.iter().all(|value| value.is_finite()).then_some(Estimated { values, covariance })
}

#[cfg(test)]
mod tests;
