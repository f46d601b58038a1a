//! The margin as a fingertip feels it: normal and tangential force from its gauges, now and once settled.
//!
//! The fingertip's filter says of every gauge where its strain will settle if the grasp is held as it is (its
//! equilibrium). The same weights that make forces of strains make settled forces of equilibria, so the
//! margin that will be left is known long before the silicone has relaxed.

use shared::adaptation::Relaxation;
use shared::fixed::microstrain;
use shared::pipeline::GAUGES;
use shared::wire::Row;

use super::body::Body;
use super::contact::{Contact, Load};
use super::growth::Material;
use super::margin::margin;
use palpate_trace::recording::parts;

/// What the gauges feel at one time; strains in µε.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Felt {
    /// Time, s.
    pub time: f64,
    /// Strain of each gauge.
    pub strain: [f64; GAUGES],
    /// Where each will settle.
    pub equilibrium: [f64; GAUGES],
    /// The part of the strain that goes with the fast rate (FA).
    pub fast: [f64; GAUGES],
    /// The strain of a silicone without memory.
    pub elastic: [f64; GAUGES],
}

impl Felt {
    /// From a row of a device; none if elastic input and equilibrium were not asked for.
    #[must_use]
    pub fn of(row: &Row) -> Option<Self> {
        let (elastic, equilibrium) = row.rest?;
        Some(Self {
            time: row.time_us as f64 * 1e-6,
            strain: parts(row).map(|(fa, sa)| fa + sa),
            equilibrium: equilibrium.map(microstrain),
            fast: parts(row).map(|(fa, _)| fa),
            elastic: elastic.map(microstrain),
        })
    }

    /// Every strain if nothing moves for so many seconds: the fast and the slow part decay.
    fn held(&self, relaxation: &Relaxation, seconds: f64) -> [f64; GAUGES] {
        let (fast, slow) = ((-relaxation.v1 * seconds).exp(), (-relaxation.v2 * seconds).exp());
        std::array::from_fn(|gauge| {
            let late = self.strain[gauge] - self.fast[gauge] - self.equilibrium[gauge];
            self.equilibrium[gauge] + fast * self.fast[gauge] + slow * late
        })
    }
}

/// A contact that grows as it is pressed, and how the force tells the compression: by the elastic response
/// of a law, with the normal force of a silicone without memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Growing {
    /// What is pressed.
    pub body: Body,
    /// What makes a force of a compression.
    pub material: Material,
}

