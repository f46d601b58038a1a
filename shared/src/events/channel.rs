//! One gauge, or one signal.

use super::config::{Config, JOLTS_MOST};
use super::vibration::{LowPass, Vibration, raised};

/// What a sample changes, with how many samples ago that showed first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Change {
    None,
    Touched(u32),
    LetGo(u32),
    Slipped(u32),
}

/// What is remembered of one channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Channel {
    smooth: LowPass,
    rest: LowPass,
    vibration: Vibration,
    /// Which way pressing drove the signal, while something is held.
    held: Option<Sense>,
    /// The reading above rest, in the sense of the press, when it last was not falling.
    before_fall: i32,
    /// The lowest FA of the present fall, in the same sense.
    lowest: i32,
    /// More than half of what was held is gone, with FA out of its resting band.
    fallen: bool,
    /// On which side of the resting band FA is, 0 within it, and since when.
    side: i32,
    on_this_side: u32,
    /// A burst that was told makes no second event.
    spent: bool,
    /// The last sample with a burst, or with a reading away from rest while something is held.
    unquiet: u32,
    /// No jolt counts until so long after this, if it is set.
    deaf_since: Option<u32>,
    jolts: Jolts,
}

/// Which way the signal goes when there is pressing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sense {
    Up,
    Down,
}

impl Sense {
    const fn of(value: i32) -> Self {
        if value < 0 { Self::Down } else { Self::Up }
    }

    const fn turn(self, value: i32) -> i32 {
        match self {
            Self::Up => value,
            Self::Down => value.saturating_neg(),
        }
    }
}

impl Channel {
    pub(super) fn at_rest(signal: i32) -> Self {
        Self {
            smooth: LowPass::at(0),
            rest: LowPass::at(raised(signal)),
            vibration: Vibration::NONE,
            held: None,
            before_fall: 0,
            lowest: 0,
            fallen: false,
            side: 0,
            on_this_side: 0,
            spent: false,
            unquiet: 0,
            deaf_since: None,
            jolts: Jolts::NONE,
        }
    }

    pub(super) const fn holds(&self) -> bool {
        self.held.is_some()
    }

    /// Another gauge has let go: so has this one if it is on the way, too weak for a burst of its own.
    pub(super) const fn let_go_with_another(&mut self) {
        if self.fallen {
            self.held = None;
        }
    }

    /// From now on no jolt counts for the time of a mask.
    pub(super) const fn deafen(&mut self, now: u32) {
        self.deaf_since = Some(now);
        self.jolts = Jolts::NONE;
    }

    /// Forgets what is too long ago to matter, before its sample number comes again.
    #[cold]
    pub(super) fn forget(&mut self, config: &Config, now: u32) {
        self.vibration.forget(config, now);
        self.deaf_since = self.deaf_since.filter(|_| self.is_deaf(config, now));
        self.jolts.forget(config, now);
    }

    /// Takes a sample, reading and FA; `holds` says whether the fingertip does.
    #[inline(always)]
    pub(super) fn step(
        &mut self,
        config: &Config,
        (signal, fa): (i32, i32),
        now: u32,
        holds: bool,
    ) -> Change {
        // Within 2^27, so that none of the differences wraps.
        let (signal, rough) = (raised(signal), raised(fa));
        let fa = self.smooth.follow(config.smoothing, rough);
        let side =
            i32::from(fa >= config.band).wrapping_sub(i32::from(fa.wrapping_neg() >= config.band));
        if side != self.side {
            self.side = side;
            self.on_this_side = now;
            self.spent = false;
        }
        let shakes = self.vibration.shakes(config, rough, fa);
        let above_rest = signal.wrapping_sub(self.rest.level());
        let change = match self.held {
            None => self.untouched(config, fa, above_rest, signal, now),
            Some(sense) => self.touched(config, sense.turn(fa), sense.turn(above_rest), now),
        };
        let jolts = shakes && self.vibration.jolts(config, now);
        if change != Change::None {
            self.spent = true;
            self.unquiet = now;
            return change;
        }
        if jolts && holds { self.slip(config, now) } else { Change::None }
    }

