//! A temperature that does not step: a coarse sensor, read often.

/// Readings that the first temperature is the mean of.
const FIRST: i32 = 64;
/// A reading moves the temperature by 2^-12 of its difference: at one reading in 10 ms the time constant is 41 s, and a sensor
/// that toggles between two values 0.3 °C apart moves it by less than its resolution.
const SHARE_BITS: u32 = 12;

/// A temperature, smoothed over many readings.
#[derive(Clone, Copy, Debug, Default)]
pub struct Smoothed {
    /// Readings so far, up to [`FIRST`].
    readings: i32,
    /// Their sum at first, 2^-8 °C; then the temperature with [`SHARE_BITS`] more bits.
    state: i32,
}

impl Smoothed {
    /// Takes a reading, 2^-8 °C; the smoothed temperature in the same unit, once there is one.
    pub fn take(&mut self, reading: i16) -> Option<i16> {
        let reading = i32::from(reading);
        if self.readings < FIRST {
            self.readings = self.readings.saturating_add(1);
            self.state = self.state.saturating_add(reading);
            if self.readings < FIRST {
                return None;
            }
            self.state = (self.state / FIRST) << SHARE_BITS;
        } else {
            let difference = reading.wrapping_sub(self.state >> SHARE_BITS);
            self.state = self.state.saturating_add(difference);
        }
        i16::try_from(self.state >> SHARE_BITS).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sensor_that_toggles_does_not() {
        let mut smoothed = Smoothed::default();
        let mut seen = Vec::new();
        for reading in 0..10_000 {
            // 0.32 °C apart.
            let read = if reading % 3 == 0 { 8_704 + 82 } else { 8_704 };
            seen.extend(smoothed.take(read));
        }
        let (least, most) = (seen.iter().min().unwrap(), seen.iter().max().unwrap());
        assert!(most - least <= 2, "{least} to {most}");
        assert!((8_704 + 82 / 3 - least).abs() <= 3);
    }

    #[test]
    fn a_step_is_followed_without_one() {
        let mut smoothed = Smoothed::default();
        let mut before = None;
        for reading in 0..60_000 {
            let now = smoothed.take(if reading < 100 { 25 * 256 } else { 26 * 256 });
            if let (Some(now), Some(before)) = (now, before) {
                let step: i16 = now - before;
                assert!(step.abs() <= 1);
            }
            before = now;
        }
        assert!((before.unwrap() - 26 * 256).abs() <= 1);
    }
}
