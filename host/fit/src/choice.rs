//! Which base laws are tried: a family with its options.

use super::hold::Terms;
use palpate_model::{BaseLaw, Elastic, Family, Kernel, MAX_TERMS, OptionError, Separation};

/// A family of base laws with its options.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// The family.
    pub family: &'static Family,
    /// Number of exponentials or branches, where the family has them.
    pub terms: Terms,
    /// What happens where contact breaks.
    pub separation: Separation,
    /// Number m of segments of a latency model, where it is given: then c0 = 1/m.
    pub segments: Option<u32>,
    /// Exponent n of the nonlinear latency model; free where it is not given.
    pub exponent: Option<Exponent>,
    /// The elastic response.
    pub elastic: Elastic,
    /// How the response relaxes.
    pub kernel: &'static Kernel,
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

impl Choice {
    /// The laws to try: one, or one for each number of exponentials or each exponent.
    ///
    /// # Errors
    /// When the family does not have an option, or not so much of it.
    pub fn laws(&self) -> Result<Vec<BaseLaw>, OptionError> {
        let law = |terms: usize, exponent: Option<f64>| {
            let law = BaseLaw::new(self.family, terms, self.separation);
            let law = law.with(self.elastic, self.kernel);
            BaseLaw { segments: self.segments, exponent, ..law }
        };
        let terms = match self.terms {
            Terms::Auto if law(1, None).has_terms() => 1..=MAX_TERMS,
            Terms::Auto => 1..=1,
            Terms::Fixed(terms) => terms..=terms,
        };
        let laws: Vec<BaseLaw> = match self.exponent {
            Some(Exponent::Auto) => ODD.map(|n| law(1, Some(n))).to_vec(),
            Some(Exponent::Given(n)) => vec![law(1, Some(n))],
            None => terms.map(|terms| law(terms, None)).collect(),
        };
        laws.iter().try_for_each(BaseLaw::check)?;
        Ok(laws)
    }
}
