//! A session at the machine: which traces are taken, in which order and when, and how warm the air is.
//! The traces have everything but the force.

use std::f64::consts::TAU;
use std::path::PathBuf;

use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use palpate_model::{BaseLaw, Hold, Move, Profile, Separation, Step};
use palpate_trace::{Column, Control, DISPLACEMENT, Head, TANGENTIAL, TEMPERATURE, Trace};

/// Acceleration at the corners, mm/s².
const ACCELERATION: f64 = 800.0;
/// Samples per second.
const RATE_HZ: f64 = 200.0;

/// What one trace is to be.
struct Plan {
    name: String,
    file: String,
    profile: Profile,
}

/// What the air and the lateral force do over the session.
pub(super) struct Around {
    /// Mean, K of each wave, its period, s, and phase.
    mean: f64,
    waves: [(f64, f64, f64); 2],
    /// Phase of the lateral force.
    sway: f64,
}

/// Ten traces in a random order: three amplitudes at three speeds, and one of repeated cycles, with
/// pauses between, in air that wanders by a few kelvin; and that air.
#[must_use]
pub(super) fn ten_traces(random: &mut ChaCha8Rng) -> (Vec<Trace>, Around) {
    let mut plans = Vec::new();
    for amplitude in [4.0, 8.0, 12.0] {
        for speed in [5.0, 20.0, 60.0] {
            let off = random.random_range(0.3..0.8);
            let steps = [stay(random.random_range(0.6..1.0)), go(amplitude), stay(4.3)];
            let end = [go(-off), stay(random.random_range(2.0..3.0))];
            plans.push(Plan {
                name: format!("{amplitude} mm at {speed} mm/s"),
                file: format!("press-{amplitude:02}mm-{speed:02}mms.csv"),
                profile: profile(-off, speed, steps.into_iter().chain(end).collect()),
            });
        }
    }
    let off = random.random_range(0.3..0.8);
    plans.push(cycles(6, 8.0, 20.0, off));
    plans.shuffle(random);
    let around = Around {
        mean: random.random_range(21.0..25.0),
        waves: [(random.random_range(1.0..2.0), 600.0), (random.random_range(0.3..0.7), 90.0)]
            .map(|(size, period)| (size, period, random.random_range(0.0..TAU))),
        sway: random.random_range(0.0..TAU),
    };
    let pauses: Vec<f64> = plans.iter().map(|_| random.random_range(10.0..40.0)).collect();
    (record(plans, &around, &pauses), around)
}

/// The base law of the specimen of [`two_traces`], and its parameters p, q, c1, c2, v1, v2.
pub const SPECIMEN: (BaseLaw, [f64; 6]) =
    (BaseLaw::fung(2, Separation::Clamp), [0.2, 0.6, 0.25, 0.2, 4.0, 0.5]);

/// The traces on which signatures are shown: a press with a hold of 4 s, and four cycles.
#[must_use]
pub fn two_traces() -> Vec<Trace> {
    let steps = vec![stay(0.5), go(8.0), stay(4.0), go(-0.5), stay(1.5)];
    let press = Plan {
        name: "press".into(),
        file: "press.csv".into(),
        profile: profile(-0.5, 20.0, steps),
    };
    let around = Around { mean: 23.0, waves: [(1.5, 5.0, 0.0), (0.0, 60.0, 0.0)], sway: 0.0 };
    record(vec![press, cycles(4, 6.0, 60.0, 0.5)], &around, &[10.0; 2])
}

fn cycles(count: usize, amplitude: f64, speed: f64, off: f64) -> Plan {
    let cycle = [go(amplitude), stay(0.4), go(-off), stay(0.6)];
    let steps = std::iter::once(stay(0.8)).chain(std::iter::repeat_n(cycle, count).flatten());
    Plan {
        name: format!("{count} cycles to {amplitude} mm at {speed} mm/s"),
        file: format!("cycles-{amplitude:02}mm-{speed:02}mms.csv"),
        profile: profile(-off, speed, steps.chain([stay(1.5)]).collect()),
    }
}

fn stay(hold_s: f64) -> Step {
    Step::Hold(Hold { hold_s })
}

fn go(to_mm: f64) -> Step {
    Step::Move(Move { to_mm, speed_mm_per_s: None })
}

fn profile(start_mm: f64, speed_mm_per_s: f64, steps: Vec<Step>) -> Profile {
    Profile {
        version: 1,
        rate_hz: RATE_HZ,
        start_mm,
        speed_mm_per_s,
        acceleration_mm_per_s2: Some(ACCELERATION),
        repeat: 1,
        steps,
    }
}

/// The plans carried out one after the other.
fn record(plans: Vec<Plan>, around: &Around, pauses: &[f64]) -> Vec<Trace> {
    let mut begin = 0.0;
    let mut traces = Vec::with_capacity(plans.len());
    for (index, (plan, pause)) in plans.into_iter().zip(pauses).enumerate() {
        let motion = plan.profile.motion();
        let mut trace = around.recorded(&motion.time, &motion.displacement, index + 1, begin);
        trace.head.name = Some(format!("practice, {}", plan.name));
        trace.path = Some(PathBuf::from(plan.file));
        begin = rounded(begin + trace.duration() + pause, 10.0);
        traces.push(trace);
    }
    traces
}

impl Around {
    /// A motion, mm at times in s, as the recording of this number that begins so many s after the session: with everything but
    /// the force.
    pub(super) fn recorded(
        &self,
        time: &[f64],
        motion: &[f64],
        number: usize,
        begin: f64,
    ) -> Trace {
        let began = time.first().copied().unwrap_or_default();
        let temperature = |t: &f64| rounded(self.temperature(begin + t - began), 100.0);
        let column = |name: &str, values: Vec<f64>| Column { name: name.into(), values };
        let lateral = |x: &f64| rounded(self.lateral(*x), 1e5);
        let columns = vec![
            column(DISPLACEMENT, motion.iter().map(|&x| rounded(x, 1e5)).collect()),
            column(TEMPERATURE, time.iter().map(temperature).collect()),
            column(TANGENTIAL, motion.iter().map(lateral).collect()),
        ];
        let control = Some(Control::Displacement);
        let mut head = Head { version: Some(1), control, ..Head::default() };
        head.setup.sequence = Some(number as i64);
        head.setup.start_s = Some(rounded(begin, 10.0));
        Trace { path: None, head, time: time.to_vec(), columns }
    }

    /// °C at a time since the session began, s.
    fn temperature(&self, set_time: f64) -> f64 {
        let wave = |&(size, period, phase): &(f64, f64, f64)| {
            size * (TAU * set_time / period + phase).sin()
        };
        self.mean + self.waves.iter().map(wave).sum::<f64>()
    }

    /// Tangential force, N, of a press that is not quite square to the specimen.
    fn lateral(&self, x: f64) -> f64 {
        let depth = x.max(0.0);
        0.02 * depth + 0.08 * (TAU * depth / 7.0 + self.sway).sin() - 0.08 * self.sway.sin()
    }
}

/// The value as it is written, with so many steps to the unit.
pub(super) fn rounded(value: f64, steps: f64) -> f64 {
    (value * steps).round() / steps
}
