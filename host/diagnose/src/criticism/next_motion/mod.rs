//! The next experiment as a motion: within the limits of a rig, the one that sets the members of a credible set furthest apart, or
//! the one after which wanted parameters are known best (`precision.rs`).
//!
//! Motions of the menu and random ones are weighed; the best few are then changed step by step for as long as that helps.

mod precision;
mod rig;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::diagnose::Diagnosis;
use super::experiment::{MENU, MOST_MEMBERS};
use super::fitted::Fitted;
use super::separation::{Condition, Foreseen, Rivals};
use palpate_fit::data::{Data, DataError};
use palpate_fit::whitening::Whitening;
use palpate_model::effects::Scales;
use palpate_model::{Hold, Model, Move, Profile, Step};
use palpate_trace::{Trace, block_means};

pub use precision::{Informing, InformingError, Precision, inform};
pub use rig::{Rig, RigError, RigFile};

/// Seed of the random motions.
pub const SEED: u64 = 23;
/// Random motions to begin with.
const DRAWN: usize = 80;
/// Motions that are changed step by step.
const KEPT: usize = 3;
/// Changes of each that are tried in a round, the best of which is taken.
const CHANGES: usize = 8;
/// Most rounds.
const ROUNDS: usize = 24;
/// Rounds without a better motion after which it is left as it is.
const PATIENCE: usize = 4;
/// Moves of a random motion, least and most.
const MOVES: std::ops::RangeInclusive<usize> = 2..=8;
/// Rest before the first motion and after the last one, s, so that the zero is seen.
const ENDS_S: f64 = 0.5;
/// The slowest move, in parts of the largest speed.
const SLOWEST: f64 = 0.01;
/// Rest before the recording, s.
const REST_S: f64 = 60.0;

/// What a motion is for.
trait Aim: Sync {
    /// What is foreseen of a recording.
    type Foreseen: Send;

    /// A motion as a recording after the others.
    fn trace(&self, time: Vec<f64>, displacement: Vec<f64>) -> Trace;

    /// What is foreseen of it; none where it has no usable motion.
    fn foresee(&self, trace: Trace) -> Option<Self::Foreseen>;

    /// What it is worth, the more the better.
    fn worth(foreseen: &Self::Foreseen) -> f64;

    /// Largest size of the signal.
    fn largest_signal(foreseen: &Self::Foreseen) -> f64;
}

/// Seconds of rest before the recording, at the temperature of the others.
const BEFORE: Condition = Condition { rest: REST_S, warmer: 0.0 };

impl Aim for Rivals<'_> {
    type Foreseen = Foreseen;

    fn trace(&self, time: Vec<f64>, displacement: Vec<f64>) -> Trace {
        Rivals::trace(self, time, displacement, BEFORE)
    }

    fn foresee(&self, trace: Trace) -> Option<Foreseen> {
        Rivals::foresee(self, trace)
    }

    fn worth(foreseen: &Foreseen) -> f64 {
        foreseen.worth()
    }

    fn largest_signal(foreseen: &Foreseen) -> f64 {
        foreseen.predicted.iter().flatten().fold(0.0, |most: f64, y| most.max(y.abs()))
    }
}

/// The best motion for something.
struct Best<F> {
    trace: Trace,
    foreseen: F,
    /// What is foreseen of the best motion of the menu, within the same limits.
    of_menu: Option<F>,
    /// Motions that were weighed.
    weighed: usize,
}

/// A motion that is proposed.
#[derive(Clone, Debug)]
pub struct NextMotion {
    /// The recording as it is to be made, without its signal.
    pub trace: Trace,
    /// What each member says of it.
    pub foreseen: Foreseen,
    /// What the members say of the best motion of the menu, within the same limits; none where none fits them.
    pub of_menu: Option<Foreseen>,
    /// Motions that were weighed.
    pub weighed: usize,
}

/// What is proposed to decide what a diagnosis left open.
#[derive(Clone, Debug)]
pub struct Proposed {
    /// The effects that the recordings do not tell apart, the best first.
    pub members: Vec<String>,
    /// What the rig may do.
    pub rig: Rig,
    /// The motion; none where none within the limits tells the members apart.
    pub motion: Option<NextMotion>,
}

/// A motion that decides between the members of the first credible set with several; no members where no set has several.
///
/// # Errors
/// When the traces are not usable.
pub fn propose(
    model: &Model,
    diagnosis: &Diagnosis,
    traces: &[Trace],
    limits: &RigFile,
) -> Result<Proposed, DataError> {
    let members = members(diagnosis).into_iter().map(|(name, _)| name.to_owned()).collect();
    let (rig, motion) = among_rivals(model, diagnosis, traces, limits, next_motion)?;
    Ok(Proposed { members, rig, motion: motion.flatten() })
}

