//! Low-pass filtering of a signal before it is analysed (6.3.3): Butterworth, both ways or one.

use std::f64::consts::{PI, SQRT_2};

use biquad::{Biquad, Coefficients, DirectForm2Transposed, Type};

use palpate_trace::{Sampling, Trace, sampling};

/// Highest order.
pub const HIGHEST_ORDER: usize = 8;
/// Time constants of the filter that are put before and after the record.
const PADDING: f64 = 15.0;

/// A Butterworth low-pass filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Butterworth {
    /// Frequency at which one pass is 3 dB down, Hz.
    pub cutoff_hz: f64,
    /// Number of poles, 1 to 8.
    pub order: usize,
    /// Forward and backward, so that nothing is delayed; else forward only, as a filter in the loop.
    pub zero_phase: bool,
}

/// Why a signal cannot be filtered.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)]
pub enum ConditioningError {
    #[error(
        "{trace}: its sampling is uneven, and a Butterworth filter needs even samples. Resample it, or analyse it unfiltered."
    )]
    Uneven { trace: String },
    #[error(
        "{trace}: a cut-off of {cutoff_hz} Hz is not between 0 and half the sampling rate, {nyquist_hz} Hz"
    )]
    Cutoff { trace: String, cutoff_hz: f64, nyquist_hz: f64 },
    #[error("order {0} of the filter is not between 1 and {HIGHEST_ORDER}")]
    Order(usize),
}

impl Butterworth {
    /// Filters one column of an evenly sampled trace.
    ///
    /// # Errors
    /// When sampling is uneven, or the cut-off or the order cannot be.
    pub fn filter(&self, trace: &Trace, values: &[f64]) -> Result<Vec<f64>, ConditioningError> {
        let uneven = || ConditioningError::Uneven { trace: trace.label() };
        let rate_hz =
            sampling(&trace.time).filter(Sampling::is_uniform).ok_or_else(uneven)?.rate_hz();
        if !(1..=HIGHEST_ORDER).contains(&self.order) {
            return Err(ConditioningError::Order(self.order));
        }
        let stages = self.stages(rate_hz).ok_or_else(|| ConditioningError::Cutoff {
            trace: trace.label(),
            cutoff_hz: self.cutoff_hz,
            nyquist_hz: 0.5 * rate_hz,
        })?;
        let pad = (PADDING * rate_hz / (2.0 * PI * self.cutoff_hz)).ceil() as usize;
        Ok(self.run(&stages, values, pad))
    }

    /// Frequency at which all passes together are 3 dB down, Hz, for a sampling rate in Hz.
    #[must_use]
    pub fn three_db_hz(&self, rate_hz: f64) -> f64 {
        if !self.zero_phase {
            return self.cutoff_hz;
        }
        // Both ways: 1/(1 + w^2n)² = 1/2, with the bilinear transform's own frequency axis.
        let narrower = (SQRT_2 - 1.0).powf(0.5 / self.order as f64);
        let warped = (PI * self.cutoff_hz / rate_hz).tan() * narrower;
        warped.atan() * rate_hz / PI
    }

    /// Second-order sections, and one of first order where the order is odd.
    fn stages(&self, rate_hz: f64) -> Option<Vec<Coefficients<f64>>> {
        let normalised = 2.0 * self.cutoff_hz / rate_hz;
        if !(normalised > 0.0 && normalised < 1.0) {
            return None;
        }
        let section =
            |kind, quality| Coefficients::from_normalized_params(kind, normalised, quality).ok();
        let order = self.order as f64;
        let pairs = (0..self.order / 2).map(|k| {
            // Poles lie evenly on a half circle.
            let angle = match self.order % 2 {
                0 => (2 * k + 1) as f64 * PI / (2.0 * order),
                _ => (k + 1) as f64 * PI / order,
            };
            section(Type::LowPass, 0.5 / angle.cos())
        });
        let single = (self.order % 2 == 1).then(|| section(Type::SinglePoleLowPass, 1.0));
        pairs.chain(single).collect()
    }

