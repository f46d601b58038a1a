//! Noise of the recorded signal.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::random::even;
use super::session::Session;

/// Kind of noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseKind {
    /// First-order autoregressive, neighbours correlated by 0.2 to 0.8.
    Correlated,
    /// Without correlation.
    White,
    /// 1/f between 1/(2π 100 s) and 1/(2π 0.01 s), plus white noise: each has 30 to 70 % of the
    /// variance. It goes on in the pauses between traces.
    Flicker,
    /// 1/f from the sampling rate down to 1/(length of the set), alone in one set of two and else with
    /// up to 50 % of white noise. It goes on in the pauses and gives each trace a zero of its own.
    FlickerThrough,
}

impl NoiseKind {
    /// Every kind.
    pub const ALL: [Self; 4] = [Self::Correlated, Self::White, Self::Flicker, Self::FlickerThrough];
}

/// Processes that forget with a time constant, s, each with a share of the variance.
struct Processes(Vec<Process>);

struct Process {
    time_s: f64,
    deviation: f64,
    value: f64,
}

impl Processes {
    /// Equal shares of `variance`, in their stationary state.
    fn new(random: &mut ChaCha8Rng, times: &[f64], variance: f64) -> Self {
        let deviation = (variance / times.len() as f64).sqrt();
        let process = |&time_s| {
            let start: f64 = StandardNormal.sample(random);
            Process { time_s, deviation, value: deviation * start }
        };
        Self(times.iter().map(process).collect())
    }

    /// Their sum after some seconds.
    fn after(&mut self, random: &mut ChaCha8Rng, seconds: f64) -> f64 {
        let mut sum = 0.0;
        for process in &mut self.0 {
            let kept = if process.time_s > 0.0 { (-seconds / process.time_s).exp() } else { 0.0 };
            let new: f64 = StandardNormal.sample(random);
            process.value =
                kept * process.value + process.deviation * (1.0 - kept * kept).sqrt() * new;
            sum += process.value;
        }
        sum
    }
}

/// Time constants, s, four a decade, of processes that together have a 1/f spectrum from
/// 1/`longest` to 1/`shortest`.
fn times_between(shortest: f64, longest: f64) -> Vec<f64> {
    // A process bends at 1/(2π its time constant), so those below 1/`longest` belong to it too.
    let (from, to) = ((shortest / std::f64::consts::TAU).log10(), longest.log10());
    let count = (4.0 * (to - from)).ceil();
    (0..=count as u32).map(|k| 10f64.powf(from + (to - from) * f64::from(k) / count)).collect()
}

/// Noise of variance one for every sample of every trace.
#[must_use]
pub fn noise(kind: NoiseKind, session: &Session, random: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
    const WHITE: f64 = 0.0;
    let rate_hz = session.rate_hz();
    let (times, flicker): (Vec<f64>, f64) = match kind {
        NoiseKind::Correlated => (vec![-1.0 / (rate_hz * even(random, 0.2, 0.8).ln())], 1.0),
        NoiseKind::White => (vec![WHITE], 1.0),
        // Thrice a decade from 0.01 s to 100 s.
        NoiseKind::Flicker => {
            ((-6..=6).map(|k| 10f64.powf(f64::from(k) / 3.0)).collect(), even(random, 0.3, 0.7))
        }
        NoiseKind::FlickerThrough => {
            (times_between(1.0 / rate_hz, session.lasts_s()), even(random, 0.5, 1.5).min(1.0))
        }
    };
    let mut slow = Processes::new(random, &times, flicker);
    let mut white = Processes::new(random, &[WHITE], 1.0 - flicker);
    let mut before = 0.0;
    let mut trace = |start: f64, samples: usize| {
        (0..samples)
            .map(|k| {
                let now = start + k as f64 / rate_hz;
                let value = slow.after(random, now - before) + white.after(random, 1.0);
                before = now;
                value
            })
            .collect()
    };
    session.recordings.iter().map(|recording| trace(recording.start_s, recording.samples)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hidden::random::{Subject, stream};

    #[test]
    fn every_kind_has_the_asked_variance() {
        for kind in NoiseKind::ALL {
            let mean_square = |seed| {
                let session = Session::whole(seed);
                let all = noise(kind, &session, &mut stream(seed, Subject::Noise)).concat();
                all.iter().map(|value| value * value).sum::<f64>() / all.len() as f64
            };
            let variance = (0..20).map(mean_square).sum::<f64>() / 20.0;
            assert!((variance - 1.0).abs() < 0.1, "{kind:?}: {variance}");
        }
    }

    /// Over many sets, the variance of the mean of a trace, and how that mean correlates with that of
    /// the trace after.
    fn zeros(kind: NoiseKind) -> (f64, f64) {
        let (mut square, mut product, mut count) = (0.0, 0.0, 0.0);
        for seed in 0..30 {
            let session = Session::whole(seed);
            let all = noise(kind, &session, &mut stream(seed, Subject::Noise));
            let mean = |trace: &Vec<f64>| trace.iter().sum::<f64>() / trace.len() as f64;
            let means: Vec<f64> = all.iter().map(mean).collect();
            for pair in means.windows(2) {
                square += 0.5 * (pair[0] * pair[0] + pair[1] * pair[1]);
                product += pair[0] * pair[1];
                count += 1.0;
            }
        }
        (square / count, product / square)
    }

    #[test]
    fn flicker_through_the_pauses_gives_neighbouring_traces_like_zeros() {
        let (variance, correlation) = zeros(NoiseKind::FlickerThrough);
        assert!(variance > 0.15, "{variance}");
        assert!(correlation > 0.25, "{correlation}");
    }

    #[test]
    fn its_spectrum_falls_as_one_over_the_frequency() {
        // Sums of squares of a Haar wavelet over octaves: equal for 1/f.
        let mut octaves = [0.0; 8];
        for seed in 0..10 {
            let session = Session::whole(seed);
            let random = &mut stream(seed, Subject::Noise);
            let times = times_between(1.0 / session.rate_hz(), session.lasts_s());
            let mut process = Processes::new(random, &times, 1.0);
            let values: Vec<f64> =
                (0..1 << 14).map(|_| process.after(random, 1.0 / session.rate_hz())).collect();
            for (octave, sum) in octaves.iter_mut().enumerate() {
                let half = 4 << octave;
                let mean = |part: &[f64]| part.iter().sum::<f64>() / half as f64;
                let pieces = values.chunks_exact(2 * half);
                let count = pieces.len() as f64;
                let square = |piece: &[f64]| (mean(&piece[..half]) - mean(&piece[half..])).powi(2);
                *sum += pieces.map(square).sum::<f64>() / count / 10.0;
            }
        }
        let (least, most) =
            octaves.iter().fold((f64::MAX, 0.0_f64), |(a, b), &v| (a.min(v), b.max(v)));
        assert!(most / least < 1.5, "{octaves:?}");
    }
}
