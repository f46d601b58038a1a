//! The margin as a fingertip feels it: normal and tangential force from its gauges, now and once settled.
//!
//! The fingertip's filter says of every gauge where its strain will settle if the grasp is held as it is (its
//! equilibrium). The same weights that make forces of strains make settled forces of equilibria, so the
//! margin that will be left is known long before the silicone has relaxed.

use shared::fixed::microstrain;
use shared::pipeline::GAUGES;
use shared::wire::Row;

use super::contact::{Contact, Load};
use super::margin::margin;
use crate::device::record::parts;

/// What the gauges feel at one time; strains in µε.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Felt {
    /// Time, s.
    pub time: f64,
    /// Strain of each gauge.
    pub strain: [f64; GAUGES],
    /// Where each will settle.
    pub equilibrium: [f64; GAUGES],
}

impl Felt {
    /// From a row of a device; none if elastic input and equilibrium were not asked for.
    #[must_use]
    pub fn of(row: &Row) -> Option<Self> {
        let (_, equilibrium) = row.rest?;
        Some(Self {
            time: row.time_us as f64 * 1e-6,
            strain: parts(row).map(|(fa, sa)| fa + sa),
            equilibrium: equilibrium.map(microstrain),
        })
    }
}

/// A force or moment from the gauges: Σ weight · strain + constant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Weights {
    /// N (or N mm) per µε of each gauge.
    pub gauges: [f64; GAUGES],
    /// N (or N mm) that are always there.
    pub constant: f64,
}

impl Weights {
    fn of(&self, strain: &[f64; GAUGES]) -> f64 {
        self.constant + self.gauges.iter().zip(strain).map(|(a, b)| a * b).sum::<f64>()
    }
}

/// A fingertip that holds something.
#[derive(Clone, Debug)]
pub struct Fingertip {
    /// Its contact.
    pub contact: Contact,
    /// Coefficient of friction μ, above 0.
    pub friction: f64,
    /// Normal force.
    pub normal: Weights,
    /// Tangential force.
    pub tangential: Weights,
    /// Moment about the normal.
    pub moment: Weights,
    /// Normal force from which on it holds something, N.
    pub threshold: f64,
    /// Strain of each gauge without a grasp, µε.
    pub zero: [f64; GAUGES],
}

/// Forces and margin, now or once settled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// Normal force, N.
    pub normal: f64,
    /// What is asked of the contact.
    pub load: Load,
    /// The load could be so many times as large; none where nothing is held.
    pub margin: Option<f64>,
}

/// How a grasp is at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Time, s.
    pub time: f64,
    /// Now.
    pub now: Hold,
    /// Once settled.
    pub settled: Hold,
}

impl Reading {
    /// Whether it slips now.
    #[must_use]
    pub fn slips(&self) -> bool {
        self.now.margin.is_some_and(|margin| margin <= 1.0)
    }

    /// Whether it holds now but will slip once settled.
    #[must_use]
    pub fn will_slip(&self) -> bool {
        let holds = self.now.margin.is_some_and(|margin| margin > 1.0);
        holds && self.settled.margin.is_none_or(|margin| margin <= 1.0)
    }
}

impl Fingertip {
    /// Forces and margins.
    #[must_use]
    pub fn read(&self, felt: &Felt) -> Reading {
        let hold = |strain: &[f64; GAUGES]| {
            let strain = std::array::from_fn(|gauge| strain[gauge] - self.zero[gauge]);
            let normal = self.normal.of(&strain);
            let force = [self.tangential.of(&strain), 0.0];
            let load = Load { force, moment: self.moment.of(&strain) };
            let held = normal > self.threshold;
            let factor = || margin(&self.contact, self.friction * normal, &load).factor;
            Hold { normal, load, margin: held.then(factor) }
        };
        Reading { time: felt.time, now: hold(&felt.strain), settled: hold(&felt.equilibrium) }
    }
}

/// Forces and margins from time to time, over samples as they come.
#[derive(Clone, Debug)]
pub struct Watch {
    fingertip: Fingertip,
    rest_s: f64,
    every_s: f64,
    /// Samples of the rest, until it is over.
    rest: Vec<Felt>,
    /// Times of the first sample and of the next reading, s.
    times: Option<(f64, f64)>,
    passed_s: f64,
}

impl Watch {
    /// With a reading every so many seconds. The strain over the first `rest_s` seconds, without a grasp, is zero.
    #[must_use]
    pub const fn new(fingertip: Fingertip, rest_s: f64, every_s: f64) -> Self {
        Self { fingertip, rest_s, every_s, rest: Vec::new(), times: None, passed_s: 0.0 }
    }

    /// Another stream begins, with a rest of its own.
    pub fn begin(&mut self) {
        self.rest.clear();
        (self.times, self.passed_s) = (None, 0.0);
    }

    /// Time begins anew, as after a reset; a zero that was taken stays.
    pub fn go_on(&mut self) {
        if !self.is_resting() {
            self.rest_s = 0.0;
        }
        self.begin();
    }

    /// Whether the zero is still being taken.
    #[must_use]
    pub fn is_resting(&self) -> bool {
        self.passed_s < self.rest_s
    }

    /// Time since the first sample, s.
    #[must_use]
    pub const fn passed_s(&self) -> f64 {
        self.passed_s
    }

