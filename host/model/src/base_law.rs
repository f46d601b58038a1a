//! The base laws: the dissertation's models, each as one declaration of its parameters and of how they
//! make a response.
//!
//! All of them are an elastic response N(x), p/(q+1) x^(q+1) (eq. 3.2) or a law of the stretch
//! ([`Elastic`]), and a memory of exponential branches or of another [`Kernel`]; they differ in what the
//! memory acts on ([`Form`]), in what is held fixed, and in the names and units by which people know
//! their parameters.

use std::ops::Range;

use super::elastic::{EXPONENTS_Q, Elastic, parameter};
use super::family::{Family, Separation};
use super::growth::Growth;
use super::hereditary::Hereditary;
use super::kernel::{Kernel, Span};
use super::response::{Form, Response};
use super::{Branch, Elasticity, HereditaryState, Motion, Parameter, Relaxation};

/// Most exponentials a law may have.
pub const MAX_TERMS: usize = 4;

/// Exponentials by default (appendix A).
pub const TERMS: usize = 2;

/// A base law with its options.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseLaw {
    /// Which law.
    pub family: Family,
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
    pub kernel: Kernel,
    /// Times over which a kernel that is no sum of exponentials is followed.
    pub span: Span,
}

const SHARES: [&str; MAX_TERMS] = ["c1", "c2", "c3", "c4"];
const RATES: [&str; MAX_TERMS] = ["v1", "v2", "v3", "v4"];
const STIFFNESSES: [&str; MAX_TERMS] = ["k1", "k2", "k3", "k4"];
const DAMPINGS: [&str; MAX_TERMS] = ["eta1", "eta2", "eta3", "eta4"];

const POSITIVE: (f64, f64) = (0.0, f64::INFINITY);
/// The exponents n that the nonlinear latency model may have.
pub const EXPONENTS_N: (f64, f64) = (1.0, 9.0);

/// Latent compression, mm, at which the rate ν of the nonlinear latency model is stated.
const UNIT_LATENT: f64 = 1.0;
/// A share c0 of zero would take an infinite latent strain; far below any that data tell.
const SMALLEST_SHARE: f64 = 1e-9;

impl BaseLaw {
    /// A law of this family with so many exponentials where it has a choice.
    #[must_use]
    pub const fn new(family: Family, terms: usize, separation: Separation) -> Self {
        let terms = if family.has_terms() { terms } else { 1 };
        let (segments, exponent) = (None, None);
        let (elastic, kernel, span) = (Elastic::Power, Kernel::Exponentials, Span::WIDEST);
        Self { family, terms, separation, segments, exponent, elastic, kernel, span }
    }

    /// This law with another elastic response and another kernel.
    #[must_use]
    pub const fn with(self, elastic: Elastic, kernel: Kernel) -> Self {
        let terms = if matches!(kernel, Kernel::Exponentials) { self.terms } else { 1 };
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
        self.family.has_terms() && self.kernel == Kernel::Exponentials
    }

    /// Fung's law with so many exponentials.
    #[must_use]
    pub const fn fung(terms: usize, separation: Separation) -> Self {
        Self::new(Family::Fung, terms, separation)
    }

