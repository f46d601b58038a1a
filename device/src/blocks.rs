//! Blocks on their way from filter to link: one that is filled, a few that wait.

use shared::wire::{Columns, Rows};

/// Blocks that may wait for the link.
const WAITING: usize = 3;
const PLACES: usize = WAITING + 1;

/// A ring of blocks; the one that is filled follows those that wait. 7 KB, which is why a device borrows it.
#[derive(Clone, Debug)]
pub struct Blocks {
    places: [Rows; PLACES],
    oldest: usize,
    waiting: usize,
    /// Rows of the oldest that were sent already.
    sent: usize,
}

impl Blocks {
    /// Empty.
    #[must_use]
    pub const fn new() -> Self {
        Self { places: [const { Rows::new() }; PLACES], oldest: 0, waiting: 0, sent: 0 }
    }

    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        (self.oldest, self.waiting, self.sent) = (0, 0, 0);
        self.filling().begin(Columns::Parts, 0, 0, 0);
    }

    /// The block that is filled.
    #[inline]
    pub(crate) fn filling(&mut self) -> &mut Rows {
        self.place(self.oldest.wrapping_add(self.waiting) % PLACES)
    }

    fn place(&mut self, at: usize) -> &mut Rows {
        let [a, b, c, d] = &mut self.places;
        match at {
            0 => a,
            1 => b,
            2 => c,
            _ => d,
        }
    }

    /// Sends the filled block on its way and begins an empty one. Without room it is dropped: how many rows were lost.
    pub(crate) fn close(&mut self) -> usize {
        let rows = self.filling().len();
        if rows == 0 {
            return 0;
        }
        if self.waiting == WAITING {
            self.filling().begin(Columns::Parts, 0, 0, 0);
            return rows;
        }
        self.waiting = self.waiting.wrapping_add(1);
        self.filling().begin(Columns::Parts, 0, 0, 0);
        0
    }

    /// Whether none waits.
    pub(crate) const fn is_empty(&self) -> bool {
        self.waiting == 0
    }

    /// The oldest block that waits, and from which row on.
    pub(crate) fn next(&mut self) -> Option<(&Rows, usize)> {
        let (at, sent) = (self.oldest, self.sent);
        (self.waiting > 0).then(|| (&*self.place(at), sent))
    }

    /// So many rows of the oldest were sent.
    pub(crate) fn sent(&mut self, rows: usize) {
        let at = self.oldest;
        self.sent = self.sent.saturating_add(rows);
        if self.sent >= self.place(at).len() {
            self.oldest = at.wrapping_add(1) % PLACES;
            self.waiting = self.waiting.saturating_sub(1);
            self.sent = 0;
        }
    }
}

impl Default for Blocks {
    fn default() -> Self {
        Self::new()
    }
}
