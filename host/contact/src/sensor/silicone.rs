//! Silicone of any composition between the two that were measured (Table 5.2).

use std::fmt;
use std::str::FromStr;

use shared::adaptation::Relaxation;

use super::SensorError;
use crate::Elastic;
use palpate_model::EQUATION_3_6;

/// Share of silicone, specific stiffness k_s (N/m²) and rate v1 (1/s): soft and hard silicone of Table 5.2.
const SOFT: (f64, f64, f64) = (0.5, 3.497e4, 0.493);
const HARD: (f64, f64, f64) = (0.9, 1.221e5, 0.695);
/// Poisson's ratio of both.
const POISSON_RATIO: f64 = 0.48;

/// The four specimens of Table 8.2: composition as silicone:thinner, and thickness, mm.
pub const TABLE_8_2: [(&str, f64); 4] = [("5:5", 4.0), ("7:3", 4.0), ("5:5", 8.0), ("7:3", 8.0)];

/// Share of silicone in a mixture of silicone and thinner, 0.5 to 0.9: what Table 5.2 spans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Composition(f64);

impl Composition {
    /// From the share of silicone.
    ///
    /// # Errors
    /// [`SensorError::Composition`] for a share outside 0.5 to 0.9.
    pub fn new(share: f64) -> Result<Self, SensorError> {
        Self::checked(share, &share.to_string())
    }

    fn checked(share: f64, given: &str) -> Result<Self, SensorError> {
        if (SOFT.0..=HARD.0).contains(&share) {
            return Ok(Self(share));
        }
        Err(SensorError::Composition { given: given.into(), least: SOFT.0, most: HARD.0 })
    }

    /// The share of silicone.
    #[must_use]
    pub const fn share(self) -> f64 {
        self.0
    }
}

impl FromStr for Composition {
    type Err = SensorError;

    /// Parts of silicone and thinner, `7:3`, or the share of silicone, `0.7`.
    fn from_str(text: &str) -> Result<Self, SensorError> {
        let number = |text: &str| text.trim().parse().unwrap_or(f64::NAN);
        let share = match text.split_once(':') {
            Some((silicone, thinner)) => {
                let (silicone, thinner): (f64, f64) = (number(silicone), number(thinner));
                silicone / (silicone + thinner)
            }
            None => number(text),
        };
        Self::checked(share, text)
    }
}

impl fmt::Display for Composition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tenths = |share: f64| (share * 1e3).round() / 1e2;
        write!(f, "{}:{}", tenths(self.0), tenths(1.0 - self.0))
    }
}

/// What a composition is like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Silicone {
    /// Its composition.
    pub composition: Composition,
    /// Modulus at once, before anything relaxes, and Poisson's ratio. The specific stiffness of Table 5.2 is that of the
    /// end of a hold; divided by c0 it is the modulus at the start.
    pub elastic: Elastic,
    /// Relaxation function (eq. 3.4).
    pub relaxation: Relaxation,
}

impl Silicone {
    /// Between the two compositions of Table 5.2 the stiffness and the slow rate are interpolated linearly in their
    /// logarithms. That table has one rate only; for want of a measurement, the shares and the ratio of fast to slow rate
    /// are those of eq. 3.6.
    #[must_use]
    pub fn of(composition: Composition) -> Self {
        let part = (composition.share() - SOFT.0) / (HARD.0 - SOFT.0);
        let between = |soft: f64, hard: f64| (soft.ln() + part * (hard / soft).ln()).exp();
        let ([c0, c1, c2], [fast, slow]) = EQUATION_3_6;
        let rate = between(SOFT.2, HARD.2);
        Self {
            composition,
            elastic: Elastic {
                modulus_pa: between(SOFT.1, HARD.1) / c0,
                poisson_ratio: POISSON_RATIO,
            },
            relaxation: Relaxation { c1, v1: rate * fast / slow, c2, v2: rate },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_compositions_of_table_5_2_have_its_stiffness_and_rate() {
        for (share, stiffness, rate) in [SOFT, HARD] {
            let silicone = Silicone::of(Composition::new(share).unwrap());
            let settled = silicone.elastic.modulus_pa * silicone.relaxation.c0();
            assert!((settled / stiffness - 1.0).abs() < 1e-12);
            assert!((silicone.relaxation.v2 / rate - 1.0).abs() < 1e-12);
        }
        let between = Silicone::of("7:3".parse().unwrap());
        let mean = (SOFT.1 * HARD.1).sqrt();
        assert!((between.elastic.modulus_pa * between.relaxation.c0() / mean - 1.0).abs() < 1e-12);
    }

    #[test]
    fn parts_and_shares_say_the_same_and_nonsense_is_refused_by_name() {
        let read = |text: &str| text.parse::<Composition>();
        assert_eq!(read("7:3").unwrap(), read("0.7").unwrap());
        assert_eq!(read("5:5").unwrap(), read("50:50").unwrap());
        assert_eq!(read("7:3").unwrap().to_string(), "7:3");
        for bad in ["", "seven", "1:9", "-1:2", "0:0", "NaN", "2"] {
            assert!(read(bad).unwrap_err().to_string().contains("parts of silicone"), "{bad}");
        }
    }
}