/// The motion of the menu that sets them furthest apart within the limits: what a proposal is measured against. None where there is
/// nothing to set apart.
///
/// # Errors
/// When the traces are not usable.
pub fn best_of_menu(
    model: &Model,
    diagnosis: &Diagnosis,
    traces: &[Trace],
    limits: &RigFile,
) -> Result<Option<Trace>, DataError> {
    let best = |rivals: &Rivals, scales: &Scales, rig: &Rig| {
        let judge = Judge { aim: rivals, rig };
        let weighed = judge.weighed(judge.menu(scales));
        let best = weighed.into_iter().max_by(|(_, a), (_, b)| a.total_cmp(b));
        best.map(|(legs, _)| judge.trace(&legs))
    };
    Ok(among_rivals(model, diagnosis, traces, limits, best)?.1.flatten())
}

/// A motion by chance within the limits: what a proposal is measured against. None where there is nothing to set apart.
///
/// # Errors
/// When the traces are not usable.
pub fn by_chance(
    model: &Model,
    diagnosis: &Diagnosis,
    traces: &[Trace],
    (limits, seed): (&RigFile, u64),
) -> Result<Option<Trace>, DataError> {
    let drawn = |rivals: &Rivals, _: &Scales, rig: &Rig| {
        let judge = Judge { aim: rivals, rig };
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut motions = (0..DRAWN).map(|_| judge.drawn(&mut random));
        let allowed = |legs: Legs| judge.weighed(vec![legs]).pop();
        motions.find_map(allowed).map(|(legs, _)| judge.trace(&legs))
    };
    Ok(among_rivals(model, diagnosis, traces, limits, drawn)?.1.flatten())
}

/// The members of the first credible set with several, the best first.
fn members(diagnosis: &Diagnosis) -> Vec<(&str, &Fitted)> {
    let mut undecided = diagnosis.found.undecided();
    undecided.truncate(MOST_MEMBERS);
    undecided
}

/// What is asked of the members of the first credible set with several, within the limits of a rig; none where no set has several.
fn among_rivals<T>(
    model: &Model,
    diagnosis: &Diagnosis,
    traces: &[Trace],
    limits: &RigFile,
    ask: impl FnOnce(&Rivals, &Scales, &Rig) -> T,
) -> Result<(Rig, Option<T>), DataError> {
    let means = block_means(traces);
    let scales = Data::of_model(model, traces)?.scales();
    let rig = limits.beside(&scales);
    let members: Vec<&Fitted> = members(diagnosis).into_iter().map(|(_, fitted)| fitted).collect();
    let searched = Data::of_model(model, means.as_deref().unwrap_or(traces))?;
    let noise = &diagnosis.noise;
    // That of means is not the noise of rows.
    let of_rows = Whitening::new(noise.level, &[], 0.0, 1);
    let rivals = Rivals {
        members: &members,
        signal: &diagnosis.signal,
        reference_temperature: searched.reference_temperature,
        traces: means.as_deref().unwrap_or(traces),
        whitening: if means.is_some() { &of_rows } else { &noise.whitening },
    };
    let told = (members.len() > 1).then(|| ask(&rivals, &scales, &rig));
    Ok((rig, told))
}

/// The motion that sets the members of a credible set furthest apart; none where no motion within the limits does.
#[must_use]
pub fn next_motion(rivals: &Rivals, scales: &Scales, rig: &Rig) -> Option<NextMotion> {
    let Best { trace, foreseen, of_menu, weighed } = best_motion(rivals, scales, rig)?;
    (foreseen.told() > 0).then_some(NextMotion { trace, foreseen, of_menu, weighed })
}

/// The motion that is worth most; none where none lies within the limits.
fn best_motion<A: Aim>(aim: &A, scales: &Scales, rig: &Rig) -> Option<Best<A::Foreseen>> {
    let judge = Judge { aim, rig };
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let mut weighed = judge.weighed(judge.menu(scales));
    let best = weighed.iter().max_by(|(_, a), (_, b)| a.total_cmp(b));
    let of_menu = best.and_then(|(legs, _)| aim.foresee(judge.trace(legs)));
    weighed.extend(judge.weighed((0..DRAWN).map(|_| judge.drawn(&mut random)).collect()));
    weighed.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    let mut count = MENU.len() + DRAWN;
    weighed.truncate(KEPT);
    for best in &mut weighed {
        let mut idle = 0;
        for _ in 0..ROUNDS {
            let changes = (0..CHANGES).map(|_| judge.changed(&best.0, &mut random)).collect();
            count += CHANGES;
            let better = judge.weighed(changes).into_iter().max_by(|(_, a), (_, b)| a.total_cmp(b));
            match better.filter(|(_, worth)| *worth > best.1) {
                Some(better) => (*best, idle) = (better, 0),
                None => idle += 1,
            }
            if idle == PATIENCE {
                break;
            }
        }
    }
    let (legs, _) = weighed.into_iter().max_by(|(_, a), (_, b)| a.total_cmp(b))?;
    let trace = judge.trace(&legs);
    let foreseen = aim.foresee(trace.clone())?;
    Some(Best { trace, foreseen, of_menu, weighed: count })
}

/// A move, and what comes after it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Leg {
    /// Where to, mm.
    to: f64,
    /// How fast, mm/s.
    speed: f64,
    /// How long it stays there, s.
    hold: f64,
}

