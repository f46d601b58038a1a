//! Fung's quasi-linear law with a power-law elastic response and a sum of exponentials.

use super::{Hereditary, HereditaryState, Motion, Parameter, Relaxation, elastic_response};
use serde::{Deserialize, Serialize};

/// Most exponentials a relaxation function may have.
pub const MAX_TERMS: usize = 4;

/// Exponentials of the relaxation function by default (appendix A).
pub const TERMS: usize = 2;

/// What happens when the indenter leaves the specimen faster than it recovers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Separation {
    /// The integral runs over the commanded motion; the recorded force is its positive part.
    #[default]
    Clamp,
    /// The parted surface is free of stress and recovers by itself until the indenter meets it.
    Free,
    /// It cannot leave: the specimen is glued or clamped, and the force may turn to tension.
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
}

/// Base law `fung`: F = ∫ g(t−s) dN(x(s)) (eq. 2.1), N(x) = p/(q+1) x^(q+1) for x > 0 (eq. 3.2),
/// g(t) = c0 + Σ ci e^(−vi t), Σ c = 1 (eq. 3.3); contact breaks at zero force unless bonded.
///
/// Its parameters are, in this order, p, q, c1…cn, v1…vn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fung {
    /// Number n of exponentials, 1 to [`MAX_TERMS`].
    pub terms: usize,
    /// What happens when contact breaks.
    pub separation: Separation,
}

const SHARES: [&str; MAX_TERMS] = ["c1", "c2", "c3", "c4"];
const RATES: [&str; MAX_TERMS] = ["v1", "v2", "v3", "v4"];

impl Fung {
    /// Name in model files and on the command line.
    pub const NAME: &'static str = "fung";

    /// The parameters p, q, c1…cn, v1…vn.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        let parameter = |name: &'static str, unit: &'static str, meaning: &'static str, range| {
            let (lower, upper): (f64, f64) = range;
            Parameter {
                name: name.into(),
                unit: unit.into(),
                meaning: meaning.into(),
                lower,
                upper,
            }
        };
        let p =
            parameter("p", "N/mm^(q+1)", "stiffness of the elastic response", (0.0, f64::INFINITY));
        let q = parameter(
            "q",
            "",
            "exponent by which the stiffness grows with compression",
            (-0.9, 6.0),
        );
        let share = |name| {
            let meaning = "share of the elastic response that relaxes at this rate";
            parameter(name, "", meaning, (0.0, 1.0))
        };
        let rate = |name| parameter(name, "1/s", "rate of relaxation", (0.0, f64::INFINITY));
        [p, q]
            .into_iter()
            .chain(SHARES[..self.terms].iter().copied().map(share))
            .chain(RATES[..self.terms].iter().copied().map(rate))
            .collect()
    }

    /// Number of parameters.
    #[must_use]
    pub fn count(&self) -> usize {
        2 + 2 * self.terms
    }

    /// The relaxation function within a parameter vector.
    #[must_use]
    pub fn relaxation(&self, parameters: &[f64]) -> Relaxation {
        let (shares, rates) = parameters[2..self.count()].split_at(self.terms);
        Relaxation::new(shares, rates)
    }

    /// Predicts the force of each motion of a data set, N, in order of recording.
    ///
    /// A motion that starts in contact counts as having just arrived there.
    #[must_use]
    pub fn predict(&self, parameters: &[f64], motions: &[Motion]) -> Vec<Vec<f64>> {
        let law = Hereditary::linear(self.relaxation(parameters).branches, self.separation);
        let mut state = HereditaryState::default();
        motions
            .iter()
            .map(|motion| {
                let elastic: Vec<f64> = motion
                    .displacement
                    .iter()
                    .map(|&x| elastic_response(parameters[0], parameters[1], x))
                    .collect();
                let mut force = Vec::new();
                law.run(&motion.time, &elastic, motion.rest_before, &mut state, &mut force);
                force
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Hold, Move, Profile, Step};

    /// Presses to 4 mm, holds, and leaves.
    fn press() -> Motion<'static> {
        Profile {
            version: 1,
            rate_hz: 200.0,
            start_mm: -0.5,
            speed_mm_per_s: 20.0,
            acceleration_mm_per_s2: None,
            repeat: 2,
            steps: vec![
                Step::Move(Move { to_mm: 4.0, speed_mm_per_s: None }),
                Step::Hold(Hold { hold_s: 2.0 }),
                Step::Move(Move { to_mm: -0.5, speed_mm_per_s: None }),
                Step::Hold(Hold { hold_s: 1.0 }),
            ],
        }
        .motion()
    }

    const PARAMETERS: [f64; 6] = [0.28, 0.45, 0.26, 0.24, 4.2, 0.55];

    fn force(separation: Separation) -> Vec<f64> {
        let law = Fung { terms: 2, separation };
        law.predict(&PARAMETERS, &[press()]).remove(0)
    }

    #[test]
    fn parting_pulls_only_where_bonded() {
        let least = |separation| force(separation).into_iter().fold(f64::INFINITY, f64::min);
        assert_eq!(least(Separation::Clamp), 0.0);
        assert!(least(Separation::Free).abs() < 1e-12);
        assert!(least(Separation::Bonded) < -0.1);
    }

    #[test]
    fn a_surface_that_recovers_by_itself_is_met_later_and_pushes_less() {
        let touch =
            |force: &[f64]| (700..force.len()).find(|&k| force[k] > 1e-3).expect("a second touch");
        let (clamp, free) = (force(Separation::Clamp), force(Separation::Free));
        // Until contact first breaks there is no difference.
        assert!((0..440).all(|k| (clamp[k] - free[k]).abs() < 1e-12));
        assert_ne!(touch(&clamp), touch(&free));
    }

    #[test]
    fn a_rest_between_traces_counts_as_time_at_the_last_place() {
        let law = Fung { terms: 2, separation: Separation::Bonded };
        let whole = press();
        let cut = 300;
        let part = |range: std::ops::Range<usize>, rest_before| Motion {
            time: whole.time[range.clone()].to_vec().into(),
            displacement: whole.displacement[range].to_vec().into(),
            rest_before,
        };
        // The cut lies in the hold: a rest of one interval is what the missing sample was.
        let split = [part(0..cut, None), part(cut..whole.time.len(), Some(1.0 / 200.0))];
        let joined: Vec<f64> = law.predict(&PARAMETERS, &split).concat();
        let expected = force(Separation::Bonded);
        assert!(joined.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}
