//! The base laws: the dissertation's models, each as one declaration of its parameters and of how they
//! make a response.
//!
//! All of them are an elastic response N(x) = p/(q+1) x^(q+1) (eq. 3.2) and a memory of exponential
//! branches; they differ in what the branches act on ([`Form`]), in what is held fixed, and in the names
//! and units by which people know their parameters.

use std::ops::Range;

use super::family::{Family, Separation};
use super::growth::Growth;
use super::hereditary::Hereditary;
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
}

const SHARES: [&str; MAX_TERMS] = ["c1", "c2", "c3", "c4"];
const RATES: [&str; MAX_TERMS] = ["v1", "v2", "v3", "v4"];
const STIFFNESSES: [&str; MAX_TERMS] = ["k1", "k2", "k3", "k4"];
const DAMPINGS: [&str; MAX_TERMS] = ["eta1", "eta2", "eta3", "eta4"];

const POSITIVE: (f64, f64) = (0.0, f64::INFINITY);
const EXPONENTS_Q: (f64, f64) = (-0.9, 6.0);
/// The exponents n that the nonlinear latency model may have.
pub const EXPONENTS_N: (f64, f64) = (1.0, 9.0);

/// Latent compression, mm, at which the rate ν of the nonlinear latency model is stated.
const UNIT_LATENT: f64 = 1.0;
/// A share c0 of zero would take an infinite latent strain; far below any that data tell.
const SMALLEST_SHARE: f64 = 1e-9;

fn parameter(
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    (lower, upper): (f64, f64),
) -> Parameter {
    Parameter { name: name.into(), unit: unit.into(), meaning: meaning.into(), lower, upper }
}

impl BaseLaw {
    /// A law of this family with so many exponentials where it has a choice.
    #[must_use]
    pub const fn new(family: Family, terms: usize, separation: Separation) -> Self {
        let terms = if family.has_terms() { terms } else { 1 };
        Self { family, terms, separation, segments: None, exponent: None }
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
        let name = self.name();
        let plural = if self.terms == 1 { "" } else { "s" };
        let mut words = match self.family {
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
            _ => name.to_owned(),
        };
        if let Some(segments) = self.segments {
            words += &format!(" with {segments} segments");
        }
        if let Some(exponent) = self.exponent {
            words += &format!(", n = {exponent}");
        }
        words
    }

