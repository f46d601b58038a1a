//! Which options a base law can have.

use super::{BaseLaw, Deformation, EXPONENTS_N, Elastic, LawOption, MAX_TERMS, Separation};

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
    #[error("`{law}` takes an exponent from {} to {}, not {exponent}", EXPONENTS_N.0, EXPONENTS_N.1)]
    Exponent { law: &'static str, exponent: f64 },
    #[error("relaxation by `{kernel}` is for `fung`, not for `{law}`")]
    NoKernel { law: &'static str, kernel: &'static str },
    #[error("the force of `{law}` is proportional to the displacement: it takes no `{elastic}`")]
    NoElastic { law: &'static str, elastic: &'static str },
    #[error("in shear `{elastic}` has the force of `{same}`: take that")]
    SameInShear { elastic: &'static str, same: &'static str },
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
        if self.separation == Separation::Bonded && !family.takes(LawOption::Bonded) {
            return Err(OptionError::Bonded(law));
        }
        if !self.kernel.is_exponentials() && !family.takes(LawOption::Relaxation) {
            return Err(OptionError::NoKernel { law, kernel: self.kernel.name });
        }
        let elastic = self.elastic.law;
        if self.elastic != Elastic::POWER && !family.takes(LawOption::Elastic) {
            return Err(OptionError::NoElastic { law, elastic: elastic.name });
        }
        let sheared =
            self.elastic.gauge.is_some_and(|gauge| gauge.deformation == Deformation::Shear);
        if let Some(same) = elastic.same_in_shear().filter(|_| sheared) {
            return Err(OptionError::SameInShear { elastic: elastic.name, same: same.name });
        }
        if let Some(segments) = self.segments {
            if !family.takes(LawOption::Segments) {
                return Err(OptionError::NoSegments(law));
            }
            if segments < 2 {
                return Err(OptionError::Segments { law, segments });
            }
        }
        if let Some(exponent) = self.exponent {
            if !family.takes(LawOption::Exponent) {
                return Err(OptionError::NoExponent(law));
            }
            if !(EXPONENTS_N.0..=EXPONENTS_N.1).contains(&exponent) {
                return Err(OptionError::Exponent { law, exponent });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ElasticLaw, Family, Gauge, Kernel};

    #[test]
    fn each_option_has_its_families_and_its_range() {
        let law = |family| BaseLaw::new(family, 2, Separation::Clamp);
        let segmented = |family, segments| BaseLaw { segments: Some(segments), ..law(family) };
        let powered = |family, n| BaseLaw { exponent: Some(n), ..law(family) };
        for good in [
            law(Family::FUNG),
            law(Family::MAXWELL),
            segmented(Family::LATENCY, 2),
            powered(Family::LATENCY_POWER, 9.0),
        ] {
            assert_eq!(good.check(), Ok(()));
        }
        let rubber =
            |kind, deformation| Elastic::stretch(kind, Gauge { length_mm: 10.0, deformation });
        let fung = |elastic| law(Family::FUNG).with(elastic, Kernel::POWER_LAW);
        let stretched = |family| law(family).with(Elastic::POWER, Kernel::STRETCHED);
        let pulled = rubber(ElasticLaw::MOONEY_RIVLIN, Deformation::Tension);
        let sheared = rubber(ElasticLaw::MOONEY_RIVLIN, Deformation::Shear);
        assert_eq!(fung(pulled).check(), Ok(()));
        let bonded = BaseLaw { separation: Separation::Bonded, ..law(Family::CREEP) };
        for (bad, words) in [
            (BaseLaw::new(Family::FUNG, 0, Separation::Clamp), "1 to 4"),
            (BaseLaw::new(Family::FUNG, 5, Separation::Clamp), "not 5"),
            (bonded, "compression"),
            (segmented(Family::FUNG, 4), "not for `fung`"),
            (segmented(Family::LATENCY, 1), "2 or more"),
            (powered(Family::LATENCY, 3.0), "not for `latency`"),
            (powered(Family::LATENCY_POWER, 9.5), "from 1 to 9, not 9.5"),
            (powered(Family::LATENCY_POWER, f64::NAN), "not NaN"),
            (stretched(Family::LATENCY), "`stretched` is for `fung`"),
            (BaseLaw { elastic: pulled, ..law(Family::MAXWELL) }, "no `mooney-rivlin`"),
            (fung(sheared), "neo-hooke"),
        ] {
            let said = bad.check().unwrap_err().to_string();
            assert!(said.contains(words), "{said}");
        }
    }
}
