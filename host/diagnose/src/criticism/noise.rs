//! The noise of a data set, from where the specimen is not touched: never from the misfit.

use super::adequacy::LEVEL;
use super::approach::{approaches, whitens};
use super::hum::{centred, without_hum};
use super::vibration::without_vibration;
use palpate_fit::data::Data;
use palpate_fit::whitening::{Likelihood, Stretch, Whitening, decays};
use palpate_trace::{Noise, Source, Trace, bridged, pooled_noise};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// What is known of the noise.
#[derive(Clone, Debug)]
pub struct NoiseModel {
    /// The filter that makes it white.
    pub whitening: Whitening,
    /// Where it was seen.
    pub seen: Seen,
    /// Number of samples it was estimated from.
    pub samples: usize,
    /// Standard deviation of one sample, in the unit of the signal.
    pub level: f64,
    /// Frequency, Hz, of a steady vibration that it was seen without; none where there is none.
    pub vibration_hz: Option<f64>,
}

impl NoiseModel {
    /// Whether it was seen where nothing touches, so that nothing that the model lacks is in it.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.seen != Seen::Residual
    }

    /// Its size, and the correlation of neighbours, as other parts of the program take it.
    #[must_use]
    pub fn in_short(&self) -> Noise {
        Noise {
            standard_deviation: self.level,
            lag1: self.whitening.coefficients().first().copied(),
            samples: self.samples,
            source: if self.seen == Seen::OnTheWayIn { Source::WayIn } else { Source::BeforeTouch },
        }
    }
}

/// Where noise was seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// At rest off the specimen, before and after the touch.
    OffTheSpecimen,
    /// Off the specimen too, on the way to the first touch, where a recording begins in motion: nothing else is on it.
    OnTheWayIn,
    /// In the residual of the model, for want of rest: what the model lacks is in it.
    Residual,
}

/// Samples of rest that are enough to see noise in.
const ENOUGH: usize = 60;
/// Samples of rest before the touch that are enough by themselves.
const PLENTY: usize = 300;
/// Times as many samples as at rest, where these are few, for which the way to the first touch tells the noise better.
const FAR_MORE: usize = 3;
/// Samples of a set from which on the way to the first touch is left alone: held against its noise a misfit of a tenth of it is searched
/// for minutes, and second differences tell a larger one as well.
const MANY: usize = 300_000;
/// Samples on the way to the first touch that are enough to see that nothing but noise is there.
const TELLS_OF_MOTION: usize = 200;
/// Variance after the touch over that before it above which the rest after it is not quiet.
const LOUDER: f64 = 1.4;
/// The same where there are few samples before the touch: their own scatter explains no such ratio.
const FAR_LOUDER: f64 = 25.0;
/// Largest correlation of neighbours that a residual may lend to the noise.
const MOST_CORRELATED: f64 = 0.9;
/// Traces whose rests can be seen to be the same.
const SEVERAL: usize = 3;
/// Times that the square of the mean over rests is that of the mean of noise, above which they may be the same.
const REPEATS: f64 = 2.0;
/// Samples that tell an autoregression as well as more.
const TELLING: usize = 50_000;
/// A stretch of rest has at least this many samples.
const SHORTEST: usize = 16;
/// Highest order of the autoregression.
const ORDER: usize = 3;
/// Logarithm of the size of each process of the flicker, over the rest of the noise, below which a million samples could not tell it by
/// the difference that counts.
const FAINT: f64 = -5.6;
/// Fall of the deviance by which flicker must be likelier than none.
const LIKELIER: f64 = 10.0;
/// Logarithms of sizes of the flicker at which a fall that large shows, at least by [`SHOWS`]: where the likeliest size lies between
/// two of them, the better of the two has a third of its fall.
const SIZES: [f64; 7] = [-5.3, -4.2, -3.1, -2.0, -0.9, 0.2, 1.3];
/// Coordinate of a correlation of neighbours above which flicker may be a part of it, or all.
const CORRELATED: f64 = 0.2;
/// Fall of the deviance that must be seen at one of those sizes for the likeliest to be searched.
const SHOWS: f64 = 2.0;
/// Time after the touch that still counts as recovery, s.
const RECOVERY: f64 = 0.3;
/// The noise, from rest off the specimen; none where the recordings have too little of it.
#[must_use]
pub fn noise_model(data: &Data) -> Option<NoiseModel> {
    let [before, after] = quiet(data);
    let count = |stretches: &[Vec<f64>]| stretches.iter().map(Vec::len).sum::<usize>();
    // What the touch has set swinging, or has not recovered yet, is no noise.
    let louder = match count(&before) {
        PLENTY.. => LOUDER,
        ENOUGH.. => FAR_LOUDER,
        _ => f64::INFINITY,
    };
    // A signal that stands still to its last digit shows no noise.
    let still = spread(&before) == 0.0;
    let alone = !still && spread(&after) > louder * spread(&before);
    let first = before.len();
    let quiet = if alone { before } else { [before, after].concat() };
    let samples = count(&quiet);
    if samples < PLENTY
        && let Some(way) = on_the_way_in(data, FAR_MORE * samples)
    {
        return Some(way);
    }
    if samples < ENOUGH {
        return None;
    }
    let longest = data.pieces.iter().map(|piece| piece.measured.len()).max().unwrap_or(0);
    let interval = data.shortest_interval();
    let (quiet, vibration_hz) = without_vibration(without_hum(quiet, interval), interval);
    let whitening = own_noise(&quiet[..first], longest).unwrap_or_else(|| estimate(quiet, longest));
    let level = whitening.standard_deviation();
    let middles: Vec<f64> = data.middles().into_iter().map(|time| time / interval).collect();
    let whitening = whitening.through_pauses(&middles);
    let seen = Seen::OffTheSpecimen;
    (level > 0.0).then_some(NoiseModel { level, whitening, seen, samples, vibration_hz })
}