impl Growing {
    /// Compression under a normal force of a silicone without memory, mm.
    fn compression(&self, elastic: f64) -> f64 {
        self.material.response.sudden_compression(elastic.max(0.0))
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
    /// What a silicone without memory would read without a grasp, µε.
    pub elastic_zero: [f64; GAUGES],
    /// How the contact grows, where it does.
    pub growing: Option<Growing>,
    /// How the gauges relax, where it is known: for the time until slip.
    pub relaxation: Option<Relaxation>,
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

impl Hold {
    /// Share of what the contact can carry that is in use, 1/margin; none where nothing is held.
    #[must_use]
    pub fn used(&self) -> Option<f64> {
        self.margin.map(f64::recip)
    }
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
    /// Compression of a contact that grows, mm.
    pub compression: Option<f64>,
    /// Time until it slips if nothing moves, s; none where it does not, or where it is not known how the gauges
    /// relax.
    pub slips_in: Option<f64>,
    /// Normal force to add now so that it holds until it has settled, N; none where nothing need be added or
    /// it is not known.
    pub tighten: Option<f64>,
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
    /// Forces and margins, and how long they last.
    #[must_use]
    pub fn read(&self, felt: &Felt) -> Reading {
        let compression = self.growing.as_ref().map(|growing| {
            let elastic =
                std::array::from_fn(|gauge| felt.elastic[gauge] - self.elastic_zero[gauge]);
            growing.compression(self.normal.of(&elastic))
        });
        let grown = self.growing.as_ref().zip(compression).and_then(|(growing, compression)| {
            self.contact.reshaped(growing.body.contact(compression)?).ok()
        });
        let contact = grown.as_ref().unwrap_or(&self.contact);
        let hold = |strain: &[f64; GAUGES]| self.hold(contact, strain);
        let (now, settled) = (hold(&felt.strain), hold(&felt.equilibrium));
        let relaxation = self.relaxation.filter(|_| now.margin.is_some());
        let later = |seconds: f64| relaxation.map(|r| hold(&felt.held(&r, seconds)));
        let slips_in = relaxation.and_then(|relaxation| {
            let slips = |seconds: f64| {
                let then = later(seconds).and_then(|hold| hold.margin);
                then.is_none_or(|margin| margin <= 1.0)
            };
            first(&slips, SETTLING_TIMES / relaxation.v2)
        });
        let tighten = relaxation.and_then(|relaxation| {
            // A margin grows as the normal force: what is wanted at each time, less what will be there.
            let short = |seconds: f64| {
                let hold = later(seconds)?;
                let wanted = hold.normal / hold.margin.filter(|margin| margin.is_finite())?;
                let left = relaxation.c0()
                    + relaxation.c1 * (-relaxation.v1 * seconds).exp()
                    + relaxation.c2 * (-relaxation.v2 * seconds).exp();
                Some((wanted - hold.normal) / left)
            };
            let looks = looks(SETTLING_TIMES / relaxation.v2);
            looks.filter_map(short).max_by(f64::total_cmp).filter(|more| *more > 0.0)
        });
        Reading { time: felt.time, now, settled, compression, slips_in, tighten }
    }

    fn hold(&self, contact: &Contact, strain: &[f64; GAUGES]) -> Hold {
        let strain = std::array::from_fn(|gauge| strain[gauge] - self.zero[gauge]);
        let normal = self.normal.of(&strain);
        let force = [self.tangential.of(&strain), 0.0];
        let load = Load { force, moment: self.moment.of(&strain) };
        let held = normal > self.threshold;
        let factor = || margin(contact, self.friction * normal, &load).factor;
        Hold { normal, load, margin: held.then(factor) }
    }
}

/// Time constants of the slow part after which a grasp has settled.
const SETTLING_TIMES: f64 = 8.0;
/// Looks into the future, and halvings of the time between two of them.
const LOOKS: u32 = 32;
const HALVINGS: u32 = 20;

/// Times until `last`, s, close together at first.
fn looks(last: f64) -> impl Iterator<Item = f64> {
    (0..=LOOKS).map(move |k| last * (f64::from(k) / f64::from(LOOKS)).powi(3))
}

/// The first time until `last`, s, at which it slips; none where it does not.
fn first(slips: &impl Fn(f64) -> bool, last: f64) -> Option<f64> {
    let mut before = 0.0;
    for mut after in looks(last) {
        if slips(after) {
            for _ in 0..HALVINGS {
                let middle = 0.5 * (before + after);
                if slips(middle) { after = middle } else { before = middle }
            }
            return Some(after);
        }
        before = after;
    }
    None
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
            self.fingertip.elastic_zero = mean(&self.rest, |felt| &felt.elastic);
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
    mean(felt, |felt| &felt.strain)
}

fn mean(felt: &[Felt], of: impl Fn(&Felt) -> &[f64; GAUGES]) -> [f64; GAUGES] {
    let count = felt.len().max(1) as f64;
    std::array::from_fn(|gauge| felt.iter().map(|felt| of(felt)[gauge]).sum::<f64>() / count)
}

#[cfg(test)]
mod tests {
    use super::super::contact::Shape;
    use super::super::pressure::PressureLaw;
    use super::*;
    use palpate_model::{BaseLaw, Separation};

    fn fingertip() -> Fingertip {
        Fingertip {
            contact: Contact::new(Shape::Circle { radius: 5.0 }, PressureLaw::HERTZ).unwrap(),
            friction: 0.5,
            normal: Weights { gauges: [0.001; GAUGES], constant: 0.0 },
            tangential: Weights { gauges: [0.0005, -0.0005, 0.0, 0.0], constant: 0.2 },
            moment: Weights::default(),
            threshold: 0.05,
            zero: [10.0, -10.0, 0.0, 0.0],
            elastic_zero: [0.0; GAUGES],
            growing: None,
            relaxation: None,
        }
    }

    /// What is felt, with all that is still to relax in the slow part.
    fn felt(time: f64, strain: [f64; GAUGES], equilibrium: [f64; GAUGES]) -> Felt {
        Felt { time, strain, equilibrium, fast: [0.0; GAUGES], elastic: [0.0; GAUGES] }
    }

    #[test]
    fn forces_are_weighted_strains_and_the_margin_is_that_of_the_load() {
        let felt = felt(1.0, [810.0, 390.0, 500.0, 300.0], [410.0, 190.0, 250.0, 150.0]);
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
        let felt = felt(1.0, [510.0, 490.0, 500.0, 500.0], [260.0, 240.0, 250.0, 250.0]);
        let reading = loaded.read(&felt);
        assert!(!reading.slips() && reading.will_slip());
        assert_eq!(reading.slips_in, None, "it is not known how the gauges relax");
        // 2 N falls to 1 N at a rate of 0.5/s; 0.6 N over 0.5 are needed: 1.2 = 1 + e^(−0.5 t).
        loaded.relaxation = Some(Relaxation { c1: 0.3, v1: 4.0, c2: 0.2, v2: 0.5 });
        let reading = loaded.read(&felt);
        let slips_in = reading.slips_in.unwrap();
        assert!((slips_in - 2.0 * 5f64.ln()).abs() < 1e-4, "{slips_in}");
        // 0.2 N are short once settled, and half of what is added stays.
        let more = reading.tighten.unwrap();
        assert!((more - 0.4).abs() < 2e-3, "{more}");
    }

    #[test]
    fn a_contact_that_grows_follows_the_compression_of_a_silicone_without_memory() {
        let body = Body::Sphere { radius: 10.0 };
        let mut pressed = fingertip();
        let law = BaseLaw::fung(1, Separation::Clamp);
        let material = Material { response: law.response(&[1.0, 1.0, 0.4, 2.0]) };
        pressed.growing = Some(Growing { body, material });
        pressed.moment = Weights { constant: 1.0, ..Weights::default() };
        let mut felt = felt(1.0, [810.0, 390.0, 500.0, 300.0], [410.0, 190.0, 250.0, 150.0]);
        felt.elastic = [500.0; GAUGES];
        // 2 N without memory: x²/2 = 2 N.
        let reading = pressed.read(&felt);
        assert!((reading.compression.unwrap() - 2.0).abs() < 1e-12);
        let shape = Shape::Circle { radius: 6.0 };
        let contact = Contact::new(shape, PressureLaw::HERTZ).unwrap();
        let expected = margin(&contact, 1.0, &reading.now.load).factor;
        assert!((reading.now.margin.unwrap() / expected - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_watch_takes_its_zero_first_and_then_reads_from_time_to_time() {
        let mut watch = Watch::new(fingertip(), 0.5, 0.2);
        let felt = |time: f64, strain: f64| felt(time, [strain; GAUGES], [strain; GAUGES]);
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
        let felt = [felt(0.0, rest, rest); 4];
        assert_eq!(fingertip().read(&felt[0]).now.margin, None);
        assert_eq!(mean_strain(&felt), rest);
    }
}
