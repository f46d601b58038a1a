//! Stops and notes in words.

use std::fmt;

use super::{Note, Stop};

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Converged => "converged: no step lowers the sum of squares",
            Self::Rounding => "converged to rounding",
            Self::Iterations => "not converged: the limit of iterations was reached",
        })
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AtSlowest { term } => {
                write!(f, "v{term} is at its lower limit: the recording is too short for this term")
            }
            Self::AtFastest { term } => {
                write!(f, "v{term} is at its upper limit: the sampling is too slow for this term")
            }
            Self::Vanishes { term } => {
                write!(f, "c{term} is held at 0 by its sign: v{term} has no meaning")
            }
            Self::ConstantAtZero => {
                f.write_str("c0 is held at 0 by its sign: nothing shows where the signal settles")
            }
            Self::Coincide { first, second } => write!(
                f,
                "v{first} and v{second} coincide: c{first} and c{second} have no meaning one by one; fit fewer terms"
            ),
            Self::Singular => f.write_str(
                "the rates are not identifiable from this hold: fit fewer terms or record longer",
            ),
            Self::ScaleNearZero => f.write_str(
                "N is hardly different from 0, so the coefficients are hardly determined",
            ),
        }
    }
}
