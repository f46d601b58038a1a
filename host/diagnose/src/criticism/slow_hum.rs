//! A hum of the mains that looks like a slow swing: at 50 samples in a second, one of 50.05 Hz turns once in 20 s.

use palpate_fit::data::Data;
use palpate_fit::least_squares::Effort;
use palpate_fit::problem::Problem;
use palpate_model::Chain;
use palpate_model::effects::{Scales, shown};

use super::fitted::Fitted;
use super::hum::MAINS;
use super::noise::NoiseModel;
use super::outside::Outside;
use super::swing::Swing;

/// A hum that samples show as a slow swing through what a model leaves.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SlowHum {
    /// Its frequency, Hz.
    pub(super) frequency: f64,
    /// The frequency, Hz, as which the samples show it.
    pub(super) shown: f64,
    /// Interval between samples, s.
    pub(super) interval: f64,
    /// The lines near 50 and near 60 Hz, Hz, that it is one of.
    pub(super) mains: [f64; 2],
}

/// Part of the shortest interval between samples by which nine of ten others exceed it at most: in uneven samples no fast line looks slow.
const UNEVEN: f64 = 1e-3;

impl SlowHum {
    /// The hum that a model leaves in a data set; none where noise alone would show as much, or where samples show any hum as a fast line.
    pub(super) fn of(
        data: &Data,
        scales: &Scales,
        (chain, values): (&Chain, &[f64]),
        noise: &NoiseModel,
    ) -> Option<Self> {
        let interval = scales.common_interval;
        if interval > (1.0 + UNEVEN) * scales.interval
            || !MAINS.into_iter().any(|mains| Swing::looks_slow(mains, interval))
        {
            return None;
        }
        let problem = Problem::new(chain, data, &noise.whitening, None);
        let fitted = Fitted::new(&problem, &problem.point(values), Effort::QUICK);
        let line = |mains: f64| {
            let line = Swing::alias(&problem, &fitted, mains, interval);
            line.filter(|line| Outside::Swing(line.clone()).is_sure(1.0))
        };
        let found = (0..MAINS.len()).filter_map(|place| Some((place, line(MAINS[place])?)));
        let (place, line) = found.max_by(|a, b| a.1.gain.total_cmp(&b.1.gain))?;
        let frequency = line.frequency_hz;
        let mut mains = scales.mains.unwrap_or(MAINS);
        mains[place] = frequency;
        Some(Self { frequency, shown: shown(frequency, interval), interval, mains })
    }
}
