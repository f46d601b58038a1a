//! Which options a base law can have.

use super::{
    BaseLaw, Deformation, EXPONENTS_N, Elastic, Family, Hyperelastic, Kernel, MAX_TERMS, Separation,
};

/// Why there is no base law with these options.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)]
pub enum OptionError {
    #[error("`{law}` takes 1 to {MAX_TERMS} exponentials or branches, not {terms}")]
    Terms { law: &'static str, terms: usize },
    #[error("`{0}` is stated for compression and cannot be bonded")]
    Bonded(&'static str),
    #[error("a number of segments is for the latency models, not for `{0}`")]
    NoSegments(&'static str),
    #[error("`{law}` takes 2 or more segments, not {segments}")]
    Segments { law: &'static str, segments: u32 },
    #[error("an exponent is for `latency-power`, not for `{0}`")]
    NoExponent(&'static str),
    #[error("`latency-power` takes an exponent from {} to {}, not {exponent}", EXPONENTS_N.0, EXPONENTS_N.1)]
    Exponent { exponent: f64 },
    #[error("relaxation by `{kernel}` is for `fung`, not for `{law}`")]
    NoKernel { law: &'static str, kernel: &'static str },
    #[error("the force of `{law}` is proportional to the displacement: it takes no `{elastic}`")]
    NoElastic { law: &'static str, elastic: &'static str },
    #[error("in shear `mooney-rivlin` has the force of `neo-hooke`: take that")]
    SameInShear,
}

impl BaseLaw {
    /// Whether its family has the options that it is given, within their ranges.
    ///
    /// # Errors
    /// [`OptionError`].
    pub fn check(&self) -> Result<(), OptionError> {
        let (family, law) = (self.family, self.name());
        if !(1..=MAX_TERMS).contains(&self.terms) {
            return Err(OptionError::Terms { law, terms: self.terms });
        }
        if self.separation == Separation::Bonded && !family.can_be_bonded() {
            return Err(OptionError::Bonded(law));
        }
        if self.kernel != Kernel::Exponentials && !family.has_kernel() {
            return Err(OptionError::NoKernel { law, kernel: self.kernel.name() });
        }
        if let Elastic::Stretch(elastic, gauge) = self.elastic {
            if family.is_linear() {
                return Err(OptionError::NoElastic { law, elastic: elastic.name() });
            }
            if elastic == Hyperelastic::MooneyRivlin && gauge.deformation == Deformation::Shear {
                return Err(OptionError::SameInShear);
            }
        }
        if let Some(segments) = self.segments {
            if !family.has_segments() {
                return Err(OptionError::NoSegments(law));
            }
            if segments < 2 {
                return Err(OptionError::Segments { law, segments });
            }
        }
        if let Some(exponent) = self.exponent {
            if family != Family::LatencyPower {
                return Err(OptionError::NoExponent(law));
            }
            if !(EXPONENTS_N.0..=EXPONENTS_N.1).contains(&exponent) {
                return Err(OptionError::Exponent { exponent });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_option_has_its_families_and_its_range() {
        let law = |family| BaseLaw::new(family, 2, Separation::Clamp);
        let segmented = |family, segments| BaseLaw { segments: Some(segments), ..law(family) };
        let powered = |family, n| BaseLaw { exponent: Some(n), ..law(family) };
        for good in [
            law(Family::Fung),
            law(Family::Maxwell),
            segmented(Family::Latency, 2),
            powered(Family::LatencyPower, 9.0),
        ] {
            assert_eq!(good.check(), Ok(()));
        }
        use crate::Gauge;
        let rubber =
            |kind, deformation| Elastic::Stretch(kind, Gauge { length_mm: 10.0, deformation });
        let fung = |elastic| law(Family::Fung).with(elastic, Kernel::PowerLaw);
        let stretched = |family| law(family).with(Elastic::Power, Kernel::Stretched);
        let pulled = rubber(Hyperelastic::MooneyRivlin, Deformation::Tension);
        let sheared = rubber(Hyperelastic::MooneyRivlin, Deformation::Shear);
        assert_eq!(fung(pulled).check(), Ok(()));
        let bonded = BaseLaw { separation: Separation::Bonded, ..law(Family::Creep) };
        for (bad, words) in [
            (BaseLaw::new(Family::Fung, 0, Separation::Clamp), "1 to 4"),
            (BaseLaw::new(Family::Fung, 5, Separation::Clamp), "not 5"),
            (bonded, "compression"),
            (segmented(Family::Fung, 4), "not for `fung`"),
            (segmented(Family::Latency, 1), "2 or more"),
            (powered(Family::Latency, 3.0), "not for `latency`"),
            (powered(Family::LatencyPower, 9.5), "from 1 to 9, not 9.5"),
            (powered(Family::LatencyPower, f64::NAN), "not NaN"),
            (stretched(Family::Latency), "`stretched` is for `fung`"),
            (BaseLaw { elastic: pulled, ..law(Family::Maxwell) }, "no `mooney-rivlin`"),
            (fung(sheared), "neo-hooke"),
        ] {
            let said = bad.check().unwrap_err().to_string();
            assert!(said.contains(words), "{said}");
        }
    }
}
