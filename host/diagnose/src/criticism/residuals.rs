//! What a model leaves of a data set, sample by sample.

use std::borrow::Cow;

use super::covariate::Covariate;
use super::region::{Region, regions};
use palpate_fit::data::{Data, Piece};
use palpate_fit::whole_motion::predict;
use palpate_model::effects::{EffectError, chain_of};
use palpate_model::{Chain, Model};

/// Values of a quantity, stretch by stretch.
pub(crate) type Values<'a> = [Cow<'a, [f64]>];

/// A data set beside what a model predicts for it.
#[derive(Clone, Debug)]
pub struct Residuals<'a> {
    data: &'a Data<'a>,
    /// Predicted signal of each stretch.
    pub predicted: Vec<Vec<f64>>,
}

/// One stretch of a recording without a gap, against the model.
#[derive(Clone, Debug)]
pub struct Stretch {
    /// Which trace of the set it is from.
    pub trace: usize,
    /// Time of each sample, s.
    pub time: Vec<f64>,
    /// Displacement at each sample, mm.
    pub displacement: Vec<f64>,
    /// Measured signal.
    pub measured: Vec<f64>,
    /// Predicted signal.
    pub predicted: Vec<f64>,
    /// Region of each sample.
    pub regions: Vec<Region>,
}

impl<'a> Residuals<'a> {
    /// Runs a model over a data set.
    ///
    /// # Errors
    /// When the model has an effect that the data set does not know.
    pub fn of(model: &Model, data: &'a Data) -> Result<Self, EffectError> {
        let (chain, parameters) = chain_of(model, &data.setting())?;
        Ok(Self::new(&chain, &parameters, data))
    }

    /// Runs a chain over a data set.
    #[must_use]
    pub fn new(chain: &Chain, parameters: &[f64], data: &'a Data) -> Self {
        Self { data, predicted: predict(chain, parameters, data) }
    }

    /// Which trace of the set each stretch is from.
    pub fn traces(&self) -> impl Iterator<Item = usize> {
        self.data.pieces.iter().map(|piece| piece.trace)
    }

    /// Measured minus predicted, stretch by stretch.
    #[must_use]
    pub fn values(&self) -> Vec<Vec<f64>> {
        let left = |(piece, predicted): (&Piece, &Vec<f64>)| {
            piece.measured.iter().zip(predicted).map(|(y, f)| y - f).collect()
        };
        self.data.pieces.iter().zip(&self.predicted).map(left).collect()
    }

    /// The values of a quantity that the residual could depend on, stretch by stretch; none where it was not recorded everywhere.
    #[must_use]
    pub fn covariate(&self, covariate: Covariate) -> Option<Vec<Cow<'_, [f64]>>> {
        let pieces = self.data.pieces.iter().zip(&self.predicted);
        pieces.map(|(piece, f)| self.data.covariate(piece, f, covariate)).collect()
    }

    /// Every stretch, to be drawn.
    pub fn stretches(&self) -> impl ExactSizeIterator<Item = Stretch> {
        self.data.pieces.iter().zip(&self.predicted).map(stretch)
    }

    /// The stretches of one trace, to be drawn.
    #[must_use]
    pub fn of_trace(&self, trace: usize) -> Vec<Stretch> {
        let all = self.data.pieces.iter().zip(&self.predicted);
        all.filter(|(piece, _)| piece.trace == trace).map(stretch).collect()
    }
}

fn stretch((piece, predicted): (&Piece, &Vec<f64>)) -> Stretch {
    Stretch {
        trace: piece.trace,
        time: piece.recorded_time(),
        displacement: piece.motion.displacement.to_vec(),
        measured: piece.measured.to_vec(),
        predicted: predicted.clone(),
        regions: regions(&piece.motion.time, &piece.motion.displacement),
    }
}

impl Stretch {
    /// Measured minus predicted.
    #[must_use]
    pub fn residual(&self) -> Vec<f64> {
        self.measured.iter().zip(&self.predicted).map(|(y, f)| y - f).collect()
    }
}
