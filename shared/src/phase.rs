//! The six regions of a grasp (section 3.4.1), found while streaming, and the type of relaxation.
//!
//! ```text
//!   signal            B
//!                    /\C                     O  the motion begins          OA preloading
//!                   /  ‾‾──____              A  the signal reaches touch   AB loading
//!                  /           ‾D            B  the signal is highest      BC transition
//!                A/              \           C  the motion stops           CD relaxation
//!   ____________O/                \E____F    D  the motion retreats        DE unloading
//!   rest                                rest E  contact is lost            EF recovery
//! ```
//!
//! Two numbers per sample are enough: the *motion*, which is the displacement where it is known and the filter's elastic
//! input otherwise (it follows the motion because it has no memory), and the *signal*, strain or force, positive in
//! compression. A gauge may lie where pressing stretches it: there the whole picture is upside down, which
//! [`State::of_either_sense`] finds out and turns over; where it was taken the wrong way round, as when a bridge was not tared,
//! it is right again with the next press. A partial release that is then held goes from unloading to relaxation
//! (of Type II), a further press from relaxation to loading; contact after recovery begins the next grasp.
//!
//! Both are averaged over the smoothing time, and the regions are looked for once for each such mean, not at every sample.
//! A boundary is known only some time after it was passed: the motion must stand for the dwell before it has stopped. So a
//! region is reported together with how many samples ago it was entered, and a reader with the whole recording puts the
//! boundary back to where it belongs. Where two boundaries become known at once, they are reported one mean apart. When
//! the signal is highest at the moment the motion stops, B is C and there is no transition.

mod average;
mod config;
mod motion;

use average::{Average, Mean};
pub use config::{Config, ConfigError, Thresholds};
use motion::{Direction, Motion};

/// A region of a grasp, section 3.4.1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Region {
    /// Before touch and after recovery.
    Rest,
    /// OA: the motion has begun, the signal has not reached the touch level.
    Preloading,
    /// AB: in contact, the motion advances.
    Loading,
    /// BC: the motion still advances but the signal already falls.
    Transition,
    /// CD: the motion stands, in contact.
    Relaxation,
    /// DE: the motion retreats, in contact.
    Unloading,
    /// EF: contact is lost, the material still recovers.
    Recovery,
}

/// The two types of relaxation, section 4.2.1, told apart by the sign of the latent part, which is turned over with the signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RelaxationType {
    /// Within the dead band of equilibrium.
    None,
    /// The signal is farther from zero than its equilibrium and decays: after loading.
    TypeI,
    /// The signal is nearer to zero than its equilibrium and recovers: after a partial unloading.
    TypeII,
}

impl RelaxationType {
    /// From the latent part and a dead band, both in LSB of the signal.
    #[must_use]
    pub const fn of(latent: i32, dead_band: i32) -> Self {
        if latent > dead_band {
            Self::TypeI
        } else if latent < dead_band.saturating_neg() {
            Self::TypeII
        } else {
            Self::None
        }
    }
}

/// What is known after a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Phase {
    /// The region the grasp is in, as far as is known.
    pub region: Region,
    /// On the sample at which a region is found: how many samples ago it was entered, 0 for this one.
    pub entered_samples_ago: Option<u32>,
    /// Type of relaxation by the latent part of the last sample of a mean.
    pub relaxation: RelaxationType,
}

/// Nothing is remembered as longer ago, so that a wrapping sample number stays unambiguous.
const LONG_AGO: u32 = 1 << 31;

/// What is remembered of a grasp. Sample numbers count from 0 and wrap; a mean is dated at the middle of its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct State {
    average: Average,
    phase: Phase,
    /// The last sample looked at.
    last: u32,
    /// Date of the last mean.
    now: u32,
    /// When the present region was entered.
    entered_at: u32,
    motion: Motion,
    contact: Contact,
    /// The same of the signal turned over.
    opposite: Contact,
    /// Highest signal since loading began.
    peak: i32,
    peak_at: u32,
    /// The last sample with the latent part outside the dead band.
    unsettled_at: u32,
    /// Where the signal would settle by itself; in recovery, the lowest of it since contact was lost.
    settles_at: i32,
    sense: Sense,
}

/// Which way the signal goes when there is pressing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sense {
    /// Up, always.
    Compression,
    /// To be found out; so far up, or down.
    Found { turned: bool },
}

impl Sense {
    const fn is_turned(self) -> bool {
        matches!(self, Self::Found { turned: true })
    }
}

/// Touch with hysteresis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Contact {
    touching: bool,
    /// When it was made or lost.
    since: u32,
    /// The last sample at or below the release level.
    below_at: u32,
    /// The last mean.
    signal: i32,
}

impl Contact {
    const fn none(signal: i32) -> Self {
        Self { touching: false, since: 0, below_at: 0, signal }
    }

    fn step(&mut self, config: &Config, mean: &Mean, now: u32) {
        let signal = mean.signal;
        if signal <= config.release {
            self.below_at = now;
        }
        let touches = if self.touching { signal > config.release } else { signal >= config.touch };
        if touches != self.touching {
            let level = if touches { config.touch } else { config.release };
            self.touching = touches;
            self.since = now.wrapping_sub(self.samples_since(level, mean));
        }
        self.signal = signal;
    }

