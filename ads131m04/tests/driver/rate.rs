//! Gains, data rates and the watch over DRDY.

use crate::script::{Script, config};
use ads131m04::{
    Clock, ClockError, Config, DrdyWatch, Gain, Oversampling, PowerMode, STUCK_AFTER_INTERVALS,
};
use proptest::prelude::*;

fn at(clkin_hz: u32, oversampling: Oversampling) -> Config {
    let clock = Clock::new(clkin_hz, PowerMode::HighResolution).unwrap();
    Config { clock, oversampling, chop: false, gains: [Gain::X1; 4] }
}

#[test]
fn the_rates_at_8_192_mhz_are_those_of_the_datasheet() {
    let rates = Oversampling::ALL.map(|osr| at(8_192_000, osr).data_rate_millihertz());
    let table = [32_000, 16_000, 8_000, 4_000, 2_000, 1_000, 500, 250].map(|hz| hz * 1000);
    assert_eq!(rates, table);
}

#[test]
fn a_clock_of_8_mhz_gives_976_563_millihertz_and_the_exact_ratio() {
    let config = at(8_000_000, Oversampling::X4096);
    assert_eq!(config.oversampling.ratio(), 4096);
    assert_eq!(config.oversampling.clkin_periods(), 8192);
    assert_eq!(config.data_rate_millihertz(), 976_563); // 976.5625 Hz
    assert_eq!(config.sample_interval_ns(), 1_024_000);
}

#[test]
fn with_the_chop_conversions_are_three_times_as_far_apart_and_wait_for_the_inputs() {
    let chopped = Config { chop: true, ..at(8_000_000, Oversampling::X1024) };
    // 3 × 1024 and 16 periods of 4 MHz.
    assert_eq!((chopped.clkin_periods(), chopped.sample_interval_ns()), (6_176, 772_000));
    assert_eq!(chopped.data_rate_millihertz(), 1_295_337);
}

#[test]
fn each_power_mode_takes_the_clocks_of_its_range_only() {
    for (power, max_hz) in [
        (PowerMode::VeryLow, 2_080_000),
        (PowerMode::Low, 4_150_000),
        (PowerMode::HighResolution, 8_400_000),
    ] {
        assert_eq!(Clock::new(max_hz, power).map(Clock::hz), Ok(max_hz));
        assert!(Clock::new(300_000, power).is_ok());
        for hz in [0, 299_999, max_hz + 1, u32::MAX] {
            assert_eq!(Clock::new(hz, power), Err(ClockError { hz, power }));
        }
    }
    let error = Clock::new(8_192_000, PowerMode::Low).unwrap_err();
    assert_eq!(error.to_string(), "Low takes a CLKIN of 300000 to 4150000 Hz, not 8192000 Hz");
}

#[test]
fn every_gain_oversampling_and_power_mode_has_its_code() {
    let powers = [PowerMode::VeryLow, PowerMode::Low, PowerMode::HighResolution];
    for (code, (gain, oversampling)) in (0_u16..).zip(Gain::ALL.into_iter().zip(Oversampling::ALL))
    {
        assert_eq!(gain.factor(), 1 << code);
        assert_eq!(oversampling.ratio(), 128 << code);
        for (power_code, power) in (0_u16..).zip(powers) {
            let clock = Clock::new(2_048_000, power).unwrap();
            let config = Config { clock, oversampling, chop: code % 2 == 1, gains: [gain; 4] };
            let clock_register = 0x0F00 | code << 2 | power_code;
            Script::default()
                .written(2, 0x1110, 0x1110)
                .written(3, clock_register, clock_register)
                .written(4, code * 0x1111, code * 0x1111)
                .written(6, 0x0600 | (code % 2) << 8, 0x0600 | (code % 2) << 8)
                .stale()
                .meet(|chip| chip.configure(&config).unwrap());
        }
    }
}

#[test]
fn missed_edges_are_counted_however_long_the_gap() {
    let mut watch = DrdyWatch::new(at(8_192_000, Oversampling::X128).sample_interval_ns(), 0);
    assert_eq!(watch.edge(31), 0); // every 31.25 µs
    assert_eq!(watch.edge(62), 0);
    assert_eq!(watch.edge(62 + 1_000_000), 31_999);
}

#[test]
fn an_edge_may_be_early_or_late_by_half_an_interval() {
    for (edge_us, missed) in [(501, 0), (1_499, 0), (1_500, 1), (2_499, 1), (2_500, 2)] {
        assert_eq!(DrdyWatch::new(1_000_000, 0).edge(edge_us), missed, "at {edge_us} µs");
    }
}

#[test]
fn a_stuck_drdy_is_noticed_after_16_intervals_and_forgiven_at_the_next_edge() {
    let mut watch = DrdyWatch::new(config().sample_interval_ns(), 5_000);
    let due_us = 5_000 + STUCK_AFTER_INTERVALS * 1_000;
    assert!(!watch.is_stuck(due_us - 1));
    assert!(watch.is_stuck(due_us));
    assert_eq!(watch.overdue(due_us), 16);
    assert_eq!(watch.edge(due_us), 15);
    assert!(!watch.is_stuck(due_us));
}

proptest! {
    #[test]
    fn the_rate_is_the_nearest_millihertz(hz in 300_000_u32..=8_400_000, osr in 0_usize..8) {
        let config = at(hz, Oversampling::ALL[osr]);
        let exact_mhz = f64::from(hz) * 1000.0 / f64::from(config.oversampling.clkin_periods());
        let exact_ns = 1e12 / exact_mhz;
        prop_assert!((f64::from(config.data_rate_millihertz()) - exact_mhz).abs() <= 0.5 + 1e-6);
        prop_assert!((f64::from(config.sample_interval_ns()) - exact_ns).abs() <= 0.5 + 1e-6);
    }

    #[test]
    fn no_time_makes_the_watch_panic(interval_ns: u32, start_us: u64, times: [u64; 8]) {
        let mut watch = DrdyWatch::new(interval_ns, start_us);
        for now_us in times {
            prop_assert!(!watch.is_stuck(now_us) || watch.overdue(now_us) >= STUCK_AFTER_INTERVALS);
            watch.edge(now_us);
            prop_assert_eq!(watch.overdue(now_us), 0);
        }
    }
}
