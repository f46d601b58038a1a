//! A base law, as a program chooses it.

use palpate_model::{BaseLaw, Elastic, Family, Kernel, Separation, TERMS};

/// A base law with its options; what does not go together is refused where it is fitted.
///
/// ```
/// use palpate::{Kernel, Law};
///
/// let three_exponentials = Law::fung().terms(3);
/// let springpot = Law::fung().relaxation(Kernel::POWER_LAW);
/// let nonlinear = Law::latency_power().exponent(3.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law(BaseLaw);

impl Law {
    /// The law of a family, of the library or of one's own, contact breaking where the force would pull.
    #[must_use]
    pub const fn of(family: &'static Family) -> Self {
        Self(BaseLaw::new(family, TERMS, Separation::Clamp))
    }

    /// Fung's quasi-linear law (eqs 2.1, 3.2, 3.3), two exponentials.
    #[must_use]
    pub const fn fung() -> Self {
        Self::of(Family::FUNG)
    }

    /// The linear latency model (eqs 4.1 to 4.11).
    #[must_use]
    pub const fn latency() -> Self {
        Self::of(Family::LATENCY)
    }

    /// The nonlinear latency model (eqs 7.2, 7.3, 7.11).
    #[must_use]
    pub const fn latency_power() -> Self {
        Self::of(Family::LATENCY_POWER)
    }

    /// This many exponentials or branches, 1 to 4.
    #[must_use]
    pub const fn terms(self, terms: usize) -> Self {
        Self(BaseLaw { terms, ..self.0 })
    }

    /// This elastic response.
    #[must_use]
    pub const fn elastic(self, elastic: Elastic) -> Self {
        Self(self.0.with(elastic, self.0.kernel))
    }

    /// This way to relax.
    #[must_use]
    pub const fn relaxation(self, kernel: &'static Kernel) -> Self {
        Self(self.0.with(self.0.elastic, kernel))
    }

    /// This many segments, 2 or more, of a latency model.
    #[must_use]
    pub const fn segments(self, segments: u32) -> Self {
        Self(BaseLaw { segments: Some(segments), ..self.0 })
    }

    /// This exponent, 1 to 9, of the nonlinear latency model.
    #[must_use]
    pub const fn exponent(self, exponent: f64) -> Self {
        Self(BaseLaw { exponent: Some(exponent), ..self.0 })
    }
}

impl From<Law> for BaseLaw {
    fn from(law: Law) -> Self {
        law.0
    }
}
