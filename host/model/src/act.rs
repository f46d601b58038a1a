//! How an effect acts on the way from the commanded motion to the recorded number.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{Expression, Hereditary, Scene};

/// A stage of the chain *motion → elasticity → relaxation → contact → sensor*.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Stage {
    /// What reaches the specimen is not what was commanded.
    Motion,
    /// The elastic response of the specimen.
    Elasticity,
    /// The time-dependence of the specimen.
    Relaxation,
    /// What happens where the indenter touches.
    Contact,
    /// The sensor and its electronics.
    Sensor,
}

impl Stage {
    /// Every stage, in the order of the chain.
    pub const ALL: [Self; 5] =
        [Self::Motion, Self::Elasticity, Self::Relaxation, Self::Contact, Self::Sensor];

    /// Name in model files, tables and answers.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Motion => "motion",
            Self::Elasticity => "elasticity",
            Self::Relaxation => "relaxation",
            Self::Contact => "contact",
            Self::Sensor => "sensor",
        }
    }
}

/// What an effect remembers from sample to sample and from trace to trace: empty before the first
/// sample of the data set, in whatever meaning the effect gives it.
pub type Remembered = Vec<f64>;

/// The law of an effect, as a function over one stretch of recording.
///
/// The first slice is the effect's parameters in the order of their declaration. At zero strength
/// every law leaves its subject as it was.
#[derive(Clone, Debug)]
pub enum Act {
    /// Changes the compression x, mm.
    Compression(fn(&Scene, &[f64], &mut Remembered, &mut [f64])),
    /// What the set-up yields, mm, under a contact force, N.
    Yield(fn(&[f64], f64) -> f64),
    /// Changes the elastic response N (last), N, at the compression x, mm (second to last).
    Elastic(fn(&Scene, &[f64], &mut Remembered, &[f64], &mut [f64])),
    /// Changes how the elastic response relaxes, at the compression x, mm.
    Relaxation(fn(&Scene, &[f64], &mut Remembered, &[f64], &mut Hereditary)),
    /// Changes the force, N, at its stage: contact or sensor.
    Force(fn(&Scene, &[f64], &mut Remembered, &mut [f64])),
    /// Adds to the force, N, at its stage; what it adds does not depend on the force, which leaves that one's derivatives as they are.
    Added(fn(&Scene, &[f64], &mut Remembered, &mut [f64])),
    /// A law of the user's own, as an expression.
    Own(Arc<Expression>),
}
