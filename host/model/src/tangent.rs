//! How a set-up that yields moves where the compression of its specimen is moved a little: the force of a specimen that remembers
//! follows, and so does what yields under it.

use super::Separation;
use super::hereditary::{Hereditary, HereditaryState};
use super::response::{Form, Response};

/// Straight lines through what a stretch does at the compressions that its set-up came to.
#[derive(Clone, Debug, Default)]
pub struct Tangent {
    /// Slope of the elastic response of a unit stiffness at each sample, N/mm.
    elastic: Vec<f64>,
    /// Slope of what yields over the force at each sample, mm/N.
    yielding: Vec<f64>,
    /// The force, N, and what yields under it, mm, at each sample.
    at: Vec<(f64, f64)>,
    /// The numbers of the laws by which the set-up yields.
    laws: Vec<f64>,
}

/// Part of a compression or of a force over which a slope is taken.
const STEP: f64 = 1e-6;
/// Largest logarithm of the ratio of two compressions, one after the other.
const MOST_TIMES: f64 = 5.0;

impl Tangent {
    /// Whether it is known for so many samples.
    #[must_use]
    pub fn knows(&self, samples: usize) -> bool {
        self.elastic.len() == samples
    }

    /// Slope of the elastic response of a unit stiffness at each sample, N/mm.
    #[must_use]
    pub fn elastic(&self) -> &[f64] {
        &self.elastic
    }

    /// What yields, mm, under forces, N, that differ little from those at each sample; none where the laws by which the set-up yields
    /// have other numbers, or another number of samples is asked for.
    #[must_use]
    pub fn yielded(&self, laws: &[f64], force: &[f64]) -> Option<Vec<f64>> {
        let known = self.laws == laws && self.at.len() == force.len();
        let at = self.at.iter().zip(&self.yielding).zip(force);
        known.then(|| {
            at.map(|(((at, yielded), slope), force)| yielded + slope * (force - at)).collect()
        })
    }

    /// Takes the slopes at these compressions, mm, where the force is so large, N; `yielded` is what yields under a force, mm, by laws of
    /// these numbers.
    pub fn take(
        &mut self,
        response: &Response,
        (compressions, force): (&[f64], &[f64]),
        (laws, yielded): (&[f64], impl Fn(f64) -> f64),
    ) {
        let slope = |at: f64, value: f64, of: &dyn Fn(f64) -> f64| {
            let step = STEP * at;
            if step == 0.0 { 0.0 } else { (of(at + step) - value) / step }
        };
        let separation = response.hereditary.separation;
        let elastic = |x: f64| response.elastic.unit(response.shape, x);
        let felt = compressions.iter().map(|&x| separation.felt(x));
        self.elastic.clear();
        self.elastic.extend(felt.map(|x| slope(x, elastic(x), &elastic)));
        self.at.clear();
        self.at.extend(force.iter().map(|&force| (force, yielded(force))));
        self.yielding.clear();
        self.yielding.extend(self.at.iter().map(|&(force, yields)| slope(force, yields, &yielded)));
        self.laws = laws.to_vec();
    }

    /// The moves, mm, of a stretch's compressions at these times, s, after which nothing is open, as far as all is straight and the base
    /// law of a stiffness p alone makes the force.
    #[must_use]
    pub fn moves(
        &self,
        (p, hereditary): (f64, &Hereditary),
        time: &[f64],
        here: &Here,
    ) -> Vec<f64> {
        let mut state = HereditaryState::default();
        hereditary.start(&mut state, None);
        let mut before: Option<f64> = None;
        let mut moves = Vec::with_capacity(time.len());
        for (k, &time) in time.iter().enumerate() {
            let interval = before.map(|before| time - before);
            before = Some(time);
            let elastic = p * self.elastic[k];
            let (held, immediate) = hereditary.affine(&mut state, k, interval);
            let moved = self.moved(k, (held, immediate * elastic), here);
            match interval {
                Some(interval) => hereditary.advance(&mut state, k, interval, elastic * moved),
                None => hereditary.jump(&mut state, elastic * moved),
            };
            moves.push(moved);
        }
        moves
    }

    /// The move, mm, of one sample whose force changes by so much, N, and with its own move by this slope, N/mm.
    fn moved(&self, k: usize, (held, slope): (f64, f64), here: &Here) -> f64 {
        let (force, yielded) = (here.force[k], here.yielded[k]);
        let (yields, yielding) = (yielded + here.open[k], self.yielding[k]);
        let (at, yields_at) = self.at[k];
        // A joint that closes yields steeply at small forces, as a power of the force, and that grows as a power of the compression: the
        // logarithms are straight, and so is the force that makes it yield so much.
        let (power, ratio) = (at * yielding / yields_at, (yielded / yields).abs());
        if !(yielding * slope > 1.0 && power > 0.0 && ratio > 0.0 && ratio.is_finite()) {
            return -(here.open[k] + yielding * held) / (1.0 + yielding * slope).max(1.0);
        }
        let compression = here.commanded[k] - yielded;
        if force * yielded > 0.0 && compression * yielded > 0.0 {
            let grows = slope * compression / force + compression / (power * yielded);
            let times = (ratio.ln() / power - held / force) / grows;
            return compression * times.clamp(-MOST_TIMES, MOST_TIMES).exp_m1();
        }
        let needed = (force.abs() * ratio.powf(1.0 / power)).copysign(yielded);
        (needed - force - held) / (needed / (yielded * power) + slope)
    }
}

/// Where a stretch is that is yet to settle, sample by sample.
#[derive(Clone, Copy, Debug)]
pub struct Here<'a> {
    /// Commanded compressions, mm.
    pub commanded: &'a [f64],
    /// What the set-up has yielded, mm.
    pub yielded: &'a [f64],
    /// By how much, mm, it yields more under the force.
    pub open: &'a [f64],
    /// The force, N.
    pub force: &'a [f64],
}

impl Response {
    /// The memory through which small moves of a compression act on the force, along the same line to either side; none where that is
    /// not the same line at every force.
    #[must_use]
    pub fn memory_of_moves(&self) -> Option<Hereditary> {
        let straight = self.form == Form::Force && self.hereditary.is_affine();
        straight.then(|| Hereditary { separation: Separation::Bonded, ..self.hereditary.clone() })
    }
}