    /// Nothing is held: is it touched?
    #[inline(always)]
    fn untouched(
        &mut self,
        config: &Config,
        fa: i32,
        above_rest: i32,
        signal: i32,
        now: u32,
    ) -> Change {
        if fa.wrapping_abs() >= config.burst {
            self.unquiet = now;
            return self.bursts(config, fa, above_rest, now);
        }
        if now.wrapping_sub(self.unquiet) > config.settle {
            self.unquiet = now.wrapping_sub(config.settle).wrapping_sub(1);
            self.rest.follow(config.resting, signal);
        }
        Change::None
    }

    /// A burst while nothing is held.
    fn bursts(&mut self, config: &Config, fa: i32, above_rest: i32, now: u32) -> Change {
        let sense = Sense::of(fa);
        // A load that makes FA burst is larger than FA: what only comes back to rest, as after a pull, is none.
        let left_rest = sense.turn(above_rest) >= config.burst.saturating_mul(2);
        if self.spent || !left_rest || !config.admits(sense == Sense::Up) {
            return Change::None;
        }
        self.held = Some(sense);
        self.before_fall = sense.turn(above_rest);
        self.lowest = 0;
        self.fallen = false;
        Change::Touched(now.wrapping_sub(self.on_this_side))
    }

    /// Something is held: is it let go of? `fa` and `above_rest` are positive for pressing.
    #[inline(always)]
    fn touched(&mut self, config: &Config, fa: i32, above_rest: i32, now: u32) -> Change {
        let away = above_rest.wrapping_abs() > config.burst;
        if away || fa.wrapping_abs() >= config.burst {
            self.unquiet = now;
        } else if now.wrapping_sub(self.unquiet) > config.settle {
            // Silence: the contact is forgotten.
            self.held = None;
        }
        if fa.wrapping_neg() < config.band {
            self.before_fall = above_rest;
            self.lowest = fa.min(0);
            self.fallen = false;
            return Change::None;
        }
        self.falls(config, fa, above_rest, now)
    }

    /// FA is beyond its resting band, the way of a release, while something is held.
    fn falls(&mut self, config: &Config, fa: i32, above_rest: i32, now: u32) -> Change {
        self.lowest = self.lowest.min(fa);
        self.fallen = above_rest < self.before_fall / 2;
        // Some of the way back, beyond the noise: the load no longer falls.
        let back = (self.lowest.saturating_abs() / 32).max(config.band);
        let turned = fa.saturating_sub(self.lowest) > back;
        let bursts = self.lowest <= config.burst.saturating_neg();
        if bursts && turned && !self.spent && self.fallen {
            self.held = None;
            return Change::LetGo(now.wrapping_sub(self.on_this_side));
        }
        Change::None
    }

    /// A jolt while something is held: does it make a slip?
    #[cold]
    fn slip(&mut self, config: &Config, now: u32) -> Change {
        if self.is_deaf(config, now) {
            return Change::None;
        }
        self.jolts.forget(config, now);
        let first = self.jolts.add(config, now);
        first.map_or(Change::None, |first| Change::Slipped(now.wrapping_sub(first)))
    }

    /// Whether no jolt counts yet.
    fn is_deaf(&self, config: &Config, now: u32) -> bool {
        self.deaf_since.is_some_and(|since| now.wrapping_sub(since) <= config.deaf)
    }
}

/// The last jolts, and whether they were already told as a slip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Jolts {
    at: [u32; JOLTS_MOST],
    /// How many of these there are.
    count: u8,
    told: bool,
}

impl Jolts {
    const NONE: Self = Self { at: [0; JOLTS_MOST], count: 0, told: false };

    /// Takes a jolt that comes at `now`; the first of a series long enough, if it makes one that was not told.
    fn add(&mut self, config: &Config, now: u32) -> Option<u32> {
        self.at.rotate_right(1);
        if let Some(newest) = self.at.first_mut() {
            *newest = now;
        }
        self.count = self.count.saturating_add(1).min(config.jolts);
        let first = *self.at.get(usize::from(config.jolts.wrapping_sub(1)))?;
        let enough = self.count == config.jolts && now.wrapping_sub(first) <= config.within;
        if !enough || self.told {
            return None;
        }
        self.told = true;
        Some(first)
    }

    /// The series is over when none came for so long.
    fn forget(&mut self, config: &Config, now: u32) {
        let last = self.at.first().copied().filter(|_| self.count > 0);
        if last.is_some_and(|last| now.wrapping_sub(last) > config.within) {
            *self = Self::NONE;
        }
    }
}
