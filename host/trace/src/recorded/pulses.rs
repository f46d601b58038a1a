//! One clock for several devices, by the line that they share: each says when it rose, by its own clock.
//!
//! What several devices say of one instant differs by their clocks alone, to a microsecond. The lines under the arrival of their
//! frames, good to some milliseconds, tell which pulses are the same; from then on the pulses tell the time, which goes evenly
//! between two of them. All are told in the host's time of the device that heard most of them.

use crate::recording::ClockFit;

/// Pulses of two devices that are no further apart than this, s of the host, are the same: they come once a second.
const SAME_S: f64 = 0.2;

/// So many pulses before the last, and after the first, tell how fast time goes on there: an error of a microsecond at each is nothing
/// over a minute.
const ENOUGH: usize = 60;

/// The clock of a device over one stretch: its line under the arrival of its frames, and when the shared line rose, µs of the device.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Timing {
    pub(super) fit: ClockFit,
    pub(super) pulses_us: Vec<u64>,
}

/// The host's time of what a device says.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct HostTime {
    /// The line under the arrival of its frames.
    fit: ClockFit,
    /// Pulses that another device heard too, by which time goes if there are any: µs of this device, and of the host. Before the first
    /// and after the last time goes on as it does near them.
    pulses: Vec<(f64, f64)>,
}

impl Timing {
    /// The host's time by the pulses that this device and a reference, with its stretches, both heard; by its own line where there
    /// are none.
    pub(super) fn beside(&self, reference: &[Timing]) -> HostTime {
        let told = reference.iter().flat_map(|stretch| {
            stretch.pulses_us.iter().map(|pulse_us| stretch.fit.host_us(*pulse_us))
        });
        let mut told: Vec<f64> = told.collect();
        told.sort_by(f64::total_cmp);
        told.dedup();
        let same = |pulse_us: &u64| {
            let own = self.fit.host_us(*pulse_us);
            let after = told.partition_point(|host_us| *host_us < own);
            let near = told[after.saturating_sub(1)..].iter().take(2);
            let nearest = near.min_by(|a, b| (*a - own).abs().total_cmp(&(*b - own).abs()))?;
            ((nearest - own).abs() < SAME_S * 1e6).then_some((*pulse_us as f64, *nearest))
        };
        let mut pulses: Vec<(f64, f64)> = self.pulses_us.iter().filter_map(same).collect();
        if pulses.windows(2).any(|pair| pair[0].0 >= pair[1].0 || pair[0].1 >= pair[1].1) {
            pulses.clear();
        }
        HostTime { fit: self.fit, pulses }
    }
}

impl HostTime {
    /// The host's time of a device time, µs.
    pub(super) fn of(&self, device_us: u64) -> f64 {
        let Some(last) = self.pulses.len().checked_sub(1) else {
            return self.fit.host_us(device_us);
        };
        let device_us = device_us as f64;
        let after = self.pulses.partition_point(|(device, _)| *device < device_us);
        let (at, other) = match after {
            0 => (0, last.min(ENOUGH)),
            _ if after > last => (last, last.saturating_sub(ENOUGH)),
            _ => (after - 1, after),
        };
        let ((device, host), (other_device, other_host)) = (self.pulses[at], self.pulses[other]);
        // One pulse alone tells when, not how fast.
        let pace = if at == other {
            1.0 / self.fit.rate
        } else {
            (other_host - host) / (other_device - device)
        };
        host + (device_us - device) * pace
    }

    /// Pulses that it rests on.
    pub(super) fn pulses(&self) -> usize {
        self.pulses.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A device whose clock reads `at(t)` µs when the host's reads t µs, fitted `late_us` late, with pulses at these host times.
    fn timing(at: impl Fn(f64) -> f64, rate: f64, late_us: f64, pulses_us: &[f64]) -> Timing {
        let fit = ClockFit {
            device_us: at(0.0) as u64,
            host_us: late_us,
            rate,
            standard_error_ppm: 1.0,
            mean_delay_us: 0.0,
            anchors: 9,
        };
        Timing { fit, pulses_us: pulses_us.iter().map(|t| at(*t).round() as u64).collect() }
    }

    fn by_line(fit: ClockFit) -> HostTime {
        HostTime { fit, pulses: Vec::new() }
    }

    #[test]
    fn what_two_devices_saw_at_once_has_one_time_however_their_frames_came() {
        let fast = |t: f64| 70e6 + t * (1.0 + 40e-6);
        // A crystal that warms up: its rate falls by 4 ppm a minute.
        let warming = |t: f64| 5e6 + t * (1.0 - 20e-6) - 4e-6 * t * t / 120e6;
        let pulses: Vec<f64> = (1..200).map(|k| 1.1e6 * f64::from(k)).collect();
        let reference = timing(fast, 1.0 + 40e-6, 0.0, &pulses);
        // Of another line, 7 ms later, that missed some.
        let other =
            timing(warming, 1.0 - 27e-6, 7_000.0, &[&pulses[2..90], &pulses[93..]].concat());
        let (first, second) =
            (by_line(reference.fit), other.beside(std::slice::from_ref(&reference)));
        assert_eq!(second.pulses(), 194);
        for t in (0..2_190).map(|k| 1e5 * f64::from(k)) {
            let apart = first.of(fast(t).round() as u64) - second.of(warming(t).round() as u64);
            let allowed = if (3.3e6..2.18e8).contains(&t) { 2.0 } else { 30.0 };
            assert!(apart.abs() < allowed, "{apart} µs at {t} µs");
        }
        // Without the pulses they are milliseconds apart.
        assert!((by_line(other.fit).of(warming(1e8) as u64) - 1e8).abs() > 2_000.0);
    }

    #[test]
    fn one_pulse_tells_the_offset_and_none_leaves_the_line() {
        let at = |t: f64| t * 1.01;
        let reference = timing(at, 1.01, 0.0, &[1e6, 2e6]);
        let one = timing(at, 1.01, 5_000.0, &[2e6]).beside(std::slice::from_ref(&reference));
        assert_eq!(one.pulses(), 1);
        assert!((one.of(at(9e6).round() as u64) - 9e6).abs() < 1.0);
        let apart = timing(at, 1.01, 5_000.0, &[2.6e6]);
        assert_eq!(apart.beside(&[reference]), by_line(apart.fit));
        assert_eq!(apart.beside(&[]), by_line(apart.fit));
    }
}
