//! A base law with its options: a family, an elastic response and a way to relax, put together.

use std::ops::Range;

use super::coordinate::Coordinate;
use super::elastic::Elastic;
use super::growth::Growth;
use super::hereditary::Hereditary;
use super::kernel::{Kernel, MemoryOf, Span};
use super::laws::{Family, LawOption, LawParameter};
use super::response::{Form, Response};
use super::separation::Separation;
use super::{Branch, Elasticity, HereditaryState, Motion, Parameter, Relaxation};

/// Most exponentials a law may have.
pub const MAX_TERMS: usize = 4;

/// Exponentials by default (appendix A).
pub const TERMS: usize = 2;

/// A base law with its options.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseLaw {
    /// Which law.
    pub family: &'static Family,
    /// Number n of exponentials, 1 to [`MAX_TERMS`]; 1 where the family has no choice.
    pub terms: usize,
    /// What happens when contact breaks.
    pub separation: Separation,
    /// Number m of segments of the latency models; c0 is 1/m then. Where absent, c0 is a parameter.
    pub segments: Option<u32>,
    /// Exponent n of the nonlinear latency model where it is given; else it is a parameter.
    pub exponent: Option<f64>,
    /// The elastic response.
    pub elastic: Elastic,
    /// How the response relaxes.
    pub kernel: &'static Kernel,
    /// Times over which a kernel that is no sum of exponentials is followed.
    pub span: Span,
}

/// State, mm, at which the rates of a law are stated that follow it by a power.
const UNIT_STATE: f64 = 1.0;

impl BaseLaw {
    /// A law of this family with so many exponentials where it has a choice.
    #[must_use]
    pub const fn new(family: &'static Family, terms: usize, separation: Separation) -> Self {
        let terms = if family.takes(LawOption::Terms) { terms } else { 1 };
        let (segments, exponent) = (None, None);
        let (elastic, kernel, span) = (Elastic::POWER, Kernel::EXPONENTIALS, Span::WIDEST);
        Self { family, terms, separation, segments, exponent, elastic, kernel, span }
    }

    /// This law with another elastic response and another kernel.
    #[must_use]
    pub const fn with(self, elastic: Elastic, kernel: &'static Kernel) -> Self {
        let terms = if kernel.is_exponentials() { self.terms } else { 1 };
        Self { elastic, kernel, terms, ..self }
    }

    /// This law for data of these times.
    #[must_use]
    pub const fn over(self, span: Span) -> Self {
        Self { span, ..self }
    }

    /// Whether the number of exponentials can be chosen.
    #[must_use]
    pub fn has_terms(&self) -> bool {
        self.family.takes(LawOption::Terms) && self.kernel.is_exponentials()
    }

    /// Fung's law with so many exponentials.
    #[must_use]
    pub const fn fung(terms: usize, separation: Separation) -> Self {
        Self::new(Family::FUNG, terms, separation)
    }

