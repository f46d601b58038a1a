//! What a model leaves of a data set, sample by sample, with everything it could depend on.

use super::covariate::Covariate;
use super::region::{Region, regions};
use palpate_fit::data::{Data, Piece};
use palpate_fit::whole_motion::predict;
use palpate_model::Chain;

/// One stretch of a recording without a gap, against the model.
#[derive(Clone, Debug)]
pub struct Stretch {
    /// Which trace of the set it is from.
    pub trace: usize,
    /// Time of each sample, s.
    pub time: Vec<f64>,
    /// Measured signal.
    pub measured: Vec<f64>,
    /// Predicted signal.
    pub predicted: Vec<f64>,
    /// Region of each sample.
    pub regions: Vec<Region>,
    /// The covariates that these recordings have, with one value for each sample.
    pub covariates: Vec<(Covariate, Vec<f64>)>,
}

impl Stretch {
    /// Measured minus predicted.
    #[must_use]
    pub fn residual(&self) -> Vec<f64> {
        self.measured.iter().zip(&self.predicted).map(|(y, f)| y - f).collect()
    }

    /// The values of a covariate, where these recordings have it.
    #[must_use]
    pub fn covariate(&self, wanted: Covariate) -> Option<&[f64]> {
        self.covariates.iter().find(|(known, _)| *known == wanted).map(|(_, values)| &values[..])
    }
}

/// Runs a chain over a data set and lays its residuals beside everything they could depend on.
#[must_use]
pub fn stretches(chain: &Chain, parameters: &[f64], data: &Data) -> Vec<Stretch> {
    let predicted = predict(chain, parameters, data);
    data.pieces
        .iter()
        .zip(predicted)
        .map(|(piece, predicted)| stretch(piece, predicted, data))
        .collect()
}

fn stretch(piece: &Piece, predicted: Vec<f64>, data: &Data) -> Stretch {
    let scene = data.scene(piece);
    let time = piece.recorded_time();
    // A velocity within a hundredth of the fastest is rest.
    let fastest = scene.velocity.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let direction = |v: &f64| if v.abs() > 0.01 * fastest { v.signum() } else { 0.0 };
    let mut covariates = vec![
        (Covariate::Displacement, piece.motion.displacement.to_vec()),
        (Covariate::Direction, scene.velocity.iter().map(direction).collect()),
        (Covariate::SetTime, (0..scene.len()).map(|k| scene.set_time(k)).collect()),
        (Covariate::Acceleration, scene.acceleration.into_owned()),
        (Covariate::Velocity, scene.velocity.into_owned()),
        (Covariate::Force, predicted.clone()),
        (Covariate::Time, scene.since.into_owned()),
        (Covariate::Cycle, scene.loadings.into_owned()),
        (Covariate::Largest, scene.largest.into_owned()),
    ];
    if let Some(warmth) = scene.warmth {
        let reference = data.reference_temperature.unwrap_or_default();
        let temperature = warmth.iter().map(|value| value + reference).collect();
        covariates.push((Covariate::Temperature, temperature));
    }
    Stretch {
        trace: piece.trace,
        regions: regions(&piece.motion.time, &piece.motion.displacement),
        time,
        measured: piece.measured.to_vec(),
        predicted,
        covariates,
    }
}
