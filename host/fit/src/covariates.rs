//! The quantities that a residual could depend on, at each sample of a stretch.

use std::borrow::Cow;

use palpate_model::covariate::Covariate;

use super::data::{Data, Piece};
use super::slope::{acceleration, velocity};

/// Part of a stretch's fastest motion below which it rests.
const REST: f64 = 0.01;

impl Data<'_> {
    /// The values of a quantity along a stretch of this data set, for which the model predicts `predicted`; none where it was not
    /// recorded.
    #[must_use]
    pub fn covariate<'b>(
        &'b self,
        piece: &'b Piece,
        predicted: &'b [f64],
        covariate: Covariate,
    ) -> Option<Cow<'b, [f64]>> {
        let (motion, known) = (&piece.motion, self.known(piece));
        let velocity = || -> Cow<'b, [f64]> {
            match known {
                Some(known) => (&known.velocity).into(),
                None => velocity(motion).into(),
            }
        };
        let acceleration = || -> Cow<'b, [f64]> {
            match known {
                Some(known) => (&known.acceleration).into(),
                None => acceleration(motion, &velocity()).into(),
            }
        };
        Some(match covariate {
            Covariate::Displacement => (&motion.displacement[..]).into(),
            Covariate::Velocity => velocity(),
            Covariate::Direction => directions(&velocity()).into(),
            Covariate::Acceleration => acceleration(),
            Covariate::Force => predicted.into(),
            Covariate::Time => (&motion.time[..]).into(),
            Covariate::SetTime => piece.set_time().into(),
            Covariate::Temperature => {
                self.reference_temperature?;
                piece.temperature()?.into()
            }
            Covariate::Cycle => piece.history().0.into(),
            Covariate::Largest => piece.history().1.into(),
        })
    }
}

/// Signs of a velocity; 0 at rest.
fn directions(velocity: &[f64]) -> Vec<f64> {
    let fastest = velocity.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let direction = |v: &f64| if v.abs() > REST * fastest { v.signum() } else { 0.0 };
    velocity.iter().map(direction).collect()
}
