//! What a model leaves of a data set, sample by sample, with everything it could depend on.

use super::covariate::{Covariate, acceleration, velocity};
use super::region::{Region, regions};
use crate::fit::data::{Data, Piece};
use crate::model::{Fung, Motion};
use crate::trace::{TEMPERATURE, Trace};

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

/// What a specimen has been through before a stretch begins.
#[derive(Clone, Copy, Default)]
struct History {
    loadings: u32,
    largest: f64,
}

/// Runs a law over a data set and lays its residuals beside everything they could depend on.
#[must_use]
pub fn stretches(law: &Fung, parameters: &[f64], data: &Data, traces: &[Trace]) -> Vec<Stretch> {
    let motions: Vec<Motion> = data.pieces.iter().map(|piece| piece.motion.clone()).collect();
    let predicted = law.predict(parameters, &motions);
    let begins = set_times(traces);
    let mut history = History::default();
    data.pieces
        .iter()
        .zip(predicted)
        .map(|(piece, predicted)| {
            let trace = &traces[piece.trace];
            stretch(piece, predicted, trace, begins[piece.trace], &mut history)
        })
        .collect()
}

/// When each trace began since the first, s: as the heads say, else one after the other.
fn set_times(traces: &[Trace]) -> Vec<f64> {
    let told: Option<Vec<f64>> = traces.iter().map(|trace| trace.head.setup.start_s).collect();
    told.unwrap_or_else(|| {
        let ends = traces.iter().scan(0.0, |end, trace| {
            let begin = *end;
            *end += trace.duration();
            Some(begin)
        });
        ends.collect()
    })
}

fn stretch(
    piece: &Piece,
    predicted: Vec<f64>,
    trace: &Trace,
    begin: f64,
    history: &mut History,
) -> Stretch {
    let motion = &piece.motion;
    let regions = regions(&motion.time, &motion.displacement);
    let velocity = velocity(motion);
    // A velocity within a hundredth of the fastest is rest.
    let fastest = velocity.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let direction =
        velocity.iter().map(|v| if v.abs() > 0.01 * fastest { v.signum() } else { 0.0 }).collect();
    let first = trace.time[0];
    let since = |time: &f64| time - first;
    let mut covariates = vec![
        (Covariate::Displacement, motion.displacement.clone()),
        (Covariate::Direction, direction),
        (Covariate::Acceleration, acceleration(motion)),
        (Covariate::Velocity, velocity),
        (Covariate::Force, predicted.clone()),
        (Covariate::Time, motion.time.iter().map(since).collect()),
        (Covariate::SetTime, motion.time.iter().map(|t| begin + since(t)).collect()),
    ];
    covariates.extend(past(motion, &regions, history));
    if let Some(temperature) = trace.column(TEMPERATURE) {
        let start = trace.time.partition_point(|time| *time < motion.time[0]);
        let values = temperature[start..start + motion.time.len()].to_vec();
        covariates.push((Covariate::Temperature, values));
    }
    Stretch {
        trace: piece.trace,
        time: motion.time.clone(),
        measured: piece.measured.clone(),
        predicted,
        regions,
        covariates,
    }
}

/// Loadings completed before and largest displacement so far; the history goes on to the next stretch.
fn past(motion: &Motion, regions: &[Region], history: &mut History) -> [(Covariate, Vec<f64>); 2] {
    let mut cycle = Vec::with_capacity(regions.len());
    let mut largest = Vec::with_capacity(regions.len());
    let mut loading = false;
    for (&x, &region) in motion.displacement.iter().zip(regions) {
        match region {
            Region::Loading => loading = true,
            // A loading is complete when it is undone.
            Region::Unloading if loading => {
                loading = false;
                history.loadings += 1;
            }
            _ => {}
        }
        history.largest = history.largest.max(x);
        cycle.push(f64::from(history.loadings));
        largest.push(history.largest);
    }
    [(Covariate::Cycle, cycle), (Covariate::Largest, largest)]
}