/// The noise, from the ways to the first touch, where nothing but noise that correlates for a few samples is on them and there are
/// more than `few` samples; none otherwise.
fn on_the_way_in(data: &Data, few: usize) -> Option<NoiseModel> {
    if data.samples() > MANY {
        return None;
    }
    let ways = approaches(data);
    let samples = ways.iter().map(Vec::len).sum();
    if samples < TELLS_OF_MOTION || samples <= few {
        return None;
    }
    let interval = data.shortest_interval();
    let (ways, vibration_hz) = without_vibration(without_hum(ways, interval), interval);
    let stretches: Vec<Stretch> = ways.iter().cloned().map(Stretch::new).collect();
    let whitening = autoregression(&stretches).0;
    let level = whitening.standard_deviation();
    let alone = vibration_hz.is_none() && level > 0.0 && whitens(&whitening, ways);
    alone.then_some(NoiseModel { whitening, seen: Seen::OnTheWayIn, samples, level, vibration_hz })
}

/// Whether what a model leaves, stretch by stretch, is no more than noise that correlates for a few samples.
pub(super) fn is_noise(left: Vec<Vec<f64>>) -> bool {
    let stretches: Vec<Stretch> = some_of(&left).into_iter().map(Stretch::new).collect();
    !stretches.is_empty() && whitens(&autoregression(&stretches).0, left)
}

/// As many samples of all stretches as tell an autoregression.
fn some_of(stretches: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let own = (TELLING / stretches.len().max(1)).max(PLENTY);
    let begin = |values: &Vec<f64>| values[..values.len().min(own)].to_vec();
    stretches.iter().filter(|values| values.len() >= SHORTEST).map(begin).collect()
}