    fn run(&self, stages: &[Coefficients<f64>], values: &[f64], pad: usize) -> Vec<f64> {
        let Some((&first, &last)) = values.first().zip(values.last()) else { return Vec::new() };
        let pad = pad.min(values.len() - 1);
        // Odd reflection, so that neither end jumps; then the filter starts settled at rest.
        let before = (1..=pad).rev().map(|k| 2.0 * first - values[k]);
        let after = (1..=pad).map(|k| 2.0 * last - values[values.len() - 1 - k]);
        let mut signal: Vec<f64> = before.chain(values.iter().copied()).chain(after).collect();
        pass(stages, &mut signal);
        if self.zero_phase {
            signal.reverse();
            pass(stages, &mut signal);
            signal.reverse();
        }
        signal[pad..pad + values.len()].to_vec()
    }
}

/// One pass, from rest at the first value.
fn pass(stages: &[Coefficients<f64>], signal: &mut [f64]) {
    let Some(&rest) = signal.first() else { return };
    for coefficients in stages {
        let mut section = DirectForm2Transposed::<f64>::new(*coefficients);
        for value in signal.iter_mut() {
            *value = rest + section.run(*value - rest);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use proptest::prelude::*;

    use super::*;

    fn sampled(rate: f64, samples: usize, f: impl Fn(f64) -> f64) -> (Trace, Vec<f64>) {
        let time: Vec<f64> = (0..samples).map(|k| k as f64 / rate).collect();
        let values = time.iter().map(|t| f(*t)).collect();
        (Trace { time, ..Trace::default() }, values)
    }

    /// Gain for a sine, from the middle of a long record.
    fn gain(filter: Butterworth, frequency: f64) -> f64 {
        let (trace, values) = sampled(200.0, 8000, |t| (TAU * frequency * t).sin());
        let filtered = filter.filter(&trace, &values).unwrap();
        let rms = |v: &[f64]| v[2000..6000].iter().map(|x| x * x).sum::<f64>().sqrt();
        rms(&filtered) / rms(&values)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn the_stated_frequency_is_three_decibels_down(
            order in 1usize..=8, zero_phase: bool, cutoff in 5.0f64..40.0
        ) {
            let filter = Butterworth { cutoff_hz: cutoff, order, zero_phase };
            let there = gain(filter, filter.three_db_hz(200.0));
            prop_assert!((there - 0.5f64.sqrt()).abs() < 2e-3, "{there}");
        }
    }

    #[test]
    fn the_gain_is_that_of_butterworth() {
        for order in 1..=8 {
            let filter = Butterworth { cutoff_hz: 10.0, order, zero_phase: false };
            let warped = (PI * 17.0 / 200.0).tan() / (PI * 10.0 / 200.0).tan();
            let expected = (1.0 + warped.powi(2 * order as i32)).sqrt().recip();
            assert!((gain(filter, 17.0) - expected).abs() < 2e-3, "order {order}");
        }
    }

    #[test]
    fn both_ways_nothing_is_delayed_and_a_ramp_comes_through() {
        let filter = Butterworth { cutoff_hz: 5.0, order: 4, zero_phase: true };
        let (trace, values) = sampled(200.0, 1000, |t| 3.0 + 2.0 * t);
        let filtered = filter.filter(&trace, &values).unwrap();
        for (a, b) in filtered.iter().zip(&values) {
            assert!((a - b).abs() < 1e-3, "{a} {b}");
        }
    }

    #[test]
    fn what_cannot_be_filtered_is_refused() {
        let filter = Butterworth { cutoff_hz: 5.0, order: 4, zero_phase: true };
        let (mut trace, values) = sampled(200.0, 100, |t| t);
        assert!(Butterworth { cutoff_hz: 100.0, ..filter }.filter(&trace, &values).is_err());
        assert!(Butterworth { order: 9, ..filter }.filter(&trace, &values).is_err());
        trace.time[50] += 0.002;
        assert!(matches!(filter.filter(&trace, &values), Err(ConditioningError::Uneven { .. })));
    }
}
