//! What the lamp on a board shows: that the device lives, and how it is.

/// How often it is lit, and for how long, µs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lamp {
    /// A short flash every two seconds.
    Waiting,
    /// On and off, once a second.
    Streaming,
    /// On and off, five times a second.
    Faulty,
}

impl Lamp {
    /// Whether it is lit at this time, µs.
    #[must_use]
    pub const fn is_lit(self, now_us: u64) -> bool {
        match self {
            Self::Waiting => now_us % 2_000_000 < 50_000,
            Self::Streaming => now_us % 1_000_000 < 500_000,
            Self::Faulty => now_us % 200_000 < 100_000,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Changes and time lit in ten seconds, looked at every 10 ms as the firmware does.
    fn shown(lamp: Lamp) -> (usize, usize) {
        let lit: Vec<bool> = (0..1_000).map(|at| lamp.is_lit(at * 10_000)).collect();
        let changes = lit.windows(2).filter(|pair| pair[0] != pair[1]).count();
        (changes, lit.iter().filter(|lit| **lit).count())
    }

    #[test]
    fn how_it_is_can_be_told_by_eye() {
        assert_eq!(shown(Lamp::Waiting), (9, 25));
        assert_eq!(shown(Lamp::Streaming), (19, 500));
        assert_eq!(shown(Lamp::Faulty), (99, 500));
    }
}
