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

    /// The displacements x, mm, that the specimen feels: off it none, unless it is bonded.
    #[must_use]
    pub fn felt(self, x: &[f64]) -> Cow<'_, [f64]> {
        if self == Self::Bonded || x.iter().all(|&x| x >= 0.0) {
            x.into()
        } else {
            x.iter().map(|x| x.max(0.0)).collect()
        }
    }
}