/// The noise of rests before the touch in which the same comes anew, trace after trace: what each differs by from their mean. None where
/// nothing does.
fn own_noise(before: &[Vec<f64>], longest: usize) -> Option<Whitening> {
    let shared = before.iter().map(Vec::len).min()?;
    let traces = before.len() as f64;
    if before.len() < SEVERAL || shared < SHORTEST {
        return None;
    }
    let rests: Vec<Vec<f64>> = before.iter().map(|rest| centred(rest[..shared].to_vec())).collect();
    let mean: Vec<f64> =
        (0..shared).map(|k| rests.iter().map(|rest| rest[k]).sum::<f64>() / traces).collect();
    let square = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
    let all: f64 = rests.iter().map(|rest| square(rest)).sum();
    if traces * square(&mean) < REPEATS * all / traces {
        return None;
    }
    let free = (traces / (traces - 1.0)).sqrt();
    let own = |rest: &Vec<f64>| rest.iter().zip(&mean).map(|(r, mean)| free * (r - mean)).collect();
    let whitening = estimate(rests.iter().map(own).collect(), longest);
    let mut same: Vec<f64> = mean.iter().map(|value| traces.sqrt() * value).collect();
    whitening.apply(&mut same);
    let degrees = shared as f64;
    let law = FisherSnedecor::new(degrees, degrees * (traces - 1.0)).ok()?;
    (law.sf(square(&same) / degrees) < LEVEL).then_some(whitening)
}

/// The noise of a data set as every answer tells it: from rest off the specimen, or where the recordings
/// have too little of it as [`pooled_noise`] finds it. None where they do not tell.
#[must_use]
pub fn noise_of(data: &Data, traces: &[Trace]) -> Option<Noise> {
    told(noise_model(data).as_ref(), traces, &data.signal)
}

/// The same where the model of the noise is known.
pub(super) fn told(seen: Option<&NoiseModel>, traces: &[Trace], signal: &str) -> Option<Noise> {
    seen.map(NoiseModel::in_short).or_else(|| pooled_noise(traces, signal))
}

/// Number of samples at rest off the specimen, in stretches that are long enough to see noise in.
#[must_use]
pub fn samples_at_rest(data: &Data) -> usize {
    quiet(data).iter().flatten().map(Vec::len).sum()
}

/// The noise for want of rest: its size from second differences where they tell, and the correlation of
/// neighbours from the residuals of a model, stretch by stretch. What the model lacks is in those, so
/// no more than a correlation is taken from them, and of means over unequal blocks, whose neighbours are
/// ever farther apart, not even that.
#[must_use]
pub fn residual_noise(residuals: &[Vec<f64>], seen: Option<Noise>, means: bool) -> NoiseModel {
    let samples = residuals.iter().map(Vec::len).sum();
    let (mut squares, mut products) = (0.0, 0.0);
    for residual in residuals {
        squares += residual.iter().map(|r| r * r).sum::<f64>();
        products += residual.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>();
    }
    let size = (squares / (samples as f64).max(1.0)).sqrt().max(f64::MIN_POSITIVE);
    let most = if means { 0.0 } else { MOST_CORRELATED };
    let correlation = (products / squares.max(f64::MIN_POSITIVE)).clamp(0.0, most);
    NoiseModel {
        whitening: Whitening::new(size, &[correlation], 0.0, 0).guess(),
        seen: Seen::Residual,
        samples,
        level: seen.map_or(size, |noise| noise.standard_deviation),
        vibration_hz: None,
    }
}

/// Variance within stretches.
fn spread(stretches: &[Vec<f64>]) -> f64 {
    let (mut squares, mut count) = (0.0, 0.0);
    for stretch in stretches {
        let centred = centred(stretch.clone());
        squares += centred.iter().map(|value| value * value).sum::<f64>();
        count += stretch.len() as f64 - 1.0;
    }
    if count > 0.0 { squares / count } else { 0.0 }
}

/// The signal at rest off the specimen without its impossible samples, stretch by stretch: before the first touch of each recording,
/// and after a touch.
fn quiet(data: &Data) -> [Vec<Vec<f64>>; 2] {
    let mut found = [Vec::new(), Vec::new()];
    for piece in &data.pieces {
        let scene = data.scene(piece);
        let (time, x) = (&piece.motion.time, &piece.motion.displacement);
        let fastest = scene.velocity.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let measured = bridged(time, x, piece.measured);
        let mut released = f64::NEG_INFINITY;
        let mut stretch = Vec::new();
        for k in 0..time.len() {
            if data.loads(x[k]) {
                released = time[k];
            }
            let rests = !data.loads(x[k]) && scene.velocity[k].abs() <= 1e-3 * fastest;
            if rests && time[k] >= released + RECOVERY {
                stretch.push(measured[k]);
            } else if !stretch.is_empty() {
                let touched = usize::from(released.is_finite());
                found[touched].push(std::mem::take(&mut stretch));
            }
        }
        found[usize::from(released.is_finite())].push(stretch);
    }
    for stretches in &mut found {
        stretches.retain(|stretch: &Vec<f64>| stretch.len() >= SHORTEST);
    }
    found
}

