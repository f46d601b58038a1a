//! The simulator: from the commanded motion to the signal, with the hidden laws at every fine step.
//!
//! The branches are integrated as what they are, differential equations dq/dt = dN/dt − v q, in
//! steps eight times finer than the samples; in the pauses between traces the steps grow. Nothing is
//! reset at the beginning of a trace, so what a law remembers it remembers from trace to trace.

use super::motion::Course;
use super::session::{Recording, Session};

/// Fine steps between two samples.
const STEPS: usize = 8;

/// Base `fung` with two exponentials.
#[derive(Clone, Copy, Debug)]
pub struct Base {
    /// Stiffness, N/mm^(q+1).
    pub p: f64,
    /// Exponent.
    pub q: f64,
    /// Shares c1, c2.
    pub shares: [f64; 2],
    /// Rates v1, v2, 1/s.
    pub rates: [f64; 2],
}

impl Base {
    /// Elastic response N, N, at a compression, mm.
    #[must_use]
    pub fn elastic(&self, x: f64) -> f64 {
        if x > 0.0 { self.p / (self.q + 1.0) * x.powf(self.q + 1.0) } else { 0.0 }
    }
}

/// What a law can look at, at one instant.
#[derive(Clone, Debug)]
pub struct Now<'a> {
    /// Time since the step before, s.
    pub step: f64,
    /// Time since the trace began, s; it runs on in the pause after it.
    pub time: f64,
    /// Time since the data set began, s.
    pub set_time: f64,
    /// Which trace of the set it is, or was before the pause.
    pub trace: usize,
    /// The commanded motion of the trace.
    pub course: &'a Course,
    /// Commanded displacement, mm.
    pub x: f64,
    /// Commanded speed, mm/s.
    pub speed: f64,
    /// Commanded acceleration, mm/s².
    pub acceleration: f64,
    /// Air temperature above the mean of the set, K.
    pub warmer: f64,
    /// Largest commanded compression so far, mm, this instant included.
    pub largest: f64,
    /// Completed loadings before this one.
    pub loadings: usize,
    /// Contact force, N, extrapolated from the two steps before.
    pub force: f64,
}