    /// Its parameters in order.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        let p = || parameter("p", "N/mm^(q+1)", "stiffness of the elastic response", POSITIVE);
        let q = |lower: f64| {
            let meaning = "exponent by which the stiffness grows with compression";
            parameter("q", "", meaning, (lower, EXPONENTS_Q.1))
        };
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
            Family::Fung => {
                let share = "share of the elastic response that relaxes at this rate";
                [
                    vec![p(), q(EXPONENTS_Q.0)],
                    each(&SHARES, "", share, (0.0, 1.0)),
                    rates("rate of relaxation"),
                ]
                .concat()
            }
            Family::Latency => {
                let mut parameters = vec![p(), q(0.0)];
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
                let mut parameters = vec![p(), q(0.0)];
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
                let p = parameter("p", "N/mm^(q+1)", "stiffness of the settled response", POSITIVE);
                [
                    vec![p, q(EXPONENTS_Q.0)],
                    each(&SHARES, "", share, (-1.0, 0.0)),
                    rates("rate of creep"),
                ]
                .concat()
            }
        }
    }

    /// Number of parameters.
    #[must_use]
    pub fn count(&self) -> usize {
        let fixed = usize::from(self.segments.is_some()) + usize::from(self.exponent.is_some());
        match self.family {
            Family::KelvinVoigt | Family::Maxwell => 2,
            Family::GeneralizedMaxwell => 1 + 2 * self.terms,
            Family::Fung | Family::Creep => 2 + 2 * self.terms,
            Family::Latency => 4 - fixed,
            Family::LatencyPower => 5 - fixed,
        }
    }

    /// Where among the parameters those of the exponentials begin: shares (or stiffnesses), and rates (or
    /// dampings). None where there is nothing to put in order.
    #[must_use]
    pub fn branches(&self) -> Option<(usize, usize)> {
        match self.family {
            Family::GeneralizedMaxwell => Some((1, 1 + self.terms)),
            Family::Fung | Family::Creep => Some((2, 2 + self.terms)),
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
        let branch = |(&share, &rate): (&f64, &f64)| Branch { share, rate };
        let branches = constants.shares.iter().zip(&constants.rates).map(branch).collect();
        let mut hereditary = Hereditary::linear(branches, self.separation);
        hereditary.retarded = self.family == Family::Creep;
        hereditary.viscosity = constants.viscosity;
        if constants.exponent != 1.0 {
            hereditary.growth = Growth::Power(constants.exponent - 1.0, UNIT_LATENT);
        }
        Response { form: self.form(), p: constants.p, q: constants.q, hereditary }
    }

    /// How a hold relaxes: the share and rate of each exponential (eq. 3.3). None where it is no sum of
    /// exponentials of the held compression.
    #[must_use]
    pub fn relaxation(&self, parameters: &[f64]) -> Option<Relaxation> {
        let Constants { shares, rates, exponent, .. } = self.constants(parameters);
        let exponential = exponent == 1.0 && !rates.is_empty() && self.form() != Form::Compression;
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
            Family::Fung | Family::Creep => {
                let (shares, rates) = parameters[2..self.count()].split_at(n);
                let sign = if self.family == Family::Creep { -1.0 } else { 1.0 };
                Constants {
                    shares: shares.iter().map(|share| sign * share).collect(),
                    rates: rates.to_vec(),
                    ..Constants::new(parameters[0], parameters[1])
                }
            }
            Family::Latency | Family::LatencyPower => {
                let (equilibrium, rest) = match self.segments {
                    Some(segments) => (1.0 / f64::from(segments), &parameters[2..]),
                    None => (parameters[2].max(SMALLEST_SHARE), &parameters[3..]),
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
                    ..Constants::new(parameters[0], parameters[1])
                }
            }
        }
    }

    /// The family's own parameters from the constants that all families share.
    #[must_use]
    pub fn parameters_of(&self, constants: &Constants) -> Vec<f64> {
        let Constants { p, q, shares, rates, exponent, viscosity } = constants;
        let equilibrium = 1.0 - shares.iter().sum::<f64>();
        match self.family {
            Family::KelvinVoigt => vec![*p, viscosity * p],
            Family::Maxwell => vec![*p, p / rates[0]],
            Family::GeneralizedMaxwell => {
                let springs = shares.iter().map(|share| share * p);
                let dampers = shares.iter().zip(rates).map(|(share, rate)| share * p / rate);
                std::iter::once(equilibrium * p).chain(springs).chain(dampers).collect()
            }
            Family::Fung => [&[*p, *q], &shares[..], &rates[..]].concat(),
            Family::Creep => {
                let shares: Vec<f64> = shares.iter().map(|share| -share).collect();
                [&[*p, *q], &shares[..], &rates[..]].concat()
            }
            Family::Latency | Family::LatencyPower => {
                let equilibrium = equilibrium.max(SMALLEST_SHARE);
                let latent = (1.0 - equilibrium) / equilibrium;
                let rate = rates[0] / (latent / UNIT_LATENT).powf(exponent - 1.0);
                let mut parameters = vec![*p, *q];
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

/// The constants that all families share: N(x) = p/(q+1) x^(q+1), branches, and what bends them.
#[derive(Clone, Debug, PartialEq)]
pub struct Constants {
    /// Stiffness p of the elastic response, N/mm^(q+1).
    pub p: f64,
    /// Exponent q of the elastic response.
    pub q: f64,
    /// Share of each branch, 0 to 1.
    pub shares: Vec<f64>,
    /// Rate of each branch, 1/s; of the nonlinear latency model at a state of 1 mm.
    pub rates: Vec<f64>,
    /// Power n of the state that its rate of change follows; 1 for a linear law.
    pub exponent: f64,
    /// Viscosity of a damper beside the spring over its stiffness, s.
    pub viscosity: f64,
}

impl Constants {
    /// An elastic response alone.
    #[must_use]
    pub const fn new(p: f64, q: f64) -> Self {
        Self { p, q, shares: Vec::new(), rates: Vec::new(), exponent: 1.0, viscosity: 0.0 }
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
