//! Blocks on their way from filter to link: one that is filled, a few that wait.

use shared::wire::Rows;

/// Blocks that may wait for the link.
const WAITING: usize = 3;
const PLACES: usize = WAITING + 1;

/// A ring of blocks; the one that is filled follows those that wait. 1 KB.
#[derive(Clone, Debug)]
pub(crate) struct Blocks {
    places: [Rows; PLACES],
    /// Place of the one that is filled.
    filling: usize,
    waiting: usize,
}

impl Blocks {
    /// Empty.
    #[must_use]
    pub(crate) const fn new() -> Self {
        Self { places: [const { Rows::new() }; PLACES], filling: 0, waiting: 0 }
    }

    /// Drops what waits, none being filled, and begins again with rows of so many gauges: how many rows were lost.
    pub(crate) fn set_gauges(&mut self, gauges: u8) -> usize {
        let mut lost: usize = 0;
        while let Some(rows) = self.next() {
            lost = lost.saturating_add(rows.len());
            self.sent();
        }
        self.places.iter_mut().for_each(|rows| rows.set_gauges(gauges));
        lost
    }

    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.waiting = 0;
        self.filling().clear();
    }

    /// The block that is filled.
    #[inline(always)]
    pub(crate) fn filling(&mut self) -> &mut Rows {
        self.place(self.filling)
    }

    /// How many rows it has.
    pub(crate) fn filled(&self) -> usize {
        self.places.get(self.filling).map_or(0, Rows::len)
    }

    /// The ring at any number.
    #[inline(always)]
    #[allow(clippy::indexing_slicing, reason = "within the ring, which the compiler knows")]
    fn place(&mut self, at: usize) -> &mut Rows {
        &mut self.places[at % PLACES]
    }

    /// Sends the filled block on its way and begins an empty one. Without room it is dropped: how many rows were lost.
    pub(crate) fn close(&mut self) -> usize {
        let mut lost = 0;
        if self.waiting < WAITING {
            self.waiting = self.waiting.wrapping_add(1);
            self.filling = self.filling.wrapping_add(1) % PLACES;
        } else {
            lost = self.filled();
        }
        self.filling().clear();
        lost
    }

    /// Whether none waits.
    pub(crate) const fn is_empty(&self) -> bool {
        self.waiting == 0
    }

    /// Whether a row, which may close one block and end another, is sure to find room on its way.
    pub(crate) const fn has_room(&self) -> bool {
        self.waiting.saturating_add(2) <= WAITING
    }

    /// The oldest block that waits.
    pub(crate) fn next(&mut self) -> Option<&Rows> {
        (self.waiting > 0).then(|| &*self.place(self.filling.wrapping_sub(self.waiting)))
    }

    /// The oldest was sent.
    pub(crate) const fn sent(&mut self) {
        self.waiting = self.waiting.saturating_sub(1);
    }
}

impl Default for Blocks {
    fn default() -> Self {
        Self::new()
    }
}
