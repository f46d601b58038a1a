//! The order in which one sample of four gauges passes through calibration, adaptation and phase.

use crate::adaptation;
use crate::calibration::{Calibrated, Calibration};
use crate::flags::Flags;
use crate::phase::{self, Region, RelaxationType};
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Gauges of a fingertip.
pub const GAUGES: usize = 4;

/// Everything that is set rather than measured. May be exchanged between samples; after a change of `calibration` call
/// [`Pipeline::recalibrate`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    /// One for each gauge.
    pub calibration: [Calibration; GAUGES],
    /// The relaxation of the silicone, the same for all gauges.
    pub adaptation: adaptation::Config,
    /// Thresholds of the regions, the same for all gauges.
    pub phase: phase::Config,
}

/// Everything known about one sample of one gauge; strains in LSB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    /// Calibrated strain.
    pub strain: i32,
    /// Fast adapting part.
    pub fa: i32,
    /// Elastic input.
    pub elastic: i32,
    /// Where the strain would settle.
    pub equilibrium: i32,
    /// Region of the grasp.
    pub region: Region,
    /// On the sample at which the region was found: how many samples ago it was entered.
    pub entered_samples_ago: Option<u32>,
    /// Type of relaxation.
    pub relaxation: RelaxationType,
    /// Warnings.
    pub flags: Flags,
}

impl Output {
    /// Slow adapting part; FA + SA is the strain, bit for bit.
    #[must_use]
    pub const fn sa(&self) -> i32 {
        self.strain.wrapping_sub(self.fa)
    }

    /// Latent part; equilibrium + latent is the strain, bit for bit.
    #[must_use]
    pub const fn latent(&self) -> i32 {
        self.strain.wrapping_sub(self.equilibrium)
    }
}

/// How often something happened on one gauge since the start; each stops at the largest `u32`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, Schema)]
pub struct Counters {
    /// Samples taken.
    pub samples: u32,
    /// Samples with the converter at a rail.
    pub converter_at_rail: u32,
    /// Samples whose strain was saturated.
    pub strain_saturated: u32,
    /// Samples at which the filter saturated.
    pub filter_saturated: u32,
}

impl Counters {
    fn count(&mut self, flags: Flags) {
        let add = |counter: &mut u32, flag| {
            *counter = counter.saturating_add(u32::from(flags.contains(flag)));
        };
        add(&mut self.samples, Flags::NONE);
        add(&mut self.converter_at_rail, Flags::CONVERTER_AT_RAIL);
        add(&mut self.strain_saturated, Flags::STRAIN_SATURATED);
        add(&mut self.filter_saturated, Flags::FILTER_SATURATED);
    }
}

/// What four gauges remember between samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Pipeline {
    channels: [Channel; GAUGES],
    /// Last counts and temperature.
    last: Option<([i32; GAUGES], i16)>,
}

/// Begins, part by part, with the first sample it sees, which is taken as settled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
struct Channel {
    adaptation: Option<adaptation::State>,
    phase: Option<phase::State>,
    counters: Counters,
}

impl Pipeline {
    /// A pipeline that has seen nothing; its first sample is taken as settled and out of contact.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes one sample of every gauge (counts, 24 bits) and the temperature (2^-8 °C). The elastic input of each gauge
    /// serves as its motion.
    pub fn process(
        &mut self,
        config: &Config,
        counts: [i32; GAUGES],
        temperature: i16,
    ) -> [Output; GAUGES] {
        self.last = Some((counts, temperature));
        let [a, b, c, d] = &config.calibration;
        let [p, q, r, s] = counts;
        self.pass(
            config,
            [
                a.apply(p, temperature),
                b.apply(q, temperature),
                c.apply(r, temperature),
                d.apply(s, temperature),
            ],
            None,
        )
    }

    /// Takes one sample that is already strain (LSB), as from a recording; strain beyond 24 bits is saturated and flagged.
    /// `motion` is the displacement where it is known, in the unit of the thresholds.
    pub fn process_strain(
        &mut self,
        config: &Config,
        strain: [i32; GAUGES],
        motion: Option<i32>,
    ) -> [Output; GAUGES] {
        let admitted = strain.map(|wide| {
            let strain = crate::fixed::saturate_to_24_bits(i64::from(wide));
            Calibrated { strain, flags: Flags::STRAIN_SATURATED.when(strain != wide) }
        });
        self.pass(config, admitted, motion)
    }

