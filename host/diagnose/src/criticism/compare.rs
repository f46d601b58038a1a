//! A model against a data set: where it is wrong.

use super::adequacy::{LEVEL, adequacy};
use super::covariate::Covariate;
use super::dependence::{Dependence, dependences};
use super::leftover::Leftover;
use super::noise::{noise_model, told};
use super::region::{Region, regions};
use super::residuals::Residuals;
use palpate_fit::data::{Data, DataError, Piece};
use palpate_fit::problem::Problem;
use palpate_model::Model;
use palpate_model::effects::chain_of;
use palpate_trace::{Noise, Trace};

/// The error of a model in one region of one trace.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Which trace of the set.
    pub trace: usize,
    /// Which region.
    pub region: Region,
    /// Number of samples.
    pub samples: usize,
    /// Root mean square of the residual, in the unit of the signal.
    pub rms: f64,
    /// Share of all that is left beyond the noise, 0 to 1; of all that is left where the noise is
    /// not known; 0 where nothing but noise is left.
    pub share_of_excess: f64,
}

/// A model against a data set.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Names of the traces, in order of recording.
    pub labels: Vec<String>,
    /// The column compared.
    pub signal: String,
    /// Noise of the signal, where the recordings tell.
    pub noise: Option<Noise>,
    /// Whether nothing but noise is left: the error is at the noise and wanders no more than it.
    pub only_noise: bool,
    /// Root mean square of the residual over all samples.
    pub rms: f64,
    /// Root mean square of the residual of each trace.
    pub trace_rms: Vec<f64>,
    /// The error in every region of every trace that has samples there.
    pub cells: Vec<Cell>,
    /// What the residual depends on, strongest first.
    pub dependences: Vec<Dependence>,
    /// Stretches that could not be compared, in words.
    pub left_out: Vec<String>,
}

/// Why a model cannot be compared with traces.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum CompareError {
    #[error("{0}")]
    Model(String),
    #[error(transparent)]
    Data(#[from] DataError),
}

/// A residual that is as white as the noise counts as noise within this many times its size.
const CLOSE: f64 = 1.1;
/// The same where nothing but the size of the noise is known.
const NOISE_ONLY: f64 = 1.03;
/// Chance below which a dependence is worth a word.
const TOLD: f64 = 0.01;

/// Compares a model with the traces of a data set, in order of recording.
///
/// # Errors
/// When the model is not usable or a trace lacks its signal or a motion.
pub fn compare(model: &Model, traces: &[Trace]) -> Result<Comparison, CompareError> {
    let data = Data::of_model(model, traces)?;
    Ok(compared(model, traces, &data)?.comparison)
}

/// The same with what the model leaves at each sample of the traces' data set.
///
/// # Errors
/// When the model is not usable.
pub fn compared<'a>(
    model: &Model,
    traces: &[Trace],
    data: &'a Data,
) -> Result<Leftover<'a>, CompareError> {
    let (chain, parameters) =
        chain_of(model, &data.setting()).map_err(|error| CompareError::Model(error.to_string()))?;
    let residuals = Residuals::new(&chain, &parameters, data);
    let seen = noise_model(data);
    let noise = told(seen.as_ref(), traces, &model.base.signal);
    let mut cells = cells(data, &residuals, noise.map_or(0.0, |noise| noise.standard_deviation));
    let only_noise = match (&seen, noise) {
        (Some(seen), Some(noise)) => {
            let problem = Problem::new(&chain, data, &seen.whitening, None);
            let found = adequacy(&problem, &problem.point(&parameters), &seen.whitening);
            found.p_value >= LEVEL && found.rms < CLOSE * found.louder * noise.standard_deviation
        }
        (None, Some(noise)) => rms(cells.iter()) < NOISE_ONLY * noise.standard_deviation,
        _ => false,
    };
    if only_noise {
        // There is nothing beyond the noise to share out.
        cells.iter_mut().for_each(|cell| cell.share_of_excess = 0.0);
    }
    let comparison = Comparison {
        rms: rms(cells.iter()),
        trace_rms: trace_rms(&cells, data.labels.len()),
        dependences: dependences(&residuals),
        labels: data.labels.clone(),
        signal: data.signal.clone(),
        noise,
        only_noise,
        cells,
        left_out: data.left_out.clone(),
    };
    Ok(Leftover { comparison, residuals })
}

/// Root mean square over cells.
fn rms<'a>(cells: impl Iterator<Item = &'a Cell>) -> f64 {
    let (square, samples) = cells.fold((0.0, 0.0), |(square, samples), cell| {
        let count = cell.samples as f64;
        (square + cell.rms * cell.rms * count, samples + count)
    });
    if samples > 0.0 { (square / samples).sqrt() } else { 0.0 }
}

