//! How fast samples are taken that are overdue, because program or computer was held up.
//!
//! A converter gives its samples one after the other. To take all that are overdue at once would be more than the line holds,
//! and rows would be lost that no device loses.

/// So many times as fast as time passes.
const CATCH_UP: u64 = 4;
/// Of a longer time than this, µs, no more is caught up at once.
const AT_ONCE_US: u64 = 20_000;

/// When samples were last taken, µs.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pace {
    last_us: u64,
}

impl Pace {
    /// Up to which time, µs, samples are to be taken now, where the next one was due at `due_us`.
    pub(super) fn until(&mut self, now_us: u64, due_us: Option<u64>) -> u64 {
        let passed = now_us.saturating_sub(self.last_us).min(AT_ONCE_US);
        self.last_us = now_us;
        due_us.map_or(now_us, |due_us| now_us.min(due_us + CATCH_UP * passed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_taken_as_they_come_due() {
        let mut pace = Pace::default();
        for now_us in (0..50_000).step_by(1_000) {
            assert_eq!(pace.until(now_us, Some(now_us)), now_us);
            assert_eq!(pace.until(now_us + 500, Some(now_us + 1_000)), now_us + 500);
        }
    }

    #[test]
    fn what_is_overdue_is_caught_up_four_times_as_fast_as_time_passes() {
        let mut pace = Pace::default();
        let (mut now_us, mut due_us) = (30_000_000, 0);
        due_us = pace.until(now_us, Some(due_us)) + 1_000;
        assert_eq!(due_us, 81_000);
        while due_us < now_us {
            now_us += 1_000;
            let until_us = pace.until(now_us, Some(due_us));
            assert!(until_us <= due_us + 4_000);
            due_us = until_us + 1_000;
        }
        assert!((36_000_000..41_000_000).contains(&now_us), "{now_us}");
    }
}
