//! What a residual is like beside the noise: how its neighbours correlate, its spectrum, its distribution.

use std::f64::consts::{PI, TAU};

use super::residuals::Stretch;
use palpate_fit::fourier::Planner;
use palpate_trace::Noise;

/// Longest lag, samples.
const LAGS: usize = 60;
/// Samples of one segment of the spectrum, where there are so many.
const SEGMENT: usize = 512;
/// Fewest samples that are worth a look.
const FEWEST: usize = 32;
/// More samples than these change nothing that can be seen.
const MOST: usize = 262_144;
/// Classes of the distribution.
const CLASSES: usize = 31;

/// The residual of one trace.
#[derive(Clone, Debug, PartialEq)]
pub struct Character {
    /// Time from one sample to the next, s: the median.
    pub interval_s: f64,
    /// Correlation with the samples 0, 1, 2, … later, about zero, −1 to 1.
    pub correlation: Vec<f64>,
    /// Frequencies above zero, Hz, evenly to half the rate.
    pub frequency_hz: Vec<f64>,
    /// Power density at each frequency, unit²/Hz: over all frequencies it adds up to the mean square.
    pub density: Vec<f64>,
    /// Edges of classes of equal width, in the unit of the signal.
    pub edges: Vec<f64>,
    /// Share of samples in each class over its width, 1/unit.
    pub shares: Vec<f64>,
}

/// The character of a trace's residual, from its first 262 144 samples; none of fewer than 32 samples, or where nothing is left.
#[must_use]
pub fn character(stretches: &[Stretch]) -> Option<Character> {
    let mut room = MOST;
    let mut residuals: Vec<Vec<f64>> = Vec::new();
    for stretch in stretches {
        let mut residual = stretch.residual();
        residual.truncate(room);
        room -= residual.len();
        residuals.push(residual);
    }
    let all = || residuals.iter().flatten().copied();
    let count = MOST - room;
    let greatest = all().fold(0.0, |most: f64, r| most.max(r.abs()));
    if count < FEWEST || greatest == 0.0 || !greatest.is_finite() {
        return None;
    }
    let interval_s = median_interval(stretches)?;
    let (frequency_hz, density) = density(&residuals, interval_s);
    let width = 2.0 * greatest / CLASSES as f64;
    let mut classes = [0_usize; CLASSES];
    for r in all() {
        classes[(((r + greatest) / width) as usize).min(CLASSES - 1)] += 1;
    }
    Some(Character {
        interval_s,
        correlation: correlation(&residuals),
        frequency_hz,
        density,
        edges: (0..=CLASSES).map(|k| k as f64 * width - greatest).collect(),
        shares: classes.iter().map(|n| *n as f64 / (count as f64 * width)).collect(),
    })
}

fn median_interval(stretches: &[Stretch]) -> Option<f64> {
    let longest = stretches.iter().max_by_key(|stretch| stretch.time.len())?;
    let mut steps: Vec<f64> = longest.time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().filter(|step| *step > 0.0)
}

fn correlation(residuals: &[Vec<f64>]) -> Vec<f64> {
    let mean_product = |lag: usize| {
        let of = |r: &Vec<f64>| -> (f64, usize) {
            let pairs = r.iter().zip(r.iter().skip(lag));
            (pairs.map(|(a, b)| a * b).sum(), r.len().saturating_sub(lag))
        };
        let (sum, count) =
            residuals.iter().map(of).fold((0.0, 0), |(s, n), (sum, count)| (s + sum, n + count));
        (count > 0).then(|| sum / count as f64)
    };
    let Some(square) = mean_product(0) else { return Vec::new() };
    let longest = residuals.iter().map(Vec::len).max().unwrap_or(0);
    let lags = 0..=LAGS.min(longest / 4);
    lags.map_while(|lag| mean_product(lag).map(|product| product / square)).collect()
}

/// Welch's estimate: Hann windows that overlap by half.
fn density(residuals: &[Vec<f64>], interval_s: f64) -> (Vec<f64>, Vec<f64>) {
    let longest = residuals.iter().map(Vec::len).max().unwrap_or(0);
    let segment = SEGMENT.min(1 << longest.max(1).ilog2());
    let hann = |k: usize| 0.5 - 0.5 * (TAU * (k as f64 + 0.5) / segment as f64).cos();
    let window: Vec<f64> = (0..segment).map(hann).collect();
    let transform = Planner::new().forward(segment);
    let mut lines = transform.make_output_vec();
    let mut sums = vec![0.0; lines.len()];
    let mut segments = 0;
    for residual in residuals {
        let starts = (0..residual.len()).step_by((segment / 2).max(1));
        for start in starts.take_while(|start| start + segment <= residual.len()) {
            let part = &residual[start..start + segment];
            let mut windowed: Vec<f64> = part.iter().zip(&window).map(|(r, w)| r * w).collect();
            // The lengths are the plan's own, the only thing it can refuse.
            if transform.process(&mut windowed, &mut lines).is_ok() {
                sums.iter_mut().zip(&lines).for_each(|(sum, line)| *sum += line.norm_sqr());
                segments += 1;
            }
        }
    }
    let power: f64 = window.iter().map(|w| w * w).sum();
    let scale = 2.0 * interval_s / (power * f64::from(segments.max(1)));
    let step_hz = 1.0 / (segment as f64 * interval_s);
    let lines = sums.iter().enumerate().skip(1);
    lines.map(|(k, sum)| (k as f64 * step_hz, sum * scale)).unzip()
}

