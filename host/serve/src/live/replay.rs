//! A trace put into a device as fast as it was recorded.

use std::time::{Duration, Instant};

use shared::pipeline::GAUGES;
use shared::wire::{Columns, INJECT_ROWS, Source, Start, ToDevice};

use palpate_link::device::replay::inject;
use palpate_link::device::session::{LinkError, Session};
use palpate_trace::recordable::Samples;

/// A device that has no room is asked again after so long.
const PAUSE: Duration = Duration::from_millis(10);

/// A trace on its way into a device.
pub(super) struct Replay {
    samples: Samples,
    /// Times as fast as it was recorded.
    speed: f64,
    stretch: usize,
    next: usize,
    /// When sample `paced.1` of the stretch was put in.
    paced: (Instant, usize),
    room: usize,
    asked: Instant,
}

/// What a step of a replay came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// Goes on.
    On,
    /// The stretch is over and another follows, as a stream of its own.
    Gap,
    /// The trace is over.
    Over,
}

impl Replay {
    pub(super) fn new(samples: Samples, speed: f64) -> Self {
        let now = Instant::now();
        Self { samples, speed, stretch: 0, next: 0, paced: (now, 0), room: INJECT_ROWS, asked: now }
    }

    /// How the stream begins that it is put into.
    pub(super) fn start(&self) -> Start {
        let interval_ns = (self.samples.interval_s * 1e9).round() as u32;
        Start { source: Source::Link { interval_ns }, columns: Columns::All }
    }

    /// Sets a device so that it takes counts for what they are, and filters as the head of the trace says.
    pub(super) fn prepare(&self, session: &mut Session) -> Result<(), LinkError> {
        let settings = &self.samples.settings;
        session.quiet()?;
        session.command(&session.identity().set_gain(settings.gain))?;
        for (gauge, sheet) in (0..GAUGES as u8).zip(settings.calibration) {
            session.command(&ToDevice::SetCalibration { gauge, sheet })?;
        }
        session.command(&ToDevice::SetFilter(settings.relaxation))?;
        session.command(&ToDevice::SetThresholds(settings.thresholds))?;
        Ok(())
    }

    /// A stream begins: time runs from here. A trace that is over begins again.
    pub(super) fn begin(&mut self) {
        if self.stretch >= self.samples.stretches.len() {
            (self.stretch, self.next) = (0, 0);
        }
        self.paced = (Instant::now(), self.next);
        self.room = INJECT_ROWS;
    }

    /// How much of the trace was put in, 0 to 1.
    pub(super) fn progress(&self) -> f64 {
        let all: usize = self.samples.stretches.iter().map(Vec::len).sum();
        let before: usize = self.samples.stretches.iter().take(self.stretch).map(Vec::len).sum();
        (before + self.next) as f64 / all.max(1) as f64
    }

    /// Puts in what is due by now.
    pub(super) fn step(&mut self, session: &mut Session) -> Result<Step, LinkError> {
        let Some(stretch) = self.samples.stretches.get(self.stretch) else { return Ok(Step::Over) };
        let passed_s = self.paced.0.elapsed().as_secs_f64() * self.speed;
        let due = self.paced.1 + (passed_s / self.samples.interval_s) as usize;
        let due = due.min(stretch.len());
        if self.room == 0 && self.asked.elapsed() >= PAUSE {
            self.room = INJECT_ROWS;
        }
        let end = due.min(self.next + self.room.min(INJECT_ROWS));
        if let Some(rows) = stretch.get(self.next..end).filter(|rows| !rows.is_empty()) {
            // What found no room is a gap by its numbers.
            self.room = inject(session, rows, None)?.1.into();
            (self.next, self.asked) = (end, Instant::now());
        }
        if self.next < stretch.len() {
            return Ok(Step::On);
        }
        (self.stretch, self.next) = (self.stretch + 1, 0);
        let over = self.stretch >= self.samples.stretches.len();
        Ok(if over { Step::Over } else { Step::Gap })
    }
}