fn estimate(stretches: Vec<Vec<f64>>, longest: usize) -> Whitening {
    let stretches: Vec<Stretch> = stretches.into_iter().map(Stretch::new).collect();
    let (plain, point) = autoregression(&stretches);
    with_flicker(&stretches, (&plain, &point), longest).unwrap_or(plain)
}

/// The autoregression of up to third order with the least Bayesian information criterion, and where it lies as [`partial`] reads it.
fn autoregression(stretches: &[Stretch]) -> (Whitening, Vec<f64>) {
    let samples: usize = stretches.iter().map(Stretch::len).sum();
    let mut best: Option<(f64, Whitening, Vec<f64>)> = None;
    let mut point: Vec<f64> = Vec::new();
    for order in 0..=ORDER {
        if order > 0 {
            point.push(0.0);
            let cost = |point: &[f64]| {
                Some(deviance(stretches, |s| Whitening::new(s, &partial(point), 0.0, 0)).0)
            };
            point = search(&point, cost).unwrap_or(point);
        }
        let (deviance, size) = deviance(stretches, |s| Whitening::new(s, &partial(&point), 0.0, 0));
        let criterion = deviance + order as f64 * (samples as f64).ln();
        if best.as_ref().is_none_or(|(least, ..)| criterion < *least) {
            best = Some((criterion, Whitening::new(size, &partial(&point), 0.0, 0), point.clone()));
        }
    }
    best.map_or_else(|| (Whitening::none(), Vec::new()), |(_, noise, point)| (noise, point))
}

/// Noise with flicker where that is likelier by far than the plain autoregression, which lies at its point.
fn with_flicker(
    stretches: &[Stretch],
    (plain, at): (&Whitening, &[f64]),
    longest: usize,
) -> Option<Whitening> {
    let here = stretches.iter().map(Stretch::len).max().unwrap_or(0);
    let make = |s: f64, point: &[f64], length| {
        let (flicker, rest) = (point[0].exp(), &point[1..]);
        Whitening::new(s, &partial(rest), s * flicker, length)
    };
    let deviance_at = |point: &[f64]| {
        let parts = decays::likelihoods(point[1].tanh(), point[0].exp(), stretches);
        likeliest(stretches, parts).0
    };
    let plain = deviance(stretches, |s| plain.scaled(s / plain.standard_deviation())).0;
    let own = at.first().copied().unwrap_or(0.0);
    let beside = if own > CORRELATED { &[own, 0.5 * own, 0.0][..] } else { &[own] };
    let mut points = SIZES.iter().flat_map(|&size| beside.iter().map(move |&own| [size, own]));
    if !points.any(|point| deviance_at(&point) + SHOWS < plain) {
        return None;
    }
    let cost = |point: &[f64]| (point[0] > FAINT).then(|| deviance_at(point));
    let point = search(&[-1.0, 0.3], cost)?;
    let (with, size) = deviance(stretches, |s| make(s, &point, here));
    (with + LIKELIER < plain).then(|| make(size, &point, longest))
}

/// Partial correlations from coordinates without bounds.
fn partial(point: &[f64]) -> Vec<f64> {
    point.iter().map(|value| value.tanh()).collect()
}

/// Minus twice the logarithm of the likelihood at the likeliest size, and that size.
fn deviance(stretches: &[Stretch], noise: impl Fn(f64) -> Whitening) -> (f64, f64) {
    let unit = noise(1.0);
    likeliest(stretches, stretches.iter().map(|stretch| unit.likelihood(stretch)))
}