    /// Sets the tares so that the last sample reads zero on every gauge, out of contact; without effect before the first.
    pub fn tare(&mut self, config: &mut Config) {
        if let Some((counts, temperature)) = self.last {
            for (calibration, counts) in config.calibration.iter_mut().zip(counts) {
                *calibration = calibration.tared(counts, temperature);
            }
            self.recalibrate(config);
        }
    }

    /// Takes the tares back.
    pub fn untare(&mut self, config: &mut Config) {
        config.calibration = config.calibration.map(|calibration| calibration.untared());
        self.recalibrate(config);
    }

    /// To be called after a change of calibration: what the filters remember is kept, the last sample is read anew so that
    /// the next is not taken for a step, and the regions begin again at rest.
    pub fn recalibrate(&mut self, config: &Config) {
        let Some((counts, temperature)) = self.last else { return };
        let readings = counts.into_iter().zip(&config.calibration);
        for (channel, (counts, calibration)) in self.channels.iter_mut().zip(readings) {
            let strain = calibration.apply(counts, temperature).strain;
            if let Some(adaptation) = &mut channel.adaptation {
                adaptation.rebase(strain);
            }
            channel.phase = None;
        }
    }

    /// What happened so far, gauge by gauge.
    #[must_use]
    pub fn counters(&self) -> [Counters; GAUGES] {
        self.channels.map(|channel| channel.counters)
    }

    fn pass(
        &mut self,
        config: &Config,
        samples: [Calibrated; GAUGES],
        motion: Option<i32>,
    ) -> [Output; GAUGES] {
        let [a, b, c, d] = &mut self.channels;
        let [p, q, r, s] = samples;
        [
            a.pass(config, p, motion),
            b.pass(config, q, motion),
            c.pass(config, r, motion),
            d.pass(config, s, motion),
        ]
    }
}

