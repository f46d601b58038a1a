//! Which base laws are tried: a family with its options.

use super::hold::Terms;
use crate::model::{BaseLaw, Family, MAX_TERMS, Separation};

/// A family of base laws with its options.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// The family.
    pub family: Family,
    /// Number of exponentials or branches, where the family has them.
    pub terms: Terms,
    /// What happens where contact breaks.
    pub separation: Separation,
    /// Number m of segments of a latency model, where it is given: then c0 = 1/m.
    pub segments: Option<u32>,
    /// Exponent n of the nonlinear latency model; free where it is not given.
    pub exponent: Option<Exponent>,
}

/// The exponent n of the nonlinear latency model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exponent {
    /// This one.
    Given(f64),
    /// The lowest of [`ODD`] that fits best.
    Auto,
}

/// Exponents among which the lowest that fits best is chosen: odd ones, as in 7.2.
pub const ODD: [f64; 5] = [1.0, 3.0, 5.0, 7.0, 9.0];

/// Why there is no such law.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs)]
pub enum ChoiceError {
    #[error("`{0}` is stated for compression and cannot be bonded")]
    Bonded(&'static str),
    #[error("--segments is for the latency models, not for `{0}`")]
    Segments(&'static str),
    #[error("--exponent is for `latency-power`, not for `{0}`")]
    Exponent(&'static str),
}

impl Choice {
    /// The laws to try: one, or one for each number of exponentials or each exponent.
    ///
    /// # Errors
    /// When the family does not have an option.
    pub fn laws(&self) -> Result<Vec<BaseLaw>, ChoiceError> {
        let (family, name) = (self.family, self.family.name());
        let law = BaseLaw { segments: self.segments, ..BaseLaw::new(family, 1, self.separation) };
        if law.separation == Separation::Bonded && !family.can_be_bonded() {
            return Err(ChoiceError::Bonded(name));
        }
        if self.segments.is_some() && !family.has_segments() {
            return Err(ChoiceError::Segments(name));
        }
        match self.exponent {
            Some(_) if family != Family::LatencyPower => return Err(ChoiceError::Exponent(name)),
            Some(Exponent::Given(n)) => return Ok(vec![BaseLaw { exponent: Some(n), ..law }]),
            Some(Exponent::Auto) => {
                return Ok(ODD.map(|n| BaseLaw { exponent: Some(n), ..law }).to_vec());
            }
            None => {}
        }
        if !family.has_terms() {
            return Ok(vec![law]);
        }
        let terms = match self.terms {
            Terms::Fixed(terms) => terms..=terms,
            Terms::Auto => 1..=MAX_TERMS,
        };
        Ok(terms.map(|terms| BaseLaw { terms, ..law }).collect())
    }
}
