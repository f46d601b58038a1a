//! What happens when contact breaks.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

/// What happens when the indenter leaves the specimen faster than it recovers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Separation {
    /// The law runs over the commanded motion; the recorded force is its positive part.
    #[default]
    Clamp,
    /// The parted surface is free of stress and recovers by itself until the indenter meets it.
    Free,
    /// It cannot leave: the specimen is glued or clamped, may be moved to either side, and the force may turn to tension.
    Bonded,
}

impl Separation {
    /// Its name in a model file.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Clamp => "clamp",
            Self::Free => "free",
            Self::Bonded => "bonded",
        }
    }

    /// The displacement, mm, that the specimen feels at a displacement x, mm: off it none, unless it is bonded.
    #[must_use]
    pub const fn felt(self, x: f64) -> f64 {
        if matches!(self, Self::Bonded) { x } else { x.max(0.0) }
    }

    /// The force, N, that the contact carries of this one: no pull, unless it is bonded.
    #[must_use]
    pub const fn carried(self, force: f64) -> f64 {
        if matches!(self, Self::Bonded) { force } else { force.max(0.0) }
    }

    /// What the specimen [feels](Self::felt) at each of these displacements, mm.
    #[must_use]
    pub fn all_felt(self, x: &[f64]) -> Cow<'_, [f64]> {
        if self == Self::Bonded || x.iter().all(|&x| x >= 0.0) {
            x.into()
        } else {
            x.iter().map(|&x| self.felt(x)).collect()
        }
    }
}
