//! The order in which one sample of four gauges passes through calibration, adaptation and phase.

use crate::adaptation;
use crate::calibration::{Calibrated, Calibration, Conversion};
use crate::fixed::saturate_to_24_bits;
use crate::flags::Flags;
use crate::phase::{self, Region, RelaxationType};
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Gauges of a fingertip.
pub const GAUGES: usize = 4;

/// Everything that is set rather than measured.
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

/// How many samples of one gauge carried a warning; each stops at the largest `u32`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, Schema)]
pub struct Counters {
    /// With the converter at a rail.
    pub converter_at_rail: u32,
    /// With a strain that was saturated.
    pub strain_saturated: u32,
    /// At which the filter saturated.
    pub filter_saturated: u32,
}

impl Counters {
    fn count(&mut self, flags: Flags) {
        let add = |counter: &mut u32, flag| {
            *counter = counter.saturating_add(u32::from(flags.contains(flag)));
        };
        add(&mut self.converter_at_rail, Flags::CONVERTER_AT_RAIL);
        add(&mut self.strain_saturated, Flags::STRAIN_SATURATED);
        add(&mut self.filter_saturated, Flags::FILTER_SATURATED);
    }
}

/// Four gauges: their configuration and what they remember between samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Pipeline {
    /// First in memory: within reach of the instructions that load and store two words at once.
    channels: [Channel; GAUGES],
    config: Config,
    samples: u32,
    /// The next sample is taken as settled.
    anew: bool,
    news: News,
    /// Of the last sample, if it came as counts.
    counts: Option<[i32; GAUGES]>,
    /// Of the conversions, 2^-8 °C.
    temperature: i16,
}

/// Whether region, relaxation or flags of any gauge may be others than a sample before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct News {
    /// At the last sample.
    now: bool,
    /// At the next one in any case, because there were flags, which hold for one sample, or the regions begin again.
    next: bool,
}

/// One gauge. All that a sample needs lies side by side, with coefficients of its own: on the device that saves a tenth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Channel {
    conversion: Conversion,
    relaxation: adaptation::Config,
    adaptation: adaptation::State,
    phase: phase::State,
    flags: Flags,
    counters: Counters,
}

impl Pipeline {
    /// A pipeline that has seen nothing; its first sample is taken as settled and out of contact.
    #[must_use]
    pub fn new(config: &Config) -> Self {
        let temperature = 0;
        let channels = config.calibration.map(|calibration| Channel {
            conversion: calibration.at(temperature),
            relaxation: config.adaptation,
            adaptation: adaptation::State::at_rest(0),
            phase: phase::State::of_either_sense(0, 0),
            flags: Flags::NONE,
            counters: Counters::default(),
        });
        Self {
            config: *config,
            channels,
            samples: 0,
            anew: true,
            news: News { now: true, next: true },
            counts: None,
            temperature,
        }
    }

    /// Takes one sample of every gauge (counts, 24 bits) and the temperature (2^-8 °C). The elastic input of each gauge
    /// serves as its motion.
    pub fn process(&mut self, counts: &[i32; GAUGES], temperature: i16) {
        self.counts = Some(*counts);
        if temperature != self.temperature {
            self.temperature = temperature;
            self.convert();
        }
        if self.anew {
            self.read_anew();
        }
        self.pass(counts, None, Channel::calibrate);
    }

    /// Takes one sample that is already strain (LSB), as from a recording; strain beyond 24 bits is saturated and flagged.
    /// `motion` is the displacement where it is known, in the unit of the thresholds; pressing must then raise the strain.
    pub fn process_strain(&mut self, strain: &[i32; GAUGES], motion: Option<i32>) {
        self.counts = None;
        if self.anew {
            self.anew = false;
            for (channel, strain) in self.channels.iter_mut().zip(strain) {
                channel.rest_at(*strain, motion);
            }
        }
        self.pass(strain, motion, Channel::admit);
    }

    /// What is known about the last sample; what is not asked for costs nothing.
    #[inline(always)]
    #[must_use]
    pub fn outputs(&self) -> [Output; GAUGES] {
        let [a, b, c, d] = &self.channels;
        [a.output(), b.output(), c.output(), d.output()]
    }

