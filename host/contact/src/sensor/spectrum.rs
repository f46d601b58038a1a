//! Amplitude over frequency.

use std::f64::consts::TAU;

use palpate_fit::fourier::Planner;

/// Amplitude of the sine at each frequency; the mean is taken off and a Hann window laid on, so a line reads its amplitude
/// in the bin nearest to it, at most 15 % low between two bins.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Frequencies, Hz, evenly from 0 to half the rate.
    pub frequency_hz: Vec<f64>,
    /// Amplitudes, in the unit of the values.
    pub amplitude: Vec<f64>,
}

impl Spectrum {
    /// The highest line above a frequency, Hz: its own frequency, Hz, and amplitude; none where there is nothing above it.
    ///
    /// A vibration that swells and fades is no sharp line. So its frequency is the mean of the power within a quarter around
    /// the highest bin.
    #[must_use]
    pub fn line_above(&self, frequency_hz: f64) -> Option<(f64, f64)> {
        let lines = || self.frequency_hz.iter().copied().zip(self.amplitude.iter().copied());
        let above = lines().filter(|line| line.0 >= frequency_hz);
        let (highest, amplitude) = above.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let near = lines().filter(|line| (line.0 - highest).abs() <= 0.25 * highest);
        let (moment, power) =
            near.fold((0.0, 0.0), |(moment, power), (f, a)| (moment + f * a * a, power + a * a));
        Some((if power > 0.0 { moment / power } else { highest }, amplitude))
    }
}

/// The spectrum of evenly sampled values.
#[must_use]
pub fn spectrum(values: &[f64], rate_hz: f64) -> Spectrum {
    let count = values.len();
    let mean = values.iter().sum::<f64>() / count.max(1) as f64;
    let hann = |k: usize| 0.5 - 0.5 * (TAU * (k as f64 + 0.5) / count as f64).cos();
    let mut windowed: Vec<f64> =
        values.iter().enumerate().map(|(k, value)| (value - mean) * hann(k)).collect();
    if count < 2 {
        return Spectrum { frequency_hz: Vec::new(), amplitude: Vec::new() };
    }
    let transform = Planner::new().forward(count);
    let mut lines = transform.make_output_vec();
    // The lengths are the plan's own, the only thing it can refuse.
    if transform.process(&mut windowed, &mut lines).is_err() {
        lines.clear();
    }
    // The window's mean is a half, a sine's line half its amplitude.
    let amplitude = lines.iter().map(|line| line.norm() * 4.0 / count as f64).collect();
    let frequency_hz = (0..lines.len()).map(|k| k as f64 * rate_hz / count as f64).collect();
    Spectrum { frequency_hz, amplitude }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_reads_its_amplitude_at_its_frequency() {
        let values: Vec<f64> =
            (0..1000).map(|k| 7.0 + 0.25 * (TAU * 40.0 * f64::from(k) * 1e-3).sin()).collect();
        let (frequency, amplitude) = spectrum(&values, 1000.0).line_above(5.0).unwrap();
        assert!((frequency - 40.0).abs() < 1e-9 && (amplitude - 0.25).abs() < 1e-3);
    }

    #[test]
    fn nothing_has_no_line() {
        assert_eq!(spectrum(&[], 10.0).line_above(0.0), None);
        assert_eq!(spectrum(&[1.0], 10.0).line_above(0.0), None);
    }
}