/// A law of one value: displacement mm, or force N.
pub type Change = Box<dyn FnMut(&Now<'_>, f64) -> f64>;
/// A law of two values, of which the last is changed.
pub type Change2 = Box<dyn FnMut(&Now<'_>, f64, f64) -> f64>;
/// A factor on the rate of a branch, by its number and the force N it still has to forget.
pub type Factor = Box<dyn FnMut(&Now<'_>, usize, f64) -> f64>;

/// What a law does at one place of the chain from commanded motion to signal.
#[allow(missing_debug_implementations)]
pub enum Act {
    /// Changes the displacement of the specimen, mm.
    Motion(Change),
    /// Changes the elastic response N, given x.
    Elastic(Change2),
    /// Changes what drives the branches (N by itself), given x.
    Drive(Change2),
    /// Changes the rates of the branches.
    Rate(Factor),
    /// Changes the force of the specimen, given N, before contact can part.
    Specimen(Change2),
    /// Changes the contact force.
    Contact(Change),
    /// Changes the recorded force.
    Sensor(Change),
}

/// What the specimen remembers.
struct Memory {
    forgetting: [f64; 2],
    drive: f64,
    forces: [f64; 2],
    largest: f64,
    touches: usize,
    touching: bool,
}

/// The signal of every trace, N, sample by sample, without noise.
#[must_use]
pub fn record(base: &Base, session: &Session, mut acts: Vec<Act>) -> Vec<Vec<f64>> {
    let mut memory = Memory {
        forgetting: [0.0; 2],
        drive: 0.0,
        forces: [0.0; 2],
        largest: 0.0,
        touches: 0,
        touching: false,
    };
    let mut simulation = Simulation { base, session, acts: &mut acts, memory: &mut memory };
    let starts = session.recordings.iter().skip(1).map(|next| Some(next.start_s));
    session
        .recordings
        .iter()
        .zip(starts.chain(std::iter::once(None)))
        .enumerate()
        .map(|(trace, (recording, next))| {
            let signal = simulation.trace(trace, recording);
            if let Some(next) = next {
                simulation.pause(trace, recording, next - recording.start_s);
            }
            signal
        })
        .collect()
}

struct Simulation<'a> {
    base: &'a Base,
    session: &'a Session,
    acts: &'a mut [Act],
    memory: &'a mut Memory,
}

impl Simulation<'_> {
    fn trace(&mut self, trace: usize, recording: &Recording) -> Vec<f64> {
        let step = 1.0 / (recording.rate_hz * STEPS as f64);
        let mut signal = Vec::with_capacity(recording.samples);
        signal.push(self.advance(trace, recording, 0.0, step));
        for fine in 1..=(recording.samples - 1) * STEPS {
            let value = self.advance(trace, recording, fine as f64 * step, step);
            if fine % STEPS == 0 {
                signal.push(value);
            }
        }
        signal
    }

    /// From the last sample to one fine step before the next trace.
    fn pause(&mut self, trace: usize, recording: &Recording, until: f64) {
        let fine = 1.0 / (recording.rate_hz * STEPS as f64);
        let mut time = recording.last_s();
        let mut step = fine;
        while until - fine - time > 1e-9 {
            step = (1.1 * step).min(0.5).min(until - fine - time);
            time += step;
            self.advance(trace, recording, time, step);
        }
    }

    fn advance(&mut self, trace: usize, recording: &Recording, time: f64, step: f64) -> f64 {
        let state = recording.course.at(time);
        let memory = &mut *self.memory;
        let touching = state.x > 0.0;
        memory.touches += usize::from(touching && !memory.touching);
        memory.touching = touching;
        memory.largest = memory.largest.max(state.x);
        let set_time = recording.start_s + time;
        let now = Now {
            step,
            time,
            set_time,
            trace,
            course: &recording.course,
            x: state.x,
            speed: state.speed,
            acceleration: state.acceleration,
            warmer: self.session.temperature(set_time) - self.session.mean_temperature,
            largest: memory.largest,
            loadings: memory.touches.saturating_sub(1),
            force: (2.0 * memory.forces[1] - memory.forces[0]).max(0.0),
        };
        self.chain(&now)
    }

    /// Commanded motion → specimen → contact → sensor.
    fn chain(&mut self, now: &Now<'_>) -> f64 {
        let Self { base, acts, memory, .. } = self;
        let mut x = now.x;
        for act in acts.iter_mut() {
            if let Act::Motion(law) = act {
                x = law(now, x);
            }
        }
        let mut elastic = base.elastic(x);
        for act in acts.iter_mut() {
            if let Act::Elastic(law) = act {
                elastic = law(now, x, elastic);
            }
        }
        let mut drive = elastic;
        for act in acts.iter_mut() {
            if let Act::Drive(law) = act {
                drive = law(now, x, drive);
            }
        }
        relax(base, acts, memory, now, drive);
        let branches: f64 = base.shares.iter().zip(&memory.forgetting).map(|(c, q)| c * q).sum();
        let mut force = (1.0 - base.shares[0] - base.shares[1]) * elastic + branches;
        for act in acts.iter_mut() {
            if let Act::Specimen(law) = act {
                force = law(now, elastic, force);
            }
        }
        force = force.max(0.0);
        memory.forces = [memory.forces[1], force];
        for act in acts.iter_mut() {
            if let Act::Contact(law) = act {
                force = law(now, force);
            }
        }
        for act in acts.iter_mut() {
            if let Act::Sensor(law) = act {
                force = law(now, force);
            }
        }
        force
    }
}

/// One exponential-Euler step of each branch, its drive growing evenly over the step.
fn relax(base: &Base, acts: &mut [Act], memory: &mut Memory, now: &Now<'_>, drive: f64) {
    for (branch, force) in memory.forgetting.iter_mut().enumerate() {
        let mut rate = base.rates[branch];
        for act in acts.iter_mut() {
            if let Act::Rate(law) = act {
                rate *= law(now, branch, *force);
            }
        }
        let (decay, gain) = decay_and_gain(rate * now.step);
        *force = decay * *force + gain * (drive - memory.drive);
    }
    memory.drive = drive;
}

/// What is left after `steps` time constants of a force, and of one that came evenly meanwhile.
#[must_use]
pub fn decay_and_gain(steps: f64) -> (f64, f64) {
    let gone = -(-steps).exp_m1();
    (1.0 - gone, if steps > 1e-12 { gone / steps } else { 1.0 })
}
