//! A day at the machine: which traces are taken, in which order and when, and how warm the air is.

use std::f64::consts::TAU;

use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::motion::Course;
use super::random::{Subject, even, log_even, sign, stream};

/// Samples per second of every trace of a usual day.
const RATE_HZ: f64 = 200.0;
/// Speed at which a trace without rest goes away, mm/s.
const AWAY_MM_S: f64 = 10.0;

/// What is measured on a day.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Day {
    /// Three amplitudes at three rates, and six cycles: [`Session::whole`].
    Usual,
    /// What another laboratory would do: [`Session::other`].
    Other,
    /// The same, but every trace comes from far off and goes there again without a rest: [`Session::in_motion`].
    InMotion,
}

/// One trace as it is planned.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Name in the head of the trace.
    pub name: String,
    /// Name of its file.
    pub file: String,
    /// What is done.
    pub course: Course,
    /// Time of the first sample since the data set began, s.
    pub start_s: f64,
    /// Number of samples.
    pub samples: usize,
    /// Samples per second.
    pub rate_hz: f64,
}

impl Recording {
    /// Time of each sample since the trace began, s.
    pub fn times(&self) -> impl Iterator<Item = f64> {
        (0..self.samples).map(|k| k as f64 / self.rate_hz)
    }

    /// Time of the last sample since the trace began, s.
    #[must_use]
    pub fn last_s(&self) -> f64 {
        (self.samples.max(1) - 1) as f64 / self.rate_hz
    }
}

/// The traces of a data set in order of recording, and the air around them.
#[derive(Clone, Debug)]
pub struct Session {
    /// The traces.
    pub recordings: Vec<Recording>,
    air: Air,
    /// Mean temperature of all samples, °C: the reference temperature of the laws.
    pub mean_temperature: f64,
}

/// Temperature over time: a slope and two slow waves.
#[derive(Clone, Debug)]
struct Air {
    mean: f64,
    slope_per_s: f64,
    /// Amplitude K, angular frequency 1/s, phase.
    waves: [(f64, f64, f64); 2],
}

impl Air {
    fn at(&self, set_time: f64) -> f64 {
        let waves =
            self.waves.iter().map(|(size, turn, phase)| size * (turn * set_time + phase).sin());
        self.mean + self.slope_per_s * set_time + waves.sum::<f64>()
    }

    fn random(random: &mut ChaCha8Rng) -> Self {
        let mut wave = || {
            let period = even(random, 200.0, 900.0);
            (even(random, 0.3, 0.9), TAU / period, even(random, 0.0, TAU))
        };
        let waves = [wave(), wave()];
        let slope_per_s = sign(random) * even(random, 0.3, 2.0) / 700.0;
        Self { mean: even(random, 21.0, 26.0), slope_per_s, waves }
    }
}

/// How the motions of one data set are carried out.
struct Habits {
    gap_mm: f64,
    corner_s: f64,
    /// Where a trace begins and ends in motion, off the specimen, mm; none where it begins and ends at rest.
    far_mm: Option<f64>,
}

impl Habits {
    fn random(random: &mut ChaCha8Rng) -> Self {
        let (gap_mm, corner_s) = (even(random, 0.5, 0.8), even(random, 0.03, 0.05));
        Self { gap_mm, corner_s, far_mm: None }
    }

    fn begin(&self, random: &mut ChaCha8Rng) -> Course {
        let rest_s = even(random, 0.5, 1.0);
        match self.far_mm {
            Some(far_mm) => Course::at_rest(-far_mm, 0.0, self.corner_s),
            None => Course::at_rest(-self.gap_mm, rest_s, self.corner_s),
        }
    }

    /// Ends a trace off the specimen.
    fn end(&self, course: &mut Course, rest_s: f64) {
        match self.far_mm {
            Some(far_mm) => course.go(-far_mm, AWAY_MM_S),
            None => course.stay(rest_s),
        }
    }

    fn hold(&self, random: &mut ChaCha8Rng, to_mm: f64, speed: f64) -> Course {
        let mut course = self.begin(random);
        course.go(to_mm, speed);
        course.stay(even(random, 4.2, 4.4));
        course.go(-self.gap_mm, speed);
        course.stay(even(random, 2.0, 3.0));
        course
    }