    /// Whether at the last sample a region was found, or region, relaxation or flags of any gauge may be others than before.
    #[inline(always)]
    #[must_use]
    pub const fn is_news(&self) -> bool {
        self.news.now
    }

    /// How many samples were taken since the start; stops at the largest `u32`.
    #[must_use]
    pub const fn samples(&self) -> u32 {
        self.samples
    }

    /// How many samples carried a warning, gauge by gauge.
    #[must_use]
    pub fn counters(&self) -> [Counters; GAUGES] {
        self.channels.each_ref().map(|channel| channel.counters)
    }

    /// The present configuration, with its tares.
    #[must_use]
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// Exchanges the configuration between two samples. What the filters remember is kept. After a change of calibration the
    /// last counts are read anew, so that the next are not taken for a step, and the regions begin again at rest.
    pub fn configure(&mut self, config: &Config) {
        let recalibrated = config.calibration != self.config.calibration;
        self.config = *config;
        for channel in &mut self.channels {
            channel.relaxation = config.adaptation;
        }
        if recalibrated {
            self.convert();
            self.read_anew();
        }
    }

    /// Exchanges the configuration between two samples together with gains or rate of the converter: the next counts are of
    /// the new gains, those before are of no use any more. What the filters remember is kept, and so are the regions, unless
    /// a strain means something else from now on: `same_strain` says that it does not.
    pub fn exchange(&mut self, config: &Config, same_strain: bool) {
        let samples = self.counts.take();
        self.configure(config);
        self.anew = self.anew || (samples.is_some() && !same_strain);
    }

    /// Sets the tares so that the last counts read zero on every gauge, out of contact; without effect if the last sample
    /// did not come as counts.
    pub fn tare(&mut self) {
        let Some(counts) = self.counts else { return };
        let mut config = self.config;
        for (calibration, counts) in config.calibration.iter_mut().zip(counts) {
            *calibration = calibration.tared(counts, self.temperature);
        }
        self.configure(&config);
    }

    /// Takes the tares back.
    pub fn untare(&mut self) {
        let calibration = self.config.calibration.map(|calibration| calibration.untared());
        self.configure(&Config { calibration, ..self.config });
    }

    /// The calibrations at the present temperature.
    #[cold]
    fn convert(&mut self) {
        for (channel, calibration) in self.channels.iter_mut().zip(&self.config.calibration) {
            channel.conversion = calibration.at(self.temperature);
        }
    }

    /// Takes the strain of the last counts for that of the last sample, so that the next one is no step.
    #[cold]
    fn read_anew(&mut self) {
        let Some(counts) = self.counts else { return };
        self.anew = false;
        self.news.next = true;
        for (channel, counts) in self.channels.iter_mut().zip(counts) {
            channel.rest_at(channel.conversion.apply(counts).strain, None);
        }
    }

    #[inline(always)]
    fn pass(
        &mut self,
        raw: &[i32; GAUGES],
        motion: Option<i32>,
        strain: impl Fn(&mut Channel, i32, &mut News) -> i32,
    ) {
        self.samples = self.samples.saturating_add(1);
        self.news.now = self.news.next;
        if self.news.next {
            self.news.next = false;
            self.channels.iter_mut().for_each(Channel::forget_flags);
        }
        let [a, b, c, d] = &mut self.channels;
        let [p, q, r, s] = *raw;
        let (phase, news) = (&self.config.phase, &mut self.news);
        let mut step = |channel: &mut Channel, raw| {
            let strain = strain(channel, raw, news);
            channel.step(phase, strain, motion, news);
        };
        step(a, p);
        step(b, q);
        step(c, r);
        step(d, s);
    }
}

impl Channel {
    /// Counts → strain.
    #[inline(always)]
    fn calibrate(&mut self, counts: i32, news: &mut News) -> i32 {
        self.conversion.ordinary(counts).unwrap_or_else(|| {
            let Calibrated { strain, flags } = self.conversion.limited(counts);
            self.warn(flags, news);
            strain
        })
    }

