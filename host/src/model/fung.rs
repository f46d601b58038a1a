//! Fung's quasi-linear law with a power-law elastic response and a sum of exponentials.

use super::{Memory, Motion, Number, Parameter, Relaxation, elastic_response};
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
        let p = Parameter {
            name: "p",
            unit: "N/mm^(q+1)",
            meaning: "stiffness of the elastic response",
            lower: 0.0,
            upper: f64::INFINITY,
        };
        let q = Parameter {
            name: "q",
            unit: "",
            meaning: "exponent by which the stiffness grows with compression",
            lower: -0.9,
            upper: 6.0,
        };
        let share = |name| Parameter {
            name,
            unit: "",
            meaning: "share of the elastic response that relaxes at this rate",
            lower: 0.0,
            upper: 1.0,
        };
        let rate = |name| Parameter {
            name,
            unit: "1/s",
            meaning: "rate of relaxation",
            lower: 0.0,
            upper: f64::INFINITY,
        };
        [p, q]
            .into_iter()
            .chain(SHARES[..self.terms].iter().copied().map(share))
            .chain(RATES[..self.terms].iter().copied().map(rate))
            .collect()
    }

    /// The relaxation function within a parameter vector.
    pub fn relaxation<T: Number>(&self, parameters: &[T]) -> Relaxation<T> {
        let (shares, rates) = parameters[2..].split_at(self.terms);
        Relaxation::new(shares, rates)
    }

    /// A specimen that has forgotten all.
    pub fn rested<T: Number>(&self) -> Memory<T> {
        Memory::rested(self.terms)
    }

    /// Predicts the force over a motion, N, and hands it to `sink` sample by sample with its index.
    ///
    /// `memory` is what the specimen remembers; it is left as the motion leaves it. A motion that
    /// starts in contact counts as having just arrived there.
    pub fn run<T: Number>(
        &self,
        parameters: &[T],
        motion: &Motion,
        memory: &mut Memory<T>,
        mut sink: impl FnMut(usize, T),
    ) {
        let relaxation = self.relaxation(parameters);
        let elastic = |x: f64| elastic_response(parameters[0], parameters[1], T::from(x));
        match motion.rest_before {
            Some(rest) => self.rest(&relaxation, memory, rest),
            None => *memory = self.rested(),
        }
        let bonded = self.separation == Separation::Bonded;
        let mut before = f64::NAN;
        for (index, (&time, &x)) in motion.time.iter().zip(&motion.displacement).enumerate() {
            let interval = time - before;
            before = time;
            let force = if index == 0 {
                memory.jump(&relaxation, elastic(x))
            } else {
                let reached = match self.separation {
                    Separation::Clamp | Separation::Bonded => elastic(x),
                    Separation::Free => larger(elastic(x), memory.free(&relaxation, interval)),
                };
                memory.step(&relaxation, reached, interval)
            };
            sink(index, if bonded { force } else { larger(force, T::from(0.0)) });
        }
    }

    /// Lets the specimen rest between two traces.
    fn rest<T: Number>(&self, relaxation: &Relaxation<T>, memory: &mut Memory<T>, seconds: f64) {
        match self.separation {
            Separation::Clamp | Separation::Bonded => memory.wait(relaxation, seconds),
            Separation::Free => {
                // The free recovery is curved; linear pieces of growing length follow it closely.
                const PIECES: i32 = 24;
                let unit = seconds / (2f64.powi(PIECES) - 1.0);
                for piece in 0..PIECES {
                    let interval = unit * 2f64.powi(piece);
                    let free = larger(memory.free(relaxation, interval), T::from(0.0));
                    memory.step(relaxation, free, interval);
                }
            }
        }
    }

    /// Predicts the force of each motion of a data set, N, in order of recording.
    #[must_use]
    pub fn predict(&self, parameters: &[f64], motions: &[Motion]) -> Vec<Vec<f64>> {
        let mut memory = self.rested();
        motions
            .iter()
            .map(|motion| {
                let mut force = Vec::with_capacity(motion.time.len());
                self.run(parameters, motion, &mut memory, |_, value| force.push(value));
                force
            })
            .collect()
    }
}

fn larger<T: Number>(a: T, b: T) -> T {
    if a.re() >= b.re() { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Hold, Move, Profile, Step};

    /// Presses to 4 mm, holds, and leaves.
    fn press() -> Motion {
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
            time: whole.time[range.clone()].to_vec(),
            displacement: whole.displacement[range].to_vec(),
            rest_before,
        };
        // The cut lies in the hold: a rest of one interval is what the missing sample was.
        let split = [part(0..cut, None), part(cut..whole.time.len(), Some(1.0 / 200.0))];
        let joined: Vec<f64> = law.predict(&PARAMETERS, &split).concat();
        let expected = force(Separation::Bonded);
        assert!(joined.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn derivatives_agree_with_differences() {
        use crate::model::seeded;
        for separation in [Separation::Clamp, Separation::Free, Separation::Bonded] {
            let law = Fung { terms: 2, separation };
            let motion = press();
            let mut slopes = Vec::new();
            let mut memory = law.rested();
            law.run(&seeded(&PARAMETERS, 0), &motion, &mut memory, |_, force| {
                slopes.push(force.eps.unwrap_generic(nalgebra::Const, nalgebra::U1));
            });
            for (place, value) in PARAMETERS.iter().enumerate() {
                let step = 1e-6 * value;
                let moved = |sign: f64| {
                    let mut parameters = PARAMETERS;
                    parameters[place] += sign * step;
                    law.predict(&parameters, std::slice::from_ref(&motion)).remove(0)
                };
                let (up, down) = (moved(1.0), moved(-1.0));
                let wrong = (0..up.len())
                    .filter(|&k| {
                        let difference = (up[k] - down[k]) / (2.0 * step);
                        (slopes[k][place] - difference).abs() > 1e-5 * (1.0 + difference.abs())
                    })
                    .count();
                // Where contact breaks within the step, the difference straddles a corner.
                assert!(wrong <= 4, "{separation:?}, parameter {place}: {wrong} samples");
            }
        }
    }
}
