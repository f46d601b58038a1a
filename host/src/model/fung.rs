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
}

/// Base law `fung`: F = ∫ g(t−s) dN(x(s)) (eq. 2.1), N(x) = p/(q+1) x^(q+1) for x > 0 (eq. 3.2),
/// g(t) = c0 + Σ ci e^(−vi t), Σ c = 1 (eq. 3.3); contact breaks at zero force.
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
        let mut before = f64::NAN;
        for (index, (&time, &x)) in motion.time.iter().zip(&motion.displacement).enumerate() {
            let interval = time - before;
            before = time;
            let force = if index == 0 {
                memory.jump(&relaxation, elastic(x))
            } else {
                let reached = match self.separation {
                    Separation::Clamp => elastic(x),
                    Separation::Free => larger(elastic(x), memory.free(&relaxation, interval)),
                };
                memory.step(&relaxation, reached, interval)
            };
            sink(index, larger(force, T::from(0.0)));
        }
    }

    /// Lets the specimen rest between two traces.
    fn rest<T: Number>(&self, relaxation: &Relaxation<T>, memory: &mut Memory<T>, seconds: f64) {
        match self.separation {
            Separation::Clamp => memory.wait(relaxation, seconds),
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
