//! Noise of the recorded signal.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::random::even;
use super::session::{RATE_HZ, Session};

/// Kind of noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseKind {
    /// First-order autoregressive, neighbours correlated by 0.2 to 0.8.
    Correlated,
    /// Without correlation.
    White,
    /// 1/f between 1/(2π 100 s) and the sampling rate, plus white noise: each has 30 to 70 % of the
    /// variance. It goes on in the pauses between traces.
    Flicker,
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

/// Noise of variance one for every sample of every trace.
#[must_use]
pub fn noise(kind: NoiseKind, session: &Session, random: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
    const WHITE: f64 = 0.0;
    let (times, flicker): (Vec<f64>, f64) = match kind {
        NoiseKind::Correlated => (vec![-1.0 / (RATE_HZ * even(random, 0.2, 0.8).ln())], 1.0),
        NoiseKind::White => (vec![WHITE], 1.0),
        // Thrice a decade from 0.01 s to 100 s.
        NoiseKind::Flicker => {
            ((-6..=6).map(|k| 10f64.powf(f64::from(k) / 3.0)).collect(), even(random, 0.3, 0.7))
        }
    };
    let mut slow = Processes::new(random, &times, flicker);
    let mut white = Processes::new(random, &[WHITE], 1.0 - flicker);
    let mut before = 0.0;
    let mut trace = |start: f64, samples: usize| {
        (0..samples)
            .map(|k| {
                let now = start + k as f64 / RATE_HZ;
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
        for kind in [NoiseKind::Correlated, NoiseKind::White, NoiseKind::Flicker] {
            let mean_square = |seed| {
                let session = Session::whole(seed);
                let all = noise(kind, &session, &mut stream(seed, Subject::Noise)).concat();
                all.iter().map(|value| value * value).sum::<f64>() / all.len() as f64
            };
            let variance = (0..20).map(mean_square).sum::<f64>() / 20.0;
            assert!((variance - 1.0).abs() < 0.1, "{kind:?}: {variance}");
        }
    }
}