    /// Name in model files and on the command line.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.family.name()
    }

    /// The law with its options in words: `fung with 2 exponentials`.
    #[must_use]
    pub fn in_words(&self) -> String {
        let name = self.short_name();
        let plural = if self.terms == 1 { "" } else { "s" };
        let mut words = match self.family {
            _ if self.kernel != Kernel::Exponentials => name,
            Family::Fung | Family::Creep => {
                format!("{name} with {} exponential{plural}", self.terms)
            }
            Family::GeneralizedMaxwell => {
                format!(
                    "{name} with {} branch{}",
                    self.terms,
                    if self.terms == 1 { "" } else { "es" }
                )
            }
            _ => name,
        };
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
        let elastic = (self.elastic != Elastic::Power).then(|| self.elastic.name());
        let kernel = match self.kernel {
            Kernel::Exponentials => None,
            Kernel::None => Some("no relaxation"),
            kernel => Some(kernel.name()),
        };
        let parts = std::iter::once(self.name()).chain(elastic).chain(kernel);
        parts.collect::<Vec<_>>().join(", ")
    }

    /// Least exponent q of its power law.
    #[must_use]
    pub const fn least_q(&self) -> f64 {
        match self.family {
            Family::Latency | Family::LatencyPower => 0.0,
            _ => EXPONENTS_Q.0,
        }
    }

    /// Its parameters in order.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        let n = self.terms;
        let each = |names: &[&'static str; MAX_TERMS], unit, meaning, range| {
            let one = move |name: &&'static str| parameter(name, unit, meaning, range);
            names[..n].iter().map(one).collect::<Vec<_>>()
        };
        let rates = |meaning| each(&RATES, "1/s", meaning, POSITIVE);
        let equilibrium = |parameters: &mut Vec<Parameter>| {
            if self.segments.is_none() {
                let meaning = "share of the elastic response that never relaxes";
                parameters.push(parameter("c0", "", meaning, (0.0, 1.0)));
            }
        };
        let elastic = self.elastic.parameters(self.least_q());
        match self.family {
            Family::KelvinVoigt | Family::Maxwell => vec![
                parameter("k", "N/mm", "stiffness of the spring", POSITIVE),
                parameter("eta", "N·s/mm", "damping of the damper", POSITIVE),
            ],
            Family::GeneralizedMaxwell => {
                let spring =
                    parameter("k0", "N/mm", "stiffness of the spring that stands alone", POSITIVE);
                let springs =
                    each(&STIFFNESSES, "N/mm", "stiffness of a branch's spring", POSITIVE);
                let dampers = each(&DAMPINGS, "N·s/mm", "damping of a branch's damper", POSITIVE);
                [vec![spring], springs, dampers].concat()
            }
            Family::Fung if self.kernel != Kernel::Exponentials => {
                [elastic, self.kernel.parameters()].concat()
            }
            Family::Fung => {
                let share = "share of the elastic response that relaxes at this rate";
                [elastic, each(&SHARES, "", share, (0.0, 1.0)), rates("rate of relaxation")]
                    .concat()
            }
            Family::Latency => {
                let mut parameters = elastic;
                equilibrium(&mut parameters);
                parameters.push(parameter(
                    "v1",
                    "1/s",
                    "rate at which the latent strain relaxes",
                    POSITIVE,
                ));
                parameters
            }
            Family::LatencyPower => {
                let mut parameters = elastic;
                equilibrium(&mut parameters);
                let meaning = "rate, 1/s, at which a latent compression of 1 mm relaxes";
                parameters.push(parameter("nu", "1/(s·mm^(n−1))", meaning, POSITIVE));
                if self.exponent.is_none() {
                    let meaning = "power of the latent strain that its rate follows";
                    parameters.push(parameter("n", "", meaning, EXPONENTS_N));
                }
                parameters
            }
            Family::Creep => {
                let share = "part of the settled compression that comes late, at this rate";
                [elastic, each(&SHARES, "", share, (-1.0, 0.0)), rates("rate of creep")].concat()
            }
        }
    }

    /// Number of parameters.
    #[must_use]
    pub fn count(&self) -> usize {
        let fixed = usize::from(self.segments.is_some()) + usize::from(self.exponent.is_some());
        let elastic = self.elastic.count();
        match self.family {
            Family::KelvinVoigt | Family::Maxwell => 2,
            Family::GeneralizedMaxwell => 1 + 2 * self.terms,
            Family::Fung if self.kernel != Kernel::Exponentials => elastic + self.kernel.count(),
            Family::Fung | Family::Creep => elastic + 2 * self.terms,
            Family::Latency => elastic + 2 - fixed,
            Family::LatencyPower => elastic + 3 - fixed,
        }
    }

    /// Where among the parameters those of the exponentials begin: shares (or stiffnesses), and rates (or
    /// dampings). None where there is nothing to put in order.
    #[must_use]
    pub fn branches(&self) -> Option<(usize, usize)> {
        let elastic = self.elastic.count();
        match self.family {
            _ if self.kernel != Kernel::Exponentials => None,
            Family::GeneralizedMaxwell => Some((1, 1 + self.terms)),
            Family::Fung | Family::Creep => Some((elastic, elastic + self.terms)),
            _ => None,
        }
    }

    /// Which parameters tell rates of linear branches, in the order of the branches.
    #[must_use]
    pub fn rates(&self) -> Range<usize> {
        match (self.family, self.branches()) {
            (_, Some((_, rates))) => rates..rates + self.terms,
            (Family::Maxwell, _) => 1..2,
            (Family::Latency, _) => self.count() - 1..self.count(),
            _ => 0..0,
        }
    }

    /// What the law makes of these parameters (more may follow).
    #[must_use]
    pub fn response(&self, parameters: &[f64]) -> Response {
        let constants = self.constants(parameters);
        let mut hereditary = Hereditary::linear(Vec::new(), self.separation);
        hereditary.viscosity = constants.viscosity;
        if matches!(self.kernel, Kernel::Exponentials | Kernel::None) {
            let branch = |(&share, &rate): (&f64, &f64)| Branch { share, rate };
            let branches = constants.shares.iter().zip(&constants.rates).map(branch);
            hereditary.branches = branches.collect();
        } else {
            let share = constants.shares[0];
            let rate = constants.rates.first().copied().unwrap_or(1.0);
            let spectrum = self.kernel.spectrum(rate, constants.order, self.span);
            hereditary.branches = spectrum.branches;
            hereditary.branches.iter_mut().for_each(|branch| branch.share *= share);
            hereditary.viscosity = share * spectrum.viscosity;
            // Of the elastic response c0 = 1 − c1 stays, whatever the branches sum to.
            let sum: f64 = hereditary.branches.iter().map(|branch| branch.share).sum();
            hereditary.on_top = sum - share;
        }
        hereditary.retarded = self.family == Family::Creep;
        if constants.exponent != 1.0 {
            hereditary.growth = Growth::Power(constants.exponent - 1.0, UNIT_LATENT);
        }
        let Constants { p, shape, .. } = constants;
        Response { form: self.form(), elastic: self.elastic, p, shape, hereditary }
    }

    /// How a hold relaxes: the share and rate of each exponential (eq. 3.3). None where it is no sum of
    /// exponentials of the held compression.
    #[must_use]
    pub fn relaxation(&self, parameters: &[f64]) -> Option<Relaxation> {
        let Constants { shares, rates, exponent, .. } = self.constants(parameters);
        let exponential = exponent == 1.0
            && !rates.is_empty()
            && self.kernel == Kernel::Exponentials
            && self.form() != Form::Compression;
        exponential.then(|| Relaxation::new(&shares, &rates))
    }

    /// What the memory acts on.
    #[must_use]
    pub const fn form(&self) -> Form {
        match self.family {
            Family::Latency | Family::LatencyPower => Form::Strain,
            Family::Creep => Form::Compression,
            _ => Form::Force,
        }
    }

    /// The constants that all families share, from the family's own parameters.
    #[must_use]
    pub fn constants(&self, parameters: &[f64]) -> Constants {
        let n = self.terms;
        let spring = |k: f64| k.max(f64::MIN_POSITIVE.sqrt());
        let (p, shape) = match self.family.is_linear() {
            true => (0.0, 0.0),
            false => self.elastic.constants(parameters),
        };
        let rest = &parameters[self.elastic.count().min(parameters.len())..];
        match self.family {
            Family::KelvinVoigt => Constants {
                viscosity: parameters[1] / spring(parameters[0]),
                ..Constants::new(parameters[0], 0.0)
            },
            Family::Maxwell => Constants {
                shares: vec![1.0],
                rates: vec![parameters[0] / spring(parameters[1])],
                ..Constants::new(parameters[0], 0.0)
            },
            Family::GeneralizedMaxwell => {
                let (springs, dampers) = parameters[..self.count()].split_at(n + 1);
                let total: f64 = springs.iter().sum();
                let rate = |(k, eta): (&f64, &f64)| k / spring(*eta);
                Constants {
                    shares: springs[1..].iter().map(|k| k / spring(total)).collect(),
                    rates: springs[1..].iter().zip(dampers).map(rate).collect(),
                    ..Constants::new(total, 0.0)
                }
            }
            Family::Fung if self.kernel != Kernel::Exponentials => {
                let own = &rest[..self.kernel.count()];
                let (shares, rates, order) = match *own {
                    [share, order] => (vec![share], vec![], order),
                    [share, tau, order] => (vec![share], vec![1.0 / spring(tau)], order),
                    _ => (vec![], vec![], 1.0),
                };
                Constants { shares, rates, order, ..Constants::new(p, shape) }
            }
            Family::Fung | Family::Creep => {
                let (shares, rates) = rest[..2 * n].split_at(n);
                let sign = if self.family == Family::Creep { -1.0 } else { 1.0 };
                Constants {
                    shares: shares.iter().map(|share| sign * share).collect(),
                    rates: rates.to_vec(),
                    ..Constants::new(p, shape)
                }
            }
            Family::Latency | Family::LatencyPower => {
                let (equilibrium, rest) = match self.segments {
                    Some(segments) => (1.0 / f64::from(segments), rest),
                    None => (rest[0].max(SMALLEST_SHARE), &rest[1..]),
                };
                let exponent = match self.family {
                    Family::Latency => 1.0,
                    _ => self.exponent.unwrap_or_else(|| rest[1]),
                };
                // The branch carries y, the latent compression is y c1/c0.
                let latent = (1.0 - equilibrium) / equilibrium;
                Constants {
                    shares: vec![1.0 - equilibrium],
                    rates: vec![rest[0] * (latent / UNIT_LATENT).powf(exponent - 1.0)],
                    exponent,
                    ..Constants::new(p, shape)
                }
            }
        }
    }

    /// The family's own parameters from the constants that all families share.
    #[must_use]
    pub fn parameters_of(&self, constants: &Constants) -> Vec<f64> {
        let Constants { p, shape, shares, rates, exponent, order, viscosity } = constants;
        let equilibrium = 1.0 - shares.iter().sum::<f64>();
        let elastic = self.elastic.parameters_of(*p, *shape);
        match self.family {
            Family::KelvinVoigt => vec![*p, viscosity * p],
            Family::Maxwell => vec![*p, p / rates[0]],
            Family::GeneralizedMaxwell => {
                let springs = shares.iter().map(|share| share * p);
                let dampers = shares.iter().zip(rates).map(|(share, rate)| share * p / rate);
                std::iter::once(equilibrium * p).chain(springs).chain(dampers).collect()
            }
            Family::Fung => {
                let kernel = match self.kernel {
                    Kernel::Exponentials => [&shares[..], &rates[..]].concat(),
                    Kernel::PowerLaw => vec![shares[0], *order],
                    Kernel::Stretched => vec![shares[0], 1.0 / rates[0], *order],
                    Kernel::None => vec![],
                };
                [elastic, kernel].concat()
            }
            Family::Creep => {
                let shares: Vec<f64> = shares.iter().map(|share| -share).collect();
                [&elastic, &shares[..], &rates[..]].concat()
            }
            Family::Latency | Family::LatencyPower => {
                let equilibrium = equilibrium.max(SMALLEST_SHARE);
                let latent = (1.0 - equilibrium) / equilibrium;
                let rate = rates[0] / (latent / UNIT_LATENT).powf(exponent - 1.0);
                let mut parameters = elastic;
                if self.segments.is_none() {
                    parameters.push(equilibrium);
                }
                parameters.push(rate);
                if self.family == Family::LatencyPower && self.exponent.is_none() {
                    parameters.push(*exponent);
                }
                parameters
            }
        }
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

/// The constants that all families share: the elastic response, branches, and what bends them.
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
    fn integral(kernel: Kernel, own: &[f64], a: f64, b: f64) -> f64 {
        let g = |t: f64| match kernel {
            Kernel::PowerLaw => 1.0 - own[0] + own[0] * t.powf(-own[1]),
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
            (Kernel::PowerLaw, vec![0.7, 0.12]),
            (Kernel::PowerLaw, vec![1.0, 0.6]),
            (Kernel::Stretched, vec![0.6, 0.4, 0.35]),
            (Kernel::Stretched, vec![0.9, 3.0, 0.8]),
        ] {
            for span in [Span::WIDEST, Span::of(shortest, 13.0)] {
                let law =
                    BaseLaw::fung(1, Separation::Bonded).with(Elastic::Power, kernel).over(span);
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