type Legs = Vec<Leg>;

struct Judge<'a, A> {
    aim: &'a A,
    rig: &'a Rig,
}

impl<A: Aim> Judge<'_, A> {
    /// The motions that the rig allows, with what each is worth.
    fn weighed(&self, motions: Vec<Legs>) -> Vec<(Legs, f64)> {
        let weigh = |legs: Legs| {
            let trace = self.trace(&legs);
            let foreseen = self.aim.foresee(trace.clone())?;
            self.allows(&foreseen, &trace).then(|| (legs, A::worth(&foreseen)))
        };
        motions.into_par_iter().filter_map(weigh).collect()
    }

    fn allows(&self, foreseen: &A::Foreseen, trace: &Trace) -> bool {
        let signal = A::largest_signal(foreseen);
        trace.duration() <= self.rig.time_s && signal <= self.rig.signal
    }

    fn trace(&self, legs: &[Leg]) -> Trace {
        let motion = self.profile(legs).motion();
        let rounded = motion.displacement.iter().map(|x| (x * 1e5).round() / 1e5).collect();
        self.aim.trace(motion.time.to_vec(), rounded)
    }

    fn profile(&self, legs: &[Leg]) -> Profile {
        let hold = |hold_s: f64| (hold_s > 0.0).then_some(Step::Hold(Hold { hold_s }));
        let steps = legs.iter().flat_map(|leg| {
            let go = Move { to_mm: leg.to, speed_mm_per_s: Some(leg.speed) };
            std::iter::once(Step::Move(go)).chain(hold(leg.hold))
        });
        let ends = || hold(ENDS_S);
        let back = Move { to_mm: -self.rig.off_mm, speed_mm_per_s: None };
        Profile {
            version: 1,
            rate_hz: self.rig.rate_hz,
            start_mm: -self.rig.off_mm,
            speed_mm_per_s: self.rig.speed_mm_per_s,
            acceleration_mm_per_s2: self.rig.acceleration_mm_per_s2,
            repeat: 1,
            steps: ends()
                .into_iter()
                .chain(steps)
                .chain([Step::Move(back)])
                .chain(ends())
                .collect(),
        }
    }

    /// The motions of the menu.
    fn menu(&self, scales: &Scales) -> Vec<Legs> {
        MENU.iter().filter_map(|experiment| self.legs(&experiment.plain(scales)?)).collect()
    }

    /// A motion of the menu within the limits.
    fn legs(&self, profile: &Profile) -> Option<Legs> {
        let mut legs: Legs = Vec::new();
        for step in (0..profile.repeat).flat_map(|_| &profile.steps) {
            match (*step, legs.last_mut()) {
                (Step::Move(Move { to_mm, speed_mm_per_s }), _) => {
                    let speed = speed_mm_per_s.unwrap_or(profile.speed_mm_per_s);
                    legs.push(self.within(Leg { to: to_mm, speed, hold: 0.0 }));
                }
                (Step::Hold(Hold { hold_s }), Some(leg)) => leg.hold += hold_s,
                (Step::Hold(_), None) => {}
            }
        }
        (!legs.is_empty()).then_some(legs)
    }

    fn within(&self, leg: Leg) -> Leg {
        let Rig { displacement_mm, off_mm, speed_mm_per_s: speed, .. } = *self.rig;
        Leg {
            to: leg.to.clamp(-off_mm, displacement_mm),
            speed: leg.speed.clamp(SLOWEST * speed, speed),
            hold: leg.hold.clamp(0.0, self.rig.time_s),
        }
    }

    fn drawn(&self, random: &mut ChaCha8Rng) -> Legs {
        (0..random.random_range(MOVES)).map(|_| self.leg(random)).collect()
    }

    fn leg(&self, random: &mut ChaCha8Rng) -> Leg {
        let Rig { displacement_mm, off_mm, speed_mm_per_s: speed, time_s, .. } = *self.rig;
        let hold =
            if random.random_bool(0.5) { 0.0 } else { random.random_range(0.0..0.3 * time_s) };
        Leg {
            to: random.random_range(-off_mm..=displacement_mm),
            speed: speed * SLOWEST.powf(random.random_range(0.0..1.0)),
            hold,
        }
    }

    /// The motion with one thing changed: a place, a speed, a hold, or a move more or less.
    fn changed(&self, legs: &[Leg], random: &mut ChaCha8Rng) -> Legs {
        let mut legs = legs.to_vec();
        let place = random.random_range(0..legs.len());
        let fresh = self.leg(random);
        let nearer = random.random_range(-0.2..0.2);
        match random.random_range(0..6) {
            0 => legs[place].to = fresh.to,
            1 => legs[place].to += nearer * self.rig.displacement_mm,
            2 => legs[place].speed = fresh.speed,
            3 => legs[place].hold = fresh.hold,
            4 if legs.len() > 1 => {
                legs.remove(place);
            }
            _ => legs.insert(place, fresh),
        }
        legs.iter().map(|leg| self.within(*leg)).collect()
    }
}
