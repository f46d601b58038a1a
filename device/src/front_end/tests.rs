//! What becomes of a converter that fails, against a script of one.

use std::collections::VecDeque;

use embedded_hal_mock::eh1::delay::NoopDelay;

use super::*;

/// Of the script, µs.
const INTERVAL_US: u64 = 1_000;

#[derive(Debug, Default)]
struct Script {
    reads: VecDeque<Result<[i32; GAUGES], ReadError>>,
    resets: u32,
    begun: u32,
    refuses: Option<ConverterFault>,
    set: Option<Setting>,
}

impl Converter for Script {
    const PART: &'static str = "script";

    fn capabilities(&self) -> Capabilities {
        Capabilities::ads131m04(8_000_000)
    }

    fn reset(&mut self, _: &mut impl DelayNs, _: &Setting) -> Result<(), ConverterFault> {
        self.resets += 1;
        Ok(())
    }

    fn begin(&mut self, _: &mut impl DelayNs, setting: &Setting) -> Result<(), ConverterFault> {
        self.begun += 1;
        assert_eq!(self.begun, self.resets, "reset before each beginning");
        self.set = Some(*setting);
        self.refuses.map_or(Ok(()), Err)
    }

    fn configure(&mut self, setting: &Setting) -> Result<(), ConverterFault> {
        self.set = Some(*setting);
        self.refuses.map_or(Ok(()), Err)
    }

    fn read(&mut self) -> Result<[i32; GAUGES], ReadError> {
        self.reads.pop_front().unwrap_or(Ok([7; GAUGES]))
    }

    fn discard_stale(&mut self) {}
}

const SETTING: Setting = Setting {
    interval_ns: INTERVAL_US as u32 * 1_000,
    gain: [128; GAUGES],
    inputs: Inputs::Gauges,
};

/// A front end, the time, and everything that was sent or counted.
struct Bench {
    front_end: FrontEnd<Script, NoopDelay>,
    now_us: u64,
    samples: u64,
    lost: u64,
    fault: Option<ConverterFault>,
}

impl Bench {
    fn listening() -> Self {
        let front_end = FrontEnd::new(Script::default(), NoopDelay::new());
        let mut bench = Self { front_end, now_us: 0, samples: 0, lost: 0, fault: None };
        bench.front_end.configure(0, SETTING).unwrap();
        bench.front_end.listen(0, true);
        bench
    }

    /// So many intervals pass, with an edge in each or none; a look every ten.
    fn pass(&mut self, intervals: u64, edges: bool) {
        for _ in 0..intervals {
            self.now_us += INTERVAL_US;
            let sample = edges.then(|| self.front_end.ready(self.now_us)).flatten();
            if let Some(sample) = sample {
                self.samples += 1;
                self.lost += sample.lost.all();
            }
            if self.now_us.is_multiple_of(10 * INTERVAL_US) {
                let found = self.front_end.look_after(self.now_us);
                self.lost += found.lost.all();
                self.fault = found.fault;
            }
        }
    }

    /// Conversions that came or were counted, of those since it listened; a few may not be told yet.
    fn accounts_for_all(&self) {
        let (told, all) = (self.samples + self.lost, self.now_us / INTERVAL_US);
        assert!(told <= all && all - told <= 20, "{told} of {all}");
    }
}

#[test]
fn the_first_conversions_settle_and_are_not_used_and_that_is_no_loss() {
    let mut bench = Bench::listening();
    bench.pass(100, true);
    assert_eq!((bench.samples, bench.lost, bench.fault), (97, 0, None));
}

#[test]
fn an_edge_whose_conversion_was_forgotten_when_listening_began_is_no_loss_but_a_later_one_is() {
    let mut bench = Bench::listening();
    bench.front_end.converter.reads.push_back(Err(ReadError::Stale));
    bench.pass(50, true);
    assert_eq!((bench.samples, bench.lost, bench.fault), (46, 0, None));
    bench.front_end.converter.reads.push_back(Err(ReadError::Stale));
    bench.pass(50, true);
    assert_eq!((bench.samples, bench.lost, bench.fault), (95, 1, None));
    bench.front_end.converter.reads = std::iter::repeat_n(Err(ReadError::Stale), 50).collect();
    bench.pass(50, true);
    assert_eq!(bench.fault, Some(ConverterFault::Damaged));
    bench.accounts_for_all();
}