    fn cycles(&self, random: &mut ChaCha8Rng) -> Course {
        let mut course = self.begin(random);
        let (hold, rest) = (even(random, 0.3, 0.5), even(random, 0.2, 0.4));
        for _ in 0..6 {
            course.go(8.0, 20.0);
            course.stay(hold);
            course.go(-self.gap_mm, 20.0);
            course.stay(rest);
        }
        course.stay(even(random, 2.0, 3.0));
        course
    }
}

/// The motions of a day.
type Plan = fn(&Habits, &mut ChaCha8Rng) -> Vec<Course>;

const PLANS: [Plan; 5] = [staircases, triangles, wanderings, long_holds, retreats];

/// Up in four steps and down again, with a hold on each.
fn staircases(habits: &Habits, random: &mut ChaCha8Rng) -> Vec<Course> {
    let mut staircase = |speed: f64| {
        let mut course = habits.begin(random);
        for to_mm in [3.0, 6.0, 9.0, 12.0, 9.0, 6.0, 3.0] {
            course.go(to_mm, speed);
            course.stay(even(random, 2.0, 5.0));
        }
        course.go(-habits.gap_mm, speed);
        habits.end(&mut course, even(random, 2.0, 5.0));
        course
    };
    [2.0, 5.0, 15.0, 40.0].map(&mut staircase).into()
}

/// Cycles without a hold, each trace to a depth and at a speed of its own.
fn triangles(habits: &Habits, random: &mut ChaCha8Rng) -> Vec<Course> {
    let mut cycles = |(to_mm, speed): (f64, f64)| {
        let mut course = habits.begin(random);
        for _ in 0..4 {
            course.go(to_mm, speed);
            course.go(-habits.gap_mm, speed);
        }
        habits.end(&mut course, even(random, 2.0, 3.0));
        course
    };
    [(12.0, 3.0), (12.0, 12.0), (6.0, 3.0), (6.0, 12.0), (12.0, 40.0), (9.0, 6.0)]
        .map(&mut cycles)
        .into()
}

/// From place to place by chance, at a speed by chance, with and without a stay.
fn wanderings(habits: &Habits, random: &mut ChaCha8Rng) -> Vec<Course> {
    let mut wandering = |_: usize| {
        let mut course = habits.begin(random);
        course.go(12.0, log_even(random, 5.0, 60.0));
        for _ in 0..9 {
            course.stay(even(random, 0.0, 1.5));
            course.go(even(random, -habits.gap_mm, 12.0), log_even(random, 5.0, 60.0));
        }
        course.go(-habits.gap_mm - 2.5, 20.0);
        habits.end(&mut course, even(random, 2.0, 3.0));
        course
    };
    (0..6).map(&mut wandering).collect()
}

/// Relaxation tests: fast to a depth, a long hold, a long rest.
fn long_holds(habits: &Habits, random: &mut ChaCha8Rng) -> Vec<Course> {
    let mut hold = |to_mm: f64| {
        let mut course = habits.begin(random);
        course.go(to_mm, 30.0);
        course.stay(even(random, 40.0, 60.0));
        course.go(-habits.gap_mm, 30.0);
        habits.end(&mut course, even(random, 10.0, 20.0));
        course
    };
    [3.0, 6.0, 9.0, 12.0].map(&mut hold).into()
}

/// The same press, and back at many speeds, each twice.
fn retreats(habits: &Habits, random: &mut ChaCha8Rng) -> Vec<Course> {
    let mut retreat = |speed: f64| {
        let mut course = habits.begin(random);
        course.go(12.0, 10.0);
        course.stay(1.0);
        course.go(-habits.gap_mm, speed);
        habits.end(&mut course, even(random, 2.0, 3.0));
        course
    };
    [1.5, 5.0, 20.0, 60.0, 1.5, 5.0, 20.0, 60.0].map(&mut retreat).into()
}

impl Session {
    /// What is done on such a day.
    #[must_use]
    pub fn of_day(day: Day, seed: u64) -> Self {
        match day {
            Day::Usual => Self::whole(seed),
            Day::Other => Self::other(seed),
            Day::InMotion => Self::in_motion(seed),
        }
    }

