//! The filter of the device over every bundled recording, against the recurrence in f64.

use palpate::decomposition::{decompose, default_relaxation, signals};
use palpate::trace::recordable::samples;
use palpate::trace::{FORCE, read};
use palpate_tests::{all_bundled, bundled};
use shared::adaptation::Relaxation;
use shared::phase::Region;
use shared::pipeline::{GAUGES, Pipeline};

/// One channel of the filter's recurrence in f64, in LSB; the first sample counts as settled.
struct Reference {
    relaxation: Relaxation,
    signal: f64,
    memories: [f64; 2],
}

impl Reference {
    /// FA, SA, elastic input, equilibrium and latent part after the next sample.
    fn step(&mut self, signal: f64, interval: f64) -> [f64; 5] {
        let Relaxation { c1, v1, c2, v2 } = self.relaxation;
        let c0 = self.relaxation.c0();
        let decay = [v1, v2].map(|v| -(-v * interval).exp_m1());
        let gain = [c1 * decay[0] / (v1 * interval), c2 * decay[1] / (v2 * interval)];
        let lost = [decay[0] * self.memories[0], decay[1] * self.memories[1]];
        let pushed = (signal - self.signal + lost[0] + lost[1]) / (c0 + gain[0] + gain[1]);
        for ((memory, gain), lost) in self.memories.iter_mut().zip(gain).zip(lost) {
            *memory += gain * pushed - lost;
        }
        self.signal = signal;
        let equilibrium = signal - self.memories[0] - self.memories[1];
        let fa = self.memories[0];
        [fa, signal - fa, equilibrium / c0, equilibrium, signal - equilibrium]
    }
}

#[test]
fn every_bundled_recording_is_decomposed_within_two_lsb_and_fa_plus_sa_is_the_signal() {
    let relaxation = default_relaxation();
    let mut worst: f64 = 0.0;
    let mut channels = 0;
    for path in all_bundled() {
        let trace = read(&path).unwrap();
        let mut names = signals(&trace).unwrap();
        names.push(FORCE.into());
        for name in names {
            let channel = decompose(&trace, &name, &relaxation, || {}).unwrap();
            assert_eq!(channel.saturated, 0);
            channels += 1;
            let first = channel.input[0] / channel.lsb;
            let mut reference = Reference { relaxation, signal: first, memories: [0.0; 2] };
            for k in 0..trace.len() {
                assert_eq!(
                    channel.fa[k] + channel.sa[k],
                    channel.input[k],
                    "{} {k}",
                    path.display()
                );
                let interval = trace.time[k.max(1)] - trace.time[k.max(1) - 1];
                let expected = reference.step(channel.input[k] / channel.lsb, interval);
                let found = [
                    channel.fa[k],
                    channel.sa[k],
                    channel.elastic[k],
                    channel.equilibrium[k],
                    channel.latent[k],
                ];
                for (found, expected) in found.iter().zip(expected) {
                    worst = worst.max((found / channel.lsb - expected).abs());
                }
            }
        }
    }
    println!("{channels} channels; largest error {worst:.3} LSB");
    assert!(channels > 60 && worst <= 2.0, "{worst} LSB over {channels} channels");
}

/// Let go at 14.53 s, the silicone springs back through the gauges and settles: the device sees recovery, no second touch.
#[test]
fn a_device_that_replays_a_press_is_in_contact_until_it_lets_go() {
    let trace = read(&bundled("press.csv")).unwrap();
    let replayed = samples(&trace).unwrap();
    let mut pipeline = Pipeline::new(&replayed.settings.config(replayed.interval_s).unwrap());
    let counts = replayed.stretches.concat();
    assert_eq!(counts.len(), trace.len());
    for (time, counts) in trace.time.iter().zip(&counts) {
        pipeline.process(counts, 25 * 256);
        let regions = pipeline.outputs().map(|output| output.region);
        if (2.5..7.5).contains(time) || (9.0..14.0).contains(time) {
            assert_eq!(regions, [Region::Relaxation; GAUGES], "{time} s");
        } else if (14.8..16.0).contains(time) {
            assert_eq!(regions, [Region::Recovery; GAUGES], "{time} s");
        } else if *time >= 16.0 {
            let free = |region: &Region| matches!(region, Region::Recovery | Region::Rest);
            assert!(regions.iter().all(free), "{time} s: {regions:?}");
        }
    }
}
