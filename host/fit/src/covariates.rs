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
            Covariate::Displacement => near(&motion.displacement, self.farthest_off()),
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

/// Displacements, none farther off the specimen than this, mm.
fn near(displacement: &[f64], farthest: f64) -> Cow<'_, [f64]> {
    if displacement.iter().all(|x| *x >= farthest) {
        return displacement.into();
    }
    displacement.iter().map(|x| x.max(farthest)).collect()
}

/// Signs of a velocity; 0 at rest.
fn directions(velocity: &[f64]) -> Vec<f64> {
    let fastest = velocity.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let direction = |v: &f64| if v.abs() > REST * fastest { v.signum() } else { 0.0 };
    velocity.iter().map(direction).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_farther_off_the_specimen_than_tells_anything() {
        assert_eq!(near(&[-100.0, -3.0, 5.0], -5.0)[..], [-5.0, -3.0, 5.0]);
        assert_eq!(near(&[-100.0, 5.0], f64::NEG_INFINITY)[..], [-100.0, 5.0]);
    }
}
