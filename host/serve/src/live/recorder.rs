//! What comes, into a file, as `palpate record` writes it.

use std::io;
use std::path::Path;
use std::time::Instant;

use super::hand::{Hand, Membership};
use palpate_link::device::heard::{Heard, Said};
use palpate_link::device::record::since_us;
use palpate_link::device::share::{File, Share};
use palpate_link::device::stream::Mark;
use palpate_trace::recording::{Gap, Note, Opened};

/// A device's part of a file that is being written.
pub(super) struct Recorder {
    share: Share,
    began: Instant,
    end: End,
    /// Rows in it, of this device.
    pub(super) rows: u64,
}

/// Who ends the file.
enum End {
    /// The only device in it.
    Alone(File),
    /// The last of those that write it.
    Together(Membership),
}

impl Recorder {
    /// Begins a file that must not be there yet.
    pub(super) fn create(file: &Path, port: &str) -> io::Result<Self> {
        let file = File::create(file, false, &Opened::now(port), false)?;
        let (share, began) = (file.alone(), Instant::now());
        Ok(Self { share, began, end: End::Alone(file), rows: 0 })
    }

    /// Begins a file that must not be there yet, or joins the fingers of a hand that write it.
    pub(super) fn join(file: &Path, hand: &Hand, device: u8) -> io::Result<Self> {
        let (share, membership) = hand.join(file, device)?;
        let began = membership.began();
        Ok(Self { share, began, end: End::Together(membership), rows: 0 })
    }

    fn now_us(&self, at: Instant) -> u64 {
        since_us(self.began, at)
    }

    /// Writes what was heard, behind what is missing before it.
    pub(super) fn take(&mut self, heard: &Heard, marks: &[Mark]) -> io::Result<()> {
        let at_us = self.now_us(heard.at);
        for gap in marks.iter().copied().filter_map(Mark::gap) {
            self.share.note(at_us, &Note::Gap(gap))?;
        }
        let Ok((_, said)) = &heard.said else { return Ok(()) };
        if let Said::Rows(rows) = said {
            self.rows += rows.len() as u64;
        }
        self.share.frame(at_us, &heard.frame)
    }

    /// Notes that something is missing now.
    pub(super) fn gap(&mut self, gap: Gap) -> io::Result<()> {
        self.share.note(self.now_us(Instant::now()), &Note::Gap(gap))
    }

    /// Writes what has waited long enough.
    pub(super) fn tick(&mut self) -> io::Result<()> {
        self.share.tick(self.now_us(Instant::now()))
    }

    /// Ends the file in order, or this device's part of it.
    pub(super) fn close(self) -> io::Result<()> {
        let now_us = self.now_us(Instant::now());
        match self.end {
            End::Alone(file) => file.close(now_us),
            End::Together(membership) => membership.end(),
        }
    }
}
