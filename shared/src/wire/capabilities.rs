//! What the converter of a device can do.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use super::by_ratio::{Oversampling, interval_of_periods_ns};
use super::settings::Settings;

/// Most rates that a converter can be set to.
pub const RATES: usize = 8;

/// Full scale that [`Settings::DEFAULT`] is calibrated for, nV.
const DEFAULT_FULL_SCALE_NV: u32 = 1_200_000_000;

/// Periods of an ADS131M04's clock from one conversion to the next with its global chop, at an oversampling ratio of 1024: 3 × 1024
/// and 16 of its modulator, two of the clock each.
const CHOPPED_PERIODS: u32 = 2 * (3 * 1_024 + 16);
/// An interval with the chop is meant by whoever names it this closely.
const MEANT_WITHIN: f64 = 1.01;

/// What the converter can do, as a device says after `Hello`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Capabilities {
    /// Gauges it reads; a pipeline takes zeros for the others, and rows do not carry them.
    pub channels: u8,
    /// Times between two samples that can be set, ns, the shortest first; behind the last are zeros.
    pub intervals_ns: [u32; RATES],
    /// Of those, the ones at which the converter takes its own offset away by swapping its inputs: bit n is the n-th.
    pub chopped: u8,
    /// Gains that can be set: bit n is a gain of 2^n.
    pub gains: u8,
    /// Full scale at a gain of 1, nV either way.
    pub full_scale_nv: u32,
    /// Bits of a count.
    pub count_bits: u8,
    /// Samples after a change of gain or rate that are given up, because they mix old and new.
    pub settling: u8,
    /// Counts of the signal with which it tests itself; 0 if it has none.
    pub test_counts: i32,
}

impl Capabilities {
    /// Those of an ADS131M04 with this clock at CLKIN, Hz; every device of release 0.1 has one.
    #[must_use]
    pub const fn ads131m04(clock_hz: u32) -> Self {
        let [a, b, c, d, e] = Oversampling::ALL;
        Self {
            channels: 4,
            intervals_ns: [
                a.interval_ns(clock_hz),
                b.interval_ns(clock_hz),
                interval_of_periods_ns(CHOPPED_PERIODS, clock_hz),
                c.interval_ns(clock_hz),
                d.interval_ns(clock_hz),
                e.interval_ns(clock_hz),
                0,
                0,
            ],
            chopped: 1 << 2,
            gains: 0xff,
            full_scale_nv: DEFAULT_FULL_SCALE_NV,
            count_bits: 24,
            settling: 3,
            // 2/15 of full scale.
            test_counts: (1 << 24) / 15,
        }
    }

    /// Times between two samples that can be set, ns.
    pub fn intervals_ns(&self) -> impl Iterator<Item = u32> {
        self.intervals_ns.into_iter().filter(|interval| *interval > 0)
    }

    /// Whether samples can be so far apart.
    #[must_use]
    pub fn has_interval(&self, interval_ns: u32) -> bool {
        self.intervals_ns().any(|has| has == interval_ns)
    }

    /// Whether a gauge can have this gain.
    #[must_use]
    pub const fn has_gain(&self, gain: u8) -> bool {
        gain.is_power_of_two() && gain & self.gains != 0
    }

    /// Whether the converter takes its own offset away at this interval.
    #[must_use]
    pub fn is_chopped(&self, interval_ns: u32) -> bool {
        let at = self.intervals_ns().position(|has| has == interval_ns);
        at.is_some_and(|at| self.chopped >> at & 1 == 1)
    }

    /// The interval that is nearest, by ratio, ns; one with the chop only if it is meant.
    #[must_use]
    pub fn nearest_ns(&self, wanted_s: f64) -> u32 {
        let off = |interval_ns: u32| {
            let ratio = f64::from(interval_ns) / (wanted_s * 1e9);
            if ratio < 1.0 { 1.0 / ratio } else { ratio }
        };
        let nearer = |a: u32, b: u32| if off(b) < off(a) { b } else { a };
        let comes = |ns: &u32| !self.is_chopped(*ns) || off(*ns) < MEANT_WITHIN;
        self.intervals_ns().filter(comes).reduce(nearer).unwrap_or(Settings::DEFAULT.interval_ns)
    }

    /// Settings of a device that was never set.
    #[must_use]
    pub fn defaults(&self) -> Settings {
        let mut settings = Settings::DEFAULT;
        for sheet in &mut settings.calibration {
            sheet.gain *= f64::from(self.full_scale_nv) / f64::from(DEFAULT_FULL_SCALE_NV);
        }
        self.suited(settings)
    }

    /// Settings as near as the converter can follow them. Gains keep the calibration true.
    #[must_use]
    pub fn suited(&self, settings: Settings) -> Settings {
        let highest = 1_u8.wrapping_shl(7_u32.saturating_sub(self.gains.leading_zeros()));
        let gain = settings.gain.map(|gain| if self.has_gain(gain) { gain } else { highest });
        let interval_ns = self.nearest_ns(settings.interval_s());
        Settings { interval_ns, ..settings }.with_gain(gain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slow, with two gains.
    const SLOW: Capabilities = Capabilities {
        channels: 1,
        intervals_ns: [12_500_000, 100_000_000, 0, 0, 0, 0, 0, 0],
        chopped: 0,
        gains: 1 << 5 | 1 << 6,
        full_scale_nv: 2 * DEFAULT_FULL_SCALE_NV,
        count_bits: 24,
        settling: 4,
        test_counts: 0,
    };

    #[test]
    fn the_nearest_rate_is_taken_by_ratio() {
        let fast = Capabilities::ads131m04(8_000_000);
        let taken = |wanted_hz: f64| 1e9 / f64::from(fast.nearest_ns(1.0 / wanted_hz));
        assert_eq!(taken(1_000.0), 976.562_5);
        assert_eq!(taken(1.0), 244.140_625);
        assert_eq!(taken(1e6), 3_906.25);
        // The one with the chop is nearer, and not meant; then it is.
        assert_eq!(taken(1_250.0), 976.562_5);
        assert_eq!(fast.nearest_ns(1.0 / 1_295.0), 772_000);
        assert!(fast.is_chopped(772_000) && !fast.is_chopped(512_000));
        // Nearer to 976.6 by difference, to 488.3 by ratio.
        assert_eq!(taken(680.0), 488.281_25);
    }

    #[test]
    fn defaults_are_what_the_converter_has_and_mean_the_same_strain() {
        let fast = Capabilities::ads131m04(8_000_000);
        assert_eq!(fast.defaults(), Settings::DEFAULT);
        let slow = SLOW.defaults();
        assert_eq!((slow.interval_ns, slow.gain[0]), (12_500_000, 64));
        // Twice the full scale and half the gain: four times the strain of a count.
        assert_eq!(slow.calibration[0].gain, 4.0 * Settings::DEFAULT.calibration[0].gain);
        slow.config(slow.interval_s()).unwrap();
        assert!(!SLOW.has_gain(128) && !SLOW.has_gain(96) && SLOW.has_gain(32));
        assert!(SLOW.has_interval(100_000_000) && !SLOW.has_interval(0));
    }
}
