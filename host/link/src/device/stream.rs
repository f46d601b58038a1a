//! What is missing from a stream: frames by their sequence numbers, rows by theirs.

use shared::wire::FrameError;

use super::heard::{Heard, Said};
use palpate_trace::recording::Gap;

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

impl Mark {
    /// The gap that a recording tells of it; none of what it holds anyway: after a damaged frame one is missing, and the settings
    /// are in it.
    #[must_use]
    pub fn gap(self) -> Option<Gap> {
        match self {
            Self::FramesLost(frames) => Some(Gap::FramesLost(frames)),
            Self::RowsLost { count, .. } => Some(Gap::RowsLost(count)),
            Self::Reset => Some(Gap::Reset),
            Self::Damaged(_) | Self::Settings { .. } => None,
        }
    }
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

    fn generation(&mut self, generation: u32) -> Option<Mark> {
        let before = self.generation.replace(generation);
        (before.is_some_and(|before| before != generation)).then_some(Mark::Settings { generation })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shared::pipeline::Pipeline;
    use shared::wire::{Columns, Head, Rows, Settings};
    use std::time::Instant;

    fn frame(sequence: u32, said: Said) -> Heard {
        let head = Head { sequence, time_us: 0 };
        Heard { at: Instant::now(), frame: vec![1; 9], said: Ok((head, said)) }
    }

    fn rows(first: u64, count: u64, generation: u32) -> Said {
        let config = Settings::DEFAULT.config(1e-3).unwrap();
        let mut pipeline = Pipeline::new(&config);
        let mut rows = Rows::new();
        rows.begin(Columns::Parts, first, first * 1_000, first * 1_000);
        rows.generation = generation;
        for row in first..first + count {
            pipeline.process(&[1; 4], 0);
            assert!(rows.push(row * 1_000, &[1; 4], &pipeline));
        }
        Said::Rows(Box::new(rows))
    }

    #[test]
    fn a_whole_stream_has_no_marks() {
        let mut stream = Stream::default();
        assert_eq!(stream.take(&frame(u32::MAX, rows(0, 16, 3))), []);
        assert_eq!(stream.take(&frame(0, rows(16, 5, 3))), []);
        assert_eq!((stream.tally().rows, stream.next_row()), (21, 21));
    }

    #[test]
    fn what_is_missing_is_counted_by_frames_and_by_rows() {
        let mut stream = Stream::default();
        stream.take(&frame(10, rows(0, 16, 0)));
        let damaged = Heard { said: Err(FrameError::Check), ..frame(11, rows(16, 16, 0)) };
        assert_eq!(stream.take(&damaged), [Mark::Damaged(FrameError::Check)]);
        let marks = stream.take(&frame(13, rows(48, 16, 0)));
        assert_eq!(marks, [Mark::FramesLost(2), Mark::RowsLost { first: 16, count: 32 }]);
        // Rows that the device dropped: no frame is missing.
        let marks = stream.take(&frame(14, rows(70, 1, 0)));
        assert_eq!(marks, [Mark::RowsLost { first: 64, count: 6 }]);
        let tally =
            Tally { frames: 3, damaged: 1, frames_lost: 2, rows: 33, rows_lost: 38, bytes: 40 };
        assert_eq!(*stream.tally(), tally);
    }

    #[test]
    fn a_reset_is_seen_by_numbers_that_go_back() {
        let mut stream = Stream::default();
        stream.take(&frame(500, rows(0, 16, 2)));
        assert_eq!(stream.take(&frame(3, rows(0, 16, 0))), [Mark::Reset]);
        assert_eq!(stream.take(&frame(4, rows(16, 1, 0))), []);
    }

    #[test]
    fn other_settings_are_marked_once() {
        let mut stream = Stream::default();
        stream.take(&frame(0, rows(0, 4, 0)));
        let settings = Said::Settings(1, Box::new(Settings::DEFAULT));
        assert_eq!(stream.take(&frame(1, settings)), [Mark::Settings { generation: 1 }]);
        assert_eq!(stream.take(&frame(2, rows(4, 4, 1))), []);
    }
}
