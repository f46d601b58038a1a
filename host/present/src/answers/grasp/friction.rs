//! `palpate grasp friction`: friction and pressure from a recorded slide.

use palpate_contact::grasp::friction::Friction;
use serde::Serialize;

use crate::answers::finite;

/// Coefficient of friction and exponent of the pressure from a slide.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub struct GraspFrictionAnswer {
    /// Version of this answer.
    pub palpate_grasp_friction: u32,
    /// Coefficient of friction μ.
    pub friction: f64,
    /// Its standard error, that of the exponent included.
    pub friction_standard_error: f64,
    /// Whether the slide determines the exponent k of the pressure.
    pub exponent_is_told: bool,
    /// Exponent k; null where the slide does not determine it, or where it is infinite: a uniform pressure.
    pub exponent: Option<f64>,
    /// Lower end of its 95 % interval; null where the slide does not determine it, or where it is infinite.
    pub exponent_least: Option<f64>,
    /// Upper end of its 95 % interval; null where the slide does not determine it, or where it is infinite.
    pub exponent_largest: Option<f64>,
    /// Standard deviation of μ from sample to sample.
    pub scatter: f64,
    /// Number of samples used.
    pub samples: usize,
    /// Least and largest share of the moment in the load of a sample: 0 for a slide along a line, 1 for a turn on the spot.
    pub moment_share: [f64; 2],
}

impl From<&Friction> for GraspFrictionAnswer {
    fn from(found: &Friction) -> Self {
        Self {
            palpate_grasp_friction: 1,
            friction: found.coefficient.0,
            friction_standard_error: found.coefficient.1,
            exponent_is_told: found.exponent.is_some(),
            exponent: found.exponent.and_then(|(k, ..)| finite(k)),
            exponent_least: found.exponent.and_then(|(_, low, _)| finite(low)),
            exponent_largest: found.exponent.and_then(|(.., high)| finite(high)),
            scatter: found.scatter,
            samples: found.samples,
            moment_share: [found.moment_share.0, found.moment_share.1],
        }
    }
}