/// The same from what the likelihood of each stretch takes for noise of size 1.
fn likeliest(
    stretches: &[Stretch],
    likelihoods: impl IntoIterator<Item = Likelihood>,
) -> (f64, f64) {
    let (mut squares, mut logarithms, mut count) = (0.0, 0.0, 0.0);
    for (stretch, parts) in stretches.iter().zip(likelihoods) {
        squares += parts.squares;
        logarithms += parts.logarithms;
        count += stretch.len() as f64 - 1.0;
    }
    let variance = (squares / count).max(f64::MIN_POSITIVE);
    (count * variance.ln() + logarithms, variance.sqrt())
}

/// A minimum near `start`, coordinate by coordinate with steps that shrink, first the way that it went last; none once the cost of a
/// point on the way down need not be known.
fn search(start: &[f64], cost: impl Fn(&[f64]) -> Option<f64>) -> Option<Vec<f64>> {
    let mut point = start.to_vec();
    let mut least = cost(&point)?;
    let mut ways = vec![1.0; point.len()];
    let mut step = 0.4;
    while step > 0.01 {
        let mut moved = false;
        for j in 0..point.len() {
            for way in [ways[j], -ways[j]] {
                let mut trial = point.clone();
                trial[j] += way * step;
                let value = cost(&trial)?;
                if value < least {
                    (point, least, moved) = (trial, value, true);
                    ways[j] = way;
                    break;
                }
            }
        }
        if !moved {
            step *= 0.5;
        }
    }
    Some(point)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    fn stretches(a: f64, sd: f64, offset: bool) -> Vec<Vec<f64>> {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        (0..20)
            .map(|number| {
                let mut value = sd * normal();
                let level = if offset { 10.0 * f64::from(number) } else { 0.0 };
                let mut next = || {
                    value = a * value + sd * (1.0 - a * a).sqrt() * normal();
                    value + level
                };
                (0..200).map(|_| next()).collect()
            })
            .collect()
    }

    #[test]
    fn an_autoregression_is_found_whatever_the_level() {
        for offset in [false, true] {
            let noise = estimate(stretches(0.7, 0.02, offset), 1000);
            assert_eq!(noise.flicker(), 0.0);
            assert!((noise.standard_deviation() / 0.02 - 1.0).abs() < 0.05, "{noise:?}");
            assert!((noise.coefficients()[0] - 0.7).abs() < 0.04, "{noise:?}");
        }
    }

    #[test]
    fn flicker_is_found_where_it_is_a_fifth_of_the_noise_and_none_where_there_is_none() {
        // Relaxations of six times, each four times the one before, are flicker.
        let with = |flicker: f64| {
            let mut random = ChaCha8Rng::seed_from_u64(9);
            let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
            let mut states = [0.0; 6];
            let stretch = |_| {
                states.iter_mut().for_each(|state| *state = normal());
                let mut next = || {
                    for (k, state) in states.iter_mut().enumerate() {
                        let decay = (-1.0 / 4f64.powi(k as i32 + 1)).exp();
                        *state = decay * *state + (1.0 - decay * decay).sqrt() * normal();
                    }
                    0.02 * (normal() + flicker * states.iter().sum::<f64>())
                };
                (0..400).map(|_| next()).collect()
            };
            estimate((0..20).map(stretch).collect(), 1000)
        };
        assert_eq!(with(0.0).flicker(), 0.0);
        for flicker in [0.2, 0.5, 1.0, 3.0] {
            let found = with(flicker).flicker();
            assert!((found / (0.02 * flicker) - 1.0).abs() < 0.3, "{found} for {flicker}");
        }
    }

    #[test]
    fn hum_is_not_noise() {
        let mut with_hum = stretches(0.5, 0.02, false);
        for (number, stretch) in with_hum.iter_mut().enumerate() {
            for (k, value) in stretch.iter_mut().enumerate() {
                *value += 0.05 * (TAU * 49.9 * 0.005 * k as f64 + number as f64).sin();
            }
        }
        let noise = estimate(without_hum(with_hum, 0.005), 1000);
        assert!((noise.standard_deviation() / 0.02 - 1.0).abs() < 0.06, "{noise:?}");
        assert!((noise.coefficients()[0] - 0.5).abs() < 0.06, "{noise:?}");
    }
}