/// The same for each trace.
pub(super) fn trace_rms(cells: &[Cell], traces: usize) -> Vec<f64> {
    let of_trace = |trace| cells.iter().filter(move |cell| trace == cell.trace);
    (0..traces).map(|trace| rms(of_trace(trace))).collect()
}

/// The error in every region of every trace.
pub(super) fn cells(data: &Data, left: &Residuals, noise: f64) -> Vec<Cell> {
    let mut sums = Sums::new(data.labels.len());
    for (piece, predicted) in data.pieces.iter().zip(&left.predicted) {
        sums.add(piece, predicted);
    }
    sums.cells(noise)
}

/// The error in every region of every trace of a problem at a point, stretch by stretch.
#[must_use]
pub fn cells_of(problem: &Problem, point: &[f64], noise: f64) -> Vec<Cell> {
    let mut sums = Sums::new(problem.data().labels.len());
    problem.each_piece(&[point.to_vec()], |piece, forces| sums.add(piece, &forces[0]));
    sums.cells(noise)
}

/// Sums of squares and numbers of samples, by trace and region.
struct Sums(Vec<[(f64, usize); Region::ALL.len()]>);

impl Sums {
    fn new(traces: usize) -> Self {
        Self(vec![[(0.0, 0); Region::ALL.len()]; traces])
    }

    fn add(&mut self, piece: &Piece, predicted: &[f64]) {
        let regions = regions(&piece.motion.time, &piece.motion.displacement);
        for ((region, measured), predicted) in
            regions.into_iter().zip(piece.measured).zip(predicted)
        {
            let (square, samples) = &mut self.0[piece.trace][region as usize];
            *square += (measured - predicted).powi(2);
            *samples += 1;
        }
    }

    fn cells(&self, noise: f64) -> Vec<Cell> {
        let mut cells = Vec::new();
        for (trace, regions) in self.0.iter().enumerate() {
            for (region, &(square, samples)) in Region::ALL.into_iter().zip(regions) {
                if samples > 0 {
                    let rms = (square / samples as f64).sqrt();
                    cells.push(Cell { trace, region, samples, rms, share_of_excess: 0.0 });
                }
            }
        }
        let excess =
            |cell: &Cell| ((cell.rms * cell.rms - noise * noise) * cell.samples as f64).max(0.0);
        let total: f64 = cells.iter().map(excess).sum();
        if total > 0.0 {
            for cell in &mut cells {
                cell.share_of_excess = excess(cell) / total;
            }
        }
        cells
    }
}

impl Comparison {
    /// Share of what is left beyond the noise in each region, largest first.
    #[must_use]
    pub fn by_region(&self) -> Vec<(Region, f64)> {
        let share = |region: Region| {
            let cells = self.cells.iter().filter(|cell| cell.region == region);
            (region, cells.map(|cell| cell.share_of_excess).sum())
        };
        let mut found: Vec<(Region, f64)> = Region::ALL.into_iter().map(share).collect();
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        found
    }

    /// How many times the noise the residual is, where the noise is known.
    #[must_use]
    pub fn over_noise(&self) -> Option<f64> {
        self.noise.map(|noise| self.rms / noise.standard_deviation)
    }

    /// Where the model fails and what the failure depends on, in a sentence or two.
    #[must_use]
    pub fn in_words(&self) -> String {
        if self.only_noise {
            return "Nothing but noise is left.".into();
        }
        let beyond = if self.noise.is_some() { " beyond the noise" } else { "" };
        let regions = self.by_region();
        let (first, share) = regions[0];
        let mut text =
            format!("{:.0} % of what is left{beyond} sits {}", 100.0 * share, first.place());
        let (second, share) = regions[1];
        if share > 0.15 {
            text += &format!(", {:.0} % {}", 100.0 * share, second.place());
        }
        text += ".";
        let told: Vec<String> = self
            .dependences
            .iter()
            .filter(|dependence| dependence.p_value <= TOLD && dependence.explained > 0.05)
            .take(3)
            .map(dependence_in_words)
            .collect();
        if told.is_empty() {
            text + " It depends on none of the quantities tried, beyond chance."
        } else {
            format!("{text} It {}.", told.join("; it "))
        }
    }
}

fn dependence_in_words(dependence: &Dependence) -> String {
    let covariate = dependence.covariate;
    let verb = match dependence.trend {
        _ if covariate == Covariate::Direction => "flips with the",
        trend if trend > 0.7 => "grows with the",
        trend if trend < -0.7 => "falls with the",
        _ => "varies with the",
    };
    format!(
        "{verb} {} {} ({:.0} % of it)",
        covariate.name(),
        covariate.symbol(),
        100.0 * dependence.explained
    )
}
