//! Whether something advances, stands or retreats, told from noise by distance and time.

use super::Config;

/// Fractional bits of a smoothed quantity.
pub(super) const SMOOTH_BITS: u32 = 16;

/// A one-pole average over 2^shift samples; it lags a steady slope by 2^shift − 1 samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Smooth(i64);

impl Smooth {
    pub(super) const fn at(value: i32) -> Self {
        Self(fine(value))
    }

    /// The average, `SMOOTH_BITS` fractional bits, with one more sample in it.
    pub(super) const fn step(&mut self, value: i32, shift: u32) -> i64 {
        let rest = fine(value).wrapping_sub(self.0).wrapping_shr(shift);
        self.0 = self.0.wrapping_add(rest);
        self.0
    }
}

/// A level with the fractional bits of a smoothed quantity.
pub(super) const fn fine(value: i32) -> i64 {
    (value as i64) << SMOOTH_BITS
}

/// Which way the motion goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    Still,
    Advancing,
    Retreating,
}

/// Follows the motion as a play does: a movement is one that covers two steps from where the motion stood, and ends when no
/// further step was made for the dwell, or when it came back by two steps from its furthest point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Motion {
    pub(super) direction: Direction,
    /// Sample at which the present direction began, put back to where the motion itself shows it.
    pub(super) since: u32,
    /// Standing: the level it stands at, which may creep by one step per dwell.
    anchor: i64,
    /// Standing: the last sample within half a step of the anchor.
    near_at: u32,
    /// Moving: the furthest point, counted in the direction of motion, and when it was reached.
    furthest: i64,
    furthest_at: u32,
    /// Moving: the last two whole steps.
    last: Mark,
    previous: Mark,
}

/// A whole step of a movement: where it ended, when, and how many samples it took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Mark {
    level: i64,
    at: u32,
    took: u32,
}

impl Motion {
    pub(super) const fn still_at(level: i64, now: u32) -> Self {
        Self {
            direction: Direction::Still,
            since: now,
            anchor: level,
            near_at: now,
            furthest: level,
            furthest_at: now,
            last: Mark { level, at: now, took: 0 },
            previous: Mark { level, at: now, took: 0 },
        }
    }

    /// Takes the smoothed motion of sample `now`.
    pub(super) fn step(&mut self, config: &Config, level: i64, now: u32) {
        match self.direction {
            Direction::Still => self.stand(config, level, now),
            Direction::Advancing => self.travel(config, level, now, Direction::Retreating),
            Direction::Retreating => {
                self.travel(config, level.wrapping_neg(), now, Direction::Advancing);
            }
        }
    }

    /// When a movement was last seen to go on for another half step. The very last part of a movement is not used: there
    /// the average creeps towards its end, however suddenly the motion stopped.
    pub(super) fn went_on_until(&self, config: &Config) -> u32 {
        self.certain_mark(config).at
    }

    fn stand(&mut self, config: &Config, level: i64, now: u32) {
        let away = level.wrapping_sub(self.anchor);
        if away.abs() <= config.motion_step >> 1 {
            self.near_at = now;
        }
        if away.abs() <= config.motion_step.wrapping_mul(2) {
            let creep = config.motion_creep;
            // Not `clamp`, which would panic if its limits were exchanged.
            self.anchor = self.anchor.wrapping_add(away.min(creep).max(creep.wrapping_neg()));
            return;
        }
        // From half a step to two steps took three quarters of the way from the anchor.
        let took = now.wrapping_sub(self.near_at);
        let began = now.wrapping_sub(took.saturating_add(took / 3));
        if away > 0 {
            self.start(Direction::Advancing, began, level, now);
        } else {
            self.start(Direction::Retreating, began, level.wrapping_neg(), now);
        }
    }

    /// `ahead`, here and below, is the level counted in the direction of motion.
    fn start(&mut self, direction: Direction, since: u32, ahead: i64, now: u32) {
        // It came two steps since it began.
        let mark = Mark { level: ahead, at: now, took: now.wrapping_sub(since) / 2 };
        *self = Self {
            direction,
            since,
            furthest: ahead,
            furthest_at: now,
            last: mark,
            previous: mark,
            ..*self
        };
    }

    fn travel(&mut self, config: &Config, ahead: i64, now: u32, back: Direction) {
        if ahead > self.furthest {
            (self.furthest, self.furthest_at) = (ahead, now);
        }
        if ahead >= self.last.level.wrapping_add(config.motion_step) {
            self.previous = self.last;
            self.last = Mark { level: ahead, at: now, took: now.wrapping_sub(self.last.at) };
        }
        if self.furthest.wrapping_sub(ahead) > config.motion_step.wrapping_mul(2) {
            self.start(back, self.furthest_at, ahead.wrapping_neg(), now);
        } else if now.wrapping_sub(self.last.at) > config.dwell {
            let level = if back == Direction::Advancing { ahead.wrapping_neg() } else { ahead };
            *self = Self { since: self.stopped_at(config, now), ..Self::still_at(level, now) };
        }
    }

    fn certain_mark(&self, config: &Config) -> Mark {
        let beyond = self.furthest.wrapping_sub(self.last.level);
        if beyond < config.motion_step >> 1 { self.previous } else { self.last }
    }

    /// When the furthest point would have been reached at the pace of the last certain step.
    fn stopped_at(&self, config: &Config, now: u32) -> u32 {
        let mark = self.certain_mark(config);
        let beyond = self.furthest.wrapping_sub(mark.level);
        let took = i64::from(mark.took.min(config.dwell));
        let samples = beyond.saturating_mul(took).checked_div(config.motion_step).unwrap_or(0);
        let passed = now.wrapping_sub(mark.at);
        mark.at.wrapping_add(u32::try_from(samples).unwrap_or(u32::MAX).min(passed))
    }
}
