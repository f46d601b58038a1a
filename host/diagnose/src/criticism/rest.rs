//! What a model says of the signal off the specimen, where nothing touches.

use super::fitted::Fitted;
use palpate_fit::problem::Problem;

/// The error of a model off the specimen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rest {
    /// Sum of squares of the whitened residual.
    pub whitened: f64,
    /// Sum of squares of the residual, in the squared unit of the signal.
    pub square: f64,
    /// Number of samples.
    pub samples: f64,
}

/// Rise of the whitened sum of squares that chance explains.
const CHANCE: f64 = 25.0;
/// Times by which an effect may raise the error at rest: the form of its law may be off there.
const FORM: f64 = 2.0;

impl Rest {
    /// The error of a fitted model off the specimen: before the first touch, and while the surfaces
    /// approach each other again.
    #[must_use]
    pub fn of(problem: &Problem, fitted: &Fitted) -> Self {
        let problem = problem.with_chain(&fitted.chain);
        let mut rest = Self::default();
        let mut index = 0;
        problem.each_piece(std::slice::from_ref(&fitted.point), |piece, forces| {
            let x = &piece.motion.displacement;
            let mut residual: Vec<f64> =
                forces[0].iter().zip(piece.measured).map(|(f, y)| f - y).collect();
            let off = off_the_specimen(x, |x| problem.data().loads(x));
            let square = |residual: &[f64]| -> f64 {
                residual.iter().zip(&off).filter(|(_, off)| **off).map(|(r, _)| r * r).sum()
            };
            let (mut weighted, mut samples) = (residual.clone(), vec![1.0; x.len()]);
            problem.weigh(index, &mut weighted);
            problem.weigh(index, &mut samples);
            let scatter = problem.scatter(index).iter().zip(&off).filter(|(_, off)| **off);
            rest.square += square(&weighted) + scatter.map(|(scatter, _)| scatter).sum::<f64>();
            problem.whiten_residual(index, &mut residual);
            rest.whitened += square(&residual);
            rest.samples += square(&samples);
            index += 1;
        });
        rest
    }

    /// Root mean square error, in the unit of the signal.
    #[must_use]
    pub fn rms(&self) -> f64 {
        (self.square / self.samples.max(1.0)).sqrt()
    }

    /// Whether an effect makes the error off the specimen larger than chance and the form of its law
    /// allow.
    #[must_use]
    pub fn denies(&self, without: &Self) -> bool {
        self.whitened - without.whitened > CHANCE && self.rms() > FORM * without.rms()
    }
}

/// Whether nothing can touch at each sample: before the first touch, and on the way in after a
/// parting. While the surfaces part they may still hold each other.
fn off_the_specimen(x: &[f64], loads: impl Fn(f64) -> bool) -> Vec<bool> {
    let mut farthest = f64::NEG_INFINITY;
    let mut touched = false;
    x.iter()
        .map(|&x| {
            if loads(x) {
                (touched, farthest) = (true, f64::NEG_INFINITY);
                return false;
            }
            farthest = farthest.max(-x);
            !touched || -x < farthest
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_that_part_are_not_yet_apart() {
        let x = [-1.0, 0.0, 0.5, 0.0, -0.5, -1.0, -0.9, -0.2, 0.3];
        let off = [true, true, false, false, false, false, true, true, false];
        assert_eq!(off_the_specimen(&x, |x| x > 0.0), off);
    }
}
