//! From the compression to the force: an elastic response and a memory, in the order of the law's form.

use super::hereditary::{Hereditary, HereditaryState};
use super::yielding::Yielding;
use super::{Elastic, Elasticity};

/// What the memory of a law acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// On the force: F = ∫ g(t−s) dN(x(s)) (eq. 2.1).
    Force,
    /// On the strain: F = N(x) ε/x with the strain at the contact ε = ∫ g(t−s) dx (eqs 4.1, 7.11).
    Strain,
    /// On the compression: F = N(D), where D is such that x = ∫ h(t−s) dD(s) (eqs 6.1, 6.2).
    Compression,
}

/// A base law with its numbers: what makes a force of a compression.
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// What the memory acts on.
    pub form: Form,
    /// The elastic response.
    pub elastic: Elastic,
    /// Its stiffness p.
    pub p: f64,
    /// Its shape: the exponent q of the power law.
    pub shape: f64,
    /// The memory.
    pub hereditary: Hereditary,
}

/// Compression, mm, below which the ratio N/x is not formed.
const TOUCHING: f64 = 1e-9;

impl Response {
    /// The specimen at rest is taken to a compression, mm, at once; the force, N.
    #[must_use]
    pub fn begin(&self, state: &mut HereditaryState, x: f64) -> f64 {
        self.sample(x, |input| self.hereditary.begin(state, input))
    }

    /// The compression goes on to x, mm, within an interval, s; the force, N.
    #[must_use]
    pub fn advance(&self, state: &mut HereditaryState, interval: f64, x: f64) -> f64 {
        self.sample(x, |input| self.hereditary.advance(state, 0, interval, input))
    }

    /// One sample: what goes into the memory, and what its answer means.
    fn sample(&self, x: f64, memory: impl FnOnce(f64) -> f64) -> f64 {
        let separation = self.hereditary.separation;
        let x = separation.felt(x);
        let elastic = |x| self.p * self.elastic.unit(self.shape, x);
        let force = match self.form {
            Form::Force => memory(elastic(x)),
            Form::Strain => {
                let strain = memory(x);
                if x.abs() > TOUCHING { elastic(x) / x * strain } else { 0.0 }
            }
            Form::Compression => elastic(memory(x)),
        };
        separation.carried(force)
    }

    /// Compression, mm, at which a sudden press of a specimen at rest gives this force, N.
    #[must_use]
    pub fn sudden_compression(&self, force: f64) -> f64 {
        reaching(force, 0.0, |x| self.begin(&mut HereditaryState::default(), x))
    }

    /// Compression, mm, that keeps the force at this value, N, at the end of an interval, s; it is not
    /// below `least`, mm.
    #[must_use]
    pub fn keeping(&self, state: &HereditaryState, interval: f64, force: f64, least: f64) -> f64 {
        reaching(force, least, |x| self.advance(&mut state.clone(), interval, x))
    }

    /// Stiffness dF/dx, N/mm, with which a specimen at rest meets a sudden move at a compression, mm.
    #[must_use]
    pub fn stiffness(&self, x: f64) -> f64 {
        let step = 1e-4 * x.abs().max(1e-3);
        let sudden = |to: f64| self.begin(&mut HereditaryState::default(), to);
        (sudden(x + step) - sudden(x - step)) / (2.0 * step)
    }

    /// Whether a set-up that yields can be followed sample by sample.
    #[must_use]
    pub fn can_yield(&self) -> bool {
        self.form != Form::Compression && self.hereditary.is_affine()
    }

    /// Runs over one stretch of a set-up that yields: times, s, commanded compressions x, mm, and the rest
    /// before, s. `next` is where the set-up comes to, mm, at a commanded compression, mm, under a force, N.
    /// The force, N, goes to `force`. Only where it [can yield](Self::can_yield).
    pub fn run_yielding(
        &self,
        (time, x, rest): (&[f64], &[f64], Option<f64>),
        state: &mut HereditaryState,
        next: impl Fn(f64, f64) -> f64,
        force: &mut Vec<f64>,
    ) {
        self.hereditary.start(state, rest);
        force.clear();
        let mut yielding = Yielding::default();
        let mut before = None;
        for (k, (&time, &x)) in time.iter().zip(x).enumerate() {
            let interval = before.map(|before: f64| time - before);
            before = Some(time);
            let (held, immediate) = self.hereditary.affine(state, k, interval);
            let under = |z: f64| self.sample(z, |input| held + immediate * input);
            let reached = yielding.reached(x, |z| next(x, under(z)));
            force.push(self.sample(reached, |input| match interval {
                Some(interval) => self.hereditary.advance(state, k, interval, input),
                None => self.hereditary.jump(state, input),
            }));
        }
    }

    /// Runs over one stretch: times, s, compressions x, mm, and the rest before, s (none where all is
    /// forgotten). `change` may change the elastic response N (last), N, at a compression, mm. The force,
    /// N, goes to `force`.
    pub fn run(
        &self,
        (time, x, rest): (&[f64], &[f64], Option<f64>),
        (state, elasticity): (&mut HereditaryState, &mut Elasticity),
        mut change: impl FnMut(&[f64], &mut [f64]),
        force: &mut Vec<f64>,
    ) {
        let separation = self.hereditary.separation;
        let law = (self.elastic, separation);
        let mut respond = |x: &[f64]| elasticity.response(law, (self.p, self.shape), x);
        // A law of one's own may act on a displacement off the specimen.
        let felt = match self.form {
            Form::Force if self.elastic == Elastic::POWER => x.into(),
            _ => separation.all_felt(x),
        };
        match self.form {
            Form::Force => {
                let mut elastic = respond(&felt);
                change(&felt, &mut elastic);
                self.hereditary.run(time, &elastic, rest, state, force);
            }
            Form::Strain => {
                let mut elastic = respond(&felt);
                change(&felt, &mut elastic);
                self.hereditary.run(time, &felt, rest, state, force);
                for ((strain, elastic), x) in force.iter_mut().zip(&elastic).zip(&*felt) {
                    *strain *= if x.abs() > TOUCHING { elastic / x } else { 0.0 };
                }
            }
            Form::Compression => {
                let mut settled = Vec::new();
                self.hereditary.run(time, &felt, rest, state, &mut settled);
                *force = respond(&settled);
                change(&settled, force);
            }
        }
    }
}

/// Largest compression that is searched, mm.
const FARTHEST: f64 = 1e6;

/// Where a force that grows with the compression x ≥ `least`, mm, reaches a value, N.
fn reaching(wanted: f64, least: f64, force: impl Fn(f64) -> f64) -> f64 {
    let mut step = 1e-3 * least.max(1.0);
    while force(least + step) < wanted && step < FARTHEST {
        step *= 2.0;
    }
    let (mut below, mut above) = (least, least + step);
    // Halving to the last bit; each law is one evaluation.
    while above - below > 1e-14 * above {
        let middle = 0.5 * (below + above);
        if middle <= below || middle >= above {
            break;
        }
        if force(middle) < wanted { below = middle } else { above = middle }
    }
    above
}
