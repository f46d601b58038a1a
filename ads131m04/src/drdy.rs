//! Counting the edges of DRDY that did not come.

/// DRDY is stuck when it was silent for this many intervals.
pub const STUCK_AFTER_INTERVALS: u64 = 16;

/// Watches the rhythm of DRDY. A value without a clock of its own: the caller brings the time, in microseconds from any
/// origin; time that goes backwards counts as none.
///
/// ```
/// use ads131m04::DrdyWatch;
///
/// let mut watch = DrdyWatch::new(1_000_000, 0); // 1 kHz, started at 0 µs
/// assert_eq!(watch.edge(1_004), 0);
/// assert_eq!(watch.edge(4_010), 2); // two edges never reached us
/// assert!(!watch.is_stuck(5_000));
/// assert!(watch.is_stuck(20_500));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DrdyWatch {
    interval_ns: u64,
    last_edge_us: u64,
}

impl DrdyWatch {
    /// Edges are due every `interval_ns`, see [`crate::Config::sample_interval_ns`], from `now_us` on.
    pub const fn new(interval_ns: u32, now_us: u64) -> Self {
        Self { interval_ns: interval_ns as u64, last_edge_us: now_us }
    }

    /// Notes an edge and says how many should have come between it and the edge before. An edge may be late or early by half
    /// an interval.
    pub fn edge(&mut self, now_us: u64) -> u64 {
        let half_ns = self.interval_ns >> 1;
        let intervals = self.intervals(self.silence_ns(now_us).saturating_add(half_ns));
        self.last_edge_us = now_us;
        intervals.saturating_sub(1)
    }

    /// Whole intervals since the last edge.
    pub fn overdue(&self, now_us: u64) -> u64 {
        self.intervals(self.silence_ns(now_us))
    }

    /// No edge for [`STUCK_AFTER_INTERVALS`]: the clock of the converter stopped, the wire broke, or its samples were left
    /// unread (see [`crate::Ads131m04::discard_stale`]).
    pub fn is_stuck(&self, now_us: u64) -> bool {
        self.overdue(now_us) >= STUCK_AFTER_INTERVALS
    }

    const fn silence_ns(&self, now_us: u64) -> u64 {
        now_us.saturating_sub(self.last_edge_us).saturating_mul(1000)
    }

    /// An interval of zero has no rhythm to miss.
    const fn intervals(&self, duration_ns: u64) -> u64 {
        match duration_ns.checked_div(self.interval_ns) {
            Some(intervals) => intervals,
            None => 0,
        }
    }
}