impl Channel {
    fn pass(&mut self, config: &Config, sample: Calibrated, motion: Option<i32>) -> Output {
        let strain = sample.strain;
        let adaptation = self.adaptation.get_or_insert_with(|| adaptation::State::at_rest(strain));
        let saturations = adaptation.saturations();
        let split = adaptation.step(&config.adaptation, strain);
        let flags =
            sample.flags | Flags::FILTER_SATURATED.when(adaptation.saturations() != saturations);
        self.counters.count(flags);

        let motion = motion.unwrap_or(split.elastic);
        let phase = self.phase.get_or_insert_with(|| phase::State::at_rest(motion, strain)).step(
            &config.phase,
            motion,
            strain,
            split.latent(),
        );
        Output {
            strain,
            fa: split.fa,
            elastic: split.elastic,
            equilibrium: split.equilibrium,
            region: phase.region,
            entered_samples_ago: phase.entered_samples_ago,
            relaxation: phase.relaxation,
            flags,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adaptation::Relaxation;
    use crate::calibration::Sheet;
    use crate::fixed::STRAIN_MAX;
    use crate::phase::Thresholds;
    use core::array;
    use proptest::prelude::*;

    fn config() -> Config {
        let interval = 1.0 / 1000.0;
        let sheet = |gauge: usize| Sheet {
            gain: 0.002 + 0.001 * gauge as f64,
            offset: 1_000 * gauge as i32,
            temperature_coefficient: 1.0,
            reference_celsius: 20.0,
        };
        let silicone = Relaxation { c1: 0.2, v1: 8.0, c2: 0.2, v2: 0.5 };
        let thresholds = Thresholds {
            touch: 5_000,
            release: 2_500,
            peak_drop: 2_000,
            motion_step: 4_000,
            latent_dead_band: 1_000,
            smoothing_s: 0.004,
            dwell_s: 0.05,
            recovery_limit_s: 10.0,
        };
        Config {
            calibration: array::from_fn(|gauge| Calibration::new(&sheet(gauge)).unwrap()),
            adaptation: adaptation::Config::new(&silicone, interval).unwrap(),
            phase: phase::Config::new(&thresholds, interval).unwrap(),
        }
    }

    /// The same press on every gauge: up in 0.2 s, held, most of it back, held; in counts.
    fn press(sample: u32) -> [i32; GAUGES] {
        let t = f64::from(sample) / 1000.0;
        let up = (t / 0.2).min(1.0) - 0.7 * ((t - 1.0) / 0.2).clamp(0.0, 1.0);
        array::from_fn(|gauge| (200_000.0 * up) as i32 + 1_000 * gauge as i32)
    }

    #[test]
    fn every_gauge_is_calibrated_filtered_and_placed_in_its_region() {
        let config = config();
        let mut pipeline = Pipeline::new();
        let mut held = [Region::Rest; GAUGES];
        for sample in 0..1_000 {
            held = pipeline.process(&config, press(sample), 20 * 256).map(|out| out.region);
        }
        assert_eq!(held, [Region::Relaxation; GAUGES]);
        let last = (1_000..1_400).map(|i| pipeline.process(&config, press(i), 20 * 256)).last();
        for (gauge, out) in last.unwrap().iter().enumerate() {
            let microstrain = (0.002 + 0.001 * gauge as f64) * 60_000.0;
            assert!((out.strain - (microstrain * 256.0) as i32).abs() <= 1);
            assert_eq!(out.fa + out.sa(), out.strain);
            assert_eq!(out.region, Region::Relaxation);
            assert_eq!(out.relaxation, RelaxationType::TypeII);
        }
        assert_eq!(pipeline.counters()[3].samples, 1_400);
    }

    #[test]
    fn a_tare_reads_zero_without_a_step_in_any_filter_and_can_be_taken_back() {
        let mut config = config();
        let untouched = config;
        let mut pipeline = Pipeline::new();
        for sample in 0..300 {
            pipeline.process(&config, press(sample), 0);
        }
        let before = pipeline.process(&config, press(300), 0);
        pipeline.tare(&mut config);
        let after = pipeline.process(&config, press(300), 0);
        for (before, after) in before.iter().zip(&after) {
            assert_eq!((after.strain, after.region), (0, Region::Rest));
            assert!((before.fa - after.fa).abs() * 50 < before.fa);
        }
        pipeline.untare(&mut config);
        assert_eq!(config, untouched);
        assert_eq!(pipeline.process(&config, press(300), 0)[0].strain, before[0].strain);
    }

    #[test]
    fn what_saturates_is_flagged_on_its_gauge_and_counted() {
        let config = config();
        let mut pipeline = Pipeline::new();
        let out = pipeline.process(&config, [0, 0, 0, STRAIN_MAX], 0);
        assert!(out[3].flags.contains(Flags::CONVERTER_AT_RAIL | Flags::STRAIN_SATURATED));
        assert_eq!(out[0].flags, Flags::NONE);
        let counters = pipeline.counters();
        assert_eq!((counters[3].converter_at_rail, counters[3].strain_saturated), (1, 1));
        assert_eq!((counters[0].converter_at_rail, counters[0].samples), (0, 1));
    }

    #[test]
    fn a_recording_in_strain_gives_what_the_same_counts_give() {
        let config = config();
        let (mut counts, mut strains) = (Pipeline::new(), Pipeline::new());
        for sample in 0..1_500 {
            let expected = counts.process(&config, press(sample), 0);
            let strain = expected.map(|out| out.strain);
            assert_eq!(strains.process_strain(&config, strain, None), expected);
        }
    }

    proptest! {
        #[test]
        fn any_counts_and_temperatures_pass_without_panic_and_keep_both_sums(
            samples in prop::collection::vec((any::<[i32; GAUGES]>(), any::<i16>()), 1..100),
        ) {
            let mut config = config();
            let mut pipeline = Pipeline::new();
            for (i, (counts, temperature)) in samples.into_iter().enumerate() {
                if i % 17 == 16 {
                    pipeline.tare(&mut config);
                }
                for out in pipeline.process(&config, counts, temperature) {
                    prop_assert_eq!(out.fa + out.sa(), out.strain);
                    prop_assert_eq!(out.equilibrium + out.latent(), out.strain);
                }
            }
        }
    }
}
