//! Functions with a memory: what an expression keeps from sample to sample. It begins anew with every stretch of recording.

/// What is kept, and what becomes of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Memory {
    /// The value behind a first-order low pass of a time constant, s; at the first sample the value itself.
    Lag,
    /// The largest value so far.
    Peak,
    /// The integral of the value over time.
    Total,
    /// For how long the value has been above 0, s; 0 while it is not.
    Since,
    /// The value behind a play: it stays until the value is more than this far from it; at the first sample the value itself.
    Play,
}

/// Functions with a memory, and how many values they take.
pub(super) const MEMORIES: [(&str, (Memory, usize)); 5] = [
    ("lag", (Memory::Lag, 2)),
    ("peak", (Memory::Peak, 1)),
    ("total", (Memory::Total, 1)),
    ("since", (Memory::Since, 1)),
    ("play", (Memory::Play, 2)),
];

/// What one function of an expression has kept.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kept {
    value: f64,
    before: f64,
}

impl Memory {
    /// Its value at a sample `interval` seconds after the one before, of `kept` from there; none at the first sample. `own` is the
    /// time constant, s, or the play of those that have one.
    pub(super) fn follow(
        self,
        kept: &mut Option<Kept>,
        value: f64,
        own: f64,
        interval: f64,
    ) -> f64 {
        let now = match (self, *kept) {
            (Self::Lag | Self::Peak | Self::Play, None) => value,
            (Self::Total | Self::Since, None) => 0.0,
            (Self::Lag, Some(_)) if own <= 0.0 => value,
            (Self::Lag, Some(kept)) => low_pass(kept.value, kept.before, value, interval / own),
            (Self::Peak, Some(kept)) => kept.value.max(value),
            (Self::Total, Some(kept)) => kept.value + 0.5 * interval * (kept.before + value),
            (Self::Since, Some(_)) if value <= 0.0 => 0.0,
            (Self::Since, Some(kept)) => kept.value + interval,
            (Self::Play, Some(kept)) => {
                let gap = own.max(0.0);
                kept.value.min(value + gap).max(value - gap)
            }
        };
        *kept = Some(Kept { value: now, before: value });
        now
    }
}

/// Output of a first-order low pass after an interval in which its input goes straight from `before`
/// to `ahead`; `turns` is the interval over the time constant.
#[must_use]
pub fn low_pass(output: f64, before: f64, ahead: f64, turns: f64) -> f64 {
    if turns <= 0.0 {
        return output;
    }
    let decay = (-turns).exp();
    let mean = -(-turns).exp_m1() / turns;
    decay * output + (mean - decay) * before + (1.0 - mean) * ahead
}
