//! Times of rows by the clock of this computer, while they come.

use std::time::{Instant, SystemTime, UNIX_EPOCH};

use palpate_trace::recording::{Clock, ClockFit};

/// The clocks are related anew so often, µs.
const EVERY_US: u64 = 1_000_000;
/// Before messages reach over so long, µs, two late ones could tilt the line between the clocks: until then the device is taken
/// to run as fast as the host.
const SPAN_US: u64 = 5_000_000;
/// What was heard longer ago is forgotten, µs: the rate of a crystal follows its temperature.
const WINDOW_US: u64 = 60_000_000;

/// Relates the times of a device to those of this computer while its messages come, later by the least delay of a message.
#[derive(Debug)]
pub(super) struct Stamps {
    began: Instant,
    began_unix_us: u64,
    clock: Clock,
    /// Where the window of the clock begins: device time of its first message, µs.
    first_us: Option<u64>,
    /// Host time less device time of the message that was least late, µs.
    offset_us: i128,
    line: Option<ClockFit>,
    related_us: u64,
}

impl Stamps {
    /// Times from now on.
    pub(super) fn new() -> Self {
        let unix = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self::since(Instant::now(), unix.as_micros() as u64)
    }

    fn since(began: Instant, began_unix_us: u64) -> Self {
        Self {
            began,
            began_unix_us,
            clock: Clock::with_window(WINDOW_US),
            first_us: None,
            offset_us: i128::MAX,
            line: None,
            related_us: 0,
        }
    }

    /// The device began anew, or another stream.
    pub(super) fn restart(&mut self) {
        *self = Self::since(self.began, self.began_unix_us);
    }

    /// A message of this device time, µs, arrived.
    pub(super) fn hear(&mut self, device_us: u64, at: Instant) {
        let passed = at.saturating_duration_since(self.began).as_micros() as u64;
        let host_us = self.began_unix_us.saturating_add(passed);
        if self.clock.anchor(device_us, host_us) {
            (self.first_us, self.line, self.offset_us) = (None, None, i128::MAX);
        }
        let first_us = *self.first_us.get_or_insert(device_us);
        self.offset_us = self.offset_us.min(i128::from(host_us) - i128::from(device_us));
        let spans = device_us.saturating_sub(first_us) >= SPAN_US;
        if spans && (self.line.is_none() || host_us >= self.related_us + EVERY_US) {
            self.line = self.clock.fit();
            self.related_us = host_us;
        }
    }

    /// Host time of a device time, ns since 1970; that of the beginning before anything was heard.
    pub(super) fn unix_ns(&self, device_us: u64) -> u64 {
        let host_us = match &self.line {
            Some(line) => line.host_us(device_us),
            None if self.first_us.is_none() => self.began_unix_us as f64,
            None => (i128::from(device_us) + self.offset_us) as f64,
        };
        (host_us * 1e3) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    const UNIX_US: u64 = 1_700_000_000_000_000;
    const BOOTED_US: u64 = 77_000_000;

    /// A device whose clock gains 80 µs in a second sends a message every 32 ms, each late by 1 ms and up to 9 more; the
    /// greatest error of a stamp, µs, over some seconds.
    fn worst_us(from_s: u64, to_s: u64) -> f64 {
        let began = Instant::now();
        let mut stamps = Stamps::since(began, UNIX_US);
        let (mut worst, mut late) = (0.0_f64, 1_u64);
        for message in 0..to_s * 1_000_000 / 32_000 {
            let host_us = message * 32_000;
            late = late.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695);
            let device_us = BOOTED_US + (host_us as f64 * (1.0 + 80e-6)) as u64;
            stamps.hear(
                device_us,
                began + Duration::from_micros(host_us + 1_000 + (late >> 33) % 9_000),
            );
            if host_us >= from_s * 1_000_000 {
                let told = stamps.unix_ns(device_us) as f64 * 1e-3 - UNIX_US as f64;
                worst = worst.max((told - host_us as f64).abs());
            }
        }
        worst
    }

    #[test]
    fn stamps_follow_the_clock_of_the_device_to_two_milliseconds() {
        let worst = worst_us(10, 300);
        assert!(worst < 2_500.0, "{worst} µs");
        // At the beginning no better than the messages are late.
        assert!(worst_us(0, 10) < 10_500.0);
    }

    #[test]
    fn a_device_that_begins_anew_is_followed_anew() {
        let began = Instant::now();
        let mut stamps = Stamps::since(began, UNIX_US);
        let second = |s: u64| Duration::from_secs(s);
        for s in 0..20 {
            stamps.hear(BOOTED_US + s * 1_000_000, began + second(s));
        }
        stamps.hear(1_000, began + second(25));
        assert_eq!(stamps.unix_ns(1_000), (UNIX_US + 25_000_000) * 1_000);
    }
}
