//! What a self-test gathers: mean and scatter of every gauge, and the rate.

use micromath::F32;
use shared::pipeline::GAUGES;
use shared::wire;

use crate::stream::Sample;

/// Samples a test takes.
const SAMPLES: u16 = 256;

/// A self-test under way.
#[derive(Clone, Debug)]
pub(crate) struct SelfTest {
    /// Command that asked for it.
    pub(crate) to: u32,
    until_us: u64,
    interval_us: f32,
    began_us: u64,
    last_us: u64,
    taken: u16,
    first: [i32; GAUGES],
    /// Sums of the differences from the first sample, and of their squares.
    sums: [i64; GAUGES],
    squares: [i64; GAUGES],
}

impl SelfTest {
    /// Begins at `now_us`; given up after twice the time that its samples should take.
    pub(crate) fn begin(to: u32, now_us: u64, interval_s: f64) -> Self {
        let interval_us = interval_s as f32 * 1e6;
        let most = interval_us * f32::from(SAMPLES) * 2.0;
        Self {
            to,
            until_us: now_us.saturating_add(most as u64),
            interval_us,
            began_us: now_us,
            last_us: now_us,
            taken: 0,
            first: [0; GAUGES],
            sums: [0; GAUGES],
            squares: [0; GAUGES],
        }
    }

    pub(crate) fn take(&mut self, sample: &Sample) {
        if self.taken == 0 {
            (self.first, self.began_us) = (sample.counts, sample.time_us);
        }
        let gauges =
            sample.counts.iter().zip(&self.first).zip(&mut self.sums).zip(&mut self.squares);
        for (((counts, first), sum), square) in gauges {
            // 25 bits: the square has 50, and 256 of them 58.
            let difference = i64::from(counts.wrapping_sub(*first));
            *sum = sum.wrapping_add(difference);
            *square = square.wrapping_add(difference.wrapping_mul(difference));
        }
        self.taken = self.taken.saturating_add(1);
        self.last_us = sample.time_us;
    }

    /// The result, once there are enough samples or no more will come.
    pub(crate) fn result(&self, now_us: u64) -> Option<wire::SelfTest> {
        let complete = self.taken >= SAMPLES;
        if !complete && now_us < self.until_us {
            return None;
        }
        let count = f32::from(self.taken.max(1));
        let scatter = |sum: i64, square: i64| {
            let (mean, mean_square) = (sum as f32 / count, square as f32 / count);
            root((mean_square - mean * mean).max(0.0))
        };
        let [a, b, c, d] = self.sums;
        let [p, q, r, s] = self.squares;
        let mut mean_counts = self.first;
        for (mean, sum) in mean_counts.iter_mut().zip(self.sums) {
            let offset = sum.checked_div(i64::from(self.taken)).unwrap_or(0);
            *mean = mean.wrapping_add(offset as i32);
        }
        let seen_us = self.last_us.saturating_sub(self.began_us) as f32;
        let due_us = self.interval_us * f32::from(self.taken.saturating_sub(1));
        Some(wire::SelfTest {
            converter: if complete { Ok(()) } else { Err(wire::ConverterFault::Stuck) },
            noise_counts: wire::PerGauge([
                scatter(a, p),
                scatter(b, q),
                scatter(c, r),
                scatter(d, s),
            ]),
            mean_counts: wire::PerGauge(mean_counts),
            samples: self.taken,
            rate_ratio: if seen_us > 0.0 { due_us / seen_us } else { 0.0 },
        })
    }
}

/// micromath's root is good to a few percent; one step of Heron's makes it a thousandth.
fn root(square: f32) -> f32 {
    let near = F32(square).sqrt().0;
    if square > 0.0 { 0.5 * (near + square / near) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_root_is_good_to_two_thousandths() {
        for square in [1e-3, 0.5, 2.0, 100.0, 123_456.0, 7e13] {
            let exact = f32::sqrt(square);
            assert!((root(square) - exact).abs() <= 2e-3 * exact, "{square}: {}", root(square));
        }
        assert_eq!(root(0.0), 0.0);
    }

    #[test]
    fn mean_scatter_and_rate_are_those_of_the_samples() {
        let mut test = SelfTest::begin(7, 1_000, 1e-3);
        for i in 0..SAMPLES {
            let noise = if i % 2 == 0 { 100 } else { -100 };
            let time_us = 2_000 + u64::from(i) * 2_000;
            let counts = [noise, 8_000_000 + noise, -8_000_000, 0];
            test.take(&Sample { time_us, counts, lost: Default::default() });
        }
        let found = test.result(0).unwrap();
        assert_eq!(found.mean_counts, [0, 8_000_000, -8_000_000, 0]);
        for (noise, expected) in found.noise_counts.into_iter().zip([100.0, 100.0, 0.0, 0.0]) {
            assert!((noise - expected).abs() < 0.5, "{noise}");
        }
        assert_eq!((found.converter, found.samples), (Ok(()), 256));
        assert!((found.rate_ratio - 0.5).abs() < 1e-3, "half the rate that was set");
    }

    #[test]
    fn without_samples_a_test_ends_and_says_so() {
        let test = SelfTest::begin(7, 0, 1e-3);
        assert_eq!(test.result(500_000), None);
        let found = test.result(512_000).unwrap();
        assert_eq!((found.converter, found.samples), (Err(wire::ConverterFault::Stuck), 0));
    }
}