    /// How long ago a straight line from the last mean to this one crossed a level.
    fn samples_since(&self, level: i32, mean: &Mean) -> u32 {
        let way = |from: i32| i64::from(mean.signal).wrapping_sub(i64::from(from));
        let samples = way(level).wrapping_mul(i64::from(mean.samples));
        let ago = samples.checked_div(way(self.signal)).unwrap_or(0);
        u32::try_from(ago).unwrap_or(0).min(mean.samples)
    }
}

impl State {
    /// Long at rest before the first sample, whose motion and signal are given. A recording that begins in motion or in contact
    /// may report a boundary from before its first sample.
    #[must_use]
    pub const fn at_rest(motion: i32, signal: i32) -> Self {
        Self {
            average: Average::of(0),
            phase: Phase {
                region: Region::Rest,
                entered_samples_ago: None,
                relaxation: RelaxationType::None,
            },
            last: 0,
            now: 0,
            entered_at: 0_u32.wrapping_sub(LONG_AGO),
            motion: Motion::still_at(motion, 0),
            contact: Contact::none(signal),
            opposite: Contact::none(signal.saturating_neg()),
            peak: signal,
            peak_at: 0,
            unsettled_at: 0,
            settles_at: signal,
            sense: Sense::Compression,
        }
    }

    /// The same for a signal that may go up or down when there is pressing, with a motion that goes as the signal does. A
    /// movement that begins at rest is pressing: if it goes the other way, both are turned over.
    #[must_use]
    pub const fn of_either_sense(motion: i32, signal: i32) -> Self {
        Self { sense: Sense::Found { turned: false }, ..Self::at_rest(motion, signal) }
    }

    /// Takes one sample: motion and signal in the units of the thresholds, and the filter's latent part.
    #[inline]
    pub fn step(&mut self, config: &Config, motion: i32, signal: i32, latent: i32) -> Phase {
        self.advance(config, motion, signal, latent);
        self.phase
    }

    /// As [`Self::step`]; whether region or type of relaxation changed.
    #[inline(always)]
    pub(crate) fn advance(
        &mut self,
        config: &Config,
        motion: i32,
        signal: i32,
        latent: i32,
    ) -> bool {
        self.phase.entered_samples_ago = None;
        self.average.add(motion, signal) && self.look(config, latent)
    }

    /// What is known after the last sample.
    #[must_use]
    pub const fn phase(&self) -> Phase {
        self.phase
    }

    /// Looks for a boundary in the mean of the samples since the last one; whether region or type of relaxation changed.
    #[inline(never)]
    fn look(&mut self, config: &Config, latent: i32) -> bool {
        let mean = self.average.mean().turned(self.sense.is_turned());
        self.average = config.average;
        self.last = self.last.wrapping_add(mean.samples);
        self.now = self.last.wrapping_sub(mean.samples / 2);
        if self.ago(self.entered_at) > LONG_AGO {
            self.entered_at = self.now.wrapping_sub(LONG_AGO);
        }
        self.motion.step(config, mean.motion, self.now);
        self.contact.step(config, &mean, self.now);
        self.opposite.step(config, &mean.turned(true), self.now);
        let turns = self.goes_the_other_way(config, self.last == mean.samples);
        let mean = mean.turned(turns);
        if turns {
            self.turn_over();
        }
        let latent = if self.sense.is_turned() { latent.saturating_neg() } else { latent };
        let relaxation = RelaxationType::of(latent, config.latent_dead_band);
        let relaxes_otherwise = relaxation != self.phase.relaxation;
        self.phase.relaxation = relaxation;
        if self.phase.relaxation != RelaxationType::None {
            self.unsettled_at = self.now;
        }
        let settles_at = mean.signal.saturating_sub(latent);
        self.settles_at = match self.phase.region {
            Region::Recovery => self.settles_at.min(settles_at),
            _ => settles_at,
        };
        let next = self.next(config, mean.signal);
        if let Some((region, since)) = next {
            let ago = self.enter(region, since);
            if region == Region::Loading {
                (self.peak, self.peak_at) = (mean.signal, self.now);
            }
            self.phase.entered_samples_ago = Some(ago.saturating_add(mean.samples / 2));
        }
        relaxes_otherwise || next.is_some()
    }

    /// Whether there is pressing that the present sense takes for the opposite: `first` of all means it is beyond touch the other
    /// way, it begins the other way from rest, or a retreat after contact was lost goes farther than the press did.
    fn goes_the_other_way(&self, config: &Config, first: bool) -> bool {
        let Sense::Found { .. } = self.sense else { return false };
        let Motion { direction, since, .. } = self.motion;
        let retreats = direction == Direction::Retreating;
        match self.phase.region {
            Region::Rest if first => self.opposite.touching && !self.contact.touching,
            Region::Rest => retreats && !self.before(since, self.entered_at),
            Region::Recovery => retreats && self.opposite.signal > self.peak.max(config.touch),
            _ => false,
        }
    }

