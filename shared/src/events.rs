//! Touch, release and incipient slip, found in FA while it streams.
//!
//! FA answers to change. A **burst** is FA beyond a level; a **jolt** is a short vibration of FA, what is left of it above a
//! corner frequency.
//!
//! - *Touch*: a burst while nothing is held. Its sign says which way pressing drives this gauge. The reading must have left
//!   its resting value the same way, by two such levels: what creeps or snaps back to rest is no touch.
//! - *Release*: a burst the other way that takes more than half of the reading away that was held when it began; told when
//!   FA turns, which it does when the load no longer falls. What is let go of more slowly than FA forgets makes no burst and
//!   no event, only silence: the contact is forgotten once the reading is back at rest.
//! - *Incipient slip*: several jolts soon after each other while something is held. The rim of a soft contact slips before
//!   its middle does, and what lets go piece by piece is felt as a series of jolts; a single knock is none. A jolt much
//!   weaker than one shortly before it, or than the load's own change, does not count, so that a hard knock deafens for some
//!   tenths of a second; and so does a touch.
//!
//! The gauges of a fingertip are heard together: it touches with the first of them, and has let go when all that held have.
//! One gauge alone cannot tell a release from a pull sideways, which may press on one gauge and relieve another.
//!
//! Nothing here depends on the gauge but levels, so any signal that goes through [`adaptation`](crate::adaptation) will do.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use crate::adaptation::Output;

mod channel;
mod config;
mod vibration;

use channel::{Change, Channel};
pub use config::{Config, ConfigError, JOLTS_MOST, Settings};

/// What happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Kind {
    /// Something is touched.
    Touch,
    /// It is let go of.
    Release,
    /// The rim of the contact slips.
    Slip,
}

/// An event, at the sample at which it became known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Event {
    /// What happened.
    pub kind: Kind,
    /// How many samples ago it showed first: when the burst left its resting band, or at the first of the jolts.
    pub began_samples_ago: u32,
    /// The channel that told it, from 0.
    pub channel: u8,
}

/// Every so many samples, what is too long ago to matter is forgotten, before its number comes again.
const FORGETTING: u32 = 1 << 16;

/// What is remembered of a fingertip of `N` gauges, or of `N` signals of one contact, between samples. Sample numbers wrap;
/// nothing is remembered as longer ago than 2^31.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct State<const N: usize> {
    channels: [Channel; N],
    now: u32,
    /// Something is held, by what was told.
    holds: bool,
    /// When a slip was last told, if it was since the touch.
    slipped_at: Option<u32>,
}

impl<const N: usize> State<N> {
    /// Nothing held, with signals (LSB) that have long rested where they are.
    #[must_use]
    pub fn at_rest(signals: [i32; N]) -> Self {
        Self { channels: signals.map(Channel::at_rest), now: 0, holds: false, slipped_at: None }
    }

    /// Whether something is held.
    #[must_use]
    pub const fn holds(&self) -> bool {
        self.holds
    }

    /// Takes what the filter says of the next sample of each channel. Where several events fall on one sample, a touch or a
    /// release is told before a slip.
    pub fn step(&mut self, config: &Config, outputs: &[Output; N]) -> Option<Event> {
        self.take(config, &outputs.each_ref().map(|output| (output.signal, output.fa)))
    }

    /// The same of signals and FA alone: nothing else is looked at.
    pub fn take(&mut self, config: &Config, parts: &[(i32, i32); N]) -> Option<Event> {
        self.now = self.now.wrapping_add(1);
        let (now, holds) = (self.now, self.holds);
        if now.is_multiple_of(FORGETTING) {
            self.channels.iter_mut().for_each(|channel| channel.forget(config, now));
        }
        let (mut changed, mut slips) = (None, None);
        for (index, (channel, part)) in self.channels.iter_mut().zip(parts).enumerate() {
            let index = index as u8;
            match channel.step(config, *part, now, holds) {
                Change::Touched(ago) if !holds => {
                    changed = changed.or(Some(Event {
                        kind: Kind::Touch,
                        began_samples_ago: ago,
                        channel: index,
                    }));
                }
                Change::LetGo(ago) => {
                    changed =
                        Some(Event { kind: Kind::Release, began_samples_ago: ago, channel: index });
                }
                Change::Slipped(ago) => {
                    slips = slips.or(Some(Event {
                        kind: Kind::Slip,
                        began_samples_ago: ago,
                        channel: index,
                    }));
                }
                Change::Touched(_) | Change::None => {}
            }
        }
        if matches!(changed, Some(Event { kind: Kind::Release, .. })) {
            self.channels.iter_mut().for_each(Channel::let_go_with_another);
        }
        let held = self.channels.iter().any(Channel::holds);
        let event = match changed {
            Some(event) if event.kind == Kind::Touch || (self.holds && !held) => Some(event),
            _ => slips.filter(|_| self.holds && !self.has_slipped_lately(config)),
        };
        self.holds = held;
        match event.map(|event| event.kind) {
            Some(Kind::Slip) => self.slipped_at = Some(self.now),
            Some(Kind::Touch | Kind::Release) => {
                self.slipped_at = None;
                self.channels.iter_mut().for_each(|channel| channel.deafen(self.now));
            }
            None => {}
        }
        event
    }

    /// A slip that goes on is told once in a settling time.
    fn has_slipped_lately(&self, config: &Config) -> bool {
        self.slipped_at.is_some_and(|at| self.now.wrapping_sub(at) <= config.settle)
    }
}

#[cfg(test)]
mod tests;