/// What nothing but noise would show in the place of a residual.
impl Character {
    /// Its correlation at each lag.
    #[must_use]
    pub fn correlation_of(&self, noise: &Noise) -> Vec<f64> {
        let neighbours = noise.lag1.unwrap_or(0.0);
        let powers = std::iter::successors(Some(1.0), |power| Some(power * neighbours));
        powers.take(self.correlation.len()).collect()
    }

    /// Its power density at each frequency, unit²/Hz.
    #[must_use]
    pub fn density_of(&self, noise: &Noise) -> Vec<f64> {
        let a = noise.lag1.unwrap_or(0.0);
        let innovation = noise.standard_deviation.powi(2) * (1.0 - a * a);
        let at = |f: &f64| {
            let turn = (TAU * f * self.interval_s).cos();
            2.0 * self.interval_s * innovation / (1.0 - 2.0 * a * turn + a * a)
        };
        self.frequency_hz.iter().map(at).collect()
    }

    /// Its share at these values, 1/unit.
    #[must_use]
    pub fn shares_of(&self, noise: &Noise, values: &[f64]) -> Vec<f64> {
        let sd = noise.standard_deviation;
        let at = |r: &f64| (-0.5 * (r / sd).powi(2)).exp() / (sd * (2.0 * PI).sqrt());
        values.iter().map(at).collect()
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use palpate_trace::Source;

    const RATE_HZ: f64 = 200.0;

    /// Noise of standard deviation 0.1 whose neighbours correlate with `a`, in two stretches.
    fn noisy(a: f64, more: impl Fn(f64) -> f64) -> Vec<Stretch> {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut before = 0.0;
        let mut stretch = |from: usize| {
            let time: Vec<f64> = (from..from + 8000).map(|k| k as f64 / RATE_HZ).collect();
            let mut next = |t: &f64| {
                // Of three uniform numbers, nearly normal.
                let u: f64 = (0..3).map(|_| random.random_range(-1.0..1.0)).sum();
                before = a * before + u * 0.1 * (1.0 - a * a).sqrt();
                before + more(*t)
            };
            let measured: Vec<f64> = time.iter().map(&mut next).collect();
            Stretch {
                trace: 0,
                predicted: vec![0.0; time.len()],
                displacement: Vec::new(),
                regions: Vec::new(),
                measured,
                time,
            }
        };
        vec![stretch(0), stretch(9000)]
    }

    fn of(stretches: &[Stretch]) -> Character {
        character(stretches).unwrap()
    }

    fn noise(a: f64) -> Noise {
        Noise { standard_deviation: 0.1, lag1: Some(a), samples: 100, source: Source::BeforeTouch }
    }

    #[test]
    fn a_residual_of_noise_alone_is_what_noise_would_show() {
        for a in [0.0, 0.6] {
            let found = of(&noisy(a, |_| 0.0));
            for (lag, (c, expected)) in
                found.correlation.iter().zip(found.correlation_of(&noise(a))).enumerate()
            {
                assert!((c - expected).abs() < 0.06, "{a}, lag {lag}: {c} {expected}");
            }
            let expected = found.density_of(&noise(a));
            for (d, e) in found.density.chunks(32).zip(expected.chunks(32)) {
                let ratio = d.iter().sum::<f64>() / e.iter().sum::<f64>();
                assert!((ratio - 1.0).abs() < 0.2, "{a}: {ratio}");
            }
            let step_hz = found.frequency_hz[1] - found.frequency_hz[0];
            let power: f64 = found.density.iter().sum::<f64>() * step_hz;
            assert!((power / 0.01 - 1.0).abs() < 0.06, "{a}: {power}");
            let width = found.edges[1] - found.edges[0];
            assert!((found.shares.iter().sum::<f64>() * width - 1.0).abs() < 1e-9);
            let middle = found.shares[CLASSES / 2];
            let expected = found.shares_of(&noise(a), &[0.0])[0];
            assert!((middle / expected - 1.0).abs() < 0.15, "{a}: {middle} {expected}");
        }
    }

    #[test]
    fn a_tone_stands_out_where_it_is() {
        let found = of(&noisy(0.0, |t| 0.1 * (TAU * 25.0 * t).sin()));
        let lines = found.frequency_hz.iter().zip(&found.density);
        let (at, highest) = lines.max_by(|a, b| a.1.total_cmp(b.1)).unwrap();
        assert!((at - 25.0).abs() < 0.5, "{at}");
        assert!(*highest > 10.0 * found.density_of(&noise(0.0))[0]);
        // Eight samples are a whole turn.
        assert!(found.correlation[8] > 0.25 && found.correlation[4] < -0.25);
    }

    #[test]
    fn of_too_little_or_of_nothing_there_is_no_character() {
        let mut few = noisy(0.0, |_| 0.0);
        few.truncate(1);
        few[0].time.truncate(31);
        few[0].measured.truncate(31);
        few[0].predicted.truncate(31);
        assert_eq!(character(&few), None);
        let mut exact = noisy(0.0, |_| 0.0);
        exact.iter_mut().for_each(|stretch| stretch.predicted.clone_from(&stretch.measured));
        assert_eq!(character(&exact), None);
        assert_eq!(character(&[]), None);
    }
}
