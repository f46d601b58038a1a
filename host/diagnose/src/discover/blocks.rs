//! Means on which a search goes as far as on all samples: what changes within a block must be noise.

use crate::criticism::fitted::Fitted;
use crate::criticism::noise::NoiseModel;
use palpate_fit::least_squares::LeastSquares;
use palpate_fit::means::Means;
use palpate_fit::problem::Problem;
use palpate_fit::whitening::Whitening;

/// How fine the blocks are that are tried in turn, and the part of the noise that what a model leaves may add to it within them: finer
/// ones are the last before all samples.
const BLOCKS: [(f64, f64); 2] = [(1.0, 0.06), (4.0, 0.2)];
/// Part by which sums of squares over means and over samples may differ.
const APART: f64 = 0.04;

/// The means on which a search goes as far as on all samples: those within whose blocks there is no more than noise.
pub(super) fn of(samples: &Problem, base: &Fitted, noise: &NoiseModel) -> Option<Means> {
    // What a model leaves is no measure of what is within blocks: where it stands for the noise, the scatter of neighbours is.
    let white = Whitening::none();
    let plain =
        (!noise.is_known()).then(|| Problem::new(samples.chain, samples.data(), &white, None));
    BLOCKS.into_iter().find_map(|(finer, hidden)| {
        let means = Means::finer(samples.data(), Some(noise.level), finer)?;
        let few = means.data(samples.data());
        let on_means = samples.on_weighted_means(&means, &few);
        let (rows, count) = (samples.rows(), means.len());
        let unseen = plain.as_ref().map_or_else(
            || on_means.unseen(),
            |plain| plain.on_weighted_means(&means, &few).unseen() / noise.level.powi(2),
        );
        let within = unseen / (rows - count) as f64;
        let over = on_means.cost(&base.point) / samples.cost(&base.point) - 1.0;
        tracing::debug!(
            "{count} means of {rows} samples: {within:.3} noises within, sums of squares apart by {over:.4}"
        );
        (within < 1.0 + hidden && over.abs() < APART).then_some(means)
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::criticism::noise::Seen;
    use palpate_fit::data::Data;
    use palpate_fit::least_squares::Effort;
    use palpate_model::{BaseLaw, Chain, Separation};
    use palpate_trace::{Column, DISPLACEMENT, FORCE, Trace};

    /// How many samples there are for each mean of presses at 200 Hz, with a noise of one and a wave of so many noises over the
    /// displacement, with this period, mm; none where the search goes over all samples.
    fn samples_for_each_mean(wave: f64, period: f64) -> Option<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let time: Vec<f64> = (0..2400).map(|k| f64::from(k) / 200.0).collect();
        let mut press = |deep: f64| {
            let x = time.iter().map(|t| (4.0 * t - 4.0).min(deep).min(36.0 - 4.0 * t).max(-0.1));
            let x: Vec<f64> = x.collect();
            let force = x.iter().map(|x| {
                let wave = wave * (TAU * x / period).sin();
                let noise: f64 = StandardNormal.sample(&mut random);
                noise + if *x > 0.0 { 40.0 * x.powf(1.5) + wave } else { 0.0 }
            });
            let column = |name: &str, values| Column { name: name.into(), values };
            let columns = vec![column(FORCE, force.collect()), column(DISPLACEMENT, x)];
            Trace { time: time.clone(), columns, ..Trace::default() }
        };
        let traces = [press(4.0), press(8.0)];
        let data = Data::of(&traces, FORCE).unwrap();
        let chain = Chain::new(BaseLaw::fung(1, Separation::Clamp));
        let whitening = Whitening::none();
        let samples = Problem::new(&chain, &data, &whitening, None);
        let base = Fitted::new(&samples, &samples.point(&[200.0, 0.5, 5.0, 1.0]), Effort::QUICK);
        let seen = Seen::OffTheSpecimen;
        let noise = NoiseModel {
            whitening: whitening.clone(),
            seen,
            samples: 400,
            level: 1.0,
            vibration_hz: None,
        };
        of(&samples, &base, &noise).map(|means| samples.rows() as f64 / means.len() as f64)
    }

    #[test]
    fn blocks_are_long_where_nothing_but_noise_is_within() {
        let smooth = samples_for_each_mean(0.0, 1.0).unwrap();
        assert!(smooth > 5.0, "{smooth}");
        let slow = samples_for_each_mean(2.0, 2.0).unwrap();
        assert!(slow > 5.0, "{slow}");
    }

    #[test]
    fn a_wave_within_blocks_makes_them_finer() {
        let coarse = samples_for_each_mean(0.0, 1.0).unwrap();
        let fine = samples_for_each_mean(2.0, 0.1);
        assert!(fine.is_none_or(|fine| fine < 0.7 * coarse), "{fine:?} for {coarse}");
    }
}