    fn turn_over(&mut self) {
        self.sense = Sense::Found { turned: !self.sense.is_turned() };
        self.motion.turn_over();
        core::mem::swap(&mut self.contact, &mut self.opposite);
    }

    /// Enters a region, not before the last one; returns how long ago.
    fn enter(&mut self, region: Region, since: u32) -> u32 {
        let ago = self.ago(since).min(self.ago(self.entered_at));
        self.phase.region = region;
        self.entered_at = self.now.wrapping_sub(ago);
        ago
    }

    const fn ago(&self, sample: u32) -> u32 {
        self.now.wrapping_sub(sample)
    }

    /// Whether `a` came before `b`.
    const fn before(&self, a: u32, b: u32) -> bool {
        self.ago(a) > self.ago(b)
    }

    /// The region to enter now, if any, and since when.
    fn next(&mut self, config: &Config, signal: i32) -> Option<(Region, u32)> {
        let Contact { touching, since: contact_since, below_at, .. } = self.contact;
        let Motion { direction, since: moved_at, .. } = self.motion;
        let lost = (!touching).then_some((Region::Recovery, contact_since));
        match (self.phase.region, direction) {
            // A motion that began before rest did is the end of recovery.
            (Region::Rest, Direction::Advancing) if self.before(self.entered_at, moved_at) => {
                Some((Region::Preloading, moved_at))
            }
            // What recovers into contact without a motion is no second grasp: the next begins with its motion. Nor is it one when it has settled.
            (Region::Recovery, Direction::Advancing)
                if touching && self.is_beyond_recovery(config, signal) =>
            {
                let moved_first = self.before(moved_at, below_at);
                Some((Region::Preloading, if moved_first { below_at } else { moved_at }))
            }
            (Region::Rest, _) if touching && !self.before(contact_since, self.entered_at) => {
                Some((Region::Preloading, below_at))
            }
            (Region::Rest, _) => None,
            (Region::Recovery, _) => self.recovered(config),

            (Region::Preloading, _) if touching => Some((Region::Loading, contact_since)),
            (Region::Preloading, Direction::Advancing) => None,
            (Region::Preloading, _) => Some((Region::Rest, moved_at)),

            (Region::Loading, _) => self.after_loading(config, signal),
            (Region::Transition | Region::Relaxation, Direction::Retreating) => {
                Some((Region::Unloading, moved_at))
            }
            (_, _) if lost.is_some() => lost,
            (Region::Transition | Region::Unloading, Direction::Still) => {
                Some((Region::Relaxation, moved_at))
            }
            (Region::Relaxation | Region::Unloading, Direction::Advancing) => {
                Some((Region::Loading, moved_at))
            }
            (Region::Transition, Direction::Advancing)
            | (Region::Relaxation, Direction::Still)
            | (Region::Unloading, Direction::Retreating) => None,
        }
    }

    /// Whether a signal is higher than it comes by itself after contact was lost. Where the motion is told from the signal, the
    /// material that springs back looks like one; it does not bring the signal beyond where it was about to settle.
    fn is_beyond_recovery(&self, config: &Config, signal: i32) -> bool {
        match self.sense {
            Sense::Compression => true,
            Sense::Found { .. } => signal >= config.touch.saturating_add(self.settles_at.max(0)),
        }
    }

    fn after_loading(&mut self, config: &Config, signal: i32) -> Option<(Region, u32)> {
        if signal > self.peak {
            (self.peak, self.peak_at) = (signal, self.now);
        }
        let Motion { direction, since: moved_at, .. } = self.motion;
        let fell = self.peak.saturating_sub(signal) > config.peak_drop;
        // Closer together than the smoothing can tell, B is C.
        let peak_came_before =
            |sample| self.ago(self.peak_at) > self.ago(sample).saturating_add(config.resolution());
        let transition = (Region::Transition, self.peak_at);
        match direction {
            // The motion may have stopped without this being known yet: it must have gone on since the peak.
            Direction::Advancing => {
                let went_on = peak_came_before(self.motion.went_on_until(config));
                (fell && went_on).then_some(transition)
            }
            // Contact may be found before the motion that made it: then that motion has not stopped, it was not yet seen.
            Direction::Still if !self.before(self.entered_at, moved_at) => {
                let waited = self.ago(self.entered_at) > config.dwell;
                waited.then_some((Region::Relaxation, self.entered_at))
            }
            _ if peak_came_before(moved_at) => Some(transition),
            Direction::Still => Some((Region::Relaxation, moved_at)),
            Direction::Retreating => Some((Region::Unloading, moved_at)),
        }
    }

    fn recovered(&self, config: &Config) -> Option<(Region, u32)> {
        let settled = self.ago(self.unsettled_at) > config.dwell;
        let late = self.ago(self.entered_at) >= config.recovery_limit;
        let since = if settled { self.unsettled_at } else { self.now };
        (settled || late).then_some((Region::Rest, since))
    }
}