    /// Name in model files and on the command line.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.family.name
    }

    /// The law with its options in words: `fung with 2 exponentials`.
    #[must_use]
    pub fn in_words(&self) -> String {
        let mut words = self.short_name();
        if self.has_terms() {
            let term = self.family.term[usize::from(self.terms > 1)];
            words += &format!(" with {} {term}", self.terms);
        }
        if let Some(segments) = self.segments {
            words += &format!(" with {segments} segments");
        }
        if let Some(exponent) = self.exponent {
            words += &format!(", n = {exponent}");
        }
        words
    }

    /// Its name with what differs from the family's own: `fung, gent, power-law`.
    #[must_use]
    pub fn short_name(&self) -> String {
        let elastic = (self.elastic != Elastic::POWER).then(|| self.elastic.name());
        let kernel = match self.kernel.memory {
            MemoryOf::Exponentials => None,
            MemoryOf::Nothing => Some("no relaxation"),
            MemoryOf::Spectrum { .. } => Some(self.kernel.name),
        };
        let parts = std::iter::once(self.name()).chain(elastic).chain(kernel);
        parts.collect::<Vec<_>>().join(", ")
    }

    /// Its parameters in order, with the coordinate that stands for each.
    #[must_use]
    pub fn declared(&self) -> Vec<LawParameter> {
        (self.family.parameters)(self)
    }

    /// Its parameters in order.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        self.declared().into_iter().map(Parameter::from).collect()
    }

    /// Number of parameters.
    #[must_use]
    pub fn count(&self) -> usize {
        self.declared().len()
    }

    /// Where among the parameters the one of this coordinate stands.
    fn place(&self, coordinate: Coordinate) -> Option<usize> {
        self.declared().iter().position(|parameter| parameter.coordinate == coordinate)
    }

    /// Where among the parameters those of the exponentials begin: shares (or stiffnesses), and rates (or
    /// dampings). None where there is nothing to put in order.
    #[must_use]
    pub fn branches(&self) -> Option<(usize, usize)> {
        let ordered = self.has_terms();
        ordered
            .then(|| self.place(Coordinate::Force(1)).zip(self.place(Coordinate::Rate(1))))
            .flatten()
    }

    /// Which parameters are rates of linear branches, in the order of the branches.
    #[must_use]
    pub fn rates(&self) -> Range<usize> {
        let linear = self.family.linear_memory && self.kernel.is_exponentials();
        match self.place(Coordinate::Rate(1)) {
            Some(first) if linear => first..first + self.terms,
            _ => 0..0,
        }
    }

    /// What the law makes of these parameters (more may follow).
    #[must_use]
    pub fn response(&self, parameters: &[f64]) -> Response {
        let constants = self.constants(parameters);
        let mut hereditary = Hereditary::linear(Vec::new(), self.separation);
        hereditary.damper = constants.viscosity;
        if let MemoryOf::Spectrum { of, .. } = self.kernel.memory {
            let share = constants.shares[0];
            let rate = constants.rates.first().copied().unwrap_or(1.0);
            let spectrum = of(rate, constants.order, self.span);
            hereditary.branches = spectrum.branches;
            hereditary.branches.iter_mut().for_each(|branch| branch.share *= share);
            hereditary.viscosity = share * spectrum.viscosity;
            // Of the elastic response c0 = 1 − c1 stays, whatever the branches sum to.
            let sum: f64 = hereditary.branches.iter().map(|branch| branch.share).sum();
            hereditary.on_top = sum - share;
        } else {
            let branch = |(&share, &rate): (&f64, &f64)| Branch { share, rate };
            let branches = constants.shares.iter().zip(&constants.rates).map(branch);
            hereditary.branches = branches.collect();
        }
        hereditary.retarded = self.family.retarded;
        if constants.exponent != 1.0 {
            hereditary.growth = Growth::Power(constants.exponent - 1.0, UNIT_STATE);
        }
        let Constants { p, shape, .. } = constants;
        Response { form: self.family.form, elastic: self.elastic, p, shape, hereditary }
    }

    /// How a hold relaxes: the share and rate of each exponential (eq. 3.3). None where it is no sum of
    /// exponentials of the held compression.
    #[must_use]
    pub fn relaxation(&self, parameters: &[f64]) -> Option<Relaxation> {
        let Constants { shares, rates, exponent, .. } = self.constants(parameters);
        let exponential = exponent == 1.0
            && !rates.is_empty()
            && self.kernel.is_exponentials()
            && self.family.form != Form::Compression;
        exponential.then(|| Relaxation::new(&shares, &rates))
    }

    /// The constants that all laws share, from the law's own parameters (more may follow).
    #[must_use]
    pub fn constants(&self, parameters: &[f64]) -> Constants {
        (self.family.constants)(self, parameters)
    }

    /// The law's own parameters from the constants that all laws share.
    #[must_use]
    pub fn parameters_of(&self, constants: &Constants) -> Vec<f64> {
        (self.family.values)(self, constants)
    }

    /// Predicts the force of each motion of a data set, N, in order of recording.
    ///
    /// A motion that starts in contact counts as having just arrived there.
    #[must_use]
    pub fn predict(&self, parameters: &[f64], motions: &[Motion]) -> Vec<Vec<f64>> {
        let response = self.response(parameters);
        let (mut state, mut elasticity) = (HereditaryState::default(), Elasticity::default());
        motions
            .iter()
            .map(|motion| {
                let mut force = Vec::new();
                let unchanged = |_: &[f64], _: &mut [f64]| {};
                response.run(
                    (&motion.time, &motion.displacement, motion.rest_before),
                    (&mut state, &mut elasticity),
                    unchanged,
                    &mut force,
                );
                force
            })
            .collect()
    }
}

/// The constants that all laws share: the elastic response, branches, and what bends them.
#[derive(Clone, Debug, PartialEq)]
pub struct Constants {
    /// Stiffness p of the elastic response: N/mm^(q+1) of the power law, N of a law of the stretch.
    pub p: f64,
    /// Shape of the elastic response: exponent q of the power law.
    pub shape: f64,
    /// Share of each branch, or of the kernel, 0 to 1.
    pub shares: Vec<f64>,
    /// Rate of each branch, 1/s; of the nonlinear latency model at a state of 1 mm; 1/τ of a stretched
    /// exponential.
    pub rates: Vec<f64>,
    /// Power n of the state that its rate of change follows; 1 for a linear law.
    pub exponent: f64,
    /// Order β of a kernel that is no sum of exponentials.
    pub order: f64,
    /// Viscosity of a damper beside the spring over its stiffness, s.
    pub viscosity: f64,
}

