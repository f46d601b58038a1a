//! The elastic response from holds at several compressions, and with it a whole model.

use shared::phase::RelaxationType;

use super::exponentials::Parameter;
use super::hold::HoldFit;
use palpate_model::{BaseLaw, Model, Separation};

/// Why holds do not make a whole model.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum ElasticLawError {
    #[error(
        "holds at one compression only do not determine the elastic response N = p/(q+1) x^(q+1): add holds at another compression, or fit the whole motion (without --hold-only)"
    )]
    OneCompression,
    #[error("the holds were fitted with different numbers of exponentials: give --terms")]
    MixedTerms,
    #[error(
        "eq. 3.4 fits the holds with {coefficient} = {value}, which is not a relaxation: use --signs"
    )]
    NotARelaxation { coefficient: Parameter, value: f64 },
}

/// A model from Type I holds: N against compression gives p and q (a straight line in logarithms),
/// the coefficients are means over the holds with the standard errors of these means.
///
/// The force at the start of a hold has already relaxed during the ramp, so p is that of the ramps'
/// speed; a fit of the whole motion is free of this.
///
/// # Errors
/// When the holds are at one compression, differ in their number of exponentials, or do not relax.
pub fn model_of_holds(fits: &[HoldFit], signal: &str) -> Result<Model, ElasticLawError> {
    let holds: Vec<&HoldFit> =
        fits.iter().filter(|hold| hold.relaxation == RelaxationType::TypeI).collect();
    let terms = holds.first().ok_or(ElasticLawError::OneCompression)?.fit.sum.terms.len();
    if holds.iter().any(|hold| hold.fit.sum.terms.len() != terms) {
        return Err(ElasticLawError::MixedTerms);
    }
    let (p, q) = power_law(&holds).ok_or(ElasticLawError::OneCompression)?;
    let coefficients =
        (1..=terms).map(Parameter::Coefficient).chain((1..=terms).map(Parameter::Rate));
    let mut estimates = vec![p, q];
    for coefficient in coefficients {
        let values: Vec<f64> =
            holds.iter().filter_map(|hold| hold.fit.value(coefficient)).collect();
        let estimate = mean_with_error(&values);
        if estimate.0 < 0.0 {
            return Err(ElasticLawError::NotARelaxation { coefficient, value: estimate.0 });
        }
        estimates.push(estimate);
    }
    let (values, errors): (Vec<f64>, Vec<Option<f64>>) = estimates.into_iter().unzip();
    let law = BaseLaw::fung(terms, Separation::Clamp);
    Ok(Model::of(&law, signal, &values, &errors))
}

/// p and q, each with its standard error, from a straight line through (ln x, ln N).
#[allow(clippy::type_complexity)]
fn power_law(holds: &[&HoldFit]) -> Option<((f64, Option<f64>), (f64, Option<f64>))> {
    let points: Vec<(f64, f64)> = holds
        .iter()
        .filter_map(|hold| Some((hold.displacement?, hold.fit.sum.scale)))
        .filter(|(x, force)| *x > 0.0 && *force > 0.0)
        .map(|(x, force)| (x.ln(), force.ln()))
        .collect();
    let count = points.len() as f64;
    let mean_x = points.iter().map(|(x, _)| x).sum::<f64>() / count;
    let mean_y = points.iter().map(|(_, y)| y).sum::<f64>() / count;
    let square: f64 = points.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    // Compressions within 2 % of each other are one.
    if points.len() < 2 || (square / count).sqrt() < 0.02 {
        return None;
    }
    let slope = points.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum::<f64>() / square;
    let level = mean_y - slope * mean_x;
    let q = slope - 1.0;
    let p = slope * level.exp();
    let residual: f64 = points.iter().map(|(x, y)| (y - level - slope * x).powi(2)).sum();
    let errors = (points.len() > 2).then(|| {
        let variance = residual / (count - 2.0);
        // ln p = ln slope + level; level and slope correlate through the mean of ln x.
        let lever = 1.0 / slope - mean_x;
        (p * (variance * (1.0 / count + lever * lever / square)).sqrt(), (variance / square).sqrt())
    });
    Some(((p, errors.map(|e| e.0)), (q, errors.map(|e| e.1))))
}

fn mean_with_error(values: &[f64]) -> (f64, Option<f64>) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    let error = (values.len() > 1).then(|| (square / (count - 1.0) / count).sqrt());
    (mean, error)
}