    /// Three amplitudes at three rates, and six cycles. One set in two goes from small to large
    /// amplitudes, rates in any order; the other takes all traces in any order.
    #[must_use]
    pub fn whole(seed: u64) -> Self {
        let random = &mut stream(seed, Subject::Session);
        let habits = Habits::random(random);
        let mut planned = Vec::new();
        for to_mm in [4, 8, 12] {
            for speed in [5, 20, 60] {
                let course = habits.hold(random, f64::from(to_mm), f64::from(speed));
                let name = format!("{to_mm} mm at {speed} mm/s");
                planned.push((to_mm, name, format!("hold-{to_mm}mm-{speed}mms.csv"), course));
            }
        }
        // Before or after the block of its amplitude.
        let place = if random.random_bool(0.5) { 7 } else { 9 };
        let cycles = habits.cycles(random);
        planned.push((
            place,
            "six cycles to 8 mm at 20 mm/s".into(),
            "cycles-8mm-20mms.csv".into(),
            cycles,
        ));
        planned.shuffle(random);
        if random.random_bool(0.5) {
            planned.sort_by_key(|(amplitude, ..)| *amplitude);
        }
        let planned = planned.into_iter().map(|(_, name, file, course)| (name, file, course));
        Self::of(random, RATE_HZ, planned)
    }

    /// What another laboratory would do, at another rate: holds on a staircase, cycles without a hold, motions by chance,
    /// few long holds, or retreats at many speeds. All reach 12 mm.
    #[must_use]
    pub fn other(seed: u64) -> Self {
        let random = &mut stream(seed, Subject::Session);
        let habits = Habits::random(random);
        Self::planned(random, &habits)
    }

    /// The same by habits without a rest: every trace comes from 15 to 30 mm off and goes there again.
    #[must_use]
    pub fn in_motion(seed: u64) -> Self {
        let random = &mut stream(seed, Subject::Session);
        let far_mm = Some(even(random, 15.0, 30.0));
        let habits = Habits { far_mm, ..Habits::random(random) };
        Self::planned(random, &habits)
    }

    fn planned(random: &mut ChaCha8Rng, habits: &Habits) -> Self {
        let plan = PLANS[random.random_range(0..PLANS.len())];
        let rate_hz = [50.0, 100.0, 250.0][random.random_range(0..3)];
        let mut planned = plan(habits, random);
        planned.shuffle(random);
        let named = planned.into_iter().enumerate().map(|(k, course)| {
            let name = format!("take {}", k + 1);
            (name, format!("take-{}.csv", k + 1), course)
        });
        Self::of(random, rate_hz, named)
    }

    /// A single trace, 8 mm at 20 mm/s.
    #[must_use]
    pub fn short(seed: u64) -> Self {
        let random = &mut stream(seed, Subject::Session);
        let habits = Habits::random(random);
        let course = habits.hold(random, 8.0, 20.0);
        Self::of(random, RATE_HZ, [("8 mm at 20 mm/s".into(), "hold-8mm-20mms.csv".into(), course)])
    }

    fn of(
        random: &mut ChaCha8Rng,
        rate_hz: f64,
        planned: impl IntoIterator<Item = (String, String, Course)>,
    ) -> Self {
        let mut start_s = 0.0;
        let mut recordings = Vec::new();
        for (name, file, course) in planned {
            let lasts_s = course.lasts_s();
            let samples = (lasts_s * rate_hz) as usize;
            recordings.push(Recording { name, file, course, start_s, samples, rate_hz });
            let next: f64 = start_s + lasts_s + even(random, 20.0, 120.0);
            start_s = (10.0 * next).round() / 10.0;
        }
        let mut session = Self { recordings, air: Air::random(random), mean_temperature: 0.0 };
        let (sum, count) = session.recordings.iter().fold((0.0, 0), |(sum, count), recording| {
            let of_all =
                recording.times().map(|time| session.temperature(recording.start_s + time));
            (sum + of_all.sum::<f64>(), count + recording.samples)
        });
        session.mean_temperature = sum / f64::from(count as u32);
        session
    }

    /// Time from the first sample to the last, pauses included, s.
    #[must_use]
    pub fn lasts_s(&self) -> f64 {
        self.recordings.last().map_or(0.0, |last| last.start_s + last.last_s())
    }

    /// Samples per second of every trace.
    #[must_use]
    pub fn rate_hz(&self) -> f64 {
        self.recordings.first().map_or(RATE_HZ, |first| first.rate_hz)
    }

    /// True temperature of the air, °C, at a time since the data set began, s.
    #[must_use]
    pub fn temperature(&self, set_time: f64) -> f64 {
        self.air.at(set_time)
    }
}