    /// Takes a sample; a reading where one is due.
    pub fn take(&mut self, felt: &Felt) -> Option<Reading> {
        let (began, next) = *self.times.get_or_insert((felt.time, felt.time + self.rest_s));
        self.passed_s = felt.time - began;
        if self.is_resting() {
            self.rest.push(*felt);
            return None;
        }
        if !self.rest.is_empty() {
            self.fingertip.zero = mean_strain(&self.rest);
            self.rest.clear();
        }
        if felt.time < next {
            return None;
        }
        let late = ((felt.time - next) / self.every_s).floor();
        self.times = Some((began, next + self.every_s * (late + 1.0)));
        Some(self.fingertip.read(felt))
    }
}

/// A weight for all gauges, or four with commas, N (or N mm) per µε.
///
/// # Errors
/// Says what to give.
pub fn weights(text: &str) -> Result<[f64; GAUGES], String> {
    let number = |text: &str| {
        let value = text.trim().parse().ok().filter(|value: &f64| value.is_finite());
        value.ok_or_else(|| "give a number".to_owned())
    };
    let values = text.split(',').map(number).collect::<Result<Vec<f64>, _>>()?;
    match values[..] {
        [one] => Ok([one; GAUGES]),
        [a, b, c, d] => Ok([a, b, c, d]),
        _ => Err("give one number, or four with commas".into()),
    }
}

/// The mean strain of a stretch of samples: what the gauges read without a grasp.
#[must_use]
pub fn mean_strain(felt: &[Felt]) -> [f64; GAUGES] {
    let count = felt.len().max(1) as f64;
    std::array::from_fn(|gauge| felt.iter().map(|felt| felt.strain[gauge]).sum::<f64>() / count)
}

#[cfg(test)]
mod tests {
    use super::super::contact::Shape;
    use super::super::pressure::PressureLaw;
    use super::*;

    fn fingertip() -> Fingertip {
        Fingertip {
            contact: Contact::new(Shape::Circle { radius: 5.0 }, PressureLaw::HERTZ).unwrap(),
            friction: 0.5,
            normal: Weights { gauges: [0.001; GAUGES], constant: 0.0 },
            tangential: Weights { gauges: [0.0005, -0.0005, 0.0, 0.0], constant: 0.2 },
            moment: Weights::default(),
            threshold: 0.05,
            zero: [10.0, -10.0, 0.0, 0.0],
        }
    }

    #[test]
    fn forces_are_weighted_strains_and_the_margin_is_that_of_the_load() {
        let felt = Felt {
            time: 1.0,
            strain: [810.0, 390.0, 500.0, 300.0],
            equilibrium: [410.0, 190.0, 250.0, 150.0],
        };
        let reading = fingertip().read(&felt);
        assert!((reading.now.normal - 2.0).abs() < 1e-12);
        assert!((reading.now.load.force[0] - 0.4).abs() < 1e-12);
        assert!((reading.now.margin.unwrap() - 2.5).abs() < 1e-9);
        assert!((reading.settled.margin.unwrap() - 0.5 / 0.3).abs() < 1e-9);
        assert!(!reading.slips() && !reading.will_slip());
    }

    #[test]
    fn a_grasp_that_relaxes_too_far_is_foretold() {
        let mut loaded = fingertip();
        loaded.tangential = Weights { constant: 0.6, ..Weights::default() };
        let felt = Felt {
            time: 1.0,
            strain: [510.0, 490.0, 500.0, 500.0],
            equilibrium: [260.0, 240.0, 250.0, 250.0],
        };
        let reading = loaded.read(&felt);
        assert!(!reading.slips() && reading.will_slip());
    }

    #[test]
    fn a_watch_takes_its_zero_first_and_then_reads_from_time_to_time() {
        let mut watch = Watch::new(fingertip(), 0.5, 0.2);
        let felt = |time: f64, strain: f64| Felt {
            time,
            strain: [strain; GAUGES],
            equilibrium: [strain; GAUGES],
        };
        let read = |from: f64, watch: &mut Watch| -> Vec<Reading> {
            let at = |ms: i32| {
                let passed = f64::from(ms) * 1e-3;
                felt(from + passed, if passed < 0.5 { 40.0 } else { 540.0 })
            };
            (0..1_000).filter_map(|ms| watch.take(&at(ms))).collect()
        };
        let readings = read(10.0, &mut watch);
        assert_eq!(readings.len(), 3, "at 0.5, 0.7 and 0.9 s");
        assert!((readings[0].now.normal - 2.0).abs() < 1e-9, "the rest is zero");
        watch.go_on();
        let readings = read(0.0, &mut watch);
        assert_eq!(readings.len(), 5, "the zero stays, so it reads from the beginning");
        assert!(readings[0].now.normal.abs() < 1e-9);
        watch.begin();
        assert!(!watch.is_resting() && watch.passed_s() == 0.0);
    }

    #[test]
    fn weights_are_one_or_four() {
        assert_eq!(weights("0.5"), Ok([0.5; GAUGES]));
        assert_eq!(weights("1,2, 3,-4"), Ok([1.0, 2.0, 3.0, -4.0]));
        for wrong in ["", "1,2", "a", "inf", "1,2,3,4,5"] {
            assert!(weights(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn without_a_grasp_there_is_no_margin() {
        let rest = [10.0, -10.0, 0.0, 1.0];
        let felt = [Felt { time: 0.0, strain: rest, equilibrium: rest }; 4];
        assert_eq!(fingertip().read(&felt[0]).now.margin, None);
        assert_eq!(mean_strain(&felt), rest);
    }
}
