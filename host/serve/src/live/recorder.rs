//! What comes, into a file, as `palpate record` writes it.

use std::fs::File;
use std::io;
use std::path::Path;
use std::time::Instant;

use palpate_link::device::heard::{Heard, Said};
use palpate_link::device::stream::Mark;
use palpate_trace::recording::{Gap, Note, Opened, Writer};

/// A file that is being written.
pub(super) struct Recorder {
    writer: Writer<File>,
    began: Instant,
    /// Rows in it.
    pub(super) rows: u64,
}

impl Recorder {
    /// Begins a file that must not be there yet.
    pub(super) fn create(file: &Path, port: &str) -> io::Result<Self> {
        let writer = Writer::create(file, false, &Opened::now(port))?;
        Ok(Self { writer, began: Instant::now(), rows: 0 })
    }

    fn now_us(&self, at: Instant) -> u64 {
        at.saturating_duration_since(self.began).as_micros() as u64
    }

    /// Writes what was heard, behind what is missing before it.
    pub(super) fn take(&mut self, heard: &Heard, marks: &[Mark]) -> io::Result<()> {
        let at_us = self.now_us(heard.at);
        for mark in marks {
            let gap = match *mark {
                Mark::FramesLost(frames) => Gap::FramesLost(frames),
                Mark::RowsLost { count, .. } => Gap::RowsLost(count),
                Mark::Reset => Gap::Reset,
                // The frame after it will be missing; the settings are in the recording.
                Mark::Damaged(_) | Mark::Settings { .. } => continue,
            };
            self.writer.note(at_us, &Note::Gap(gap))?;
        }
        let Ok((_, said)) = &heard.said else { return Ok(()) };
        if let Said::Rows(rows) = said {
            self.rows += rows.len() as u64;
        }
        self.writer.frame(at_us, &heard.frame)
    }

    /// Notes that something is missing now.
    pub(super) fn gap(&mut self, gap: Gap) -> io::Result<()> {
        self.writer.note(self.now_us(Instant::now()), &Note::Gap(gap))
    }

    /// Writes what has waited long enough.
    pub(super) fn tick(&mut self) -> io::Result<()> {
        self.writer.tick(self.now_us(Instant::now()))
    }

    /// Ends the file in order.
    pub(super) fn close(self) -> io::Result<()> {
        let now_us = self.now_us(Instant::now());
        self.writer.close(now_us)
    }
}
