//! What a reader should know about a sample before trusting it.

use core::ops::BitOr;

/// A set of warnings about one sample of one gauge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Flags(u8);

impl Flags {
    /// No warning.
    pub const NONE: Self = Self(0);
    /// The converter stood at one end of its 24 bits: the bridge is out of its range.
    pub const CONVERTER_AT_RAIL: Self = Self(1);
    /// The calibrated strain did not fit in 24 bits and was saturated.
    pub const STRAIN_SATURATED: Self = Self(1 << 1);
    /// The filter had to saturate a memory.
    pub const FILTER_SATURATED: Self = Self(1 << 2);

    /// The bits, for the wire: 0 converter at rail, 1 strain saturated, 2 filter saturated.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// From bits; those without a meaning are dropped.
    #[must_use]
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits & 0b111)
    }

    /// Whether every warning of `other` is among these.
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// `self` if `condition`, else none.
    #[must_use]
    pub const fn when(self, condition: bool) -> Self {
        if condition { self } else { Self::NONE }
    }
}

impl BitOr for Flags {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_keep_what_was_put_in_and_nothing_else() {
        let both = Flags::CONVERTER_AT_RAIL | Flags::STRAIN_SATURATED.when(true);
        assert!(both.contains(Flags::CONVERTER_AT_RAIL) && both.contains(Flags::STRAIN_SATURATED));
        assert!(!both.contains(Flags::FILTER_SATURATED));
        assert_eq!(Flags::from_bits(both.bits()), both);
        assert_eq!(Flags::from_bits(0xf8), Flags::NONE);
    }
}
