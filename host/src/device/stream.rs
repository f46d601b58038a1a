//! What is missing from a stream: frames by their sequence numbers, rows by theirs.

use shared::wire::FrameError;

use super::heard::{Heard, Said};

/// Something about a stream that is not a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A frame came damaged.
    Damaged(FrameError),
    /// Frames did not come; damaged ones are among them.
    FramesLost(u32),
    /// Rows did not come, or were lost by the device.
    RowsLost {
        /// Number of the first.
        first: u64,
        /// How many.
        count: u64,
    },
    /// Other settings from here on.
    Settings {
        /// Their generation.
        generation: u32,
    },
    /// The device began anew.
    Reset,
}

/// What came and what did not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Tally {
    /// Whole frames.
    pub frames: u64,
    /// Damaged frames.
    pub damaged: u64,
    /// Frames that did not come.
    pub frames_lost: u64,
    /// Rows.
    pub rows: u64,
    /// Rows that did not come, or were lost by the device.
    pub rows_lost: u64,
    /// Bytes on the line.
    pub bytes: u64,
}

/// Follows a stream.
#[derive(Clone, Debug, Default)]
pub struct Stream {
    next_sequence: Option<u32>,
    next_row: u64,
    generation: Option<u32>,
    tally: Tally,
}

impl Stream {
    /// What came so far.
    #[must_use]
    pub const fn tally(&self) -> &Tally {
        &self.tally
    }

    /// Number of the row that should come next.
    #[must_use]
    pub const fn next_row(&self) -> u64 {
        self.next_row
    }

    /// A stream begins, with row 0; what was counted stays.
    pub const fn start(&mut self) {
        self.next_row = 0;
    }

    /// Begins with a device that is another, or was reset.
    pub const fn restart(&mut self) {
        (self.next_sequence, self.generation) = (None, None);
        self.start();
    }

    /// Takes what was heard; marks come in their order, before the rows of this frame.
    pub fn take(&mut self, heard: &Heard) -> Vec<Mark> {
        self.tally.bytes += heard.frame.len() as u64 + 1;
        let (head, said) = match &heard.said {
            Ok(whole) => whole,
            Err(error) => {
                self.tally.damaged += 1;
                return vec![Mark::Damaged(*error)];
            }
        };
        self.tally.frames += 1;
        let mut marks = Vec::new();
        let lost = self.next_sequence.map_or(0, |next| head.sequence.wrapping_sub(next));
        if lost >= 1 << 31 {
            // Numbers do not go back but with a reset.
            self.restart();
            marks.push(Mark::Reset);
        } else if lost > 0 {
            self.tally.frames_lost += u64::from(lost);
            marks.push(Mark::FramesLost(lost));
        }
        self.next_sequence = Some(head.sequence.wrapping_add(1));
        match said {
            Said::Settings(generation, _) => marks.extend(self.generation(*generation)),
            Said::Rows(rows) => {
                marks.extend(self.generation(rows.generation));
                let missing = rows.first.saturating_sub(self.next_row);
                if missing > 0 {
                    self.tally.rows_lost += missing;
                    marks.push(Mark::RowsLost { first: self.next_row, count: missing });
                }
                self.next_row = rows.first.saturating_add(rows.len() as u64);
                self.tally.rows += rows.len() as u64;
            }
            _ => {}
        }
        marks
    }

    /// Settings come ahead of the blocks that they make, and blocks that were made before may follow them.
    fn generation(&mut self, generation: u32) -> Option<Mark> {
        let before = *self.generation.get_or_insert(generation);
        self.generation = Some(before.max(generation));
        (generation > before).then_some(Mark::Settings { generation })
    }
}