    /// Strain → strain of 24 bits.
    #[inline(always)]
    fn admit(&mut self, wide: i32, news: &mut News) -> i32 {
        let strain = saturate_to_24_bits(i64::from(wide));
        if strain != wide {
            self.warn(Flags::STRAIN_SATURATED, news);
        }
        strain
    }

    /// Strain of 24 bits → everything else.
    #[inline(always)]
    fn step(&mut self, phase: &phase::Config, strain: i32, motion: Option<i32>, news: &mut News) {
        if self.adaptation.advance(&self.relaxation, strain) {
            self.warn(Flags::FILTER_SATURATED, news);
        }
        let split = self.adaptation.output(&self.relaxation);
        let motion = motion.unwrap_or(split.elastic);
        if self.phase.advance(phase, motion, strain, split.latent()) {
            news.now = true;
        }
    }

    #[cold]
    #[inline(never)]
    fn warn(&mut self, flags: Flags, news: &mut News) {
        *news = News { now: true, next: true };
        self.flags = self.flags | flags;
        self.counters.count(flags);
    }

    #[cold]
    #[inline(never)]
    fn forget_flags(&mut self) {
        self.flags = Flags::NONE;
    }

    /// Takes a strain for settled; the regions begin at rest.
    fn rest_at(&mut self, strain: i32, motion: Option<i32>) {
        self.adaptation.rebase(strain);
        let split = self.adaptation.output(&self.relaxation);
        self.phase = match motion {
            Some(motion) => phase::State::at_rest(motion, split.signal),
            None => phase::State::of_either_sense(split.elastic, split.signal),
        };
    }

