//! The line that the fingers of a hand share: one of them raises it once a second, all of them say when it rose.
//!
//! Every finger raises its own output, which is joined to the line on one finger only.

use stm32f4xx_hal::gpio::{Alternate, Output, PA6, PA7};

use super::edge;

/// What is caught is the lower 16 bits of a time in µs: looked at less often than this, it says nothing.
const LATEST_US: u64 = 60_000;

/// The ends of the line at this finger.
pub struct SharedLine {
    output: PA7<Output>,
    _input: PA6<Alternate<{ edge::FUNCTION }>>,
    looked_us: u64,
}

impl SharedLine {
    /// The line by its two pins; the input is to be pulled down, so that a wire that is not there does not rise.
    pub fn new(output: PA7<Output>, input: PA6<Alternate<{ edge::FUNCTION }>>) -> Self {
        Self { output, _input: input, looked_us: 0 }
    }

    /// Raises the line if this finger is the one that does, or lets it fall.
    pub fn raise(&mut self, high: bool) {
        self.output.set_state(high.into());
    }

    /// When it rose, µs, if it did once since the last call; twice is noise.
    pub fn rose(&mut self, now_us: u64) -> Option<u64> {
        let late = now_us.saturating_sub(self.looked_us) > LATEST_US;
        self.looked_us = now_us;
        edge::rose(now_us).filter(|_| !late)
    }
}