impl Constants {
    /// An elastic response alone.
    #[must_use]
    pub const fn new(p: f64, shape: f64) -> Self {
        Self {
            p,
            shape,
            shares: Vec::new(),
            rates: Vec::new(),
            exponent: 1.0,
            order: 1.0,
            viscosity: 0.0,
        }
    }

    /// Share of the elastic response that never relaxes.
    #[must_use]
    pub fn equilibrium(&self) -> f64 {
        1.0 - self.shares.iter().sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Hold, Move, Profile, Step};

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
        let law = BaseLaw::fung(2, separation);
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

    /// ∫ g from `a` to `b`, s, of a kernel that is no sum of exponentials.
    fn integral(kernel: &Kernel, own: &[f64], a: f64, b: f64) -> f64 {
        let g = |t: f64| match kernel.name {
            "power-law" => 1.0 - own[0] + own[0] * t.powf(-own[1]),
            _ => 1.0 - own[0] + own[0] * (-(t / own[1]).powf(own[2])).exp(),
        };
        // In w, t = a + (b − a) w^8, what is steep near t = 0 is smooth.
        let rule = gauss_quad::GaussLegendre::new(std::num::NonZero::new(120).unwrap());
        rule.integrate(0.0, 1.0, |w: f64| g(a + (b - a) * w.powi(8)) * (b - a) * 8.0 * w.powi(7))
    }

    #[test]
    fn kernels_agree_with_the_integral_over_any_motion() {
        // A linear elastic response over ramps and a hold, sampled unevenly; F is the sum over the ramps
        // of their rate times the integral of g over the time since.
        let corners = [(0.0, 0.0), (0.31, 2.0), (4.0, 2.0), (4.2, 0.8), (9.0, 0.8), (13.0, 3.0)];
        let mut time = vec![0.0];
        for pair in corners.windows(2) {
            let count = 40;
            // Dense after each corner, thin before the next.
            let place = |k: i32| {
                pair[0].0 + (pair[1].0 - pair[0].0) * (f64::from(k) / f64::from(count)).powi(2)
            };
            time.extend((1..=count).map(place));
        }
        let x = |t: f64| {
            let pair = corners.windows(2).find(|pair| t <= pair[1].0).unwrap();
            pair[0].1 + (pair[1].1 - pair[0].1) * (t - pair[0].0) / (pair[1].0 - pair[0].0)
        };
        let displacement: Vec<f64> = time.iter().map(|&t| x(t)).collect();
        let motion = Motion {
            time: time.clone().into(),
            displacement: displacement.into(),
            rest_before: None,
        };
        let shortest = time.windows(2).map(|pair| pair[1] - pair[0]).fold(1.0, f64::min);
        for (kernel, own) in [
            (Kernel::POWER_LAW, vec![0.7, 0.12]),
            (Kernel::POWER_LAW, vec![1.0, 0.6]),
            (Kernel::STRETCHED, vec![0.6, 0.4, 0.35]),
            (Kernel::STRETCHED, vec![0.9, 3.0, 0.8]),
        ] {
            for span in [Span::WIDEST, Span::of(shortest, 13.0)] {
                let law =
                    BaseLaw::fung(1, Separation::Bonded).with(Elastic::POWER, kernel).over(span);
                let parameters = [&[0.5, 0.0], &own[..]].concat();
                let force = law.predict(&parameters, std::slice::from_ref(&motion)).remove(0);
                for (k, &t) in time.iter().enumerate().skip(1) {
                    let part = |pair: &[(f64, f64)]| {
                        let (from, to) = (pair[0].0, pair[1].0.min(t));
                        if to <= from {
                            return 0.0;
                        }
                        let rate = (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0);
                        rate * integral(kernel, &own, t - to, t - from)
                    };
                    let exact = 0.5 * corners.windows(2).map(part).sum::<f64>();
                    let off = (force[k] - exact).abs();
                    assert!(off < 1e-4, "{kernel:?} {own:?} at {t} s: {} {exact}", force[k]);
                }
            }
        }
    }

    #[test]
    fn a_rest_between_traces_counts_as_time_at_the_last_place() {
        let law = BaseLaw::fung(2, Separation::Bonded);
        let whole = press();
        let cut = 300;
        let part = |range: Range<usize>, rest_before| Motion {
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
