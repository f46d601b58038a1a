//! Whether something advances, stands or retreats, told from noise by distance and time.

use super::{Config, LONG_AGO};

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
    anchor: i32,
    /// Standing: the last level within half a step of the anchor, when that was, and the anchor then.
    near: i32,
    near_at: u32,
    left: i32,
    /// Moving: the furthest point, counted in the direction of motion, and when it was reached.
    furthest: i32,
    furthest_at: u32,
    /// Moving: the last two whole steps.
    last: Mark,
    previous: Mark,
}

/// A whole step of a movement, or more: where it ended, when, how far it went and how many samples it took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Mark {
    level: i32,
    at: u32,
    covered: i32,
    took: u32,
}

impl Motion {
    pub(super) const fn still_at(level: i32, now: u32) -> Self {
        let mark = Mark { level, at: now, covered: 1, took: 0 };
        Self {
            direction: Direction::Still,
            since: now,
            anchor: level,
            near: level,
            near_at: now,
            left: level,
            furthest: level,
            furthest_at: now,
            last: mark,
            previous: mark,
        }
    }

    /// Takes the mean motion up to sample `now`.
    pub(super) fn step(&mut self, config: &Config, level: i32, now: u32) {
        match self.direction {
            Direction::Still => self.stand(config, level, now),
            Direction::Advancing => self.travel(config, level, now, Direction::Retreating),
            Direction::Retreating => {
                self.travel(config, level.saturating_neg(), now, Direction::Advancing);
            }
        }
    }

    /// Takes the motion the other way round. What counts in its direction stays.
    pub(super) fn turn_over(&mut self) {
        self.direction = match self.direction {
            Direction::Still => Direction::Still,
            Direction::Advancing => Direction::Retreating,
            Direction::Retreating => Direction::Advancing,
        };
        for level in [&mut self.anchor, &mut self.near, &mut self.left] {
            *level = level.saturating_neg();
        }
    }

    /// When a movement was last seen to go on for another half step. The very last part of a movement is not used: there
    /// the average creeps towards its end, however suddenly the motion stopped.
    pub(super) fn went_on_until(&self, config: &Config) -> u32 {
        self.certain_mark(config).at
    }

    fn stand(&mut self, config: &Config, level: i32, now: u32) {
        let away = level.saturating_sub(self.anchor);
        let distance = away.saturating_abs();
        if distance <= config.motion_step >> 1 {
            (self.near, self.near_at, self.left) = (level, now, self.anchor);
        }
        if distance <= config.motion_turn {
            let creep = config.motion_creep;
            // Not `clamp`, which would panic if its limits were exchanged.
            self.anchor = self.anchor.saturating_add(away.min(creep).max(creep.saturating_neg()));
            return;
        }
        let began = self.began_at(level, now);
        if away > 0 {
            self.start(Direction::Advancing, began, level, distance, now);
        } else {
            self.start(Direction::Retreating, began, level.saturating_neg(), distance, now);
        }
    }

    /// When a straight line through the last level near the anchor and the present one left the anchor.
    fn began_at(&self, level: i32, now: u32) -> u32 {
        let way = |from: i32| i64::from(level).wrapping_sub(i64::from(from));
        let took = i64::from(now.wrapping_sub(self.near_at).min(LONG_AGO));
        let ago = way(self.left).saturating_mul(took).checked_div(way(self.near)).unwrap_or(0);
        now.wrapping_sub(u32::try_from(ago).unwrap_or(0))
    }

    /// `ahead`, here and below, is the level counted in the direction of motion, and `covered` the way since it began.
    fn start(&mut self, direction: Direction, since: u32, ahead: i32, covered: i32, now: u32) {
        let mark = Mark { level: ahead, at: now, covered, took: now.wrapping_sub(since) };
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

    fn travel(&mut self, config: &Config, ahead: i32, now: u32, back: Direction) {
        if ahead > self.furthest {
            (self.furthest, self.furthest_at) = (ahead, now);
        }
        let covered = ahead.saturating_sub(self.last.level);
        if covered >= config.motion_step {
            self.previous = self.last;
            let took = now.wrapping_sub(self.last.at);
            self.last = Mark { level: ahead, at: now, covered, took };
        }
        let returned = self.furthest.saturating_sub(ahead);
        if returned > config.motion_turn {
            self.start(back, self.furthest_at, ahead.saturating_neg(), returned, now);
        } else if now.wrapping_sub(self.last.at) > config.dwell {
            let level = if back == Direction::Advancing { ahead.saturating_neg() } else { ahead };
            *self = Self { since: self.stopped_at(config, now), ..Self::still_at(level, now) };
        }
    }

    fn certain_mark(&self, config: &Config) -> Mark {
        let beyond = self.furthest.saturating_sub(self.last.level);
        if beyond < config.motion_step >> 1 { self.previous } else { self.last }
    }

    /// When the furthest point would have been reached at the pace of the last certain step.
    fn stopped_at(&self, config: &Config, now: u32) -> u32 {
        let mark = self.certain_mark(config);
        let beyond = i64::from(self.furthest.saturating_sub(mark.level));
        let took = i64::from(mark.took.min(config.dwell));
        let samples = beyond.saturating_mul(took).checked_div(i64::from(mark.covered)).unwrap_or(0);
        let passed = now.wrapping_sub(mark.at);
        mark.at.wrapping_add(u32::try_from(samples).unwrap_or(u32::MAX).min(passed))
    }
}
