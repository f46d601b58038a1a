//! A share of a count with its confidence interval.

use std::fmt;

/// So many of so many.
#[derive(Clone, Copy, Debug, Default)]
pub struct Share {
    /// How many are.
    pub are: usize,
    /// Of how many.
    pub of: usize,
}

impl Share {
    /// Counts those for which it is so.
    pub fn count(all: impl Iterator<Item = bool>) -> Self {
        let (mut are, mut of) = (0, 0);
        for is in all {
            are += usize::from(is);
            of += 1;
        }
        Self { are, of }
    }

    /// The share; not a number where nothing was counted.
    pub fn value(self) -> f64 {
        self.are as f64 / self.of as f64
    }

    /// Wilson's interval of 95 % confidence.
    pub fn interval(self) -> (f64, f64) {
        const Z: f64 = 1.959_963_985;
        let n = self.of as f64;
        let centre = (self.value() + Z * Z / (2.0 * n)) / (1.0 + Z * Z / n);
        let variance = self.value() * (1.0 - self.value()) / n + (Z / (2.0 * n)).powi(2);
        let half = Z * variance.sqrt() / (1.0 + Z * Z / n);
        ((centre - half).max(0.0), (centre + half).min(1.0))
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (low, high) = self.interval();
        let percent = |share: f64| 100.0 * share;
        write!(
            f,
            "{:5.1} % [{:5.1}, {:5.1}] {:>4}/{:<4}",
            percent(self.value()),
            percent(low),
            percent(high),
            self.are,
            self.of
        )
    }
}