#[test]
fn a_wire_that_breaks_is_a_fault_every_conversion_counts_and_the_fault_ends_with_it() {
    let mut bench = Bench::listening();
    bench.pass(50, true);
    let missing = Err(ReadError::Fault(ConverterFault::Missing));
    bench.front_end.converter.reads = std::iter::repeat_n(missing, 1_000).collect();
    bench.pass(1_000, true);
    assert_eq!((bench.samples, bench.fault), (47, Some(ConverterFault::Missing)));
    bench.accounts_for_all();
    bench.pass(50, true);
    assert_eq!((bench.samples, bench.fault), (97, None));
    bench.accounts_for_all();
}

#[test]
fn a_converter_that_was_reset_is_set_anew_and_the_gap_is_counted() {
    let mut bench = Bench::listening();
    bench.pass(55, true);
    bench.front_end.converter.set = None;
    bench.front_end.converter.reads.push_back(Err(ReadError::SettingsLost));
    bench.pass(100, true);
    assert_eq!(bench.front_end.converter.set, Some(SETTING));
    assert_eq!((bench.front_end.converter.begun, bench.fault), (2, None));
    assert!(bench.samples >= 125, "{}", bench.samples);
    bench.accounts_for_all();
}

#[test]
fn one_that_refuses_its_settings_is_tried_again_each_second_not_each_look() {
    let mut bench = Bench::listening();
    bench.pass(55, true);
    bench.front_end.converter.refuses = Some(ConverterFault::Register);
    bench.front_end.converter.reads.push_back(Err(ReadError::SettingsLost));
    bench.pass(3_000, true);
    assert_eq!(bench.fault, Some(ConverterFault::Register));
    assert!((3..=5).contains(&bench.front_end.converter.begun), "at once and each second");
    bench.accounts_for_all();
    bench.front_end.converter.refuses = None;
    bench.pass(1_100, true);
    assert_eq!(bench.fault, None);
    bench.accounts_for_all();
}

#[test]
fn a_line_that_stands_still_is_a_fault_and_what_should_have_come_is_counted() {
    let mut bench = Bench::listening();
    bench.pass(50, true);
    assert!(bench.front_end.expects_edges());
    bench.pass(5_000, false);
    assert_eq!(bench.fault, Some(ConverterFault::Stuck));
    assert!(!bench.front_end.expects_edges(), "no reset will mend it");
    bench.accounts_for_all();
    bench.pass(50, true);
    assert_eq!(bench.fault, None);
    bench.accounts_for_all();
}

#[test]
fn a_change_while_listening_settles_again_and_the_first_sample_says_so() {
    let mut bench = Bench::listening();
    bench.pass(50, true);
    let halved = Setting { gain: [64; GAUGES], ..SETTING };
    bench.front_end.configure(bench.now_us, halved).unwrap();
    let mut first = None;
    let mut given_up = 0;
    while first.is_none() {
        bench.now_us += INTERVAL_US;
        first = bench.front_end.ready(bench.now_us);
        given_up += u64::from(first.is_none());
    }
    let first = first.unwrap();
    assert_eq!((first.lost.missed, first.lost.exchanged, given_up), (3, true, 3));
    bench.now_us += INTERVAL_US;
    assert_eq!(bench.front_end.ready(bench.now_us).unwrap().lost, Lost::NONE);
}

#[test]
fn losses_that_a_look_takes_before_the_first_sample_do_not_take_its_exchange_along() {
    let mut bench = Bench::listening();
    bench.pass(50, true);
    let halved = Setting { gain: [64; GAUGES], ..SETTING };
    bench.front_end.configure(bench.now_us, halved).unwrap();
    bench.pass(3, true);
    let found = bench.front_end.look_after(bench.now_us);
    assert!(!found.lost.exchanged);
    bench.now_us += INTERVAL_US;
    assert!(bench.front_end.ready(bench.now_us).unwrap().lost.exchanged);
}