    #[inline(always)]
    fn output(&self) -> Output {
        let split = self.adaptation.output(&self.relaxation);
        let phase = self.phase.phase();
        Output {
            strain: split.signal,
            fa: split.fa,
            elastic: split.elastic,
            equilibrium: split.equilibrium,
            region: phase.region,
            entered_samples_ago: phase.entered_samples_ago,
            relaxation: phase.relaxation,
            flags: self.flags,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adaptation::Relaxation;
    use crate::calibration::Sheet;
    use crate::fixed::{STRAIN_MAX, STRAIN_MIN};
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
        let mut pipeline = Pipeline::new(&config());
        for sample in 0..1_000 {
            pipeline.process(&press(sample), 20 * 256);
        }
        assert_eq!(pipeline.outputs().map(|out| out.region), [Region::Relaxation; GAUGES]);
        for sample in 1_000..1_400 {
            pipeline.process(&press(sample), 20 * 256);
        }
        for (gauge, out) in pipeline.outputs().iter().enumerate() {
            let microstrain = (0.002 + 0.001 * gauge as f64) * 60_000.0;
            assert!((out.strain - (microstrain * 256.0) as i32).abs() <= 1);
            assert_eq!(out.fa + out.sa(), out.strain);
            assert_eq!(out.region, Region::Relaxation);
            assert_eq!(out.relaxation, RelaxationType::TypeII);
        }
        assert_eq!(pipeline.samples(), 1_400);
    }

    #[test]
    fn a_gauge_that_pressing_stretches_is_in_the_same_region_as_one_that_it_compresses() {
        let mut config = config();
        let stretched = Sheet {
            gain: -0.002,
            offset: 0,
            temperature_coefficient: 0.0,
            reference_celsius: 20.0,
        };
        config.calibration[2] = Calibration::new(&stretched).unwrap();
        config.calibration[3] = Calibration::new(&Sheet { gain: 0.002, ..stretched }).unwrap();
        let mut pipeline = Pipeline::new(&config);
        for sample in 0..1_400 {
            let [counts, ..] = press(sample);
            pipeline.process(&[counts; GAUGES], 20 * 256);
            let [.., stretched, compressed] = pipeline.outputs();
            assert_eq!(stretched.strain, -compressed.strain);
            // A motion that begins is found a little later than touch is.
            if !(1..100).contains(&sample) {
                let told = |out: &Output| (out.region, out.relaxation);
                assert_eq!(told(&stretched), told(&compressed), "sample {sample}");
            }
        }
        let [.., stretched, _] = pipeline.outputs();
        assert_eq!(stretched.region, Region::Relaxation);
        assert_eq!(stretched.relaxation, RelaxationType::TypeII);
    }

    #[test]
    fn a_tare_reads_zero_without_a_step_in_any_filter_and_can_be_taken_back() {
        let untouched = config();
        let mut pipeline = Pipeline::new(&untouched);
        for sample in 0..=300 {
            pipeline.process(&press(sample), 0);
        }
        let before = pipeline.outputs();
        pipeline.tare();
        pipeline.process(&press(300), 0);
        for (before, after) in before.iter().zip(&pipeline.outputs()) {
            assert_eq!((after.strain, after.region), (0, Region::Rest));
            assert!((before.fa - after.fa).abs() * 50 < before.fa);
        }
        pipeline.untare();
        assert_eq!(pipeline.config(), &untouched);
        pipeline.process(&press(300), 0);
        assert_eq!(pipeline.outputs()[0].strain, before[0].strain);
    }

    #[test]
    fn a_change_of_gain_is_no_press_and_keeps_regions_and_what_the_filter_remembers() {
        let (config, mut halved) = (config(), config());
        let mut pipeline = Pipeline::new(&config);
        let at_half_gain = |sample| press(sample).map(|counts| counts / 2);
        for sample in 0..=600 {
            pipeline.process(&press(sample), 0);
        }
        let before = pipeline.outputs();
        for gauge in 0..GAUGES {
            let sheet = Sheet {
                gain: 2.0 * (0.002 + 0.001 * gauge as f64),
                offset: 500 * gauge as i32,
                temperature_coefficient: 1.0,
                reference_celsius: 20.0,
            };
            halved.calibration[gauge] = Calibration::new(&sheet).unwrap();
        }
        pipeline.exchange(&halved, true);
        for _ in 0..10 {
            pipeline.process(&at_half_gain(600), 0);
            for (before, after) in before.iter().zip(&pipeline.outputs()) {
                assert!((after.strain - before.strain).abs() <= 2);
                assert_eq!(after.region, before.region);
                assert!((before.fa - after.fa).abs() * 20 < before.strain, "{before:?} {after:?}");
            }
        }
        // A strain that means something else is no step either.
        pipeline.exchange(&config, false);
        pipeline.process(&at_half_gain(600), 0);
        for (before, after) in before.iter().zip(&pipeline.outputs()) {
            assert!((before.fa - after.fa).abs() * 20 < before.strain, "{before:?} {after:?}");
        }
    }

    #[test]
    fn a_change_of_temperature_takes_effect_with_its_sample() {
        let config = config();
        let mut pipeline = Pipeline::new(&config);
        for (sample, celsius) in [20, 20, 21, 21, -5].into_iter().enumerate() {
            let counts = press(sample as u32);
            pipeline.process(&counts, celsius * 256);
            let expected = array::from_fn(|gauge| {
                config.calibration[gauge].apply(counts[gauge], celsius * 256).strain
            });
            assert_eq!(pipeline.outputs().map(|out| out.strain), expected);
        }
    }

    #[test]
    fn a_change_of_thresholds_or_relaxation_keeps_the_region_and_what_the_filter_remembers() {
        let mut config = config();
        let mut pipeline = Pipeline::new(&config);
        for sample in 0..500 {
            pipeline.process(&press(sample), 0);
        }
        let before = pipeline.outputs();
        let slower = Relaxation { c1: 0.2, v1: 4.0, c2: 0.2, v2: 0.3 };
        config.adaptation = adaptation::Config::new(&slower, 0.001).unwrap();
        pipeline.configure(&config);
        assert_eq!(pipeline.outputs(), before);
        pipeline.process(&press(500), 0);
        assert_eq!(pipeline.outputs()[0].region, before[0].region);
        assert!((pipeline.outputs()[0].fa - before[0].fa).abs() * 50 < before[0].fa);
    }

    #[test]
    fn what_saturates_is_flagged_on_its_gauge_and_counted() {
        let mut pipeline = Pipeline::new(&config());
        pipeline.process(&[0, 0, 0, STRAIN_MAX], 0);
        let out = pipeline.outputs();
        assert!(out[3].flags.contains(Flags::CONVERTER_AT_RAIL | Flags::STRAIN_SATURATED));
        assert_eq!(out[0].flags, Flags::NONE);
        let counters = pipeline.counters();
        assert_eq!((counters[3].converter_at_rail, counters[3].strain_saturated), (1, 1));
        assert_eq!(counters[0], Counters::default());
        pipeline.process(&[0; GAUGES], 0);
        assert_eq!((pipeline.outputs()[3].flags, pipeline.counters()), (Flags::NONE, counters));
    }

    #[test]
    fn a_filter_that_saturates_after_an_exchange_is_flagged_and_counted() {
        let extremes = [STRAIN_MIN + 1, STRAIN_MAX - 1];
        let share = |c1, v1| {
            let relaxation = Relaxation { c1, v1, c2: 0.0, v2: 0.01 };
            adaptation::Config::new(&relaxation, 0.001).unwrap()
        };
        let mut config = config();
        let mut pipeline = Pipeline::new(&config);
        let mut flagged = 0;
        for i in 0..8 {
            // Each step up is remembered, each step down forgotten at once.
            config.adaptation = if i % 2 == 1 { share(0.95, 0.02) } else { share(0.0, 1.0) };
            pipeline.configure(&config);
            pipeline.process_strain(&[extremes[i % 2]; GAUGES], None);
            flagged += u32::from(pipeline.outputs()[0].flags.contains(Flags::FILTER_SATURATED));
        }
        assert!(flagged > 0);
        assert_eq!(pipeline.counters()[0].filter_saturated, flagged);
    }

    #[test]
    fn a_recording_in_strain_gives_what_the_same_counts_give() {
        let config = config();
        let (mut counts, mut strains) = (Pipeline::new(&config), Pipeline::new(&config));
        for sample in 0..1_500 {
            counts.process(&press(sample), 0);
            let expected = counts.outputs();
            strains.process_strain(&expected.map(|out| out.strain), None);
            assert_eq!(strains.outputs(), expected);
        }
    }

    #[test]
    fn strain_without_counts_is_not_tared() {
        let mut pipeline = Pipeline::new(&config());
        pipeline.process_strain(&[7_000; GAUGES], None);
        let before = pipeline;
        pipeline.tare();
        assert_eq!(pipeline, before);
    }

    proptest! {
        #[test]
        fn what_is_no_news_is_as_it_was(
            steps in prop::collection::vec((any::<u32>(), prop::bool::weighted(0.02)), 1..300),
        ) {
            let mut pipeline = Pipeline::new(&config());
            let mut before = pipeline.outputs();
            for (sample, (noise, tares)) in (0..).zip(steps) {
                if tares {
                    pipeline.tare();
                }
                let rail = if noise % 16 == 0 { 1 << 23 } else { 0 };
                pipeline.process(&press(4 * sample).map(|counts| (counts | rail) - (noise >> 19) as i32), 0);
                let after = pipeline.outputs();
                if !pipeline.is_news() {
                    for (before, after) in before.iter().zip(&after) {
                        prop_assert_eq!(before.state(), after.state());
                        prop_assert_eq!(after.entered_samples_ago, None);
                    }
                }
                before = after;
            }
        }

        #[test]
        fn any_counts_and_temperatures_pass_without_panic_and_keep_both_sums(
            samples in prop::collection::vec((any::<[i32; GAUGES]>(), any::<i16>()), 1..100),
        ) {
            let mut pipeline = Pipeline::new(&config());
            for (i, (counts, temperature)) in samples.into_iter().enumerate() {
                if i % 17 == 16 {
                    pipeline.tare();
                }
                pipeline.process(&counts, temperature);
                for out in pipeline.outputs() {
                    prop_assert_eq!(out.fa + out.sa(), out.strain);
                    prop_assert_eq!(out.equilibrium + out.latent(), out.strain);
                }
            }
        }
    }
}
